"""The symbolic half of a factorisation: everything that the pattern alone decides."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TypeAlias, final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from geodesic_toolkit._typing import FloatArray, IndexArray, IntArray
from geodesic_toolkit.errors import SolverError

__all__ = ["LANES", "Analysis", "Panels", "analyze"]

Panels: TypeAlias = FloatArray | NDArray[np.uint32]
"""The dense blocks of a factor, one after the other: numbers, or the upper halves of numbers.

They hold L, but for its diagonal, of which they hold the inverse. `LANES` zeros follow."""

KEPT = 2**27
"""Bytes of room for a solve that wait for the next one, at the most."""

LANES = 4
"""Numbers that the substitution reads at once, wherever a column ends."""


@final
@dataclass(frozen=True, eq=False, repr=False)
class Analysis:
    """Order, supernodes and places of the Cholesky factor of every matrix of one pattern.

    Column ``j`` of the factor belongs to vertex ``order[j]``. Supernode s has the columns
    ``first[s] <= j < first[s + 1]`` and the rows ``rows[row_starts[s]:row_starts[s + 1]]``, of
    which its own columns come first; its dense panel of that shape is stored by columns from
    ``panels[s]``.

    Attributes
    ----------
    indptr, indices : ndarray
        The pattern, as the matrix has it.
    order : ndarray of shape (N,), int32
        The permutation.
    starts, lower_rows, places : ndarray
        The permuted lower triangle by columns, and where its entries are in a matrix's data.
    first : ndarray of shape (S + 1,), int32
    row_starts : ndarray of shape (S + 1,), int64
    rows : ndarray, int32
    above : ndarray of shape (S,), int32
        The parent of each supernode, -1 at roots.
    panels : ndarray of shape (S + 1,), int64
    stack : int
        Numbers on the stack of update matrices, at the most.
    tallest : int
        Rows of the tallest supernode.
    largest : int
        Numbers in the largest panel.
    """

    indptr: IndexArray | IntArray
    indices: IndexArray | IntArray
    order: IndexArray
    starts: IntArray
    lower_rows: IndexArray
    places: IntArray
    first: IndexArray
    row_starts: IntArray
    rows: IndexArray
    above: IndexArray
    panels: IntArray
    stack: int
    tallest: int
    largest: int
    _rooms: list[FloatArray] = field(default_factory=list)

    @contextmanager
    def room(self, size: int) -> Iterator[FloatArray]:
        """Lend `size` numbers to work in, in which anything may stand.

        Memory from the system comes with a fault for every page. So that of the last solve is kept
        for the next one, of whichever factor, up to `KEPT` bytes.
        """
        try:
            whole = self._rooms.pop()
        except IndexError:  # the first solve, or another thread has it
            whole = np.empty(0)
        if len(whole) < size:
            whole = np.empty(size)  # NumPy's, also for kernels: it asks for large pages
        try:
            yield whole[:size]
        finally:
            if whole.nbytes <= KEPT and not self._rooms:
                self._rooms.append(whole)

    @property
    def n_vertices(self) -> int:
        """Number N of unknowns."""
        return len(self.order)

    @property
    def n_stored(self) -> int:
        """Numbers that a factor stores, explicit zeros included."""
        return int(self.panels[-1])

    @property
    def nbytes(self) -> int:
        """Bytes of the arrays, without those of the matrix."""
        own = set(vars(self)) - {"indptr", "indices", "stack", "tallest", "largest", "_rooms"}
        return sum(getattr(self, name).nbytes for name in own)

    def factor_bytes(self, *, halves: bool) -> float:
        """Return what making a factor takes, of whole numbers or of their upper halves."""
        from geodesic_toolkit.linear.supernodal._front import packed_size  # Numba: when needed

        room = 8.0 * (self.stack + packed_size(self.tallest))
        if halves:
            return room + 4.0 * (self.n_stored + LANES) + 8.0 * (self.largest + LANES)
        return room + 8.0 * (self.n_stored + LANES)

    def fits(self, matrix: csr_array) -> bool:
        """Return whether `matrix` has the pattern that was analysed."""
        return matrix.shape == (self.n_vertices, self.n_vertices) and all(
            own is other or np.array_equal(own, other)
            for own, other in ((self.indptr, matrix.indptr), (self.indices, matrix.indices))
        )


def analyze(matrix: csr_array) -> Analysis:
    """Return the analysis of the pattern of a symmetric `matrix` with sorted indices.

    Raises
    ------
    SolverError
        It is not square, or has entries without a mirror image.
    """
    from geodesic_toolkit.linear.supernodal import _elimination, _ordering  # Numba: when needed

    if matrix.shape[0] != matrix.shape[1]:
        raise SolverError(f"only square matrices have Cholesky factors, not one of {matrix.shape}")
    indptr = np.ascontiguousarray(matrix.indptr, dtype=np.int64)
    indices = np.ascontiguousarray(matrix.indices, dtype=np.int32)
    if not _elimination.is_symmetric(indptr, indices):
        row, column = _without_mirror_image(matrix)
        raise SolverError(
            f"the matrix is not symmetric: it has an entry ({row}, {column}) and none at "
            f"({column}, {row})"
        )
    elimination = _ordering.minimum_degree(indptr, indices)
    order, first, tallest, above = _elimination.supernodes(
        *elimination[:4], _elimination.postorder(elimination.parents), _elimination.STRICT
    )
    starts, lower_rows, places, row_starts, rows = _elimination.structure(
        indptr, indices, order, _inverse(order), first, tallest, above, elimination.n_full
    )
    heights = np.diff(row_starts)
    sizes = heights * np.diff(first)
    return Analysis(
        indptr=matrix.indptr,
        indices=matrix.indices,
        order=order,
        starts=starts,
        lower_rows=lower_rows,
        places=places,
        first=first,
        row_starts=row_starts,
        rows=rows,
        above=above,
        panels=np.concatenate([[0], np.cumsum(sizes)]),
        stack=_elimination.stack_peak(first, row_starts, above),
        tallest=int(heights.max(initial=0)),
        largest=int(sizes.max(initial=0)),
    )


def _without_mirror_image(matrix: csr_array) -> tuple[int, int]:
    """Return the first entry of a matrix that has no counterpart across the diagonal."""
    n = matrix.shape[0]
    rows = np.repeat(np.arange(n), np.diff(matrix.indptr))
    entries, mirrored = rows * n + matrix.indices, matrix.indices * np.int64(n) + rows
    row, column = divmod(int(np.setdiff1d(entries, mirrored)[0]), n)
    return row, column


def _inverse(permutation: IndexArray) -> IndexArray:
    inverse = np.empty_like(permutation)
    inverse[permutation] = np.arange(len(permutation), dtype=permutation.dtype)
    return inverse
