"""The contract of a linear solver, as executable laws."""

from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import numpy as np
from scipy.sparse import csr_array, dia_array, diags_array, eye_array, kron, random_array

from geodesic_toolkit.core.frozen import freeze, freeze_csr
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.errors import InvalidOptionError, SolverError
from geodesic_toolkit.laplacians.cotan import CotanLaplacian
from geodesic_toolkit.linear.base import Factor, LinearSolver
from geodesic_toolkit.testing import shapes
from geodesic_toolkit.testing.conformance import (
    Check,
    ConformanceReport,
    Measured,
    as_checks,
    run_checks,
)
from geodesic_toolkit.testing.figures import relative
from geodesic_toolkit.testing.recipe_laws import RECIPE_LAWS, faults

__all__ = ["SOLVER_LAWS", "check_linear_solver", "linear_solver_checks"]

RESIDUAL = 1e-6
"""Tolerance of any solver: a distance must not lose more than the discretization does."""

REPEATED = 1e-12
"""Tolerance of the same solve in another way: in a block, again, in another thread."""

COMPONENTWISE = 1e-9
"""Tolerance of every entry, relative to itself: about N roundings of one operation."""


def linear_solver_checks(
    solver: LinearSolver, *, expected_failures: Mapping[str, str] | None = None
) -> list[Check]:
    """Return the contract of a linear solver as a list of checks, one per law.

    Parameters
    ----------
    solver : LinearSolver
        An instance; its options are checked with it.
    expected_failures : mapping of str to str, optional
        Laws that are known to fail, with the reason; added to ``solver.known_failures``. A law that
        holds nevertheless is reported too.

    Returns
    -------
    list of Check
        Calling one raises if its law is broken; ``check.run()`` returns the figures.

    Raises
    ------
    InvalidOptionError
        The solver is not an instance, or a failure is declared for a law that does not exist.

    Notes
    -----
    As a test module::

        import geodesic_toolkit as gt, pytest
        from my_package import MySolver

        @pytest.mark.parametrize("law", gt.testing.linear_solver_checks(MySolver()), ids=str)
        def test_my_solver_keeps_the_contract(law): law()

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> checks = gt.testing.linear_solver_checks(gt.SuperLU())
    >>> {check.law: check for check in checks}["tiny_entries_are_resolved"].run().ok
    True
    """
    if not isinstance(solver, LinearSolver):
        raise InvalidOptionError(f"expected an instance of a LinearSolver, not {solver!r}")
    expected = {**solver.known_failures, **(expected_failures or {})}
    return as_checks(SOLVER_LAWS, SolverSubject(solver), expected)


def check_linear_solver(
    solver: LinearSolver, *, expected_failures: Mapping[str, str] | None = None
) -> ConformanceReport:
    """Check a linear solver against the whole contract.

    Parameters and errors are those of :func:`linear_solver_checks`.

    Returns
    -------
    ConformanceReport
        Every law with its figure and its bound.

    Raises
    ------
    ConformanceError
        Laws are broken, or laws that were declared to fail hold: the message has all of them, with
        figures and bounds.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.testing.check_linear_solver(gt.CG()).ok
    True
    """
    checks = linear_solver_checks(solver, expected_failures=expected_failures)
    return run_checks(solver, checks).or_raise()


class SolverSubject:
    """A solver with the systems on which it is measured; each is factorised once."""

    def __init__(self, solver: LinearSolver) -> None:
        self.recipe = solver
        self._factors: dict[str, Factor] = {}

    def cases(self) -> Iterator[tuple[str, csr_array, Factor]]:
        """Iterate over the systems: a name, the matrix, its factor."""
        for name, matrix in systems().items():
            if name not in self._factors:
                self._factors[name] = self.recipe.factorize(matrix)
            yield name, matrix, self._factors[name]


@cache
def systems() -> dict[str, csr_array]:
    """Return symmetric positive definite matrices, read-only."""
    ball = CotanLaplacian().assemble(shapes.icosphere(2))
    count, first = ball.n_vertices, np.zeros(ball.n_vertices)
    first[0] = ball.stiffness.diagonal()[0]
    rng = np.random.default_rng(0)
    sparse = random_array((150, 150), density=0.03, rng=rng, dtype=np.float64)
    named = {
        "one unknown": eye_array(1) * 3.0,
        "diagonal": diags_array(np.logspace(-2, 2, 40)),
        "random": sparse @ sparse.T + 0.1 * eye_array(150),
        "heat on a sphere": diags_array(ball.mass) + ball.spacing**2 * ball.stiffness,
        "Poisson on a sphere": ball.stiffness + diags_array(first),
        "two blocks": diags_array(np.where(np.arange(count) % 2, 1.0, 2.0)),
    }
    return {name: freeze_csr(csr_array(matrix)) for name, matrix in named.items()}


def solution_solves_the_system(subject: SolverSubject) -> Iterable[Measured]:
    """``A x = b`` for random and for mesh matrices (residual, relative to b)."""
    for name, matrix, factor in subject.cases():
        load = _load(matrix, 1)[:, 0]
        residual = np.linalg.norm(matrix @ factor.solve(load) - load) / np.linalg.norm(load)
        yield Measured(float(residual), RESIDUAL, name)


def analysis_serves_any_matrix(subject: SolverSubject) -> Iterable[Measured]:
    """An analysis factorises matrices of its pattern, and of others (residual, relative to b)."""
    analysis = subject.recipe.analyse(systems()["heat on a sphere"])
    for name, matrix in systems().items():
        load = _load(matrix, 1)[:, 0]
        solution = analysis.factorize(matrix).solve(load)
        residual = np.linalg.norm(matrix @ solution - load) / np.linalg.norm(load)
        yield Measured(float(residual), RESIDUAL, name)


def blocks_equal_their_columns(subject: SolverSubject) -> Iterable[Measured]:
    """A block (N, K) is solved as its columns are (difference, relative to the largest entry)."""
    for name, matrix, factor in subject.cases():
        block = _load(matrix, 3)
        solution = factor.solve(block)
        for k in range(3):
            yield Measured(
                relative(solution[:, k], factor.solve(block[:, k].copy())), REPEATED, name
            )


def result_is_a_fresh_float64_array(subject: SolverSubject) -> Iterable[Measured]:
    """A solution is a new writeable float64 array of b's shape, and b does not change."""
    for name, matrix, factor in subject.cases():
        for shape in ((), (1,), (3,)):
            load = freeze(
                _load(matrix, 3)[:, : shape[0]].copy() if shape else _load(matrix, 1)[:, 0].copy()
            )
            before, solution = load.copy(), factor.solve(load)
            found = []
            if solution.shape != load.shape:
                found.append(f"shape {solution.shape} for {load.shape}")
            if solution.dtype != np.float64:
                found.append(f"dtype {solution.dtype}")
            if np.shares_memory(solution, load) or not solution.flags.writeable:
                found.append("the array is shared")
            if (load != before).any():
                found.append("b was overwritten")
            yield Measured(float(len(found)), 0.0, f"{name}: {'; '.join(found)}")


def memory_order_does_not_matter(subject: SolverSubject) -> Iterable[Measured]:
    """Fortran-ordered and strided right-hand sides give the same solution (relative)."""
    for name, matrix, factor in subject.cases():
        block = _load(matrix, 4)
        expected = factor.solve(block)
        yield Measured(relative(factor.solve(np.asfortranarray(block)), expected), REPEATED, name)
        yield Measured(relative(factor.solve(block[:, ::2]), expected[:, ::2]), REPEATED, name)
        yield Measured(relative(factor.solve(block[:, 1]), expected[:, 1]), REPEATED, name)


def factor_can_be_used_again(subject: SolverSubject) -> Iterable[Measured]:
    """Solving again, after other right-hand sides or in place, gives the same (relative)."""
    for name, matrix, factor in subject.cases():
        load = _load(matrix, 2)
        first = factor.solve(load)
        factor.solve(-3 * load[:, ::-1])
        yield Measured(relative(factor.solve(load), first), REPEATED, name)
        yield Measured(relative(factor.solve_over(load.copy()), first), REPEATED, name)


def factor_is_safe_from_threads(subject: SolverSubject) -> Iterable[Measured]:
    """Threads that use one factor concurrently get the result of a single thread (relative)."""
    for name, matrix, factor in subject.cases():
        loads = [_load(matrix, 2) * (k + 1) for k in range(16)]
        alone = [factor.solve(load) for load in loads]
        with ThreadPoolExecutor(8) as pool:
            together = list(pool.map(factor.solve, loads))
        for got, expected in zip(together, alone, strict=True):
            yield Measured(relative(got, expected), REPEATED, name)


def factor_tells_its_size(subject: SolverSubject) -> Iterable[Measured]:
    """``nnz`` and ``nbytes`` are integers: at least one entry per row, and 8 bytes per entry."""
    for name, matrix, factor in subject.cases():
        sizes, found = (factor.nnz, factor.nbytes), []
        if not all(isinstance(size, int) and not isinstance(size, bool) for size in sizes):
            found.append(f"nnz, nbytes = {sizes!r} are not integers")
        elif factor.nnz < matrix.shape[0] or factor.nbytes < 8 * factor.nnz:
            found.append(f"nnz, nbytes = {sizes!r} for {matrix.shape[0]} unknowns")
        yield Measured(float(len(found)), 0.0, f"{name}: {'; '.join(found)}")


def tiny_entries_are_resolved(subject: SolverSubject) -> Iterable[Measured]:
    """Entries down to 1e-270 have a small relative error if the solver is `componentwise`."""
    if not subject.recipe.componentwise:
        return
    for n, time in ((640, 1.0), (100, 100.0), (130, 0.01)):
        matrix, exact = _heat_on_a_path(n, time)
        load = np.zeros(n)
        load[0] = 1.0
        rng = np.random.default_rng(n)
        for order in (np.arange(n), rng.permutation(n)):
            shuffled = freeze_csr(csr_array(matrix[order][:, order]))
            solution = subject.recipe.factorize(shuffled).solve(load[order])
            yield Measured(
                _log_error(solution, exact[order]), COMPONENTWISE, f"path of {n}, t = {time}"
            )
    matrix, load, exact = _heat_on_a_grid()
    solution = subject.recipe.factorize(matrix).solve(load)
    yield Measured(_log_error(solution, exact), COMPONENTWISE, "grid of 15 x 15")


def singular_matrices_are_refused(subject: SolverSubject) -> Iterable[Measured]:
    """A singular matrix raises a SolverError, on factorising or on solving."""
    chain = _path_laplacian(30)
    hollow = diags_array(np.r_[np.ones(9), 0.0])
    found = []
    for name, matrix in (("path without a grounded vertex", chain), ("row of zeros", hollow)):
        load = np.zeros(matrix.shape[0])
        load[-1] = 1.0
        try:
            subject.recipe.factorize(freeze_csr(csr_array(matrix))).solve(load)
        except SolverError:
            continue
        except Exception as error:  # noqa: BLE001 - the error is the finding
            found.append(f"{name}: {type(error).__name__}: {error}")
        else:
            found.append(f"{name}: no error")
    yield faults(found)


def componentwise_is_declared(subject: SolverSubject) -> Iterable[Measured]:
    """The class declares whether it is `componentwise`: True or False."""
    declared: Any = getattr(type(subject.recipe), "componentwise", None)
    yield faults([] if isinstance(declared, bool) else [f"componentwise is {declared!r}"])


def _load(matrix: csr_array, columns: int) -> FloatArray:
    return np.random.default_rng(5).normal(size=(matrix.shape[0], columns))


def _log_error(solution: FloatArray, log_exact: FloatArray) -> float:
    """Return the largest difference of logarithms; inf if an entry is not positive."""
    if not (solution > 0).all():
        return np.inf
    return float(np.abs(np.log(solution) - log_exact).max())


def _path_laplacian(n: int) -> dia_array:
    degree = np.r_[1.0, np.full(n - 2, 2.0), 1.0]
    beside = np.full(n, -1.0)
    return dia_array((np.stack([beside, degree, beside]), [-1, 0, 1]), shape=(n, n))


def _heat_on_a_path(n: int, time: float) -> tuple[csr_array, FloatArray]:
    """Return ``I + t L`` of a path, and the logarithm of its solution for heat at the first vertex.

    ``u_j = C cosh(θ (n - 1/2 - j))`` with ``cosh θ = 1 + 1/(2t)``, and C from the first row.
    """
    matrix = eye_array(n) + time * _path_laplacian(n)
    rate = np.arccosh(1 + 1 / (2 * time))
    steps = n - 0.5 - np.arange(n)
    log_cosh = rate * steps + np.log1p(np.exp(-2 * rate * steps))  # omits log 2, which cancels
    first = (1 + time) - time * np.exp(log_cosh[1] - log_cosh[0])
    return csr_array(matrix), log_cosh - log_cosh[0] - np.log(first)


@cache
def _heat_on_a_grid() -> tuple[csr_array, FloatArray, FloatArray]:
    """Return ``I + t L`` of a square grid, a load at its corner, and log u.

    The reference eliminates in extended precision without pivoting, as suits an M-matrix.
    """
    n, time = 15, 1e-3
    one = _path_laplacian(n)
    laplacian = kron(one, eye_array(n)) + kron(eye_array(n), one)
    matrix = csr_array(eye_array(n * n) + time * laplacian)
    load = np.zeros(n * n)
    load[0] = 1.0
    dense, right = matrix.toarray().astype(np.longdouble), load.astype(np.longdouble)
    for k in range(n * n - 1):
        below = dense[k + 1 :, k] / dense[k, k]
        dense[k + 1 :, k + 1 :] -= below[:, None] * dense[k, k + 1 :]
        right[k + 1 :] -= below * right[k]
    for k in range(n * n - 1, -1, -1):
        right[k] = (right[k] - dense[k, k + 1 :] @ right[k + 1 :]) / dense[k, k]
    return freeze_csr(matrix), load, np.log(right).astype(np.float64)


SOLVER_LAWS = (
    *RECIPE_LAWS,
    componentwise_is_declared,
    solution_solves_the_system,
    analysis_serves_any_matrix,
    blocks_equal_their_columns,
    result_is_a_fresh_float64_array,
    memory_order_does_not_matter,
    factor_can_be_used_again,
    factor_is_safe_from_threads,
    factor_tells_its_size,
    tiny_entries_are_resolved,
    singular_matrices_are_refused,
)
"""The contract of :class:`~geodesic_toolkit.LinearSolver`: functions of a subject, in order."""
