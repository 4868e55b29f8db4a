"""Curves: points whose neighbours lie only ahead of them and behind them."""

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.geometry.components import connected_by_edges

__all__ = ["MIN_COSINE_AHEAD", "curve_links", "directions", "largest_chain", "lie_on_lines"]

NEIGHBOURS_ALONG_LINE = 6
"""Neighbours that have to be on one line with a point: three before and three behind."""

MAX_VARIANCE_ACROSS_LINES = 0.05
"""Maximum variance across these neighbours and the point, relative to that along them, on a line.
Seven points of a line have 0.02 with noise of a third of their spacing, of a circle of 40 points
0.01; the median of points that are drawn at random from a surface is 0.4."""

NEIGHBOURS_TO_NEXT_POINT = 12
"""Neighbours among which the next point of a curve is searched. On a line sampled at random, one
point in 2,000 has all of them on one side."""

MIN_COSINE_AHEAD = 0.8
"""Minimum cosine of the angle between the direction of a curve and its next point. The next turn of
a helix, five spacings away, is not within 37 degrees of it among these neighbours."""

N_PROBES = 2000
"""Points at which lines of a cloud are searched first."""

MIN_SHARE_OF_PROBES = 0.05
"""Minimum share of the probes on lines at which all points are checked. Measured: it is 0.3 % on
clouds drawn at random from surfaces."""


def lie_on_lines(points: FloatArray, near: IntArray) -> BoolArray:
    """Return a mask (N,) of the points whose nearest neighbours are on one line.

    It is all False if this holds for less than :data:`MIN_SHARE_OF_PROBES` of the probes.

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
    near : ndarray of shape (N, k), int64
        Nearest first.
    """
    count = len(points)
    result = np.zeros(count, dtype=np.bool_)
    if count == 0 or near.shape[1] < NEIGHBOURS_ALONG_LINE:
        return result
    probes = np.linspace(0, count - 1, min(N_PROBES, count)).astype(np.int64)
    if directions(points, near[probes], probes)[1].mean() >= MIN_SHARE_OF_PROBES:
        result = directions(points, near, np.arange(count))[1]
    return result


def curve_links(points: FloatArray, near: IntArray, chosen: IntArray) -> IntArray:
    """Return the edges (L, 2) from chosen points of curves to the next points on either side.

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
    near : ndarray of shape (N, k), int64
        Nearest first.
    chosen : ndarray of shape (M,), int64
    """
    if near.shape[1] == 0 or len(chosen) == 0:
        return np.empty((0, 2), dtype=np.int64)
    near = near[chosen, :NEIGHBOURS_TO_NEXT_POINT]
    axes, certain = directions(points, near, chosen)
    offsets = points[near] - points[chosen][:, None]
    offsets /= np.linalg.norm(offsets, axis=2, keepdims=True)
    axes[~certain] = offsets[~certain, 0]
    along = np.einsum("nkd,nd->nk", offsets, axes)
    ends = [near[:, 0]]
    starts = [chosen]
    for side in (along > MIN_COSINE_AHEAD, along < -MIN_COSINE_AHEAD):
        there = side.any(axis=1)
        ends.append(near[there, side[there].argmax(axis=1)])
        starts.append(chosen[there])
    links = np.column_stack([np.concatenate(starts), np.concatenate(ends)])
    return np.unique(np.sort(links, axis=1), axis=0)


def largest_chain(points: FloatArray, near: IntArray, on_lines: BoolArray) -> float:
    """Return the share of the points that the longest curve holds.

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
    near : ndarray of shape (N, k), int64
        Nearest first.
    on_lines : ndarray of shape (N,), bool
    """
    links = curve_links(points, near, np.flatnonzero(on_lines))
    if len(links) == 0:
        return 0.0
    return float(np.bincount(connected_by_edges(links, len(points))).max() / len(points))


def directions(
    points: FloatArray, near: IntArray, chosen: IntArray
) -> tuple[FloatArray, BoolArray]:
    """Return the directions in which neighbourhoods extend most, (M, 3), and a mask of lines.

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
    near : ndarray of shape (M, k), int64
        Neighbours of the chosen points, nearest first.
    chosen : ndarray of shape (M,), int64
    """
    places = points[np.column_stack([chosen, near[:, :NEIGHBOURS_ALONG_LINE]])]
    places -= places.mean(axis=1, keepdims=True)
    spread, axes = np.linalg.eigh(places.transpose(0, 2, 1) @ places)
    lines = (spread[:, 1] <= MAX_VARIANCE_ACROSS_LINES * spread[:, 2]) & (
        near.shape[1] >= NEIGHBOURS_ALONG_LINE
    )
    return np.ascontiguousarray(axes[:, :, 2]), np.asarray(lines)
