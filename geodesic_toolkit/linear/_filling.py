"""The compiled form of :func:`geodesic_toolkit.linear.log_solve.fill_from_neighbours`."""

from numba import types

from geodesic_toolkit._compiled import kernel
from geodesic_toolkit._typing import FloatArray, IndexArray

__all__ = ["fill"]

HELPERS = "a1564d29fd4d43f9"
"""Digest of what else is compiled into the kernels: Numba looks at this file only."""

_indices = types.Array(types.int32, 1, "C", readonly=True)
_values = types.Array(types.float64, 1, "C", readonly=True)


@kernel(
    types.void(_indices, _indices, _values, types.float64[:], types.int32[::1], types.float64[::1])
)
def fill(  # noqa: PLR0917 - kernels take no keywords
    indptr: IndexArray,
    indices: IndexArray,
    data: FloatArray,
    solution: FloatArray,
    rows: IndexArray,
    means: FloatArray,
) -> None:
    """Fill the entries `rows` of u, which are 0, from neighbours with a value, ring by ring.

    `rows` is changed; `means` is as long and may hold anything.
    """
    left = len(rows)
    while True:
        for m in range(left):
            mass, total, found, known = 0.0, 0.0, 0.0, False
            for entry in range(indptr[rows[m]], indptr[rows[m] + 1]):
                neighbour, value = indices[entry], data[entry]
                mass += value
                if neighbour != rows[m] and value != 0:
                    total += abs(value)
                    if solution[neighbour] > 0:
                        found += abs(value) * solution[neighbour]
                        known = True
            means[m] = found / (abs(mass) + total) if known else -1.0
        waiting = 0
        for m in range(left):  # now that no row looks at its neighbours any more
            if means[m] < 0:
                rows[waiting] = rows[m]
                waiting += 1
            else:
                solution[rows[m]] = means[m]
        if waiting == left:
            return
        left = waiting
