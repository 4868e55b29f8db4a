"""Distinct points and their nearest neighbours, by scikit-learn."""

import numpy as np

from geodesic_toolkit._typing import BoolArray, FloatArray, IntArray

__all__ = ["GRID", "distinct_points", "nearest_neighbours", "normalised"]

GRID = 2.0**-36
"""Points closer than this share of the cloud's size are one: what follows divides by distances."""


def normalised(points: FloatArray, present: BoolArray) -> tuple[FloatArray, float]:
    """Return the present points about the middle of their box, and the scale to multiply them by.

    The coordinates of the result lie in [-1, 1] and on a grid of step :data:`GRID`: surveyors'
    coordinates of millions lose their common part before anything is squared, no size over- or
    underflows, and points that differ by rounding alone become equal.

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
    present : ndarray of shape (N,), bool

    Returns
    -------
    points : ndarray of shape (P, 3), float64
    scale : float
        Half the longest side of the box; 1 where all points are one.
    """
    chosen = points[present]
    low, high = chosen.min(axis=0), chosen.max(axis=0)
    scale = float((high / 2 - low / 2).max()) or 1.0
    centred = (chosen - (low / 2 + high / 2)) / scale
    return np.round(centred / GRID) * GRID, scale


def distinct_points(points: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the first point of each place, and which place every point lies at.

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
    rank = np.empty(len(first), dtype=np.int64)
    rank[ascending] = np.arange(len(first))
    place = np.empty(len(points), dtype=np.int64)
    place[order] = rank[group]
    return first[ascending], place


def nearest_neighbours(points: FloatArray, k: int) -> IntArray:
    """Return the k nearest other points of every point, of shape (N, k), nearest first.

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
        Distinct.
    k : int
        Below N.
    """
    from sklearn.neighbors import NearestNeighbors  # heavy: more than a second

    search = NearestNeighbors(n_neighbors=k + 1, algorithm="kd_tree").fit(points)
    return np.asarray(search.kneighbors(n_neighbors=k, return_distance=False), dtype=np.int64)
