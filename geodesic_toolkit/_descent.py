"""The compiled right-hand side of the Poisson step, for linear functions on triangles.

Gradient, normalisation and divergence of :class:`~geodesic_toolkit.ElementGradient` in one pass:
nothing of the size of the faces is written.
"""

import math

import numba
import numpy as np
from numba import types

from geodesic_toolkit._typing import FloatArray, IntArray

__all__ = ["descent_load", "descent_loads"]

TINY = 1e-300
"""Differences of heat below it are taken for no slope at all."""

# One signature each, of arrays that are only read: those that may be written to fit as well.
kernel = numba.njit
options = {"cache": True, "nogil": True, "error_model": "numpy"}
ELEMENTS = types.Array(types.int64, 2, "C", readonly=True)
TABLE = types.Array(types.float64, 2, "C", readonly=True)
VALUES = types.Array(types.float64, 1, "C", readonly=True)


@kernel(  # type: ignore[untyped-decorator]
    types.void(ELEMENTS, TABLE, VALUES, VALUES, types.boolean, types.float64[::1]), **options
)
def descent_load(  # noqa: PLR0917 - kernels take no keywords
    elements: IntArray,
    inverse_frames: FloatArray,
    measure: FloatArray,
    heat: FloatArray,
    logarithmic: bool,
    load: FloatArray,
) -> None:
    """Add ``Gᵀ W X`` with ``X = -∇u/|∇u|`` to `load`, (N,), from u or, if `logarithmic`, log u.

    On a triangle with the values u₀, u₁, u₂ and the inverse frame (p, q, r) the gradient is
    ``(p (u₁ - u₀), q (u₁ - u₀) + r (u₂ - u₀))``. Its direction does not change if the differences
    are divided by the larger one, and then nothing underflows.
    """
    for e in range(len(elements)):
        i, j, k = elements[e, 0], elements[e, 1], elements[e, 2]
        origin, first, second = heat[i], heat[j], heat[k]
        if logarithmic:
            largest = max(origin, first, second)
            if largest == -math.inf:
                continue
            origin = math.exp(origin - largest)
            first = math.exp(first - largest)
            second = math.exp(second - largest)
        first -= origin
        second -= origin
        scale = 1 / max(abs(first), abs(second), TINY)
        first *= scale
        second *= scale
        p, q, r = inverse_frames[e, 0], inverse_frames[e, 1], inverse_frames[e, 2]
        x, y = p * first, q * first + r * second
        weight = -measure[e] / math.sqrt(max(x * x + y * y, TINY))
        to_first, to_second = weight * (p * x + q * y), weight * (r * y)
        load[i] -= to_first + to_second
        load[j] += to_first
        load[k] += to_second


@kernel(  # type: ignore[untyped-decorator]
    types.void(ELEMENTS, TABLE, VALUES, TABLE, types.boolean, types.float64[:, ::1]), **options
)
def descent_loads(  # noqa: PLR0917 - kernels take no keywords
    elements: IntArray,
    inverse_frames: FloatArray,
    measure: FloatArray,
    heat: FloatArray,
    logarithmic: bool,
    loads: FloatArray,
) -> None:
    """Do as `descent_load` with K columns at once, (N, K): its lines in loops over the columns.

    Loops without branches that write to one row each are what compiles to vector instructions.
    """
    columns = heat.shape[1]
    first, second = np.empty(columns), np.empty(columns)
    for e in range(len(elements)):
        i, j, k = elements[e, 0], elements[e, 1], elements[e, 2]
        p, q, r = inverse_frames[e, 0], inverse_frames[e, 1], inverse_frames[e, 2]
        area = -measure[e]
        at_i, at_j, at_k = heat[i], heat[j], heat[k]
        if logarithmic:
            for c in range(columns):
                largest = max(at_i[c], at_j[c], at_k[c])
                if largest == -math.inf:
                    largest = 0.0
                origin = math.exp(at_i[c] - largest)
                first[c] = math.exp(at_j[c] - largest) - origin
                second[c] = math.exp(at_k[c] - largest) - origin
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
