"""The compiled sorting of the sides of triangles by the vertices at their ends.

Half-edge ``3 f + c`` is the side of face f opposite its corner c. It runs from corner c + 1 to
corner c + 2. Those of one edge meet at its vertex of lower index: there stiffness adds them up, and
edge flips find who is whose twin.
"""

from typing import Any, NamedTuple

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

from geodesic_toolkit._compiled import kernel
from geodesic_toolkit._pointers import pointer, prefetch, shifted
from geodesic_toolkit._typing import IndexArray, IntArray

__all__ = ["SIDE", "SIDES", "Sides", "sorted_sides"]

HELPERS = "a66f349ab98391e9"
"""Digest of what else is compiled into the kernels: Numba looks at this file only."""

SIDE = np.dtype([("head", np.int32), ("half", np.int32)])
"""A half-edge as the end of lower index has it: the other end and the number of the half-edge, or
``~number`` where it runs down from there."""

AHEAD = 48
"""Corners by which memory is asked for ahead: half-edges go to places in no order."""

FACES = types.Array(types.int64, 2, "C", readonly=True)
SIDES = numba.from_dtype(SIDE)[::1]


class Sides(NamedTuple):
    """The half-edges of triangles: those of vertex v are ``halves[starts[v]:starts[v + 1]]``.

    They are in the order of the triangles.
    """

    starts: IndexArray
    halves: NDArray[Any]


def sorted_sides(faces: IntArray, n_vertices: int) -> Sides:
    """Return the half-edges of `faces`, (F, 3), by their vertices of lower index.

    There must be fewer than 2³¹ of them.
    """
    starts, halves = np.zeros(n_vertices + 1, dtype=np.int32), np.empty(faces.size, dtype=SIDE)
    _sort(faces, starts, np.empty(n_vertices, dtype=np.int32), halves)
    return Sides(starts, halves)


@kernel(types.void(FACES, *(types.int32[::1],) * 2, SIDES))
def _sort(faces: IntArray, starts: IndexArray, room: IndexArray, halves: NDArray[Any]) -> None:
    """Do so; `starts`, (N + 1,), is zero before, and `room`, (N,), to work in."""
    sides, n_vertices = faces.size, room.size
    corner, start, free = pointer(faces), pointer(starts), pointer(room)
    for f in range(0, sides, 3):
        i, j, k = corner[f], corner[f + 1], corner[f + 2]
        start[min(j, k) + 1] += 1
        start[min(k, i) + 1] += 1
        start[min(i, j) + 1] += 1
    for v in range(n_vertices):
        free[v] = start[v]
        start[v + 1] += start[v]
    half, place_of = 0, pointer(halves)
    for f in range(0, sides, 3):
        soon = min(f + AHEAD, sides - 3)
        a, b, c = corner[soon], corner[soon + 1], corner[soon + 2]
        prefetch(shifted(place_of, np.int64(free[min(b, c)])))
        prefetch(shifted(place_of, np.int64(free[min(c, a)])))
        prefetch(shifted(place_of, np.int64(free[min(a, b)])))
        i, j, k = corner[f], corner[f + 1], corner[f + 2]
        for tail, head in ((j, k), (k, i), (i, j)):
            low = min(tail, head)
            place = free[low]
            halves[place].head = max(tail, head)
            halves[place].half = half if tail < head else ~half
            free[low] = place + 1
            half += 1
