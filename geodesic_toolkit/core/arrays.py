"""Cheaper forms of the NumPy functions that the path from a mesh to its distances calls.

Arrays in memory that kernels use again, where NumPy would ask the system for fresh pages; and the
different numbers of an array without masked arrays, which take a tenth of a build to import.
"""

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit import _native

__all__ = ["copied", "distinct", "empty", "joined"]

Number = TypeVar("Number", np.float64, np.int64)


def empty(shape: tuple[int, ...], dtype: type[Number]) -> NDArray[Number]:
    """Return an array of numbers of 64 bits in which anything may stand."""
    size = 1
    for length in shape:
        size *= length
    return _native.empty(size).view(dtype).reshape(shape)


def copied(array: NDArray[Any], dtype: type[Number]) -> NDArray[Number]:
    """Return a C-ordered copy of an array, of another type perhaps, as ``numpy.array`` does."""
    result = empty(array.shape, dtype)
    np.copyto(result, array, casting="unsafe")
    return result


def distinct(values: NDArray[Number]) -> NDArray[Number]:
    """Return the different numbers of an array, sorted, as ``numpy.unique`` does."""
    ordered = np.sort(values, axis=None)
    first = np.ones(len(ordered), dtype=np.bool_)
    np.not_equal(ordered[1:], ordered[:-1], out=first[1:])
    return ordered[first]


def joined(parts: Sequence[NDArray[Number]]) -> NDArray[Number]:
    """Return arrays one after the other; a copy only if there are several."""
    return np.ascontiguousarray(parts[0] if len(parts) == 1 else np.concatenate(parts))
