"""Factors of which only the upper half of each number is kept."""

import numpy as np
import pytest
from scipy.sparse import csr_array, diags_array

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, SolverError
from geodesic_toolkit.linear.patterns import plus_diagonal
from geodesic_toolkit.registry.catalog import resolve_solvers
from geodesic_toolkit.testing import shapes

FULL, COMPACT = gt.Supernodal(), gt.Supernodal(compact=True)
DIGITS = 2.0**-21
"""Largest relative error of the upper half of a number."""


def grid(n, m):
    """A triangulated rectangle of unit squares."""
    x, y = np.meshgrid(np.arange(float(n)), np.arange(float(m)), indexing="ij")
    corner = (np.arange(n - 1)[:, None] * m + np.arange(m - 1)).ravel()
    lower = np.column_stack([corner, corner + m, corner + 1])
    upper = np.column_stack([corner + 1, corner + m, corner + m + 1])
    vertices = np.column_stack([x.ravel(), y.ravel(), np.zeros(n * m)])
    return gt.TriangleMesh(vertices, np.concatenate([lower, upper]))


def heat_system(mesh):
    metric = gt.CotanLaplacian().assemble(mesh)
    return plus_diagonal(metric.rows, metric.mass, metric.scales**2).scipy


@pytest.fixture(scope="module")
def sphere_system():
    return heat_system(shapes.icosphere(4))


def test_every_number_is_rounded_to_its_upper_half(sphere_system):
    full, compact = (linear.factorize(sphere_system)._factor.panels for linear in (FULL, COMPACT))
    assert compact.dtype == np.uint32
    widened = (compact.astype(np.uint64) << np.uint64(32)).view(np.float64)
    np.testing.assert_allclose(widened, full, rtol=DIGITS, atol=0)


def test_it_takes_half_the_memory_and_says_so(sphere_system):
    full, compact = FULL.factorize(sphere_system), COMPACT.factorize(sphere_system)
    assert 2 * compact.nbytes == full.nbytes
    assert compact.nnz == full.nnz


@pytest.mark.parametrize("columns", [None, 1, 2, 5, 16, 20])
def test_solutions_have_six_digits(sphere_system, columns):
    n = sphere_system.shape[0]
    load = np.random.default_rng(0).normal(size=n if columns is None else (n, columns))
    exact, found = (solver.factorize(sphere_system).solve(load) for solver in (FULL, COMPACT))
    np.testing.assert_allclose(found, exact, atol=2e-6 * np.abs(exact).max())


@pytest.mark.parametrize("mesh", [grid(350, 350), shapes.tube(300, 8)], ids=["grid", "tube"])
def test_heat_is_right_in_every_entry_however_small(mesh):
    """Single precision ends at 1e-45, which a long separator exceeds."""
    system = heat_system(mesh)
    load = np.zeros(system.shape[0])
    load[0] = 1.0
    exact, found = (solver.factorize(system).solve(load) for solver in (FULL, COMPACT))
    assert 0 < exact.min() < 1e-100
    np.testing.assert_allclose(found, exact, rtol=1e-4)


def test_distances_agree_with_those_of_a_full_factor():
    mesh = grid(150, 150)
    full, compact = (gt.GeodesicSolver(mesh, solver=linear) for linear in (FULL, COMPACT))
    exact = full.distances([0, 11_000])
    found = compact.distances([0, 11_000])
    np.testing.assert_allclose(found, exact, atol=1e-5 * exact.max())
    assert found[0, 0] == found[1, 11_000] == 0


def test_a_matrix_that_needs_all_its_digits_keeps_them():
    """A chain that is almost not grounded."""
    n, held = 3000, 1e-9
    chain = diags_array(
        [np.full(n - 1, -1.0), np.r_[1.0, np.full(n - 2, 2.0), 1.0] + held, np.full(n - 1, -1.0)],
        offsets=[-1, 0, 1],
    )
    system = csr_array(chain)
    load = np.random.default_rng(0).normal(size=n)
    full, compact = FULL.factorize(system), COMPACT.factorize(system)
    assert compact.nbytes == full.nbytes
    np.testing.assert_array_equal(compact.solve(load), full.solve(load))


def test_a_matrix_whose_row_sums_overflow_keeps_its_factor_in_full():
    system = csr_array(np.array([[1.7e308, 1e308], [1e308, 1.7e308]]))
    full, compact = FULL.factorize(system), COMPACT.factorize(system)
    load = np.array([1e308, -1e308])
    np.testing.assert_array_equal(compact.solve(load), full.solve(load))


def test_what_a_full_factor_refuses_is_refused():
    with pytest.raises(SolverError, match="not positive definite"):
        COMPACT.factorize(csr_array(np.array([[1.0, 2.0], [2.0, 1.0]])))


def test_a_matrix_without_unknowns_has_an_empty_factor():
    assert COMPACT.factorize(csr_array((0, 0))).solve(np.zeros(0)).shape == (0,)


@pytest.mark.parametrize("compact", ["yes", 1, None])
def test_compact_is_true_or_false(compact):
    with pytest.raises(InvalidOptionError, match="compact must be True or False"):
        gt.Supernodal(compact=compact)


@pytest.mark.parametrize(("vertices", "compact"), [(19_999, False), (20_000, True)])
def test_auto_keeps_halves_of_what_does_not_stay_in_cache(vertices, compact):
    assert resolve_solvers("auto", vertices) == (gt.Supernodal(compact=compact),) * 2


def test_auto_keeps_halves_of_heat_that_gives_nothing_but_an_order():
    mesh = shapes.icosphere(2)
    solver = gt.GeodesicSolver(mesh, refine=True)
    assert solver.method.heat_solver == COMPACT
    whole = gt.GeodesicSolver(mesh, refine=True, solver=FULL)
    np.testing.assert_allclose(solver.distance(3), whole.distance(3), rtol=1e-6)
