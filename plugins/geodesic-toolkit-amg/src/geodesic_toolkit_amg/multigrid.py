"""Conjugate gradients preconditioned by algebraic multigrid, by way of PyAMG."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, SolverError

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["AMG"]

FloatArray: TypeAlias = NDArray[np.float64]

MAX_UNKNOWNS_OF_COARSEST = 500
"""Unknowns of a level that is factorised, by a direct solver."""

STALLED = 1e3
"""Residual, in tolerances, above which an iteration that ended has not found the solution: PyAMG
measures it recursively, and rounding adds to the true one."""


@final
@dataclass(frozen=True, kw_only=True)
class AMG(gt.LinearSolver):
    """Conjugate gradients with a classical (Ruge-Stüben) multigrid preconditioner.

    For the Poisson step, in memory that grows in proportion to the number of vertices. **Not for
    heat**: the iteration stops at a residual, which says nothing about the small values of heat far
    from the sources. The heat step takes the default solver, or refuses this one where it is asked
    for by name, unless `allow_heat` insists.

    Parameters
    ----------
    rtol : float
        Residual norm, relative to that of the right-hand side, at which the iteration stops.
    max_iterations : int
        Steps after which it gives up.
    strength : float
        Share of the largest entry of a row from which on a connection is strong, from 0 to 1.
    allow_heat : bool
        Let the heat step use it all the same, to study what goes wrong.

    Raises
    ------
    InvalidOptionError
        A tolerance or strength outside (0, 1), or fewer than one iteration.

    References
    ----------
    J. W. Ruge, K. Stüben, *Algebraic Multigrid*, in: Multigrid Methods, SIAM 1987,
    https://doi.org/10.1137/1.9781611971057.ch4

    N. Bell, L. N. Olson, J. Schroder, B. Southworth, *PyAMG*, Journal of Open Source Software 8,
    2023, https://doi.org/10.21105/joss.05495

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> sphere = gt.testing.shapes.icosphere(3)
    >>> direct = gt.GeodesicSolver(sphere, refine=False).distance(0)
    >>> iterative = gt.GeodesicSolver(sphere, refine=False, solver="amg").distance(0)
    >>> bool(abs(direct - iterative).max() < 1e-6)
    True
    """

    rtol: float = 1e-10
    max_iterations: int = 500
    strength: float = 0.25
    allow_heat: bool = False

    componentwise: ClassVar[bool] = False
    references: ClassVar[tuple[str, ...]] = (
        "10.1137/1.9781611971057.ch4",
        "10.21105/joss.05495",
    )

    def __post_init__(self) -> None:
        for option in ("rtol", "strength"):
            if not 0 < getattr(self, option) < 1:
                raise InvalidOptionError(
                    f"{option} must lie between 0 and 1, not {getattr(self, option)!r}"
                )
        if self.max_iterations < 1:
            raise InvalidOptionError(
                f"max_iterations must be positive, not {self.max_iterations!r}"
            )

    def factorize(self, matrix: csr_array) -> AMGFactor:
        """Return the levels of the multigrid method for a symmetric positive definite `matrix`."""
        import pyamg
        from scipy.sparse import csr_matrix

        rows = csr_matrix(matrix)
        rows.sort_indices()
        diagonal = rows.diagonal()
        if not diagonal.min() > 0:
            bad = int(diagonal.argmin())
            raise SolverError(
                f"the matrix is not positive definite: its diagonal entry {bad} is {diagonal[bad]}"
            )
        levels = pyamg.ruge_stuben_solver(
            rows,
            strength=("classical", {"theta": self.strength}),
            max_coarse=MAX_UNKNOWNS_OF_COARSEST,
            coarse_solver="splu",
        )
        return AMGFactor(rows, levels, self)


class AMGFactor(gt.Factor):
    """The levels of a matrix, on which every solve iterates from the start."""

    def __init__(self, matrix: Any, levels: Any, options: AMG) -> None:
        self._matrix, self._levels, self._options = matrix, levels, options
        # PyAMG factorises the coarsest level at the first solve, which threads must not do at once.
        self.solve(np.ones(matrix.shape[0]))

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Return x with ``A x = b``, column by column."""
        columns = right_hand_side.reshape(len(right_hand_side), -1)
        solution = np.column_stack([self._solve_column(column) for column in columns.T])
        return solution.reshape(right_hand_side.shape)

    def _solve_column(self, column: FloatArray) -> FloatArray:
        options, size = self._options, float(np.linalg.norm(column))
        if size == 0:
            return np.zeros(len(column))
        load = np.ascontiguousarray(column, dtype=np.float64)
        try:
            solution = self._levels.solve(
                load, tol=options.rtol, maxiter=options.max_iterations, accel="cg"
            )
        except RuntimeError as error:  # of SuperLU, which factorises the coarsest level
            raise SolverError(f"the coarsest level cannot be factorised: {error}") from error
        residual = float(np.linalg.norm(self._matrix @ solution - load) / size)
        if not residual <= STALLED * options.rtol:
            raise SolverError(
                f"multigrid left a residual of {residual:.1e} after {options.max_iterations} "
                f"iterations, and rtol is {options.rtol:g}: the matrix is singular or far from "
                'an M-matrix; raise max_iterations, or use solver="supernodal"'
            )
        return np.asarray(solution)

    @property
    def nnz(self) -> int:
        """Entries of the matrices of all levels and of what connects them."""
        return sum(int(matrix.nnz) for matrix in self._matrices())

    @property
    def nbytes(self) -> int:
        """Bytes of these."""
        return sum(
            int(matrix.data.nbytes + matrix.indices.nbytes + matrix.indptr.nbytes)
            for matrix in self._matrices()
        )

    def _matrices(self) -> list[Any]:
        """Return the matrices of all levels; PyAMG keeps one from and one to each but the last."""
        levels = self._levels.levels
        return [level.A for level in levels] + [
            matrix for level in levels[:-1] for matrix in (level.P, level.R)
        ]
