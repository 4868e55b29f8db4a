"""SciPy's conjugate gradients."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, final

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.errors import InvalidOptionError, SolverError
from geodesic_toolkit.linear.base import Factor, LinearSolver

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["CG"]


@final
@dataclass(frozen=True, kw_only=True)
class CG(LinearSolver):
    """Conjugate gradients without a preconditioner, stopped at a relative residual.

    It is for the Poisson step, **not for heat**: an iterate is zero beyond the neighbours that it
    has reached, one ring per step, and the residual depends so little on small values that the far
    half of a mesh may stay at exactly 0. The heat method rejects it for heat unless `allow_heat` is
    set.

    Parameters
    ----------
    rtol : float
        Residual norm, relative to that of the right-hand side, at which the iteration stops.
    max_iterations : int, optional
        Maximum number of steps; 10 N by default.
    allow_heat : bool
        Allow the heat step to use it, to study its errors.

    Raises
    ------
    InvalidOptionError
        A tolerance outside (0, 1), or fewer than one iteration.

    References
    ----------
    M. R. Hestenes, E. Stiefel, *Methods of Conjugate Gradients for Solving Linear Systems*,
    J. Res. Natl. Bur. Stand. 49, 1952, https://doi.org/10.6028/jres.049.044

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> sphere = gt.testing.shapes.icosphere(2)
    >>> direct = gt.GeodesicSolver(sphere).distance(0)
    >>> iterative = gt.GeodesicSolver(sphere, solver=gt.CG(rtol=1e-10)).distance(0)
    >>> bool(abs(direct - iterative).max() < 1e-6)
    True
    """

    rtol: float = 1e-8
    max_iterations: int | None = None
    allow_heat: bool = False

    componentwise: ClassVar[bool] = False
    references: ClassVar[tuple[str, ...]] = ("10.6028/jres.049.044",)

    def __post_init__(self) -> None:
        if not 0 < self.rtol < 1:
            raise InvalidOptionError(f"rtol must lie between 0 and 1, not {self.rtol!r}")
        if self.max_iterations is not None and self.max_iterations < 1:
            raise InvalidOptionError(
                f"max_iterations must be positive, not {self.max_iterations!r}"
            )

    def factorize(self, matrix: csr_array) -> CGFactor:
        """Return `matrix` with the options of the iteration; nothing is computed yet."""
        return CGFactor(matrix, self)


class CGFactor(Factor):
    """A matrix on which every solve iterates from the start."""

    def __init__(self, matrix: csr_array, options: CG) -> None:
        self._matrix = matrix
        self._options = options

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Return x with ``A x = b``, column by column."""
        columns = right_hand_side.reshape(len(right_hand_side), -1)
        solution = np.column_stack([self._solve_column(column) for column in columns.T])
        return solution.reshape(right_hand_side.shape)

    def _solve_column(self, column: FloatArray) -> FloatArray:
        from scipy.sparse.linalg import cg  # takes half a second: import it when needed

        options = self._options
        with np.errstate(divide="ignore", invalid="ignore"):  # a singular matrix is reported below
            solution, status = cg(
                self._matrix, column, rtol=options.rtol, atol=0.0, maxiter=options.max_iterations
            )
        if status != 0 or not np.isfinite(solution).all():
            raise SolverError(
                f"conjugate gradients did not reach rtol={options.rtol:g} in "
                f"{options.max_iterations or 10 * len(column)} iterations; loosen rtol, raise "
                'max_iterations, or use solver="superlu"'
            )
        return np.asarray(solution)

    @property
    def nnz(self) -> int:
        """Entries of the matrix, which is not factorised."""
        return int(self._matrix.nnz)

    @property
    def nbytes(self) -> int:
        """Bytes of the matrix."""
        return int(
            self._matrix.data.nbytes + self._matrix.indices.nbytes + self._matrix.indptr.nbytes
        )
