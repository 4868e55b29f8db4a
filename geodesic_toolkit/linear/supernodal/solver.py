"""Sparse Cholesky as a linear solver."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np
from scipy.sparse import csr_array

from geodesic_toolkit.errors import InvalidOptionError, SolverError
from geodesic_toolkit.linear.base import LinearSolver
from geodesic_toolkit.linear.memory import factor_bytes, require_memory
from geodesic_toolkit.linear.supernodal.analysis import analyze
from geodesic_toolkit.linear.supernodal.factor import SupernodalFactor, factorize

__all__ = ["Supernodal"]

OF_LU = 1 / 3
"""Share of the bytes of L and U that L takes, one row index serving a whole row of a supernode.

The analysis knows how many there are; this is to refuse at once what is hopeless.
"""

TOLERANCE = 1e-4
"""Error from which on a compact factor is not used. Measured on meshes and grids of up to 560,000
vertices: 1e-6 to 7e-6."""


@final
@dataclass(frozen=True, kw_only=True)
class Supernodal(LinearSolver):
    """Supernodal sparse Cholesky: minimum-degree ordering, multifrontal, dense kernels of its own.

    The pattern is analysed once for all matrices that share it, and no step holds Python's lock.
    On an M-matrix every step adds numbers of one sign: each entry of the solution is accurate
    relative to itself. Its kernels are compiled by Numba on first use on a machine.

    Parameters
    ----------
    compact : bool
        Keep the upper half of each number of a factor: its sign, its whole range and six digits.
        Half the memory, and solves that wait for memory are up to twice as fast; a solution is off
        by about 1e-6 of its largest value, and each value of heat by about 1e-6 of itself. A factor
        is tried before it is used, and kept in full where that does not hold.

    Raises
    ------
    InvalidOptionError
        `compact` is neither.

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

    compact: bool = False

    componentwise: ClassVar[bool] = True
    references: ClassVar[tuple[str, ...]] = ("10.1137/S0895479894278952", "10.1137/1034004")

    def __post_init__(self) -> None:
        if not isinstance(self.compact, bool | np.bool_):
            raise InvalidOptionError(f"compact must be True or False, not {self.compact!r}")

    def analyze(self, matrix: csr_array) -> "SupernodalFactorizer":
        """Return what factorises matrices with the pattern of `matrix`."""
        require_memory(
            OF_LU * factor_bytes(matrix.shape[0], matrix.nnz),
            f"factorising {matrix.shape[0]} unknowns with {matrix.nnz} entries",
        )
        return SupernodalFactorizer(_canonical(matrix), compact=bool(self.compact))

    def factorize(self, matrix: csr_array) -> SupernodalFactor:
        """Return the Cholesky factor of a symmetric positive definite `matrix`."""
        return self.analyze(matrix)(matrix)


class SupernodalFactorizer:
    """Factorises matrices of one pattern, which is analysed once.

    Parameters
    ----------
    pattern : csr_array of shape (N, N)
        Without repeated entries; its values are not used.
    compact : bool
        Keep the upper half of each number only, where that will do.
    """

    def __init__(self, pattern: csr_array, *, compact: bool = False) -> None:
        self.analysis = analyze(pattern)
        self.compact = compact

    def expected_bytes(self, n_factors: int) -> float:
        """Return what so many factors take, with their stacks of update matrices: exactly that."""
        one = self.analysis.factor_bytes(halves=self.compact) + 24.0 * self.analysis.n_vertices
        return self.analysis.nbytes + n_factors * one

    def __call__(self, matrix: csr_array) -> SupernodalFactor:
        """Return the Cholesky factor of `matrix`; of another pattern, after an analysis of it."""
        its = _canonical(matrix)
        analysis = self.analysis if self.analysis.fits(its) else analyze(its)
        _require_finite(its)
        if self.compact:
            factor = factorize(its, analysis, halves=True)
            if _is_accurate(factor, its):
                return factor
        return factorize(its, analysis)


def _is_accurate(factor: SupernodalFactor, matrix: csr_array) -> bool:
    """Return whether a factor gives back the constant vector.

    That is nearly in the null space of a Laplacian, so its equations are those that errors of the
    factor hurt most.
    """
    ones = np.ones(matrix.shape[0])
    try:
        error = np.abs(factor.solve(matrix @ ones) - ones).max(initial=0.0)
    except SolverError:  # the sums overflow, which is for the full factor to report
        return False
    return bool(error <= TOLERANCE)


def _require_finite(matrix: csr_array) -> None:
    finite = np.isfinite(matrix.data)
    if not finite.all():
        entry = int(np.argmin(finite))
        row = int(np.searchsorted(matrix.indptr, entry, side="right")) - 1
        raise SolverError(
            f"the matrix is not finite: entry ({row}, {matrix.indices[entry]}) is "
            f"{matrix.data[entry]}"
        )


def _canonical(matrix: csr_array) -> csr_array:
    """Return a matrix without repeated entries, itself if it has none."""
    if matrix.has_canonical_format:
        return matrix
    tidy = matrix.copy()
    tidy.sum_duplicates()
    return tidy
