"""Level sets of functions that are linear on triangles, as chains of segments."""

from typing import NamedTuple

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["Chain", "level_set"]

ASIDE = 1e-12
"""Share of the largest value by which a level set keeps off vertices: it goes through edges."""


class Chain(NamedTuple):
    """A part of a level set, from one edge that it crosses to the next.

    Attributes
    ----------
    faces : ndarray of shape (P,), int64
        A face with each of the points: the one that the next segment lies in, or the last one did.
    weights : ndarray of shape (P, 3), float64
        The points in barycentric coordinates of those faces.
    closed : bool
        Whether the last point is joined to the first.
    """

    faces: IntArray
    weights: FloatArray
    closed: bool


def level_set(faces: IntArray, values: FloatArray, level: float = 0.0) -> list[Chain]:
    """Return where a function crosses a level, larger values on the left.

    Parameters
    ----------
    faces : ndarray of shape (F, 3), int64
        Counterclockwise, seen from where left is left. Faces with a value that is not finite are
        left out.
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
    """Return the segments: the edges that they come in by and leave by, faces, and both ends."""
    count = len(values)
    off = np.asarray(values - level)
    finite = np.isfinite(off)
    aside = ASIDE * max(float(np.abs(off[finite]).max(initial=0.0)), np.finfo(np.float64).tiny)
    off = np.where(np.abs(off) < aside, aside, off)
    above = off > 0
    number = above[faces].sum(axis=1)
    mixed = (number == 1) | (number == 2)
    crossed = np.flatnonzero(mixed & finite[faces].all(axis=1))
    corners = faces[crossed]
    rows = np.arange(len(crossed))
    sides = []
    for falls in (True, False):  # where the rim of the face goes down, the line comes in
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
