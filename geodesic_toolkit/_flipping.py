"""The compiled edge flips of :mod:`geodesic_toolkit.geometry.intrinsic`.

Half-edge ``3 f + c`` is the side of face f opposite its corner c. It runs from corner c + 1 to
corner c + 2, and its twin, on the other side of the edge, runs back.
"""

import math

import numpy as np
from numba import types
from numpy.typing import NDArray

from geodesic_toolkit._compiled import kernel, part
from geodesic_toolkit._pointers import pointer, prefetch, shifted
from geodesic_toolkit._typing import BoolArray, FloatArray, IndexArray, IntArray

__all__ = ["flip_edges", "twins"]

HELPERS = "05e4ccb5caf08178"
"""Digest of what else is compiled into the kernels: Numba looks at this file only."""

TOLERANCE = 1e-10
"""Sum of two cotangents below zero, over that of 1 and their sizes, from which on an edge is
flipped: no rounding must flip it back."""

NONE, ONE, AGAINST, ALONG, MORE = range(5)
"""Half-edges between two vertices: none, one, two that run against or along one another, more."""

FACES = types.Array(types.int64, 2, "C", readonly=True)
FLAGS = types.Array(types.boolean, 1, "C", readonly=True)


def twins(faces: IntArray, n_vertices: int) -> tuple[IntArray, bool]:
    """Return the twin of each half-edge, and whether they run against each other everywhere.

    Only the two half-edges of an edge that has just two are twins; the others have -1.
    """
    sides = faces.size
    found, starts = np.empty(sides, dtype=np.int64), np.zeros(n_vertices + 1, dtype=np.int64)
    gathered, ends = np.empty(sides, dtype=np.int64), np.empty(sides, dtype=np.int32)
    free, met = np.empty(n_vertices, dtype=np.int64), np.zeros(n_vertices, dtype=np.int8)
    coherent = _pair(faces, found, starts, gathered, ends, free, met)
    return found, coherent


@kernel(
    types.boolean(
        FACES, *(types.int64[::1],) * 3, types.int32[::1], types.int64[::1], types.int8[::1]
    )
)
def _pair(  # noqa: PLR0917 - kernels take no keywords
    faces: IntArray,
    found: IntArray,
    starts: IntArray,
    halves: IntArray,
    others: IndexArray,
    taken: IntArray,
    met: NDArray[np.int8],
) -> bool:
    """Write the twins to `found`, and return whether they run against each other.

    The rest is to work in: `starts` (N + 1,) and `met` (N,) are zero before, `halves` and `others`
    have the size of the faces, `taken` is (N,).
    """
    sides, n_vertices = faces.size, met.size
    corner, start, free = pointer(faces), pointer(starts), pointer(taken)
    for f in range(0, sides, 3):
        i, j, k = corner[f], corner[f + 1], corner[f + 2]
        start[min(j, k) + 1] += 1
        start[min(k, i) + 1] += 1
        start[min(i, j) + 1] += 1
    for v in range(n_vertices):
        free[v] = start[v]
        start[v + 1] += start[v]

    # Half-edges by their vertex of lower index, and ~half for those that run down to it.
    gathered, end = pointer(halves), pointer(others)
    half = 0
    for f in range(0, sides, 3):
        i, j, k = corner[f], corner[f + 1], corner[f + 2]
        for tail, head in ((j, k), (k, i), (i, j)):
            low = min(tail, head)
            place = free[low]
            gathered[place], end[place] = half if tail < head else ~half, max(tail, head)
            free[low] = place + 1
            half += 1

    twin, first, seen = pointer(found), free, pointer(met)
    coherent = True
    for v in range(n_vertices):
        for place in range(start[v], start[v + 1]):
            signed, other = gathered[place], end[place]
            half = max(signed, ~signed)
            prefetch(shifted(twin, half))
            twin[half] = -1
            if seen[other] == NONE:
                first[other], seen[other] = signed, ONE
                continue
            mate = max(first[other], ~first[other])
            if seen[other] == ONE:
                twin[half], twin[mate] = mate, half
                seen[other] = AGAINST if (first[other] < 0) != (signed < 0) else ALONG
            else:
                if twin[mate] >= 0:
                    twin[twin[mate]] = twin[mate] = -1
                seen[other] = MORE
        for place in range(start[v], start[v + 1]):
            coherent &= seen[end[place]] != ALONG
            seen[end[place]] = NONE
    return coherent


@part()
def _doubled_area(p: float, q: float, r: float) -> float:
    """Return twice the area by Kahan's order of Heron's formula, which does not cancel."""
    a, c = max(p, q, r), min(p, q, r)
    b = max(min(p, q), min(max(p, q), r))
    product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    return math.sqrt(max(product, 0.0)) / 2


@part()
def _first_to_look_at(
    lengths: FloatArray, twin: IntArray, waiting: IntArray, is_waiting: BoolArray
) -> int:
    """Write the half-edges opposite obtuse angles, one of which is in any two of more than π."""
    known = 0
    for half in range(len(twin)):
        f, c = half // 3, half % 3
        side, one, other = lengths[f, c], lengths[f, (c + 1) % 3], lengths[f, (c + 2) % 3]
        if twin[half] >= 0 and side * side > one * one + other * other:
            waiting[known] = half
            is_waiting[half] = True
            known += 1
    return known


def flip_edges(faces: IntArray, lengths: FloatArray, twin: IntArray, held: BoolArray) -> int:
    """Flip edges until none has opposite angles of more than π together; return how many.

    Edges at vertices that are `held`, (N,), stay. The other arrays change in place.
    """
    waiting, is_waiting = np.empty_like(twin), np.zeros(len(twin), dtype=bool)
    return _flip(faces, lengths, twin, held, waiting, is_waiting, np.empty((3, 4), dtype=np.int64))


@kernel(
    types.int64(
        types.int64[:, ::1],
        types.float64[:, ::1],
        types.int64[::1],
        FLAGS,
        types.int64[::1],
        types.boolean[::1],
        types.int64[:, ::1],
    )
)
def _flip(  # noqa: PLR0917 - kernels take no keywords
    faces: IntArray,
    lengths: FloatArray,
    twin: IntArray,
    held: BoolArray,
    waiting: IntArray,
    is_waiting: BoolArray,
    room: IntArray,
) -> int:
    """Do so. Half-edges that wait to be looked at are on a stack.

    Whatever a flip may have spoilt goes there again, under the name that it has after the flip.
    """
    known = _first_to_look_at(lengths, twin, waiting, is_waiting)
    flips = 0
    old, new, across = room[0], room[1], room[2]
    while known > 0:
        known -= 1
        half = waiting[known]
        is_waiting[half] = False
        mate = twin[half]
        if mate < 0 or mate // 3 == half // 3:
            continue
        f, c, g, d = half // 3, half % 3, mate // 3, mate % 3
        old[0], old[1] = 3 * g + (d + 1) % 3, 3 * f + (c + 2) % 3  # ad and ca, b opposite both
        old[2], old[3] = 3 * f + (c + 1) % 3, 3 * g + (d + 2) % 3  # bc and db, a opposite both
        if held[faces[f, (c + 1) % 3]] or held[faces[f, (c + 2) % 3]]:
            continue
        ab, bc, ca = lengths[f, c], lengths[f, (c + 1) % 3], lengths[f, (c + 2) % 3]
        ad, db = lengths[g, (d + 1) % 3], lengths[g, (d + 2) % 3]
        above, below = _doubled_area(ab, bc, ca), _doubled_area(ab, ad, db)
        # Twice the cotangents at c and d, times the doubled area of each triangle.
        at_c, at_d = bc * bc + ca * ca - ab * ab, ad * ad + db * db - ab * ab
        at_c, at_d = at_c * below, at_d * above
        if not at_c + at_d < -TOLERANCE * (above * below + abs(at_c) + abs(at_d)):
            continue
        x = ((ca - bc) * (ca + bc) - (ad - db) * (ad + db)) / (2 * ab)
        y = (above + below) / ab
        cd = math.sqrt(x * x + y * y)
        at = faces[f, (c + 1) % 3], faces[f, (c + 2) % 3], faces[f, c], faces[g, d]
        faces[f, 0], faces[f, 1], faces[f, 2] = at[2], at[0], at[3]
        faces[g, 0], faces[g, 1], faces[g, 2] = at[3], at[1], at[2]
        lengths[f, 0], lengths[f, 1], lengths[f, 2] = ad, cd, ca
        lengths[g, 0], lengths[g, 1], lengths[g, 2] = bc, cd, db
        new[0], new[1], new[2], new[3] = 3 * f, 3 * f + 2, 3 * g, 3 * g + 2
        for side in range(4):
            across[side] = twin[old[side]]
            for moved in range(4):
                if twin[old[side]] == old[moved]:
                    across[side] = new[moved]
        for side in range(4):
            twin[new[side]] = across[side]
            if across[side] >= 0:
                twin[across[side]] = new[side]
                if not is_waiting[new[side]]:
                    is_waiting[new[side]] = True
                    waiting[known] = new[side]
                    known += 1
        twin[3 * f + 1], twin[3 * g + 1] = 3 * g + 1, 3 * f + 1
        flips += 1
    return flips
