"""Sparse matrices in the form of the kernels, without SciPy.

Importing ``scipy.sparse`` takes longer than factorising a mesh of 30,000 vertices, so the path from
a mesh to its distances avoids it; SciPy is imported only if a SciPy matrix is requested.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.frozen import FrozenArrays
from geodesic_toolkit.core.types import FloatArray, IndexArray, IntArray
from geodesic_toolkit.errors import NotEnoughMemoryError

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["MOST_ENTRIES", "CompressedRows"]

MOST_ENTRIES = np.iinfo(np.int32).max
"""Largest number of entries that row pointers of 32 bits can count; with 64 bits, half of the
memory of a matrix would be indices."""


@dataclass(frozen=True, eq=False, repr=False)
class CompressedRows(FrozenArrays):
    """A square sparse matrix in compressed rows.

    Attributes
    ----------
    indptr : ndarray of shape (N + 1,), int32
        Row i has the entries ``indptr[i] <= k < indptr[i + 1]``.
    indices : ndarray of int32
        Their columns, each once per row, and sorted unless stated otherwise.
    data : ndarray of float64
        Their values.
    """

    indptr: IndexArray
    indices: IndexArray
    data: FloatArray

    @classmethod
    def of(cls, matrix: csr_array | CompressedRows, *, copy: bool = False) -> CompressedRows:
        """Return a square SciPy matrix in this form.

        The matrix does not change, and may be unsorted. If it has this form already, the result
        shares its memory unless `copy` is true.

        Raises
        ------
        NotEnoughMemoryError
            The matrix has more entries than 32 bits can count.
        """
        if isinstance(matrix, CompressedRows):
            indptr, indices, data = matrix.arrays
            return cls(indptr.copy(), indices.copy(), data.copy()) if copy else matrix
        if copy or not matrix.has_canonical_format:
            matrix = matrix.copy()
            matrix.sum_duplicates()
        if matrix.nnz > MOST_ENTRIES:
            raise NotEnoughMemoryError(
                f"a matrix of {matrix.nnz} entries is too large: row pointers of 32 bits count "
                f"{MOST_ENTRIES}; thin out the shape, or split it"
            )
        return cls(
            np.ascontiguousarray(matrix.indptr, dtype=np.int32),
            np.ascontiguousarray(matrix.indices, dtype=np.int32),
            np.ascontiguousarray(matrix.data, dtype=np.float64),
        )

    @property
    def arrays(self) -> tuple[IndexArray, IndexArray, FloatArray]:
        """Row pointers, columns and values: the first arguments of kernels."""
        return self.indptr, self.indices, self.data

    @property
    def shape(self) -> tuple[int, int]:
        """The shape (N, N)."""
        return (len(self.indptr) - 1,) * 2

    @property
    def nnz(self) -> int:
        """Number of entries."""
        return len(self.indices)

    @property
    def row_of_entry(self) -> IndexArray:
        """The row of every entry."""
        return np.repeat(np.arange(self.shape[0], dtype=np.int32), np.diff(self.indptr))

    def diagonal(self) -> FloatArray:
        """Return the diagonal, of shape (N,); missing entries are 0."""
        places = self.diagonal_places
        if len(places) == self.shape[0]:
            return self.data[places]
        found = np.zeros(self.shape[0])
        found[self.indices[places]] = self.data[places]
        return found

    @cached_property
    def diagonal_places(self) -> IntArray:
        """The positions of the diagonal entries, row by row."""
        return _native.diagonal_places(self.indptr, self.indices)

    def with_data(self, data: FloatArray) -> CompressedRows:
        """Return the matrix with the same pattern and other values."""
        other = CompressedRows(self.indptr, self.indices, data)
        if "diagonal_places" in self.__dict__:
            other.__dict__["diagonal_places"] = self.diagonal_places
        return other

    @cached_property
    def scipy(self) -> csr_array:
        """The matrix as a SciPy matrix on the same memory; columns must be sorted."""
        from scipy.sparse import csr_array

        matrix = csr_array((self.data, self.indices, self.indptr), shape=self.shape)
        matrix.has_canonical_format = True  # avoids a scan by SciPy
        return matrix

    def __getstate__(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in ("indptr", "indices", "data")}
