"""Matrices of one pattern, which differ only in their values."""

import threading

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.rows import CompressedRows
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.linear.base import Analysis, Factor, LinearSolver
from geodesic_toolkit.linear.memory import require_memory

__all__ = ["SharedAnalysis", "factorize_pairs", "plus_diagonal"]


def plus_diagonal(
    matrix: CompressedRows, diagonal: FloatArray, scale: float | FloatArray = 1.0
) -> CompressedRows:
    """Return ``diag(diagonal) + diag(scale) A`` on the pattern of A, if it has a diagonal.

    Sums of sparse matrices drop entries that happen to be zero, which changes the pattern.

    Parameters
    ----------
    matrix : CompressedRows of shape (N, N)
    diagonal : ndarray of shape (N,)
    scale : float or ndarray of shape (N,)

    Examples
    --------
    >>> import numpy as np
    >>> from scipy.sparse import csr_array
    >>> from geodesic_toolkit.core.rows import CompressedRows
    >>> from geodesic_toolkit.linear.patterns import plus_diagonal
    >>> matrix = CompressedRows.of(csr_array([[1.0, -1.0], [-1.0, 1.0]]))
    >>> plus_diagonal(matrix, np.array([5.0, 6.0]), 2.0).scipy.toarray()
    array([[ 7., -2.],
           [-2.,  8.]])
    """
    diagonal_indices = matrix.diagonal_places  # the result shares this cached value
    scales = np.ascontiguousarray(scale, dtype=np.float64).reshape(-1)
    if len(diagonal_indices) != len(diagonal):
        from scipy.sparse import csr_array, diags_array

        rows = np.repeat(np.broadcast_to(scales, len(diagonal)), np.diff(matrix.indptr))
        scaled = matrix.with_data(matrix.data * rows)
        return CompressedRows.of(csr_array(scaled.scipy + diags_array(diagonal)))
    diagonal = np.ascontiguousarray(diagonal, dtype=np.float64)
    return matrix.with_data(
        _native.plus_diagonal(*matrix.arrays, diagonal_indices, scales, diagonal)
    )


class SharedAnalysis(Analysis):
    """The analysis of the first factorised matrix, shared by all later ones.

    Several threads may use it: they wait for the analysis, not for each other's factors.

    Parameters
    ----------
    solver : LinearSolver
    n_factors : int
        Number of expected factors, which may be made at the same time.
    """

    def __init__(self, solver: LinearSolver, n_factors: int = 1) -> None:
        self._solver = solver
        self._n_factors = n_factors
        self._lock = threading.Lock()
        self._analysis: Analysis | None = None

    def factorize(self, matrix: CompressedRows) -> Factor:
        """Return the factor of a matrix.

        Raises
        ------
        SolverError
            The matrix is singular or not positive definite.
        NotEnoughMemoryError
            All expected factors would not fit together.
        """
        given = matrix if self._solver.takes_rows else matrix.scipy
        with self._lock:
            if self._analysis is None:
                analysis = self._solver.analyse(given)
                _require_memory(analysis, self._n_factors, matrix)
                self._analysis = analysis  # set last, so that a call after an error checks again
        return self._analysis.factorize(given)

    @property
    def known(self) -> Analysis | None:
        """The analysis, if a matrix has been factorised."""
        return self._analysis

    def expected_bytes(self, n_factors: int | None = None) -> float:
        """Return the bytes that factors take: all expected ones, unless `n_factors` is given.

        They are known from the pattern, once that is analysed; the result is 0 before, and if the
        solver does not predict them.
        """
        if self._analysis is None:
            return 0.0
        return self._analysis.expected_bytes(n_factors or self._n_factors)


def factorize_pairs(
    solver: LinearSolver,
    matrix: CompressedRows,
    pattern: CompressedRows,
    known: Analysis | None = None,
) -> Factor:
    """Return the factor of the real form of a complex Hermitian matrix.

    Parameters
    ----------
    solver : LinearSolver
    matrix : CompressedRows of shape (2 N, 2 N)
        Each entry ``a + i b`` is a block ``[[a, -b], [b, a]]``.
    pattern : CompressedRows of shape (N, N)
        That of the complex matrix.
    known : Analysis, optional
        One that may be of the pattern.

    Raises
    ------
    SolverError
        The matrix is singular or not positive definite.
    NotEnoughMemoryError
        The factor would not fit.
    """
    given = matrix if solver.takes_rows else matrix.scipy
    analysis = solver.analyse_pairs(given, pattern, known)
    _require_memory(analysis, 1, matrix)
    return analysis.factorize(given)


def _require_memory(analysis: Analysis, n_factors: int, matrix: CompressedRows) -> None:
    size = f"{matrix.shape[0]} unknowns with {matrix.nnz} entries"
    require_memory(analysis.expected_bytes(n_factors), f"{n_factors} x factorising {size}")
