"""The compiled right-hand side of the Poisson step, for linear functions on triangles.

Gradient, normalisation and divergence of :class:`~geodesic_toolkit.ElementGradient` in one pass:
nothing of the size of the faces is written.
"""

import math
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from geodesic_toolkit._compiled import kernel
from geodesic_toolkit._pointers import pointer
from geodesic_toolkit._typing import FloatArray, IndexArray, IntArray

__all__ = ["AT_ONCE", "descent_load", "descent_loads", "split"]

HELPERS = "a66f349ab98391e9"
"""Digest of what else is compiled into the kernels: Numba looks at this file only."""

LOG_2 = math.log(2)

TINY = 1e-300
"""Differences of heat below it are taken for no slope at all."""

NOTHING = -(2**30)
"""Power of two that stands for no heat at all."""

AT_ONCE = 64
"""Triangles at a time: their differences of heat stay in the first level of cache."""

# One signature each, of arrays that are only read: those that may be written to fit as well.
ELEMENTS = types.Array(types.int64, 2, "C", readonly=True)
TABLE = types.Array(types.float64, 2, "C", readonly=True)
VALUES = types.Array(types.float64, 1, "C", readonly=True)
POWERS = types.Array(types.int32, 1, "C", readonly=True)
POWER_TABLE = types.Array(types.int32, 2, "C", readonly=True)


@kernel(types.void(VALUES, types.float64[::1], types.int32[::1]))
def split(logarithms: FloatArray, fractions: FloatArray, powers: IndexArray) -> None:
    """Write u as ``fractions * 2**powers``, where `logarithms` are log u: doubles of any range.

    Fractions are at least 1 and less than 2; where there is no heat they are 0.
    """
    for v in range(len(logarithms)):
        power = logarithms[v] / LOG_2
        if power <= NOTHING:
            fractions[v], powers[v] = 0.0, NOTHING
        else:  # what is no number stays none
            whole = math.floor(power)
            fractions[v], powers[v] = math.exp((power - whole) * LOG_2), np.int32(whole)


@intrinsic  # type: ignore[untyped-decorator]
def _two_to(_context: Any, _power: Any) -> Any:
    """Return ``2**n``, n <= 0, and 0 where that is no normal number.

    The upper bits of such a double are n + 1023, and all others are 0.
    """

    def code(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        number = ir.IntType(64)
        upper = builder.add(arguments[0], number(1023))
        upper = builder.select(builder.icmp_signed(">", upper, number(0)), upper, number(0))
        return builder.bitcast(builder.shl(upper, number(52)), ir.DoubleType())

    return types.float64(types.int64), code


@kernel(
    types.void(ELEMENTS, TABLE, VALUES, VALUES, POWERS, types.float64[::1], types.float64[:, ::1])
)
def descent_load(  # noqa: PLR0917 - kernels take no keywords
    elements: IntArray,
    inverse_frames: FloatArray,
    measure: FloatArray,
    heat: FloatArray,
    powers: IndexArray,
    load: FloatArray,
    room: FloatArray,
) -> None:
    """Add ``Gᵀ W X`` with ``X = -∇u/|∇u|`` to `load`, (N,).

    u is `heat`, or ``heat * 2**powers`` if there are `powers`, of which only those matter that the
    corners of a triangle do not share. On a triangle with the values u₀, u₁, u₂ and the inverse
    frame (p, q, r) the gradient is ``(p (u₁ - u₀), q (u₁ - u₀) + r (u₂ - u₀))``. Its direction does
    not change if the differences are divided by the larger one, and then nothing underflows.

    A few triangles at a time: divisions and roots compile to vector instructions in a loop of their
    own, apart from vertices that triangles share. There is `room` of shape (2, K) for K of them.
    """
    corner, frame, area = pointer(elements), pointer(inverse_frames), pointer(measure)
    value, power, sums = pointer(heat), pointer(powers), pointer(load)
    first, second, at_once = pointer(room[0]), pointer(room[1]), room.shape[1]
    for begin in range(0, len(elements), at_once):
        count = min(at_once, len(elements) - begin)
        for c in range(count):
            e = 3 * (begin + c)
            i, j, k = corner[e], corner[e + 1], corner[e + 2]
            if powers.size:
                top = np.int64(max(power[i], power[j], power[k]))
                origin = value[i] * _two_to(power[i] - top)
                first[c] = value[j] * _two_to(power[j] - top) - origin
                second[c] = value[k] * _two_to(power[k] - top) - origin
            else:
                first[c], second[c] = value[j] - value[i], value[k] - value[i]
        for c in range(count):
            e = 3 * (begin + c)
            p, q, r = frame[e], frame[e + 1], frame[e + 2]
            scale = 1 / max(abs(first[c]), abs(second[c]), TINY)
            x = p * (first[c] * scale)
            y = q * (first[c] * scale) + r * (second[c] * scale)
            weight = -area[begin + c] / math.sqrt(max(x * x + y * y, TINY))
            first[c], second[c] = weight * (p * x + q * y), weight * (r * y)
        for c in range(count):
            e = 3 * (begin + c)
            sums[corner[e]] -= first[c] + second[c]
            sums[corner[e + 1]] += first[c]
            sums[corner[e + 2]] += second[c]


@kernel(types.void(ELEMENTS, TABLE, VALUES, TABLE, POWER_TABLE, *(types.float64[:, ::1],) * 2))
def descent_loads(  # noqa: PLR0917 - kernels take no keywords
    elements: IntArray,
    inverse_frames: FloatArray,
    measure: FloatArray,
    heat: FloatArray,
    powers: IndexArray,
    loads: FloatArray,
    room: FloatArray,
) -> None:
    """Do as `descent_load` with K columns at once, (N, K): its lines in loops over the columns.

    Loops without branches that write to one row each are what compiles to vector instructions.
    There is `room` of shape (2, K) to work in.
    """
    columns = heat.shape[1]
    first, second = room[0], room[1]
    for e in range(len(elements)):
        i, j, k = elements[e, 0], elements[e, 1], elements[e, 2]
        p, q, r = inverse_frames[e, 0], inverse_frames[e, 1], inverse_frames[e, 2]
        area = -measure[e]
        at_i, at_j, at_k = heat[i], heat[j], heat[k]
        if powers.size:
            by_i, by_j, by_k = powers[i], powers[j], powers[k]
            for c in range(columns):
                top = np.int64(max(by_i[c], by_j[c], by_k[c]))
                origin = at_i[c] * _two_to(by_i[c] - top)
                first[c] = at_j[c] * _two_to(by_j[c] - top) - origin
                second[c] = at_k[c] * _two_to(by_k[c] - top) - origin
        else:
            for c in range(columns):
                first[c] = at_j[c] - at_i[c]
                second[c] = at_k[c] - at_i[c]
        for c in range(columns):
            scale = 1 / max(abs(first[c]), abs(second[c]), TINY)
            x = p * (first[c] * scale)
            y = q * (first[c] * scale) + r * (second[c] * scale)
            weight = area / math.sqrt(max(x * x + y * y, TINY))
            first[c] = weight * (p * x + q * y)
            second[c] = weight * (r * y)
        load_i, load_j, load_k = loads[i], loads[j], loads[k]
        for c in range(columns):
            load_i[c] -= first[c] + second[c]
        for c in range(columns):
            load_j[c] += first[c]
        for c in range(columns):
            load_k[c] += second[c]
