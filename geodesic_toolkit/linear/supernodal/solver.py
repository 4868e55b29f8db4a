"""Sparse Cholesky as a linear solver."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np
from scipy.sparse import csr_array

from geodesic_toolkit.errors import SolverError
from geodesic_toolkit.linear.base import LinearSolver
from geodesic_toolkit.linear.memory import factor_bytes, require_memory
from geodesic_toolkit.linear.supernodal.analysis import Analysis, analyze
from geodesic_toolkit.linear.supernodal.factor import SupernodalFactor, factorize

__all__ = ["Supernodal"]

OF_LU = 1 / 3
"""Share of the bytes of L and U that L takes, one row index serving a whole row of a supernode.

The analysis knows how many there are; this is to refuse at once what is hopeless.
"""


@final
@dataclass(frozen=True, kw_only=True)
class Supernodal(LinearSolver):
    """Supernodal sparse Cholesky: minimum-degree ordering, multifrontal, on SciPy's BLAS.

    The pattern is analysed once for all matrices that share it, and no step holds Python's lock.
    On an M-matrix every step adds numbers of one sign: each entry of the solution is accurate
    relative to itself. Its kernels are compiled by Numba on first use on a machine.

    References
    ----------
    P. R. Amestoy, T. A. Davis, I. S. Duff, *An Approximate Minimum Degree Ordering Algorithm*,
    SIAM J. Matrix Anal. Appl. 17, 1996, https://doi.org/10.1137/S0895479894278952

    J. W. H. Liu, *The Multifrontal Method for Sparse Matrix Solution: Theory and Practice*, SIAM
    Review 34, 1992, https://doi.org/10.1137/1034004

    Examples
    --------
    >>> import numpy as np
    >>> from scipy.sparse import csr_array
    >>> import geodesic_toolkit as gt
    >>> factor = gt.Supernodal().factorize(csr_array([[2.0, -1.0], [-1.0, 2.0]]))
    >>> factor.solve(np.array([3.0, 0.0]))
    array([2., 1.])
    """

    componentwise: ClassVar[bool] = True
    references: ClassVar[tuple[str, ...]] = ("10.1137/S0895479894278952", "10.1137/1034004")

    def analyze(self, matrix: csr_array) -> "SupernodalFactorizer":
        """Return what factorises matrices with the pattern of `matrix`."""
        require_memory(
            OF_LU * factor_bytes(matrix.shape[0], matrix.nnz),
            f"factorising {matrix.shape[0]} unknowns with {matrix.nnz} entries",
        )
        return SupernodalFactorizer(_canonical(matrix))

    def factorize(self, matrix: csr_array) -> SupernodalFactor:
        """Return the Cholesky factor of a symmetric positive definite `matrix`."""
        return self.analyze(matrix)(matrix)


class SupernodalFactorizer:
    """Factorises matrices of one pattern, which is analysed once.

    Parameters
    ----------
    pattern : csr_array of shape (N, N)
        Without repeated entries; its values are not used.
    """

    def __init__(self, pattern: csr_array) -> None:
        self.analysis = analyze(pattern)

    def expected_bytes(self, n_factors: int) -> float:
        """Return what so many factors take, with their stacks of update matrices: exactly that."""
        numbers = self.analysis.n_stored + self.analysis.stack + 3 * self.analysis.n_vertices
        return self.analysis.nbytes + n_factors * 8.0 * numbers

    def __call__(self, matrix: csr_array) -> SupernodalFactor:
        """Return the Cholesky factor of `matrix`; of another pattern, after an analysis of it."""
        its = _canonical(matrix)
        analysis = self.analysis if self.analysis.fits(its) else analyze(its)
        return _factorize(its, analysis)


def _factorize(matrix: csr_array, analysis: Analysis) -> SupernodalFactor:
    finite = np.isfinite(matrix.data)
    if not finite.all():
        entry = int(np.argmin(finite))
        row = int(np.searchsorted(matrix.indptr, entry, side="right")) - 1
        raise SolverError(
            f"the matrix is not finite: entry ({row}, {matrix.indices[entry]}) is "
            f"{matrix.data[entry]}"
        )
    return factorize(matrix, analysis)


def _canonical(matrix: csr_array) -> csr_array:
    """Return a matrix without repeated entries, itself if it has none."""
    if matrix.has_canonical_format:
        return matrix
    tidy = matrix.copy()
    tidy.sum_duplicates()
    return tidy
