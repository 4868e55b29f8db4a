"""Shortest paths through points on edges: where a path across faces begins."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import dijkstra

from geodesic_toolkit.analysis.paths.metric.faces import FacesAround, segment_length
from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["Leg", "legs_between", "legs_of"]

LEAST_POINTS, MOST_POINTS = 3, 12
"""Points inside each edge, as many as `MAX_LINES` allows.

With 1, 2, 3, 5 and 8 points 6, 8, 9, 8 and 12 of 89 paths on a sphere and two tori ended on the
longer side of a pointed vertex, and were up to 4.5e-4 longer (before `MAX_TRIES` of the strips).
"""

MAX_LINES = 30_000
"""Number of lines between points up to which edges have more points than the least number: a path
across a few large faces may run along an edge for less than a quarter of it."""


@dataclass(frozen=True)
class Leg:
    """A strip of faces from a vertex of the first to one of the last."""

    strip: list[int]
    start: int
    end: int


def legs_between(
    surface: FacesAround, among: IntArray, n_vertices: int, *, start: int, ends: IntArray
) -> list[Leg]:
    """Return the strip of faces from a vertex to the nearest of several.

    It is that of the shortest path that passes edges at their ends or at points in equal parts of
    them. Paths along edges are among those.

    Parameters
    ----------
    surface : FacesAround
    among : ndarray of int64
        The faces that the path may cross.
    n_vertices : int
    start : int
    ends : ndarray of int64
        Without the start.

    Returns
    -------
    list of Leg
        Empty if no face connects them; more than one where the path goes through a vertex in which
        faces meet that no others around it connect.
    """
    faces, lengths = surface.faces[among], surface.lengths[among]
    edges, place = _edges(faces)
    shortest = np.full(len(edges), np.inf)
    np.minimum.at(shortest, place.ravel(), lengths.ravel())
    points = _points_per_edge(len(faces))
    nodes, weights = _nodes(faces, place, n_vertices, points)
    count = n_vertices + points * len(edges)
    lines = zip(
        _across(lengths, nodes, weights), _along(edges, shortest, n_vertices, points), strict=True
    )
    tails, heads, values = (np.concatenate(parts) for parts in lines)
    graph = csr_array(coo_array((values, (tails, heads)), shape=(count, count)))
    distance, before = dijkstra(
        graph, directed=False, indices=np.array(start), return_predecessors=True
    )
    end = int(ends[np.argmin(distance[ends])])
    if not np.isfinite(distance[end]):
        return []
    found = [end]
    while found[-1] != start:
        found.append(int(before[found[-1]]))
    supports = [
        [node] if node < n_vertices else edges[(node - n_vertices) // points].tolist()
        for node in found[::-1]
    ]
    return legs_of(surface, supports)


def _edges(faces: IntArray) -> tuple[IntArray, IntArray]:
    """Return the edges (E, 2), sorted ends first, and the edge opposite each corner, (F, 3)."""
    ends = np.sort(faces[:, [[1, 2], [2, 0], [0, 1]]], axis=2)
    stride = int(faces.max()) + 1
    keys, place = np.unique(ends[..., 0] * stride + ends[..., 1], return_inverse=True)
    return np.column_stack([keys // stride, keys % stride]), place.reshape(-1, 3)


def _points_per_edge(n_faces: int) -> int:
    """Return the number of points inside each edge: faces have 3 k (k + 1) lines across each."""
    many = int(np.sqrt(MAX_LINES / (3 * n_faces)))
    return min(max(many, LEAST_POINTS), MOST_POINTS)


def _nodes(
    faces: IntArray, place: IntArray, n_vertices: int, points: int
) -> tuple[IntArray, FloatArray]:
    """Return the nodes on the border of each face, (F, K), and their barycentric weights, (K, 3).

    The corners are the first, then the points of the edge opposite each corner.
    """
    steps = np.arange(points)
    shares = (steps + 1) / (points + 1)
    nodes, weights = [faces], [np.eye(3)]
    for corner in range(3):
        tail, head = (corner + 1) % 3, (corner + 2) % 3
        forth = (faces[:, tail] < faces[:, head])[:, None]
        order = np.where(forth, steps, steps[::-1])
        nodes.append(n_vertices + points * place[:, corner, None] + order)
        own = np.zeros((points, 3))
        own[:, tail], own[:, head] = 1 - shares, shares
        weights.append(own)
    return np.hstack(nodes), np.vstack(weights)


def _across(
    lengths: FloatArray, nodes: IntArray, weights: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return tails, heads and lengths of the lines across faces."""
    pairs = np.array(
        [
            (one, other)
            for one, other in combinations(range(len(weights)), 2)
            if ((weights[one] + weights[other]) > 0).all()  # not on one edge
        ]
    )
    steps = weights[pairs[:, 1]] - weights[pairs[:, 0]]
    values = segment_length(lengths[:, None], steps[None])
    return nodes[:, pairs[:, 0]].ravel(), nodes[:, pairs[:, 1]].ravel(), values.ravel()


def _along(
    edges: IntArray, lengths: FloatArray, n_vertices: int, points: int
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return tails, heads and lengths of the parts of edges."""
    inner = n_vertices + np.arange(len(edges) * points).reshape(-1, points)
    nodes = np.hstack([edges[:, :1], inner, edges[:, 1:]])
    parts = np.repeat(lengths / (points + 1), points + 1)
    return nodes[:, :-1].ravel(), nodes[:, 1:].ravel(), parts


def legs_of(surface: FacesAround, supports: list[list[int]]) -> list[Leg]:
    """Return the strips of a course of points that are at a vertex or between an edge's ends.

    None for a course without points.
    """
    if not supports:
        return []
    strips: list[list[int]] = [[]]
    stops = [supports[0][0]]
    for here, there in pairwise(supports):
        face, strip = _face_of(surface, here, there), strips[-1]
        if strip and len(here) == 1 and strip[-1] != face:
            chain = surface.chain(strip[-1], face, here[0])
            if not chain:
                stops.append(here[0])
                strips.append([face])
            strip.extend(chain[1:])
        else:
            strip.append(face)
    stops.append(supports[-1][0])
    return [
        Leg(surface.without_returns(strip), *ends)
        for strip, ends in zip(strips, pairwise(stops), strict=True)
    ]


def _face_of(surface: FacesAround, here: list[int], there: list[int]) -> int:
    """Return the face between two points, that of the lesser length where they share an edge."""
    corners = sorted({*here, *there})
    beside = surface.with_corners(*corners)
    if len(corners) > 2:
        return beside[0]
    return min(beside, key=lambda face: surface.edge_length(face, *corners))
