"""Matrices that differ in their values only."""

import threading

import numpy as np
from scipy.sparse import csr_array, diags_array

from geodesic_toolkit._typing import FloatArray
from geodesic_toolkit.linear.base import Factor, Factorizer, LinearSolver
from geodesic_toolkit.linear.memory import require_memory

__all__ = ["SharedAnalysis", "plus_diagonal"]


def plus_diagonal(
    matrix: csr_array, diagonal: FloatArray, scale: float | FloatArray = 1.0
) -> csr_array:
    """Return ``diag(diagonal) + diag(scale) A`` on the pattern of A, if that has a diagonal.

    Sums of sparse matrices lose entries that happen to be zero, and with them the pattern.

    Parameters
    ----------
    matrix : csr_array of shape (N, N)
    diagonal : ndarray of shape (N,)
    scale : float or ndarray of shape (N,)

    Examples
    --------
    >>> import numpy as np
    >>> from scipy.sparse import csr_array
    >>> from geodesic_toolkit.linear.patterns import plus_diagonal
    >>> plus_diagonal(csr_array([[1.0, -1.0], [-1.0, 1.0]]), np.array([5.0, 6.0]), 2.0).toarray()
    array([[ 7., -2.],
           [-2.,  8.]])
    """
    n = matrix.shape[0]
    counts = np.diff(matrix.indptr)
    places = np.flatnonzero(matrix.indices == np.repeat(np.arange(n, dtype=np.int32), counts))
    scales = scale if np.ndim(scale) == 0 else np.repeat(scale, counts)
    scaled = csr_array((matrix.data * scales, matrix.indices, matrix.indptr), shape=matrix.shape)
    scaled.has_canonical_format = matrix.has_canonical_format  # or SciPy looks through it
    if len(places) != n:
        return csr_array(scaled + diags_array(diagonal))
    scaled.data[places] += diagonal
    return scaled


class SharedAnalysis:
    """Factorises matrices with a solver that analyses the pattern of the first only.

    Several threads may call it: they wait for the analysis, not for one another's factor.

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
        self._factorizer: Factorizer | None = None

    def __call__(self, matrix: csr_array) -> Factor:
        """Return the factor of a matrix.

        Raises
        ------
        SolverError
            It has none.
        NotEnoughMemoryError
            All that are to come would not fit together.
        """
        with self._lock:
            if self._factorizer is None:
                factorizer = self._solver.analyze(matrix)
                size = f"{matrix.shape[0]} unknowns with {matrix.nnz} entries"
                needed = factorizer.expected_bytes(self._n_factors)
                require_memory(needed, f"{self._n_factors} x factorising {size}")
                self._factorizer = factorizer  # not before: the next call is to ask again
        return self._factorizer(matrix)

    def expected_bytes(self, n_factors: int | None = None) -> float:
        """Return the bytes that making the factors takes, all of them unless told how many.

        Known from their pattern alone, once that is analysed; 0 before, and where the solver does
        not foresee it.
        """
        if self._factorizer is None:
            return 0.0
        return self._factorizer.expected_bytes(n_factors or self._n_factors)
