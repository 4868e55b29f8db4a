"""SciPy's SuperLU, set up for symmetric matrices."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, final

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.errors import NotEnoughMemoryError, SolverError
from geodesic_toolkit.linear.base import Factor, LinearSolver
from geodesic_toolkit.linear.memory import factor_bytes, require_memory

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["SuperLU"]


@final
@dataclass(frozen=True, kw_only=True)
class SuperLU(LinearSolver):
    """Sparse LU without pivoting, by SciPy's SuperLU with a minimum-degree ordering.

    On a symmetric positive definite matrix the pivots stay on the diagonal, and on an M-matrix
    every step adds numbers of equal sign: each entry of the solution is accurate relative to
    itself.

    References
    ----------
    J. W. Demmel, S. C. Eisenstat, J. R. Gilbert, X. S. Li, J. W. H. Liu, *A Supernodal Approach to
    Sparse Partial Pivoting*, SIAM J. Matrix Anal. Appl. 20, 1999,
    https://doi.org/10.1137/S0895479895291765

    Examples
    --------
    >>> import numpy as np
    >>> from scipy.sparse import csr_array
    >>> import geodesic_toolkit as gt
    >>> factor = gt.SuperLU().factorize(csr_array([[2.0, -1.0], [-1.0, 2.0]]))
    >>> factor.solve(np.array([3.0, 0.0]))
    array([2., 1.])
    """

    componentwise: ClassVar[bool] = True
    references: ClassVar[tuple[str, ...]] = ("10.1137/S0895479895291765",)

    def factorize(self, matrix: csr_array) -> SuperLUFactor:
        """Return the LU factors of a symmetric positive definite `matrix`."""
        require_memory(
            factor_bytes(matrix.shape[0], matrix.nnz),
            f"factorising {matrix.shape[0]} unknowns with {matrix.nnz} entries",
        )
        from scipy.sparse.linalg import splu  # takes half a second: import it when needed

        try:
            factors = splu(
                matrix.tocsc(),
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except MemoryError as error:
            raise NotEnoughMemoryError(
                f"SuperLU ran out of memory factorising {matrix.shape[0]} unknowns "
                f"with {matrix.nnz} entries"
            ) from error
        except RuntimeError as error:
            raise SolverError(
                f"SuperLU could not factorise {matrix.shape[0]} unknowns: {error}"
            ) from error
        return SuperLUFactor(factors)


class SuperLUFactor(Factor):
    """LU factors held by SuperLU."""

    def __init__(self, factors: Any) -> None:
        self._factors = factors

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Return x with ``A x = b``, for one column or a block of them."""
        solution: FloatArray = self._factors.solve(right_hand_side)
        if not np.isfinite(solution).all():
            raise SolverError(
                "SuperLU's solution is not finite: the matrix is singular to working precision"
            )
        return solution

    @property
    def nnz(self) -> int:
        """Entries of L and U."""
        return int(self._factors.nnz)

    @property
    def nbytes(self) -> int:
        """Bytes of their values and row indices (8 + 4 per entry)."""
        return 12 * self.nnz
