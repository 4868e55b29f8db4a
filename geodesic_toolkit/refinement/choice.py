"""The default choice of refinement, with its reason."""

from typing import Literal

from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.edge_gradient import EdgeGradient
from geodesic_toolkit.geometry.across_edges import MIN_GROWTH_OF_SOLIDS
from geodesic_toolkit.geometry.along_edges import AlongEdges
from geodesic_toolkit.geometry.lines import (
    MAX_SHARE_OF_MESHES,
    is_network,
    share_of_meshes,
    widest_level,
)
from geodesic_toolkit.refinement.wavefronts import made_of_triangles

__all__ = ["refinement_of"]

MAX_CUBED_WIDTH_PER_VERTEX = 3e5
"""Cube of the width of a graph, per vertex, above which a factor for heat is too expensive.

The width is that of the widest level of a breadth-first search, and a factor takes about a dozen
times its cube in multiplications: at most a millisecond for each vertex. The cubed width per vertex
is 1.4 √n in a square of n vertices, 0.4 n in a cube, and 0.06 n² among 15 neighbours in ten
dimensions: squares of any size, cubes of 700,000 voxels and some 2,000 such samples are below the
limit. Fronts have no such limit: among 20 neighbours their corners take 40 µs and 3 kB a vertex in
cubes of 3, 4, 5 and 10 dimensions, of 1,000 samples as of 100,000.
"""

MIN_COVERED_SHARE, MIN_COVERED_SHARE_OF_LATTICES = 0.95, 0.6
"""Minimum share of the junctions whose edges are connected by corners, for fronts to cross the
corners, and the same share in lattices, whose corners are known rather than guessed. Neighbour
graphs of 8 and more have 0.97 to 1, meshes and lattices 1, with a twentieth of the edges missing
0.93 and with a tenth 0.78; neighbour graphs of 4 to 6 have 0.71 to 0.94 and have errors 2 % smaller
with heat, and a honeycomb has 0. Networks that sample no space are far below: random ones of 6 to
60 neighbours, with hubs, communities or rewired rings have 0 to 0.4.
"""

MIN_CLOSED_SHARE_OF_SOLIDS = 0.95
"""Minimum share of the edges surrounded by triangles in a graph that samples a solid. They surround
80 to 94 % of the edges of 8 to 12 neighbours in cubes, where fronts are 6 to 15 % too late and heat
5 to 10 % off, 97 to 99 % of those of 15 and 20 (2 to 5 %, heat 5 to 10 %), and all edges of
tetrahedra and of voxels with diagonals.
Where heat is too expensive, fronts remain: paths along edges are longer still, 15 % for 10 % in a
cube of 10 neighbours, 25 for 16 in 5 dimensions and 61 for 45 in 10.
"""

MIN_CLOSED_SHARE_OF_SAMPLES, MIN_CLOSED_SHARE_IN_MANY_DIMENSIONS = 0.5, 0.03
"""Minimum of the same share in neighbour graphs, and where a graph grows as in many dimensions.
Neighbour graphs of 4 to 30 have 0.55 and more in 3 to 5 dimensions, 0.06 to 0.7 in 10 to 200. In
voxels without diagonals and in meshes of triangles, where fronts are accurate, it is 0 inside, and
up to 0.36 with the rim.
"""

MIN_GROWTH_IN_MANY_DIMENSIONS = 5.0
"""Vertices within two edges, per neighbour, from which on a graph has many dimensions. Neighbour
graphs of 4 to 30 have 5.5 to 17 in 10 to 200 dimensions, voxels and meshes of triangles up to 4.2.
"""


def refinement_of(
    metric: Discretization, *, heat_is_meant: bool = False
) -> tuple[bool | Literal["across"], str]:
    """Return how to refine distances on a discretization, and the reason in words.

    Parameters
    ----------
    metric : Discretization
    heat_is_meant : bool
        True if options are given that only heat uses.

    Returns
    -------
    refine : bool or "across"
        "across" where fronts should cross the corners of a graph, or a metric has its own fronts.
    reason : str
    """
    if metric.fronts is not None:
        if heat_is_meant:
            return False, "heat, as its own options are given"
        return "across", "fronts can cross the elements"
    if made_of_triangles(metric):
        return True, "fronts can cross the triangles"
    if metric.along_edges is not None:
        return _on_graph(metric.along_edges, metric, heat_is_meant)
    return False, "there are neither triangles for fronts to cross nor edges with lengths"


def _on_graph(
    paths: AlongEdges, metric: Discretization, heat_is_meant: bool
) -> tuple[bool | Literal["across"], str]:
    if paths.instead_of_heat:
        return True, f"the path along edges: {paths.instead_of_heat}"
    assert isinstance(metric.gradient, EdgeGradient)  # for the type checker
    edges = metric.gradient.edges  # without those of length 0
    share = share_of_meshes(paths.n_vertices, edges)
    if share <= MAX_SHARE_OF_MESHES:
        return True, (
            f"the path along edges: the graph is one-dimensional except at {share:.1%} of its "
            "vertices"
        )
    proper = paths.lengths > 0
    if metric.local_scale and is_network(
        paths.n_vertices, paths.edges[proper], paths.lengths[proper]
    ):
        return True, (
            "the path along edges: junctions have up to four neighbours, and edges have many "
            "lengths, as in a street network; refine=False, or a dim, treats vertices as samples"
        )
    return _on_samples(paths, metric, heat_is_meant)


def _on_samples(
    paths: AlongEdges, metric: Discretization, heat_is_meant: bool
) -> tuple[bool | Literal["across"], str]:
    """Return how to measure a graph whose vertices are samples.

    The width matters for heat alone: fronts need no factor.
    """
    assert isinstance(metric.gradient, EdgeGradient)  # for the type checker
    gaps = gaps_of_solid = ""
    if across := metric.local_scale and not heat_is_meant:
        gaps, gaps_of_solid = _gaps(metric), _gaps_of_solid(metric)
        if not (gaps or gaps_of_solid):
            return "across", "fronts can cross the corners of the graph"
    width = widest_level(paths.n_vertices, metric.gradient.edges)
    if float(width) ** 3 <= MAX_CUBED_WIDTH_PER_VERTEX * paths.n_vertices:
        if not across:
            return False, "heat, across the edges: the graph samples a surface or a solid"
        return False, (
            "heat, across the edges, 5 to 15 % off, in more than three dimensions 10 to 60 %: "
            f"{gaps_of_solid or gaps}; more neighbours would help"
        )
    too_wide = (
        f"a front from one vertex is {width} vertices wide, and a factor for heat would take too "
        "long; refine=False uses it anyway"
    )
    if across and not gaps:
        return "across", (
            "fronts can cross the corners of the graph, but are 10 to 60 % too late: "
            f"{gaps_of_solid}; {too_wide}"
        )
    return True, f"the path along edges: {too_wide}"


def _gaps_of_solid(metric: Discretization) -> str:
    """Describe the edges of a solid that triangles do not surround; "" if almost none."""
    assert metric.across_edges is not None  # graphs have both kinds of paths
    corners = metric.across_edges.corners
    many = corners.growth > MIN_GROWTH_IN_MANY_DIMENSIONS
    least = MIN_CLOSED_SHARE_IN_MANY_DIMENSIONS if many else MIN_CLOSED_SHARE_OF_SAMPLES
    if (
        corners.growth > MIN_GROWTH_OF_SOLIDS
        and least < corners.closed < MIN_CLOSED_SHARE_OF_SOLIDS
    ):
        return f"in a solid, triangles surround {corners.closed:.0%} of the edges only"
    return ""


def _gaps(metric: Discretization) -> str:
    """Describe the gaps that corners leave between the edges of a graph; "" if almost none."""
    assert metric.across_edges is not None  # as above
    corners = metric.across_edges.corners
    if corners.covered < (MIN_COVERED_SHARE_OF_LATTICES if corners.lattice else MIN_COVERED_SHARE):
        return f"there are gaps between the edges at {1 - corners.covered:.0%} of the junctions"
    return ""
