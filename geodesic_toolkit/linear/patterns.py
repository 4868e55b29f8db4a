"""Matrices that differ in their values only."""

import threading

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.rows import CompressedRows
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.linear.base import Analysis, Factor, LinearSolver
from geodesic_toolkit.linear.memory import require_memory

__all__ = ["SharedAnalysis", "plus_diagonal"]


def plus_diagonal(
    matrix: CompressedRows, diagonal: FloatArray, scale: float | FloatArray = 1.0
) -> CompressedRows:
    """Return ``diag(diagonal) + diag(scale) A`` on the pattern of A, if that has a diagonal.

    Sums of sparse matrices lose entries that happen to be zero, and with them the pattern.

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
    places = matrix.diagonal_places  # first, so that the other matrix has them too
    scales = np.ascontiguousarray(scale, dtype=np.float64).reshape(-1)
    if len(places) != len(diagonal):
        from scipy.sparse import csr_array, diags_array

        rows = np.repeat(np.broadcast_to(scales, len(diagonal)), np.diff(matrix.indptr))
        scaled = matrix.with_data(matrix.data * rows)
        return CompressedRows.of(csr_array(scaled.scipy + diags_array(diagonal)))
    diagonal = np.ascontiguousarray(diagonal, dtype=np.float64)
    return matrix.with_data(_native.plus_diagonal(*matrix.arrays, places, scales, diagonal))


class SharedAnalysis(Analysis):
    """The analysis of the first matrix that is factorised, for all that follow.

    Several threads may use it: they wait for the analysis, not for one another's factor.

    Parameters
    ----------
    solver : LinearSolver
    n_factors : int
        How many factors are to come, at the same time perhaps.
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
            It has none.
        NotEnoughMemoryError
            All that are to come would not fit together.
        """
        given = matrix if self._solver.takes_rows else matrix.scipy
        with self._lock:
            if self._analysis is None:
                analysis = self._solver.analyse(given)
                size = f"{matrix.shape[0]} unknowns with {matrix.nnz} entries"
                needed = analysis.expected_bytes(self._n_factors)
                require_memory(needed, f"{self._n_factors} x factorising {size}")
                self._analysis = analysis  # not before: the next call is to ask again
        return self._analysis.factorize(given)

    def expected_bytes(self, n_factors: int | None = None) -> float:
        """Return the bytes that making the factors takes, all of them unless given how many.

        Known from their pattern alone, once that is analysed; 0 before, and where the solver does
        not foresee it.
        """
        if self._analysis is None:
            return 0.0
        return self._analysis.expected_bytes(n_factors or self._n_factors)
