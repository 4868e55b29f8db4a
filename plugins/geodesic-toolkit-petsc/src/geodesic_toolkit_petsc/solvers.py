"""The linear solvers: conjugate gradients with multigrid, and MUMPS."""

from __future__ import annotations

import weakref
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, NotEnoughMemoryError, SolverError
from geodesic_toolkit_petsc import systems
from geodesic_toolkit_petsc.processes import processes

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from geodesic_toolkit_petsc.library import Library

__all__ = ["MUMPS", "Distributed", "PETSc"]

FloatArray: TypeAlias = NDArray[np.float64]

BYTES_OF_VALUE, BYTES_OF_INDEX = 8, 4

MOST_ENTRIES = int(np.iinfo(np.int32).max)
"""Largest number that PETSc's integers of 32 bits count."""


@final
@dataclass(frozen=True, kw_only=True)
class PETSc(gt.LinearSolver):
    """Conjugate gradients with algebraic multigrid for the Poisson step, and MUMPS for the heat.

    Under ``mpiexec`` each process has its rows of the matrix, the multigrid levels and the factor.
    Process 0 runs the program; the others help, and end with it.

    Parameters
    ----------
    preconditioner : {"hypre", "gamg"}
        Multigrid of hypre (BoomerAMG), or of PETSc itself.
    rtol : float
        Residual norm, relative to that of the right-hand side, at which the iteration stops.
    max_iterations : int
        Steps after which it gives up.
    heat : {"mumps", "cg"}
        Solver of the heat step. "cg", the same iteration, needs less memory, and is **not
        accurate** where heat is below `rtol` of its largest value, some 20 edges from the source.

    Raises
    ------
    InvalidOptionError
        A value outside those above, a tolerance outside (0, 1), or fewer than one iteration.

    References
    ----------
    S. Balay, W. D. Gropp, L. C. McInnes, B. F. Smith, *Efficient Management of Parallelism in
    Object-Oriented Numerical Software Libraries*, in: Modern Software Tools in Scientific
    Computing, 1997, https://doi.org/10.1007/978-1-4612-1986-6_8

    V. E. Henson, U. M. Yang, *BoomerAMG: A Parallel Algebraic Multigrid Solver and Preconditioner*,
    Applied Numerical Mathematics 41, 2002, https://doi.org/10.1016/S0168-9274(01)00115-5

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> sphere = gt.testing.shapes.icosphere(3)
    >>> direct = gt.GeodesicSolver(sphere, refine=False).distance(0)
    >>> iterative = gt.GeodesicSolver(sphere, refine=False, solver="petsc").distance(0)
    >>> bool(abs(direct - iterative).max() < 1e-6)
    True
    """

    preconditioner: Literal["hypre", "gamg"] = "hypre"
    rtol: float = 1e-10
    max_iterations: int = 500
    heat: Literal["mumps", "cg"] = "mumps"

    componentwise: ClassVar[bool] = False
    references: ClassVar[tuple[str, ...]] = (
        "10.1007/978-1-4612-1986-6_8",
        "10.1016/S0168-9274(01)00115-5",
    )

    def __post_init__(self) -> None:
        for option, values in (("preconditioner", ("hypre", "gamg")), ("heat", ("mumps", "cg"))):
            if getattr(self, option) not in values:
                raise InvalidOptionError(
                    f"{option} must be one of {', '.join(values)}, not {getattr(self, option)!r}"
                )
        if not 0 < self.rtol < 1:
            raise InvalidOptionError(f"rtol must lie between 0 and 1, not {self.rtol!r}")
        if self.max_iterations < 1:
            raise InvalidOptionError(
                f"max_iterations must be positive, not {self.max_iterations!r}"
            )

    @property
    def allow_heat(self) -> bool:  # type: ignore[override] # an option of another name
        """True if `heat` asks for the iteration."""
        return self.heat == "cg"

    def for_heat(self) -> gt.LinearSolver:
        """Return the solver of the heat step: MUMPS, unless `heat` is "cg"."""
        return self if self.allow_heat else MUMPS()

    def leads(self) -> bool:
        """Return True on process 0; on others, help until it ends, and return False."""
        return processes().lead()

    def factorize(self, matrix: csr_array) -> Distributed:
        """Return the multigrid levels of a symmetric positive definite `matrix`."""
        return Distributed(matrix, self, max(systems.MAX_RESIDUAL, 10 * self.rtol))

    def set_up(self, library: Library, matrix: Any) -> tuple[Any, int]:
        """Return PETSc's solver for a distributed matrix, and how many entries it stores."""
        return systems.set_up_iteration(library, matrix, self)


@final
@dataclass(frozen=True, kw_only=True)
class MUMPS(gt.LinearSolver):
    """Sparse Cholesky factors by MUMPS, in parts on all processes.

    There is no pivoting, so that on an M-matrix each entry of a solution is accurate relative to
    itself.

    References
    ----------
    P. R. Amestoy, I. S. Duff, J.-Y. L'Excellent, J. Koster, *A Fully Asynchronous Multifrontal
    Solver Using Distributed Dynamic Scheduling*, SIAM J. Matrix Anal. Appl. 23, 2001,
    https://doi.org/10.1137/S0895479899358194

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> sphere = gt.testing.shapes.icosphere(2)
    >>> distance = gt.GeodesicSolver(sphere, solver="petsc-mumps").distance(0)
    >>> bool(abs(distance - gt.geodesic_distance(sphere, 0)).max() < 1e-6)
    True
    """

    componentwise: ClassVar[bool] = True
    references: ClassVar[tuple[str, ...]] = ("10.1137/S0895479899358194",)

    def leads(self) -> bool:
        """Return True on process 0; on others, help until it ends, and return False."""
        return processes().lead()

    def factorize(self, matrix: csr_array) -> Distributed:
        """Return the Cholesky factor of a symmetric positive definite `matrix`."""
        return Distributed(matrix, self, systems.MAX_RESIDUAL)

    def set_up(self, library: Library, matrix: Any) -> tuple[Any, int]:
        """Return PETSc's solver for a distributed matrix, and how many entries it stores."""
        return systems.set_up_factor(library, matrix)


class Distributed(gt.Factor):
    """A system on all processes, made from a matrix on process 0.

    Parameters
    ----------
    matrix : csr_array of shape (N, N)
    recipe : PETSc or MUMPS
    tolerance : float
        Largest residual of a solution, relative to the right-hand side.

    Attributes
    ----------
    iterations : tuple of int
        Steps of the last block, for each column; 1 with a factor.
    """

    def __init__(self, matrix: csr_array, recipe: PETSc | MUMPS, tolerance: float) -> None:
        if not recipe.leads():
            raise SystemExit(0)  # the program is that of process 0, which has ended
        if not matrix.has_canonical_format:
            matrix = matrix.copy()
            matrix.sum_duplicates()
        if matrix.nnz > MOST_ENTRIES:
            raise NotEnoughMemoryError(
                f"a matrix of {matrix.nnz} entries is too large: PETSc counts {MOST_ENTRIES}"
            )
        diagonal = matrix.diagonal()
        if not diagonal.min(initial=np.inf) > 0:
            bad = int(np.argmin(np.nan_to_num(diagonal, nan=-np.inf)))
            raise SolverError(
                f"the matrix is not positive definite: its diagonal entry {bad} is {diagonal[bad]}"
            )
        everyone = processes()
        bounds = systems.split_rows(matrix.indptr, everyone.count)
        self._shape, self._tolerance = matrix.shape, tolerance
        self._system = everyone.new_system()
        self.iterations: tuple[int, ...] = ()
        self._n_stored: int = everyone.run(
            systems.make,
            data=(matrix.indptr, matrix.indices, matrix.data),
            system=self._system,
            recipe=recipe,
            bounds=bounds,
            entries=np.asarray(matrix.indptr[bounds], dtype=np.int64),
        )
        weakref.finalize(self, everyone.release, self._system)

    def solve(self, right_hand_side: FloatArray) -> FloatArray:
        """Return x with ``A x = b``, column by column."""
        columns = right_hand_side.reshape(len(right_hand_side), -1)
        solved = processes().run(
            systems.solve,
            data=columns,
            system=self._system,
            columns=columns.shape[1],
            tolerance=self._tolerance,
        )
        self.iterations = solved.iterations
        return np.ascontiguousarray(solved.values.reshape(right_hand_side.shape))

    @property
    def nnz(self) -> int:
        """Entries of the factor; without one, of the matrix (levels of hypre are not known)."""
        return self._n_stored

    @property
    def nbytes(self) -> int:
        """Bytes of their values and row indices, on all processes."""
        return (BYTES_OF_VALUE + BYTES_OF_INDEX) * self.nnz
