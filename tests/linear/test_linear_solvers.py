"""Linear solvers: agreement, tiny entries, clear errors."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np
import pytest
import slow_kernels
from scipy.sparse import csr_array, diags_array, random_array

import geodesic_toolkit as gt
from geodesic_toolkit.core.rows import CompressedRows
from geodesic_toolkit.errors import InvalidOptionError, SolverError
from geodesic_toolkit.heat.log_range import fill_from_neighbours
from geodesic_toolkit.registry.catalog import resolve_solvers
from geodesic_toolkit.testing import shapes


@pytest.fixture(scope="module")
def heat_matrix():
    discretization = gt.CotanLaplacian().assemble(shapes.icosphere(2))
    return csr_array(discretization.stiffness + np.diag(discretization.mass))


@pytest.mark.parametrize("solver", [gt.SuperLU(), gt.Supernodal(), gt.CG(rtol=1e-12)], ids=repr)
def test_solutions_solve(solver, heat_matrix):
    load = np.random.default_rng(0).normal(size=(162, 3))
    factor = solver.factorize(heat_matrix)
    np.testing.assert_allclose(heat_matrix @ factor.solve(load), load, atol=1e-9)
    np.testing.assert_allclose(factor.solve(load[:, 0]), factor.solve(load)[:, 0], atol=1e-12)
    assert factor.nnz > 0
    assert factor.nbytes > factor.nnz


def test_a_singular_matrix_is_an_error():
    with pytest.raises(SolverError, match="singular"):
        gt.SuperLU().factorize(csr_array((3, 3)))


def test_an_unfinished_iteration_is_an_error(heat_matrix):
    factor = gt.CG(rtol=1e-14, max_iterations=2).factorize(heat_matrix)
    with pytest.raises(SolverError, match="did not reach rtol=1e-14 in 2 iterations"):
        factor.solve(np.eye(162)[0])


@pytest.mark.parametrize(
    "options", [{"rtol": 0}, {"rtol": 2}, {"rtol": np.nan}, {"max_iterations": 0}]
)
def test_options_outside_their_values_are_refused(options):
    with pytest.raises(InvalidOptionError):
        gt.CG(**options)


@final
@dataclass(frozen=True, kw_only=True)
class WithHeat(gt.LinearSolver):
    """A solver that names another one for the heat."""

    componentwise: ClassVar[bool] = False

    def for_heat(self):
        return gt.SuperLU()

    def factorize(self, matrix):
        return gt.SuperLU().factorize(matrix)


def test_the_heat_step_takes_the_solver_that_the_chosen_one_names():
    assert resolve_solvers(WithHeat()) == (gt.SuperLU(), WithHeat())
    assert resolve_solvers(gt.SuperLU()) == (gt.SuperLU(), gt.SuperLU())
    assert resolve_solvers(gt.CG()) == (gt.Supernodal(compact=False), gt.CG())
    assert resolve_solvers(gt.CG(allow_heat=True)) == (gt.CG(allow_heat=True),) * 2


def test_every_process_leads_unless_its_solver_says_otherwise():
    assert gt.Supernodal().leads()


def test_missing_heat_is_filled_from_neighbours_ring_by_ring():
    path = csr_array(np.diag(np.full(4, 2.0)) - np.eye(4, k=1) - np.eye(4, k=-1) + np.eye(4))
    heat, log_heat = np.array([1.0, -0.1, 0.0, -0.3]), np.array([0.0, *[-np.inf] * 3])
    missing = np.array([False, True, True, True])
    fill_from_neighbours(CompressedRows.of(path), heat, missing, logarithmic=False)
    fill_from_neighbours(CompressedRows.of(path), log_heat, missing, logarithmic=True)
    assert (heat > 0).all()
    assert (np.diff(heat) < 0).all()
    np.testing.assert_allclose(log_heat, np.log(heat))


@pytest.mark.parametrize("seed", range(20))
def test_heat_is_filled_as_its_readable_form_fills_it(seed):
    rng = np.random.default_rng(seed)
    graph = random_array((60, 60), density=rng.uniform(0.01, 0.08), rng=rng, format="csr")
    weights = csr_array(graph + graph.T)
    signs = np.where(rng.random(weights.nnz) < 0.1, 1.0, -1.0)
    weights.data = weights.data * np.where(rng.random(weights.nnz) < 0.1, 0.0, signs)
    matrix = csr_array(weights + diags_array(rng.uniform(1, 9, 60)))
    heat = rng.random((60, 3))
    missing = rng.random(60) < rng.uniform(0.1, 0.95)
    expected = np.where(missing, 0.0, heat[:, 1])
    rows = (matrix.indptr, matrix.indices, matrix.data)
    slow_kernels.fill(*rows, expected, np.flatnonzero(missing))
    fill_from_neighbours(CompressedRows.of(matrix), heat[:, 1], missing, logarithmic=False)
    np.testing.assert_allclose(heat[:, 1], expected, rtol=1e-13)


def test_heat_far_below_what_floats_hold_is_filled_as_its_logarithm():
    path = csr_array(np.diag(np.full(3, 2.0)) - np.eye(3, k=1) - np.eye(3, k=-1))
    log_heat = np.array([-5000.0, -np.inf, -5001.0])
    fill_from_neighbours(CompressedRows.of(path), log_heat, np.isinf(log_heat), logarithmic=True)
    assert log_heat[1] == pytest.approx(-5000 + np.log((1 + np.exp(-1.0)) / 2))


def test_what_no_value_reaches_stays_empty():
    apart = csr_array(np.eye(3))
    heat, log_heat = np.array([1.0, -1.0, 0.0]), np.array([0.0, -np.inf, -np.inf])
    missing = np.array([False, True, True])
    fill_from_neighbours(CompressedRows.of(apart), heat, missing, logarithmic=False)
    fill_from_neighbours(CompressedRows.of(apart), log_heat, missing, logarithmic=True)
    np.testing.assert_array_equal(heat, [1.0, 0.0, 0.0])
    np.testing.assert_array_equal(log_heat, [0.0, -np.inf, -np.inf])
