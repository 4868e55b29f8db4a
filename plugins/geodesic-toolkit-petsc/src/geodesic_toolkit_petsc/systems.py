"""Linear systems in parts: the operations of all processes on their rows."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit.errors import NotEnoughMemoryError, SolverError

if TYPE_CHECKING:
    from geodesic_toolkit_petsc.library import Library
    from geodesic_toolkit_petsc.processes import Parts
    from geodesic_toolkit_petsc.solvers import MUMPS, PETSc

__all__ = ["Solved", "make", "solve", "split_rows"]

FloatArray: TypeAlias = NDArray[np.float64]

OUT_OF_MEMORY = 55
"""PETSc's error PETSC_ERR_MEM."""

WORKSPACES = (20, 50, 100, 200, 400)
"""Per cents by which MUMPS enlarges its estimate of the workspace, tried in turn."""

MUMPS_WORKSPACE = 14
"""Index of this option in MUMPS's ICNTL."""

WORKSPACE_TOO_SMALL = (-8, -9, -11, -14, -15, -17, -20)
"""MUMPS's errors that a larger workspace cures."""

NO_MEMORY = (-7, -13, -19)
"""MUMPS's errors where the system has no more memory, or not as much as it may use."""

MAX_RESIDUAL = 1e-6
"""Residual, relative to the right-hand side, above which a solution is not one. A singular matrix
leaves about 1. Rounding leaves 2e-7 for the stiffest cloud of those measured, with every solver."""


@dataclass(frozen=True)
class _Part:
    """The rows of one process, with the solver that all processes share.

    Residuals are multiplied by `weights`, one over the roots of the diagonal: equations of
    different stiffness then count alike. Points that nearly coincide have entries 1e9 times as
    large as others.
    """

    matrix: Any
    solver: Any
    weights: Any
    vectors: tuple[Any, Any, Any]
    bounds: NDArray[np.int64]


@dataclass(frozen=True)
class Solved:
    """The solutions of a block, on process 0.

    Attributes
    ----------
    values : ndarray of shape (N, K)
    iterations : tuple of int
        Steps for each column; 1 with a factor.
    """

    values: FloatArray
    iterations: tuple[int, ...]


def split_rows(indptr: NDArray[Any], count: int) -> NDArray[np.int64]:
    """Return the first row of each process, and N: about as many entries for each."""
    cuts = np.searchsorted(indptr, np.arange(1, count) * (int(indptr[-1]) / count))
    return np.array([0, *cuts, len(indptr) - 1], dtype=np.int64)


# -- the operations --------------------------------------------------------------------------------


def make(
    library: Library,
    parts: Parts,
    *,
    data: Any,
    system: int,
    recipe: PETSc | MUMPS,
    bounds: NDArray[np.int64],
    entries: NDArray[np.int64],
) -> Generator[None, None, int]:
    """Make a system of compressed rows that process 0 has, and return its number of entries.

    Parameters
    ----------
    data : (indptr, indices, data), on process 0
    system : int
    recipe : PETSc or MUMPS
    bounds : ndarray of shape (processes + 1,)
        First row of each process.
    entries : ndarray of shape (processes + 1,)
        First entry of each process.
    """
    rank = library.communicator.Get_rank()
    n_rows, n_entries = (int(np.diff(each)[rank]) for each in (bounds, entries))
    lengths = np.empty(n_rows, dtype=np.int32)
    indices = np.empty(n_entries, dtype=np.int32)
    values = np.empty(n_entries)
    given = [None] * 3 if data is None else [np.diff(data[0]), *data[1:]]
    yield
    for whole, part, cuts in (
        (given[0], lengths, bounds),
        (given[1], indices, entries),
        (given[2], values, entries),
    ):
        _scatter(library, whole, part, cuts)
    indptr = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int32)
    with _typed_errors(library, f"making {bounds[-1]} unknowns ready"):
        matrix = library.petsc.Mat().createAIJ(
            size=((n_rows, int(bounds[-1])),) * 2,
            csr=(indptr, indices, values),
            comm=library.communicator,
        )
        matrix.setOption(library.petsc.Mat.Option.SPD, True)
        solver, n_stored = recipe.set_up(library, matrix)
        # Always the same vectors: sums of numbers depend on how memory is aligned.
        vectors = tuple(matrix.createVecLeft() for _ in range(3))
        weights = matrix.getDiagonal()
        weights.sqrtabs()
        weights.reciprocal()
        parts[system] = _Part(matrix, solver, weights, vectors, bounds)
    return n_stored


def solve(
    library: Library,
    parts: Parts,
    *,
    data: FloatArray | None,
    system: int,
    columns: int,
    tolerance: float,
) -> Generator[None, None, Solved | None]:
    """Solve for a block (N, K) that process 0 has, and return the solutions to it."""
    part: _Part = parts[system]
    load, solution, _ = part.vectors
    values = None if data is None else np.empty(data.shape, order="F")
    yield
    iterations = []
    with _typed_errors(library, f"solving for {part.bounds[-1]} unknowns"):
        for k in range(columns):
            with load as own:
                _scatter(library, None if data is None else data[:, k], own, part.bounds)
            iterations.append(_solve_column(part, tolerance))
            with solution as own:
                _gather(library, own, None if values is None else values[:, k], part.bounds)
    return None if values is None else Solved(values, tuple(iterations))


def _solve_column(part: _Part, tolerance: float) -> int:
    """Solve for one column in place, and return the steps that it took."""
    load, solution, rest = part.vectors
    solution.set(0.0)
    rest.pointwiseMult(part.weights, load)
    size = rest.norm()
    if size == 0.0:
        return 0
    part.solver.solve(load, solution)
    steps, reason = part.solver.getIterationNumber(), part.solver.getConvergedReason()
    part.matrix.mult(solution, rest)
    rest.axpy(-1.0, load)
    rest.pointwiseMult(part.weights, rest)
    residual = rest.norm() / size
    if reason < 0 or not residual <= tolerance:
        raise SolverError(
            f"the residual is {residual:.1e} of the right-hand side after {steps} iterations, and "
            f"may be {tolerance:.0e}: the matrix is singular, not positive definite, or far from "
            'an M-matrix; raise max_iterations, loosen rtol, or use solver="supernodal"'
        )
    return int(steps)


def _scatter(library: Library, whole: Any, part: NDArray[Any], cuts: NDArray[np.int64]) -> None:
    """Send parts of an array of process 0 to all."""
    sent = None
    if whole is not None:
        whole = np.ascontiguousarray(whole, dtype=part.dtype)
        sent = [whole, np.diff(cuts), cuts[:-1], _type(library, part)]
    library.communicator.Scatterv(sent, [part, _type(library, part)])


def _gather(library: Library, part: NDArray[Any], whole: Any, cuts: NDArray[np.int64]) -> None:
    """Write parts of all processes to an array of process 0."""
    got = None if whole is None else [whole, np.diff(cuts), cuts[:-1], _type(library, part)]
    library.communicator.Gatherv([part, _type(library, part)], got)


def _type(library: Library, values: NDArray[Any]) -> Any:
    return library.mpi.DOUBLE if values.dtype == np.float64 else library.mpi.INT32_T


# -- the two solvers of PETSc ----------------------------------------------------------------------


def set_up_iteration(library: Library, matrix: Any, recipe: PETSc) -> tuple[Any, int]:
    """Return conjugate gradients with their preconditioner, and the entries of the matrix."""
    solver = library.petsc.KSP().create(comm=library.communicator)
    solver.setOptionsPrefix("geodesic_")
    solver.setOperators(matrix)
    solver.setType("cg")
    solver.setNormType(library.petsc.KSP.NormType.UNPRECONDITIONED)
    solver.setTolerances(rtol=recipe.rtol, atol=0.0, max_it=recipe.max_iterations)
    levels = solver.getPC()
    levels.setType(recipe.preconditioner)
    if recipe.preconditioner == "hypre":
        levels.setHYPREType("boomeramg")
    solver.setFromOptions()
    solver.setUp()
    return solver, int(matrix.getInfo()["nz_used"])


def set_up_factor(library: Library, matrix: Any) -> tuple[Any, int]:
    """Return a solver with MUMPS's Cholesky factor, and the entries of the factor."""
    for workspace in WORKSPACES:
        solver = library.petsc.KSP().create(comm=library.communicator)
        solver.setOptionsPrefix("geodesic_mumps_")
        solver.setOperators(matrix)
        solver.setType("preonly")
        cholesky = solver.getPC()
        cholesky.setType("cholesky")
        cholesky.setFactorSolverType("mumps")
        cholesky.setFactorSetUpSolverType()
        factor = cholesky.getFactorMatrix()
        factor.setMumpsIcntl(MUMPS_WORKSPACE, workspace)
        solver.setFromOptions()
        solver.setUp()
        status, detail = factor.getMumpsInfog(1), factor.getMumpsInfog(2)
        if status not in WORKSPACE_TOO_SMALL:
            break
    work = f"factorising {matrix.getSize()[0]} unknowns"
    if status in NO_MEMORY or status in WORKSPACE_TOO_SMALL:
        raise NotEnoughMemoryError(
            f"MUMPS has not enough memory for {work} (its error {status}, {detail}): use more "
            "processes, on more machines"
        )
    if status < 0 or factor.getMumpsInfog(12) > 0:
        raise SolverError(
            f"the matrix is singular or not positive definite: MUMPS failed {work} with "
            f"{factor.getMumpsInfog(12)} negative pivots (its error {status}, {detail})"
        )
    stored = factor.getMumpsInfog(29)
    return solver, -1_000_000 * stored if stored < 0 else stored  # it counts many in millions


@contextmanager
def _typed_errors(library: Library, work: str) -> Iterator[None]:
    """Turn errors of PETSc into those of geodesic-toolkit."""
    try:
        yield
    except library.petsc.Error as error:
        said = " ".join(str(error).split())
        if error.ierr == OUT_OF_MEMORY:
            raise NotEnoughMemoryError(f"PETSc has not enough memory for {work}: {said}") from error
        raise SolverError(f"PETSc failed {work}: {said}") from error
