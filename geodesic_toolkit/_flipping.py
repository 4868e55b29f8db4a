"""The compiled edge flips of :mod:`geodesic_toolkit.geometry.intrinsic`.

The twin of a half-edge, on the other side of its edge, runs back. Half-edges have the numbers that
:mod:`geodesic_toolkit._sides` gives them.
"""

import math
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from geodesic_toolkit._compiled import kernel, part
from geodesic_toolkit._pointers import pointer, prefetch, shifted
from geodesic_toolkit._sides import SIDES, Sides
from geodesic_toolkit._typing import BoolArray, FloatArray, IndexArray, IntArray

__all__ = ["flip_edges", "twins"]

HELPERS = "9c48fa060695d630"
"""Digest of what else is compiled into the kernels: Numba looks at this file only."""

TOLERANCE = 1e-10
"""Sum of two cotangents below zero, over that of 1 and their sizes, from which on an edge is
flipped: no rounding must flip it back."""

NONE, ONE, AGAINST, ALONG, MORE = range(5)
"""Half-edges between two vertices: none, one, two that run against or along one another, more."""

FLAGS = types.Array(types.boolean, 1, "C", readonly=True)


def twins(sides: Sides) -> tuple[IntArray, bool]:
    """Return the twin of each half-edge, and whether they run against each other everywhere.

    Only the two half-edges of an edge that has just two are twins; the others have -1.
    """
    found, n_vertices = np.empty(len(sides.halves), dtype=np.int64), len(sides.starts) - 1
    first, met = np.empty(n_vertices, dtype=np.int32), np.zeros(n_vertices, dtype=np.int8)
    coherent = _pair(sides.starts, sides.halves, found, first, met)
    return found, coherent


@kernel(types.boolean(types.int32[::1], SIDES, types.int64[::1], types.int32[::1], types.int8[::1]))
def _pair(
    starts: IndexArray,
    halves: NDArray[Any],
    found: IntArray,
    first_met: IndexArray,
    met: NDArray[np.int8],
) -> bool:
    """Write the twins to `found`, and return whether they run against each other.

    The rest is to work in: `first_met` and `met`, (N,), of which the latter is zero before.
    """
    start, twin, first, seen = pointer(starts), pointer(found), pointer(first_met), pointer(met)
    coherent = True
    for v in range(met.size):
        for place in range(start[v], start[v + 1]):
            signed, other = halves[place].half, halves[place].head
            half = max(signed, ~signed)
            prefetch(shifted(twin, np.int64(half)))
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
            other = halves[place].head
            coherent &= seen[other] != ALONG
            seen[other] = NONE
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
    known, length, mate = 0, pointer(lengths), pointer(twin)
    for half in range(0, len(twin), 3):
        one, two, three = length[half], length[half + 1], length[half + 2]
        one, two, three = one * one, two * two, three * three
        for side, square, others in (
            (half, one, two + three),
            (half + 1, two, three + one),
            (half + 2, three, one + two),
        ):
            if square > others and mate[side] >= 0:
                waiting[known], is_waiting[side] = side, True
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
