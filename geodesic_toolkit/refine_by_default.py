"""Whether distances are refined where the caller leaves it open, and why."""

from geodesic_toolkit.discretization import Discretization
from geodesic_toolkit.geometry.along_edges import AlongEdges
from geodesic_toolkit.geometry.dimension import share_of_meshes, widest_level
from geodesic_toolkit.gradient import EdgeGradient
from geodesic_toolkit.refine import made_of_triangles

__all__ = ["refinement_of"]

NEARLY_EVERYWHERE = 0.05
"""Share of the vertices that may lie in meshes of a graph of lines. Trees, chains and streets with
a bend each have none; square grids with every tenth edge missing have 0.8, three by three 0.11.
"""

DEAR = 1e6
"""Multiplications for each vertex from which on a factor is too dear: some 0.2 ms.

They are estimated by the cube of the widest level of a breadth-first search, which no separator
need exceed. Grids stay far below: 2,000 vertices for each one in squares, 2.4 million in cubes.
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
    width = widest_level(ways.n_vertices, edges)
    if float(width) ** 3 > DEAR * ways.n_vertices:
        return True, (
            f"the way along edges: a front from one vertex is {width} vertices wide, and a factor "
            "would take too long; refine=False insists on it"
        )
    return False, "heat, across the edges: the graph samples more than lines"
