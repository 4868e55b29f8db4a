"""Tears: gaps at which stars leave near points of one sheet unconnected.

The star of a point excludes triangles that reach past its neighbours, because these bridge the
outside of a boundary, or an empty region. If a surface is not much wider than the spacing, and
sampled at random, such a region is sometimes as wide as the surface, and the stars are disconnected
there: distances across the gap of a band of random points closed to a ring then follow the long
arc.
"""

from typing import Any

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.laplacians.pointcloud.curves import MIN_COSINE_AHEAD, directions

__all__ = ["bridges"]

N_NEAR = 12
"""Number of neighbours that are near. At the rim of a surface they lie within 2.8 spacings, and
points as near across a gap in a plane share a triangle anyway."""

MAX_SQUARED_SINE_ON_SHEET = 0.2
"""Square of the sine of the elevation up to which a neighbour lies on the sheet of a point: the
limit of a star for neighbours beyond the first (``kGrown`` in ``native/clouds/stars.cpp``)."""

MIN_SHARE_OF_OPEN_POINTS = 0.75
"""Minimum share of open points among the near ones on a line, or a narrow band."""

PAIRS_PER_BATCH = 50_000
"""Pairs that are checked at once: each has some forty points around either end."""


def bridges(
    points: FloatArray,
    normals: FloatArray,
    near: IntArray,
    edges: IntArray,
    is_open: BoolArray,
    *,
    oriented: bool,
    curved: BoolArray,
) -> IntArray:
    """Return links (L, 2) across tears, between near points more than four edges apart.

    Each open point is linked to the nearest such point, if both are near to each other, so that
    isolated points stay so, and each lies on the sheet of the other. If nearly all near points are
    open, normals are unreliable, and it is enough to lie ahead or behind; on curves normals are
    meaningless, and points have to lie ahead or behind.

    Parameters
    ----------
    points, normals : ndarray of shape (N, 3), float64
    near : ndarray of shape (N, k), int64
        Nearest first.
    edges : ndarray of shape (E, 2), int64
        Directed edges of the stars. Edges in one direction only do not connect.
    is_open : ndarray of shape (N,), bool
        Points that may have links.
    oriented : bool
        True if the signs of the normals are meaningful.
    curved : ndarray of shape (N,), bool
        Points on curves.
    """
    queried = np.flatnonzero(is_open)
    if len(queried) == 0 or near.shape[1] == 0:
        return np.empty((0, 2), dtype=np.int64)
    wider, near = near[:, : 2 * N_NEAR], near[queried, :N_NEAR]
    pairs = np.column_stack([queried.repeat(near.shape[1]), near.ravel()])  # of each nearest first
    agree = (wider[pairs[:, 1]] == pairs[:, :1]).any(axis=1)
    agree &= _share_a_sheet(points, normals, pairs, oriented) & ~curved[pairs].any(axis=1)
    narrow = is_open[near].mean(axis=1) >= MIN_SHARE_OF_OPEN_POINTS
    if narrow.any():
        agree |= _share_a_line(points, pairs, queried[narrow], near[narrow])
    pairs = pairs[agree]
    pairs = pairs[_are_far(pairs, edges, len(points), steps=2)]
    in_narrow = np.isin(pairs[:, 0], queried[narrow])  # the rest of the near points' steps
    in_narrow[in_narrow] = ~_are_far(pairs[in_narrow], edges, len(points), steps=N_NEAR // 2 + 1)
    pairs = pairs[~in_narrow]
    _, first = np.unique(pairs[:, 0], return_index=True)
    return np.unique(np.sort(pairs[first], axis=1), axis=0)


def _share_a_line(
    points: FloatArray, pairs: IntArray, narrow: IntArray, near: IntArray
) -> BoolArray:
    axes = np.zeros_like(points)
    axes[narrow] = directions(points, near, narrow)[0]
    steps = points[pairs[:, 1]] - points[pairs[:, 0]]
    least = MIN_COSINE_AHEAD**2 * np.einsum("nd,nd->n", steps, steps)
    return np.asarray(
        (np.einsum("nd,nd->n", steps, axes[pairs[:, 0]]) ** 2 >= least)
        & (np.einsum("nd,nd->n", steps, axes[pairs[:, 1]]) ** 2 >= least)
    )


def _share_a_sheet(
    points: FloatArray, normals: FloatArray, pairs: IntArray, oriented: bool
) -> BoolArray:
    steps = points[pairs[:, 1]] - points[pairs[:, 0]]
    most = MAX_SQUARED_SINE_ON_SHEET * np.einsum("nd,nd->n", steps, steps)
    one, other = normals[pairs[:, 0]], normals[pairs[:, 1]]
    flat = np.ones(len(pairs), dtype=np.bool_)
    for normal in (one, other):
        flat &= np.einsum("nd,nd->n", steps, normal) ** 2 <= most
    if oriented:
        flat &= np.einsum("nd,nd->n", one, other) > 0
    return flat


def _are_far(pairs: IntArray, edges: IntArray, n_points: int, *, steps: int) -> BoolArray:
    """Return a mask of the pairs that are more than ``2 * steps`` edges apart."""
    from scipy.sparse import csr_array

    if len(pairs) == 0:
        return np.zeros(0, dtype=np.bool_)
    about = np.zeros(n_points, dtype=np.bool_)  # within so many steps
    about[pairs] = True
    for _ in range(steps):
        about[edges[about[edges[:, 0]], 1]] = True
    edges = edges[about[edges[:, 0]] & about[edges[:, 1]]]
    ones = np.ones(len(edges), dtype=np.float32)
    adjacency: Any = csr_array((ones, tuple(edges.T)), shape=(n_points, n_points))
    queried, place = np.unique(pairs, return_inverse=True)
    place = place.reshape(pairs.shape)
    own = (np.ones(len(queried), dtype=np.float32), (np.arange(len(queried)), queried))
    reached: Any = csr_array(own, shape=(len(queried), n_points))  # from each
    adjacency = adjacency.multiply(adjacency.T).tocsr()
    for _ in range(steps):
        reached = reached + reached @ adjacency
        reached.data[:] = 1.0
    far = np.ones(len(pairs), dtype=np.bool_)
    for begin in range(0, len(pairs), PAIRS_PER_BATCH):
        some = slice(begin, begin + PAIRS_PER_BATCH)
        both = reached[place[some, 0]].multiply(reached[place[some, 1]])
        far[some] = both.sum(axis=1) == 0
    return far
