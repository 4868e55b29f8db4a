"""Whether distances are refined where the caller leaves it open, and why."""

from geodesic_toolkit.discretization import Discretization
from geodesic_toolkit.geometry.along_edges import AlongEdges
from geodesic_toolkit.geometry.lines import (
    NEARLY_EVERYWHERE,
    is_network,
    share_of_meshes,
    widest_level,
)
from geodesic_toolkit.gradient import EdgeGradient
from geodesic_toolkit.refine import made_of_triangles

__all__ = ["refinement_of"]

DEAR = 3e5
"""Cube of the width of a graph, for each vertex, from which on a factor is too dear.

The width is that of the widest level of a breadth-first search, and a factor takes about a dozen
times its cube in multiplications: at most a millisecond for each vertex. In a square of n vertices
that is 1.4 √n, in a cube 0.4 n, among 15 neighbours in ten dimensions 0.06 n²: squares of any size,
cubes of 700,000 voxels and some 2,000 such samples are below.
"""


def refinement_of(metric: Discretization) -> tuple[bool, str]:
    """Return whether to refine distances on a discretization, and the reason in words.

    Parameters
    ----------
    metric : Discretization

    Returns
    -------
    refine : bool
    reason : str
    """
    if made_of_triangles(metric):
        return True, "fronts can cross the triangles"
    if metric.along_edges is not None:
        return _on_graph(metric.along_edges, metric)
    return False, "there are neither triangles for fronts to cross nor edges with lengths"


def _on_graph(ways: AlongEdges, metric: Discretization) -> tuple[bool, str]:
    if ways.instead_of_heat:
        return True, f"the way along edges: {ways.instead_of_heat}"
    assert isinstance(metric.gradient, EdgeGradient)  # for the type checker
    edges = metric.gradient.edges  # without those of length 0
    share = share_of_meshes(ways.n_vertices, edges)
    if share <= NEARLY_EVERYWHERE:
        return True, (
            f"the way along edges: the graph is one-dimensional but for {share:.1%} of its vertices"
        )
    proper = ways.lengths > 0
    if metric.local_scale and is_network(ways.n_vertices, ways.edges[proper], ways.lengths[proper]):
        return True, (
            "the way along edges: junctions have up to four neighbours, and edges all kinds of "
            "lengths, as in a street network; refine=False, or a dim, takes it for samples"
        )
    width = widest_level(ways.n_vertices, edges)
    if float(width) ** 3 > DEAR * ways.n_vertices:
        return True, (
            f"the way along edges: a front from one vertex is {width} vertices wide, and a factor "
            "would take too long; refine=False insists on it"
        )
    return False, "heat, across the edges: the graph samples more than lines"
