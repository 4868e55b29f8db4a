"""The scale of distance about each vertex of a graph, read off the graph.

A potential such as a distance from far away rises along an edge by at most the length of the edge,
and by just that where the edge points its way. How much too steep potentials are is therefore the
greatest rise for the way along edges, over pairs of vertices near by and potentials from many
sides. On the axes of a square grid, or of a bar of voxels, ways along edges are straight, and the
greatest rise is there; where ways along edges are straight in no direction, as among neighbours of
random samples, the greatest rise is luck as well, and the mean rise along shortest ways, which
would give back the way along edges, has a say.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from geodesic_toolkit._typing import BoolArray, FloatArray, IntArray
from geodesic_toolkit.geometry.along_edges import AlongEdges

__all__ = ["rises"]

FIELDS = 32
"""Potentials, each from one vertex of every part. Fewer see too few directions of a solid: the mean
error on a cube of 12³ voxels is 7.5 % with 16 and 6.6 % with 32, of which 4.7 % are the method's.
"""

TRACED = 8
"""Fields whose own shortest ways are followed; their mean needs no more."""

NEIGHBOURHOODS = 64
"""Neighbourhoods in a part, at most; from 64 to 128 errors change by less than 0.5 %."""

SPARSE = 20
"""Vertices for each neighbourhood of a small part."""

BALL = 300
"""Vertices of a neighbourhood: 150, 300 and 600 give the same to 1 %."""

HOPS = 8
"""Edges from its middle to its rim at most, where a graph is thin."""

MEMBERS = 16
"""Vertices of a neighbourhood from which its rises are taken and averaged."""

STRAIGHT = 0.98
"""Part of the way between two vertices by which a shortest way that leads past both differs."""

TAXICAB, RANDOM = 0.8, 0.9
"""Mean over greatest rise, below and above which ways along edges are straight in some directions
only, or equally in all. Lattices with neighbours along their axes have 0.5 to 0.76, with a jitter
of 0.3 up to 0.86; all neighbour graphs of two-dimensional samples 0.86 to 0.95.
"""

SAY = 0.6
"""Weight of the mean rise where ways are equally straight in all directions."""

PARTS = 256
"""Parts of a graph that are looked at, the largest first; the others take the median."""


@dataclass(frozen=True)
class _Ball:
    """A neighbourhood: its vertices, some of its members, and the ways from those, (m, n)."""

    vertices: IntArray
    members: IntArray
    ways: FloatArray
    pairs: BoolArray


def rises(
    graph: AlongEdges, part: IntArray, potentials: Callable[[list[IntArray]], FloatArray]
) -> FloatArray:
    """Return by how much potentials rise for each unit of length about each vertex.

    Parameters
    ----------
    graph : AlongEdges
        Lengths are positive.
    part : ndarray of shape (N,), int64
        The connected part of every vertex.
    potentials : callable
        From K sets of vertices to the potentials (K, N) that distance would be if their gradient
        had the length 1.

    Returns
    -------
    ndarray of shape (N,), float64
        Positive; 1 at vertices without edges.
    """
    sizes = np.bincount(part)
    order = np.argsort(part, kind="stable")
    begins = np.concatenate([[0], np.cumsum(sizes)])[:-1]
    some = np.flatnonzero(sizes > 1)
    some = some[np.argsort(-sizes[some], kind="stable")][:PARTS]
    if not len(some):
        return np.ones(len(part))
    sides = np.random.default_rng(0).random(FIELDS)
    sources = np.stack(
        [order[begins[some] + (side * sizes[some]).astype(np.int64)] for side in sides]
    )
    centres = np.concatenate([order[begins[one] + _spread(int(sizes[one]))] for one in some])
    limit = np.clip(sizes[part[centres]] // 4, 12, BALL)
    balls = [_ball(graph.matrix, int(c), int(n)) for c, n in zip(centres, limit, strict=True)]
    used = np.unique(np.concatenate([ball.vertices for ball in balls]))
    heights = np.concatenate(
        [potentials(list(half))[:, used] for half in np.split(sources, FIELDS // 16)]
    )
    traced = sources[:TRACED]
    ways = graph.distances(
        np.arange(TRACED + 1) * traced.shape[1], traced.ravel(), np.zeros(traced.size)
    )[:, used]
    found = np.array([_rise(ball, used, heights, ways, sources) for ball in balls])
    return _spread_out(graph.matrix, centres, np.where(found > 0, found, np.nan))


def _spread(size: int) -> IntArray:
    """Return the places of neighbourhoods among so many vertices, one at random in each stretch."""
    count = min(max(size // SPARSE, 1), NEIGHBOURHOODS)
    return np.asarray(
        (np.arange(count) + np.random.default_rng(0).random(count)) * size / count, dtype=np.int64
    )


def _ball(matrix: Any, centre: int, limit: int) -> _Ball:
    """Return the vertices nearest to one, about `limit` of them."""
    from scipy.sparse.csgraph import dijkstra

    vertices = np.array([centre])
    for _ in range(HOPS):
        wider = np.union1d(vertices, matrix[vertices].indices)
        if len(wider) == len(vertices) or len(vertices) > 2 * limit:
            break
        vertices = wider
    inner = matrix[vertices][:, vertices]
    ways = dijkstra(inner, directed=False, indices=int(np.searchsorted(vertices, centre)))
    if len(vertices) > limit:
        near = ways < np.partition(ways, limit)[limit]
        if np.count_nonzero(near) > limit // 4:  # not all on one sphere
            vertices, ways, inner = vertices[near], ways[near], inner[near][:, near]
    half = ways.max() / 2
    within = np.flatnonzero(ways <= half)
    members = within[np.unique(np.linspace(0, len(within) - 1, MEMBERS).astype(np.int64))]
    between = dijkstra(inner, directed=False, indices=members)
    pairs = np.isfinite(between) & (between >= half) & (between > 0)
    some = pairs.any(axis=1)
    return _Ball(vertices, members[some], between[some], pairs[some])


def _rise(
    ball: _Ball, used: IntArray, heights: FloatArray, ways: FloatArray, sources: IntArray
) -> float:
    """Return how steep potentials are in a neighbourhood, NaN where it has none to compare."""
    if not len(ball.members):
        return np.nan
    here = np.searchsorted(used, ball.vertices)
    outside = ~np.isin(sources, ball.vertices).any(axis=1)  # near its source a field has a kink
    fields = np.flatnonzero(outside) if outside.any() else np.arange(len(sources))
    steep = np.zeros((len(ball.members), len(fields)))
    along: list[FloatArray] = []
    local = heights[fields][:, here]
    passed = ways[fields[fields < TRACED]][:, here]
    for row, (member, length, pairs) in enumerate(
        zip(ball.members, ball.ways, ball.pairs, strict=True)
    ):
        rise = np.abs(local[:, pairs] - local[:, [member]]) / length[pairs]
        steep[row] = rise.max(axis=1)
        led = np.abs(passed[:, pairs] - passed[:, [member]]) >= STRAIGHT * length[pairs]
        along.append(rise[: len(passed)][led])
    greatest = float(steep.mean(axis=0).max())
    traced = np.concatenate(along)
    if not len(traced) or greatest <= 0:
        return greatest
    mean = min(float(traced.mean()), greatest)
    weight = SAY * np.clip((mean / greatest - TAXICAB) / (RANDOM - TAXICAB), 0, 1)
    return float(greatest * (1 - weight) + mean * weight)


def _spread_out(matrix: Any, centres: IntArray, found: FloatArray) -> FloatArray:
    """Return what was found at centres for all vertices: at the nearest, smoothed along edges."""
    from scipy.sparse.csgraph import dijkstra

    known = np.isfinite(found)
    if not known.any():
        return np.ones(matrix.shape[0])
    _, _, nearest = dijkstra(
        matrix, directed=False, indices=centres[known], min_only=True, return_predecessors=True
    )
    values = np.full(matrix.shape[0], np.log(np.median(found[known])))
    values[centres[known]] = np.log(found[known])
    reached = nearest >= 0
    values[reached] = values[nearest[reached]]
    degree = np.diff(matrix.indptr)
    rows = np.repeat(np.arange(len(degree)), degree)
    for _ in range(3):
        around = np.bincount(rows, values[matrix.indices], len(degree))
        values = (values + around) / (1 + degree)
    return np.asarray(np.where(degree > 0, np.exp(values), 1.0))
