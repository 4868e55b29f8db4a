"""Checks that the data of a discretization share, and the form in which kernels take matrices."""

import numpy as np
from scipy.sparse import csr_array

from geodesic_toolkit._typing import FloatArray, IndexArray, IntArray
from geodesic_toolkit.errors import InvalidDiscretizationError, NotEnoughMemoryError

__all__ = ["MOST_ENTRIES", "check_finite", "check_range", "coerce", "compressed_rows"]

MOST_ENTRIES = np.iinfo(np.int32).max
"""Entries of a matrix that row pointers of 32 bits can count; half of its memory would be indices
otherwise."""


def compressed_rows(matrix: csr_array) -> tuple[IndexArray, IndexArray, FloatArray]:
    """Return row pointers, columns and values as kernels take them; no copy where they are so.

    Raises
    ------
    NotEnoughMemoryError
        There are more entries than 32 bits can count.
    """
    if matrix.nnz > MOST_ENTRIES:
        raise NotEnoughMemoryError(
            f"a matrix of {matrix.nnz} entries is too large: row pointers of 32 bits count "
            f"{MOST_ENTRIES}; thin out the shape, or work on its parts"
        )
    return (
        np.ascontiguousarray(matrix.indptr, dtype=np.int32),
        np.ascontiguousarray(matrix.indices, dtype=np.int32),
        np.ascontiguousarray(matrix.data, dtype=np.float64),
    )


def coerce(data: object, **dtypes: type[np.generic]) -> None:
    """Give the named attributes their dtype and C order; no copy where they have both."""
    for name, dtype in dtypes.items():
        try:
            array = np.ascontiguousarray(getattr(data, name), dtype=dtype)
        except (TypeError, ValueError) as error:
            raise InvalidDiscretizationError(f"{name} is not an array: {error}") from error
        object.__setattr__(data, name, array)


def check_range(indices: IntArray, n_vertices: int, name: str) -> None:
    if indices.size and not (indices.min() >= 0 and indices.max() < n_vertices):
        outside = ((indices < 0) | (indices >= n_vertices)).any(axis=1)
        bad = int(np.flatnonzero(outside)[0])
        raise InvalidDiscretizationError(
            f"{name} {bad} refers to {indices[bad].tolist()}; there are {n_vertices} vertices"
        )


def check_finite(values: FloatArray, name: str) -> None:
    if not np.isfinite(values.sum()):  # one pass without a temporary; look closer only on doubt
        rows = np.isfinite(values).reshape(len(values), -1).all(axis=1)
        if not rows.all():
            raise InvalidDiscretizationError(
                f"{name} {int(np.flatnonzero(~rows)[0])} is not finite"
            )
