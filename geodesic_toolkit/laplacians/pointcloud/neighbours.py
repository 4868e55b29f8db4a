"""Distinct points and their nearest neighbours, by SciPy."""

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.geometry.threads import threads_for

__all__ = [
    "RELATIVE_GRID_WIDTH",
    "along_curve",
    "distinct_points",
    "nearest_among",
    "nearest_neighbours",
    "normalised",
]

POINTS_PER_QUERY = 100_000
"""Points in one query for neighbours: the distances, which are not kept, take as much memory as the
neighbours do."""

BIT_SPREADING_STEPS = (
    (32, 0x1F00000000FFFF),
    (16, 0x1F0000FF0000FF),
    (8, 0x100F00F00F00F00F),
    (4, 0x10C30C30C30C30C3),
    (2, 0x1249249249249249),
)
"""Shifts and masks that put two zeros between any two of 21 bits."""

RELATIVE_GRID_WIDTH = 2.0**-36
"""Points closer than this share of the cloud's size are merged, because later steps divide by
distances."""


def normalised(points: FloatArray, present: BoolArray) -> tuple[FloatArray, float]:
    """Return the present points relative to the middle of their box, and the scale of the result.

    The coordinates of the result lie in [-1, 1], on a grid of step :data:`RELATIVE_GRID_WIDTH`:
    surveyors' coordinates of millions lose their common part before anything is squared, sizes do
    not overflow or underflow, and points that differ by rounding alone become equal.

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
    present : ndarray of shape (N,), bool

    Returns
    -------
    points : ndarray of shape (P, 3), float64
    scale : float
        Half the longest side of the box; 1 if all points are equal.
    """
    chosen = points[present]
    low, high = chosen.min(axis=0), chosen.max(axis=0)
    scale = float((high / 2 - low / 2).max()) or 1.0
    centred = (chosen - (low / 2 + high / 2)) / scale
    return np.round(centred / RELATIVE_GRID_WIDTH) * RELATIVE_GRID_WIDTH, scale


def distinct_points(points: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the first point at each position, and the position of every point.

    Parameters
    ----------
    points : ndarray of shape (P, 3), float64

    Returns
    -------
    first : ndarray of shape (D,), int64
        Ascending, so that the distinct points keep their order.
    place : ndarray of shape (P,), int64
        ``points[first[place]]`` equals ``points``.
    """
    order = np.lexsort(points.T)
    ordered = points[order]
    new = np.ones(len(points), dtype=np.bool_)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    group = np.cumsum(new) - 1
    first = np.minimum.reduceat(order, np.flatnonzero(new))
    ascending = np.argsort(first)
    group_number = np.empty(len(first), dtype=np.int64)
    group_number[ascending] = np.arange(len(first))
    place = np.empty(len(points), dtype=np.int64)
    place[order] = group_number[group]
    return first[ascending], place


def along_curve(points: FloatArray) -> IntArray:
    """Return the order of points of :func:`normalised` along a Z-curve, of shape (N,).

    References
    ----------
    G. M. Morton, *A computer oriented geodetic data base*, IBM, 1966
    """
    cells = ((points + 1) * (2**20 - 1) / 2).astype(np.uint64)
    code = np.zeros(len(points), dtype=np.uint64)
    for axis in range(3):
        bits = cells[:, axis]
        for shift, mask in BIT_SPREADING_STEPS:
            bits = (bits | (bits << np.uint64(shift))) & np.uint64(mask)
        code |= bits << np.uint64(axis)
    return np.argsort(code, kind="stable")


def nearest_neighbours(points: FloatArray, k: int) -> IntArray:
    """Return the k nearest other points of every point, of shape (N, k), nearest first.

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
        Distinct.
    k : int
        Below N.
    """
    everything = np.arange(len(points))
    return nearest_among(points, everything, everything, k)


def nearest_among(points: FloatArray, kept: IntArray, queried: IntArray, k: int) -> IntArray:
    """Return the k nearest other points among some of them, of shape (M, k), nearest first.

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
        Distinct.
    kept : ndarray of shape (P,), int64
        Candidates for neighbours, ascending.
    queried : ndarray of shape (M,), int64
        Points whose neighbours are searched.
    k : int
        Below P.
    """
    from scipy.spatial import cKDTree

    tree = cKDTree(points if len(kept) == len(points) else points[kept])
    is_kept = np.zeros(len(points), dtype=np.bool_)
    is_kept[kept] = True
    result = np.empty((len(queried), k), dtype=np.int64)
    for begin in range(0, len(queried), POINTS_PER_QUERY):
        some = queried[begin : begin + POINTS_PER_QUERY]
        found = np.asarray(tree.query(points[some], k=k + 1, workers=threads_for(len(some)))[1])
        # A kept point finds itself first.
        near = np.where(is_kept[some][:, None], found[:, 1:], found[:, :-1])
        result[begin : begin + POINTS_PER_QUERY] = kept[near]
    return result
