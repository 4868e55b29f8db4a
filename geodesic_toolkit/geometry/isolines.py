"""Level sets of functions that are linear on triangles, as chains of segments."""

from typing import NamedTuple

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["Chain", "level_set"]

MIN_RELATIVE_OFFSET_FROM_VERTICES = 1e-12
"""Minimum offset of values at vertices from the level, relative to the largest value, so that a
level set crosses edges only."""


class Chain(NamedTuple):
    """A connected part of a level set, as a chain of segments between edges.

    Attributes
    ----------
    faces : ndarray of shape (P,), int64
        A face of each point: that of the next segment, or of the last one at the end.
    weights : ndarray of shape (P, 3), float64
        The points in barycentric coordinates of these faces.
    closed : bool
        True if the last point is joined to the first.
    """

    faces: IntArray
    weights: FloatArray
    closed: bool


def level_set(faces: IntArray, values: FloatArray, level: float = 0.0) -> list[Chain]:
    """Return the level set of a function, with larger values on its left.

    Parameters
    ----------
    faces : ndarray of shape (F, 3), int64
        Counterclockwise, seen from the side that defines left. Faces with a value that is not
        finite are skipped.
    values : ndarray of shape (N,), float64
    level : float

    Returns
    -------
    list of Chain

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.geometry.isolines import level_set
    >>> (chain,) = level_set(np.array([[0, 1, 2]]), np.array([1.0, -1.0, -1.0]))
    >>> chain.weights
    array([[0.5, 0.5, 0. ],
           [0.5, 0. , 0.5]])
    """
    entries, exits, crossed, begins, ends = _segments(faces, values, level)
    following = {int(edge): segment for segment, edge in enumerate(entries)}
    beginnings = ~np.isin(entries, exits)
    done = np.zeros(len(entries), dtype=np.bool_)
    chains = []
    for first in (*np.flatnonzero(beginnings).tolist(), *range(len(entries))):
        if done[first]:
            continue
        own, at = [], first
        while at is not None and not done[at]:
            done[at] = True
            own.append(at)
            at = following.get(int(exits[at]))
        closed = at == first
        on = crossed[own], begins[own]
        if not closed:
            on = np.append(on[0], on[0][-1]), np.concatenate([on[1], ends[own[-1:]]])
        chains.append(Chain(*on, closed))
    return chains


def _segments(
    faces: IntArray, values: FloatArray, level: float
) -> tuple[IntArray, IntArray, IntArray, FloatArray, FloatArray]:
    """Return the segments: their entry and exit edges, faces, and both ends."""
    count = len(values)
    off = np.asarray(values - level)
    finite = np.isfinite(off)
    aside = MIN_RELATIVE_OFFSET_FROM_VERTICES * max(
        float(np.abs(off[finite]).max(initial=0.0)), np.finfo(np.float64).tiny
    )
    off = np.where(np.abs(off) < aside, aside, off)
    above = off > 0
    number = above[faces].sum(axis=1)
    mixed = (number == 1) | (number == 2)
    crossed = np.flatnonzero(mixed & finite[faces].all(axis=1))
    corners = faces[crossed]
    rows = np.arange(len(crossed))
    sides = []
    for falls in (True, False):  # the line enters at the edge with falling values
        tail = above[corners] == falls
        head = above[np.roll(corners, -1, axis=1)] != falls
        c = (tail & head).argmax(axis=1)
        i, j = corners[rows, c], corners[rows, (c + 1) % 3]
        share = off[i] / (off[i] - off[j])
        weights = np.zeros((len(crossed), 3))
        weights[rows, c], weights[rows, (c + 1) % 3] = 1 - share, share
        sides.append((np.minimum(i, j) * count + np.maximum(i, j), weights))
    (entries, begins), (exits, ends) = sides
    return entries, exits, crossed, begins, ends
