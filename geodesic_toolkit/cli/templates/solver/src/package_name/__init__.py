"""A linear solver for geodesic-toolkit: sparse LU with pivoting, by SciPy."""

from dataclasses import dataclass
from typing import Any, ClassVar, Literal, final, get_args

import numpy as np
from numpy.typing import NDArray

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, NotEnoughMemoryError, SolverError

__all__ = ["PivotedLU"]

Ordering = Literal["COLAMD", "MMD_AT_PLUS_A", "MMD_ATA", "NATURAL"]


@final
@dataclass(frozen=True, kw_only=True)
class PivotedLU(gt.LinearSolver):
    """Sparse LU with partial pivoting, by :func:`scipy.sparse.linalg.splu`.

    Pivoting subtracts numbers of equal size, so that tiny entries of a solution are not accurate
    relative to themselves: the heat step uses another solver.

    Parameters
    ----------
    ordering : str
        Order of the columns, as SciPy names it.

    Raises
    ------
    InvalidOptionError
        SciPy does not have the ordering.

    References
    ----------
    J. W. Demmel, S. C. Eisenstat, J. R. Gilbert, X. S. Li, J. W. H. Liu, *A Supernodal Approach to
    Sparse Partial Pivoting*, 1999, https://doi.org/10.1137/S0895479895291765
    """

    ordering: Ordering = "MMD_AT_PLUS_A"

    componentwise: ClassVar[bool] = False
    references: ClassVar[tuple[str, ...]] = ("10.1137/S0895479895291765",)

    def __post_init__(self) -> None:
        known = get_args(Ordering)
        if self.ordering not in known:
            raise InvalidOptionError(
                f"ordering must be one of {', '.join(known)}, not {self.ordering!r}"
            )

    def factorize(self, matrix: Any) -> gt.Factor:
        """Return the LU factors of a symmetric positive definite matrix, a csr_array."""
        from scipy.sparse.linalg import splu  # takes half a second: import it when needed

        work = f"factorising {matrix.shape[0]} unknowns with {matrix.nnz} entries"
        try:
            return _Factors(splu(matrix.tocsc(), permc_spec=self.ordering))
        except MemoryError as error:
            raise NotEnoughMemoryError(f"SciPy ran out of memory {work}") from error
        except RuntimeError as error:
            raise SolverError(f"SciPy failed {work}: {error}") from error


class _Factors(gt.Factor):
    """L and U, which SciPy keeps."""

    def __init__(self, factors: Any) -> None:
        self._factors = factors

    def solve(self, right_hand_side: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return x with ``A x = b``, for one column, (N,), or a block of them, (N, K)."""
        solution: NDArray[np.float64] = self._factors.solve(right_hand_side)
        if not np.isfinite(solution).all():
            raise SolverError("the solution is not finite: the matrix is singular")
        return solution

    @property
    def nnz(self) -> int:
        """Entries of L and U."""
        return int(self._factors.nnz)

    @property
    def nbytes(self) -> int:
        """Bytes of their values and row indices: 8 + 4 for each entry."""
        return 12 * self.nnz
