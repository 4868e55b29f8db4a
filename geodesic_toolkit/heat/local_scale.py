"""The local scale of distance at each vertex of a graph, estimated from the graph.

A potential such as a distance from far away rises along an edge by at most the length of the edge,
and by exactly that if the edge has the direction of its gradient. Potentials are therefore too
steep by the greatest rise per length of path along edges, over pairs of vertices nearby and
potentials from many sides. On the axes of a square grid, or of a bar of voxels, paths along edges
are straight, and the greatest rise is found there. If paths along edges are not straight in any
direction, as among neighbours of random samples, the greatest rise also depends on chance, and is
averaged with the mean rise along shortest paths, which alone would reproduce the path along edges.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.geometry.along_edges import AlongEdges

__all__ = ["rises"]

N_POTENTIALS = 16
"""Number of potentials, each from one vertex of every component; twice as many in solids with few
directions.

The mean error on a cube of 12³ voxels is 7.5 % with 16 and 6.6 % with 32, of which 4.7 % are the
method's own; in the plane 16 are enough.
"""

MIN_DIMENSION_OF_SOLIDS = 2.2
"""Minimum dimension of a solid; grids in the plane are estimated at 1.7 to 2.1."""

N_NEIGHBOURHOODS_COMPARED = 3
"""Neighbourhoods that are compared if directions are few."""

DEGREE_TOLERANCE = 0.1
"""Maximum relative difference of the mean degrees of neighbourhoods of one kind."""

QUANTILE_OF_RISE = 0.8
"""Quantile of the rises of neighbourhoods of one kind that is taken as usual."""

N_TRACED_POTENTIALS = 8
"""Potentials whose shortest paths are followed; more are not needed for their mean."""

MAX_NEIGHBOURHOODS = 64
"""Maximum number of neighbourhoods in a component; from 64 to 128 errors change by less than
0.5 %."""

VERTICES_PER_NEIGHBOURHOOD = 20
"""Vertices per neighbourhood in a small component."""

VERTICES_OF_NEIGHBOURHOOD = 300
"""Number of vertices of a neighbourhood: 150, 300 and 600 give the same to 1 %."""

MAX_RADIUS_IN_EDGES = 8
"""Maximum number of edges from the centre of a neighbourhood to its rim, in thin graphs."""

N_MEMBERS_AVERAGED = 16
"""Vertices of a neighbourhood from which rises are measured and averaged."""

MIN_RATIO_OF_STRAIGHT_PATHS = 0.98
"""Minimum ratio of the difference along a shortest path past two vertices to their distance."""

MAX_MEAN_OF_LATTICES, MIN_MEAN_OF_RANDOM_SAMPLES = 0.82, 0.9
"""Ratio of the mean rise to the greatest one below which paths along edges are straight in some
directions only, and above which equally in all. Lattices with neighbours along their axes have 0.5
to 0.76, with a jitter of 0.3 up to 0.86; all neighbour graphs of two-dimensional samples 0.86 to
0.95.
"""

WEIGHT_OF_MEAN_RISE = 0.4
"""Weight of the mean rise where paths are equally straight in all directions."""

MAX_COMPONENTS_EXAMINED = 256
"""Number of components that are measured, the largest first; the others take the median."""


@dataclass(frozen=True)
class _Ball:
    """A neighbourhood: its vertices, some of its members, and the paths from these, (m, n)."""

    vertices: IntArray
    members: IntArray
    paths: FloatArray
    pairs: BoolArray


def rises(
    graph: AlongEdges,
    part: IntArray,
    dimension: int,
    potentials: Callable[[list[IntArray]], FloatArray],
) -> FloatArray:
    """Return the rise of potentials per unit of length at each vertex.

    Parameters
    ----------
    graph : AlongEdges
        Lengths are positive.
    part : ndarray of shape (N,), int64
        The component of every vertex.
    dimension : int
        The dimension for which potentials are scaled.
    potentials : callable
        Function of K sets of vertices that returns the potentials (K, N).

    Returns
    -------
    ndarray of shape (N,), float64
        Positive; 1 at vertices without edges.
    """
    sizes = np.bincount(part)
    order = np.argsort(part, kind="stable")
    begins = np.concatenate([[0], np.cumsum(sizes)])[:-1]
    large = np.flatnonzero(sizes > 1)
    large = large[np.argsort(-sizes[large], kind="stable")][:MAX_COMPONENTS_EXAMINED]
    if not len(large):
        return np.ones(len(part))
    sides = np.random.default_rng(0).random(2 * N_POTENTIALS)
    sources = np.stack(
        [order[begins[large] + (side * sizes[large]).astype(np.int64)] for side in sides]
    )
    centres = np.unique(
        np.concatenate(
            [order[begins[one] + _positions_of_centres(int(sizes[one]))] for one in large]
        )
    )
    limit = np.clip(sizes[part[centres]] // 4, 12, VERTICES_OF_NEIGHBOURHOOD)
    balls = [_ball(graph.matrix, int(c), int(n)) for c, n in zip(centres, limit, strict=True)]
    used = np.unique(np.concatenate([ball.vertices for ball in balls]))
    traced = sources[:N_TRACED_POTENTIALS]
    paths = graph.distances(
        np.arange(N_TRACED_POTENTIALS + 1) * traced.shape[1], traced.ravel(), np.zeros(traced.size)
    )[:, used]
    cells, near = _cells(graph, centres)
    heights = np.zeros((0, len(used)))
    for fields in (sources[:N_POTENTIALS], sources[N_POTENTIALS:]):
        heights = np.concatenate([heights, potentials(list(fields))[:, used]])
        fields_used = sources[: len(heights)]
        greatest, mean = np.array(
            [_rise(ball, used, heights, paths, fields_used) for ball in balls]
        ).T
        if not _solid(greatest, mean, dimension):
            break
    degrees = np.diff(graph.matrix.indptr)
    edges = np.array([degrees[ball.vertices].mean() for ball in balls])
    alike = np.abs(edges - edges[:, None]) <= DEGREE_TOLERANCE * edges
    alike &= part[centres] == part[centres][:, None]
    values = _weighed(greatest, mean, near, alike)
    return _smoothed_over_graph(graph.matrix, cells, values)


def _solid(greatest: FloatArray, mean: FloatArray, dimension: int) -> bool:
    """Return True if paths are straight in few directions of more than two dimensions.

    More potentials are then needed, because few come from those directions; their cost is small
    beside that of a factor.
    """
    known = greatest > 0
    crooked = known & (mean < MAX_MEAN_OF_LATTICES * greatest)
    return bool(
        np.any(crooked) and np.median(greatest[crooked]) ** 2 * dimension > MIN_DIMENSION_OF_SOLIDS
    )


def _positions_of_centres(size: int) -> IntArray:
    """Return the indices of centres among so many vertices, one at random in each interval."""
    count = min(max(size // VERTICES_PER_NEIGHBOURHOOD, 1), MAX_NEIGHBOURHOODS)
    return np.asarray(
        (np.arange(count) + np.random.default_rng(0).random(count)) * size / count, dtype=np.int64
    )


def _ball(matrix: Any, centre: int, limit: int) -> _Ball:
    """Return the neighbourhood of a vertex: the nearest vertices, about `limit` of them."""
    from scipy.sparse.csgraph import dijkstra

    vertices = np.array([centre])
    for _ in range(MAX_RADIUS_IN_EDGES):
        wider = np.union1d(vertices, matrix[vertices].indices)
        if len(wider) == len(vertices) or len(vertices) > 2 * limit:
            break
        vertices = wider
    inner = matrix[vertices][:, vertices]
    paths = dijkstra(inner, directed=False, indices=[int(np.searchsorted(vertices, centre))])[0]
    if len(vertices) > limit:
        near = paths < np.partition(paths, limit)[limit]
        if np.count_nonzero(near) > limit // 4:  # not all on one sphere
            vertices, paths, inner = vertices[near], paths[near], inner[near][:, near]
    half = paths.max() / 2
    within = np.flatnonzero(paths <= half)
    members = within[
        np.unique(np.linspace(0, len(within) - 1, N_MEMBERS_AVERAGED).astype(np.int64))
    ]
    between = dijkstra(inner, directed=False, indices=members)
    pairs = np.isfinite(between) & (between >= half) & (between > 0)
    compared = pairs.any(axis=1)
    return _Ball(vertices, members[compared], between[compared], pairs[compared])


def _rise(
    ball: _Ball, used: IntArray, heights: FloatArray, paths: FloatArray, sources: IntArray
) -> tuple[float, float]:
    """Return the greatest rise of potentials in a neighbourhood, and the mean along shortest paths.

    The greatest rise is the maximum over fields of a mean over members. Both are NaN if there are
    no vertices to compare.
    """
    if not len(ball.members):
        return np.nan, np.nan
    here = np.searchsorted(used, ball.vertices)
    outside = ~np.isin(sources, ball.vertices).any(axis=1)  # a field has a kink near its source
    fields = np.flatnonzero(outside) if outside.any() else np.arange(len(sources))
    local = heights[np.ix_(fields, here)]
    length = np.where(ball.pairs, ball.paths, np.inf)
    rise = np.abs(local[:, None, :] - local[:, ball.members, None]) / length
    greatest = float(rise.max(axis=2).mean(axis=1).max())
    passed = paths[np.ix_(fields[fields < N_TRACED_POTENTIALS], here)]
    covered = np.abs(passed[:, None, :] - passed[:, ball.members, None])
    on_path = covered >= MIN_RATIO_OF_STRAIGHT_PATHS * length
    if not on_path.any():
        return greatest, greatest
    return greatest, min(float(rise[: len(passed)][on_path].mean()), greatest)


def _cells(graph: AlongEdges, centres: IntArray) -> tuple[IntArray, BoolArray]:
    """Return the nearest of n centres to each vertex, or -1, and a mask of near cells, (n, n).

    Near cells of a cell touch it, and have the nearest centres.
    """
    from scipy.sparse.csgraph import dijkstra

    apart, _, nearest = dijkstra(
        graph.matrix, directed=False, indices=centres, min_only=True, return_predecessors=True
    )
    number = np.full(graph.n_vertices + 1, -1)
    number[centres] = np.arange(len(centres))
    cells = number[np.where(nearest >= 0, nearest, graph.n_vertices)]
    ends = cells[graph.edges]
    border = ends[:, 0] != ends[:, 1]
    length = graph.lengths[border] + apart[graph.edges[border]].sum(axis=1)
    between = np.full((len(centres), len(centres)), np.inf)
    for one, other in ((0, 1), (1, 0)):
        np.minimum.at(between, (ends[border, one], ends[border, other]), length)
    np.fill_diagonal(between, 0.0)
    last = np.sort(between, axis=1)[:, min(N_NEIGHBOURHOODS_COMPARED, len(centres)) - 1]
    return cells, np.isfinite(between) & (between <= last[:, None])


def _weighed(
    greatest: FloatArray, mean: FloatArray, near: BoolArray, alike: BoolArray
) -> FloatArray:
    """Return the weighted rises, NaN for neighbourhoods without vertices to compare.

    If paths along edges are straight in some directions only, few potentials come from there, and
    in an oblique vessel potentials never do. Then the greatest rise of the neighbours is included,
    and the rise that most neighbourhoods with about as many edges reach.
    """
    known = greatest > 0
    straight = np.divide(mean, greatest, out=np.ones_like(mean), where=known)
    crooked = known & (straight < MAX_MEAN_OF_LATTICES)
    others = np.where(near & crooked[:, None] & crooked, greatest, 0.0)
    has_crooked = crooked.any()
    kind = np.where(alike & crooked[:, None] & crooked, greatest, np.nan)
    usual = np.zeros_like(greatest)
    if has_crooked:
        usual[crooked] = np.nanquantile(kind[crooked], QUANTILE_OF_RISE, axis=1)
    greatest = np.where(known, np.maximum(np.maximum(greatest, others.max(axis=1)), usual), np.nan)
    weight = WEIGHT_OF_MEAN_RISE * np.clip(
        (straight - MAX_MEAN_OF_LATTICES) / (MIN_MEAN_OF_RANDOM_SAMPLES - MAX_MEAN_OF_LATTICES),
        0,
        1,
    )
    return np.asarray(greatest * (1 - weight) + mean * weight)


def _smoothed_over_graph(matrix: Any, cells: IntArray, found: FloatArray) -> FloatArray:
    """Return the values of cells at all vertices, smoothed along edges; 1 without edges."""
    known = np.isfinite(found)
    if not known.any():
        return np.ones(matrix.shape[0])
    logs = np.log(np.where(known, found, np.median(found[known])))
    values = np.where(cells >= 0, logs[cells], np.median(logs))
    degree = np.diff(matrix.indptr)
    rows = np.repeat(np.arange(len(degree)), degree)
    for _ in range(3):
        around = np.bincount(rows, values[matrix.indices], len(degree))
        values = (values + around) / (1 + degree)
    return np.asarray(np.where(degree > 0, np.exp(values), 1.0))
