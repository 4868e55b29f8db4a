"""The best of the ways down from a vertex, straightened; what paths on meshes and clouds share."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_array, csr_array

from geodesic_toolkit._typing import FloatArray
from geodesic_toolkit.analysis.descent import descend
from geodesic_toolkit.geometry.fans import Fans
from geodesic_toolkit.geometry.strips import Way, beside_cones, shortest_way
from geodesic_toolkit.geometry.triangles import edges_of_faces

__all__ = ["best_way"]


NEARLY = 1.05
"""Ways over a vertex up to so many times as long as the shortest are straightened and compared:
refined distances err by some per cent on coarse meshes."""

MOST = 12
"""Such vertices that are tried, those of the shortest ways."""


def best_way(
    fans: Fans, height: FloatArray, back: FloatArray, start: int, ends: set[int]
) -> list[tuple[int, dict[int, float]]]:
    """Return the points of a geodesic from a vertex to one of several, each in a face.

    Near a place where ways of equal length meet, steepest descent may take the wrong one. So it
    also sets out to every neighbour of the start that is lower, back from the ends, and to both
    from vertices over which a way is hardly longer than over any other and shorter than over their
    neighbours; the shortest of what comes out is taken.

    Parameters
    ----------
    fans : Fans
    height : ndarray of shape (N,), float64
        The distance from the ends, 0 there.
    back : ndarray of shape (N,), float64
        The distance from the start, 0 there.
    start : int
    ends : set of int

    Returns
    -------
    list of (face, mapping of vertex to weight)
    """
    best: list[tuple[Way, int, int]] = []
    for stops, strips in _descents(fans, height, back, start, ends):
        ways = [
            (shortest_way(fans, strip, first, last), first, last)
            for strip, first, last in _joined(fans, stops, strips)
        ]
        if not best or _length(ways) < _length(best):
            best = ways
    crossings: list[tuple[int, dict[int, float]]] = []
    for way, first, last in best:
        crossings += beside_cones(fans, way, first, last).crossings
    return crossings


def _length(ways: list[tuple[Way, int, int]]) -> float:
    return sum(way.length for way, _, _ in ways)


def _descents(
    fans: Fans, height: FloatArray, back: FloatArray, start: int, ends: set[int]
) -> Iterator[tuple[list[int], list[list[int]]]]:
    """Go down from a vertex in every way; where none leads to an end, along edges."""
    arrived = False
    seen: set[int] = set()
    stops, strips = descend(fans, height, start)
    if stops[-1] in ends:
        arrived = True
        yield stops, strips
    for face in fans.around(start):
        for neighbour in fans.others(face, start):
            if neighbour in seen or not height[neighbour] < height[start]:
                continue
            seen.add(neighbour)
            stops, strips = descend(fans, height, neighbour)
            if stops[-1] in ends:
                arrived = True
                yield [start, *stops], [[face], *strips]
    for vertex in _between(fans, height + back, start):
        stops, strips = descend(fans, height, vertex)
        came, behind = descend(fans, back, vertex)
        if stops[-1] in ends and came[-1] == start:
            arrived = True
            reverse = [strip[::-1] for strip in behind[::-1]]
            yield [*came[::-1], *stops[1:]], [*reverse, *strips]
    if not arrived:  # into hollows that are none of the sources
        yield _along_edges(fans, start, ends)


def _between(fans: Fans, total: FloatArray, start: int) -> list[int]:
    """Return vertices over which a way is nearly the shortest, and shorter than beside them."""
    edges, _ = edges_of_faces(fans.faces, len(fans.vertices))
    beside = np.full(len(total), np.inf)
    np.minimum.at(beside, edges.ravel(), total[edges[:, ::-1]].ravel())
    near = np.flatnonzero((total <= beside) & (total <= NEARLY * total.min()))
    found: list[int] = near[np.argsort(total[near], kind="stable")][:MOST].tolist()
    return [vertex for vertex in found if vertex != start]


def _along_edges(fans: Fans, start: int, ends: set[int]) -> tuple[list[int], list[list[int]]]:
    """Return the shortest way along edges, as `descend` does."""
    from scipy.sparse.csgraph import dijkstra  # a tenth of a second

    count = len(fans.vertices)
    edges, _ = edges_of_faces(fans.faces, count)
    lengths = np.linalg.norm(np.diff(fans.vertices[edges], axis=1)[:, 0], axis=1)
    graph = csr_array(coo_array((lengths, tuple(edges.T)), shape=(count, count)))
    distance, before = dijkstra(  # the stubs know only sparse matrices
        graph,  # type: ignore[call-overload]
        directed=False,
        indices=start,
        return_predecessors=True,
    )
    stops = [min(ends, key=lambda end: distance[end])]
    while stops[-1] != start:
        stops.append(int(before[stops[-1]]))
    stops.reverse()
    return stops, [[fans.at_edge(a, b)[0]] for a, b in pairwise(stops)]


def _joined(
    fans: Fans, stops: list[int], strips: list[list[int]]
) -> list[tuple[list[int], int, int]]:
    """Join strips around the vertices between them: (strip, first vertex, last vertex).

    More than one where the surface hangs together at a vertex only.
    """
    legs = [(list(strips[0]), stops[0], stops[1])]
    for strip, first, last in zip(strips[1:], stops[1:-1], stops[2:], strict=True):
        chain = fans.chain(legs[-1][0][-1], strip[0], first)
        if chain is None:
            legs.append((list(strip), first, last))
        else:
            legs[-1] = (legs[-1][0] + chain[1:] + strip[1:], legs[-1][1], last)
    return legs
