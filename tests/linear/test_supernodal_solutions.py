"""The built-in solver: dense fronts, factors and solutions, compared with libraries."""

from decimal import Decimal, localcontext
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matrices import (
    LAPLACIANS,
    SOLVER,
    arrow,
    graph_laplacian,
    graphs,
    grid,
    panels_of,
    path,
    plus,
    random_definite,
)
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csr_array, diags_array

import geodesic_toolkit as gt
from geodesic_toolkit import _native
from geodesic_toolkit.core.frozen import freeze
from geodesic_toolkit.errors import SolverError
from geodesic_toolkit.testing import shapes

# -- dense fronts ----------------------------------------------------------------------------------


def front(height, width, seed=0):
    """The first columns of a random positive definite matrix, and all of it."""
    root = np.random.default_rng(seed).normal(size=(height, height)) / np.sqrt(height)
    whole = root @ root.T + np.eye(height)
    return whole[:width].flatten(), whole


TALL, PACKED, CHUNK = 2 * _native.LANES, 320, 128
"""Rows of a tile, rows from which on they are packed, and columns at once."""


HEIGHTS = [*range(1, 2 * TALL + 2), CHUNK + 1, PACKED + 1, PACKED + CHUNK + 5]
WIDTHS = [1, 2, 3, 4, 5, 8, CHUNK - 1, CHUNK, CHUNK + 1, 2 * CHUNK + 6]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("height", "width"), [(tall, wide) for tall in HEIGHTS for wide in WIDTHS if wide <= tall]
)
def test_fronts_of_all_shapes_are_eliminated_as_by_dense_cholesky(height, width):
    below = height - width
    panel, whole = front(height, width)
    failed, update = _native.eliminate_front(panel, height, width)
    assert failed == -1
    lower = np.linalg.cholesky(whole)
    found = np.tril(panel[: height * width].reshape(width, height).T)
    np.fill_diagonal(found, 1 / np.diagonal(found))
    np.testing.assert_allclose(found, lower[:, :width], atol=1e-13)
    left = np.tril(update.reshape(below, below).T)
    np.testing.assert_allclose(
        left, np.tril(-lower[width:, :width] @ lower[width:, :width].T), atol=1e-13
    )


@pytest.mark.parametrize("bad", [0, 1, 2, 3, 4, 6, CHUNK, CHUNK + 1])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan])
def test_a_front_names_the_first_column_without_a_pivot(bad, value):
    height = CHUNK + 20
    panel, _ = front(height, height - 10)
    panel[bad * height + bad] = value
    assert _native.eliminate_front(panel, height, height - 10)[0] == bad


# -- numbers below the normal ones -----------------------------------------------------------------


def test_subnormal_entries_count_for_nothing_and_are_back_afterwards():
    """They cost a hundred times as much; what is left of a chain behind them is exactly zero."""
    n = 400
    heat = plus(1e-2 * path(n), 1.0)
    load = np.zeros(n)
    load[0] = 1.0
    smallest = np.finfo(np.float64).tiny
    found = SOLVER.factorize(heat)
    for solution in (found.solve(load), found.solve(load[:, None] * [1, 1, 1])[:, 1]):
        assert solution[0] > 0.9
        assert (solution == 0).any()
        assert not ((solution > 0) & (solution < smallest)).any()
    assert np.nextafter(0.0, 1.0) * np.float64(2.0) > 0
    with pytest.raises(SolverError):
        SOLVER.factorize(path(10))
    assert np.nextafter(0.0, 1.0) * np.float64(2.0) > 0


# -- factors and solutions against libraries -------------------------------------------------------


@pytest.mark.parametrize("kind", ["M-matrix", "both signs"])
def test_hundreds_of_random_systems_are_solved_as_by_dense_cholesky(kind):
    for seed in range(150):
        rng = np.random.default_rng(seed)
        matrix = random_definite(rng, kind)
        load = rng.normal(size=(matrix.shape[0], int(rng.integers(1, 20))))
        exact = cho_solve(cho_factor(matrix.toarray()), load)
        found = SOLVER.factorize(matrix)
        np.testing.assert_allclose(found.solve(load), exact, atol=1e-11 * np.abs(exact).max())
        first = found.solve(load[:, 0])
        np.testing.assert_allclose(first, exact[:, 0], atol=1e-11 * np.abs(exact).max())


@pytest.mark.parametrize("kind", ["M-matrix", "both signs"])
def test_unknowns_in_any_units_are_solved_for(kind):
    for seed in range(50):
        rng = np.random.default_rng(seed)
        matrix = random_definite(rng, kind)
        units = 10.0 ** rng.uniform(-50, 50, matrix.shape[0])
        load = rng.normal(size=(matrix.shape[0], 3))
        scaled = csr_array(diags_array(units) @ matrix @ diags_array(units))
        got = SOLVER.factorize(scaled).solve(units[:, None] * load) * units[:, None]
        exact = cho_solve(cho_factor(matrix.toarray()), load)
        np.testing.assert_allclose(got, exact, atol=1e-10 * np.abs(exact).max())


@pytest.mark.parametrize("shift", [1e-3, 1.0, 1e3])
def test_systems_of_shapes_are_solved_as_by_superlu(laplacian, shift):
    system = plus(laplacian, shift)
    load = np.random.default_rng(1).normal(size=(system.shape[0], 3))
    expected = gt.SuperLU().factorize(system).solve(load)
    got = SOLVER.factorize(system).solve(load)
    np.testing.assert_allclose(got, expected, atol=1e-11 * np.abs(expected).max())


@pytest.mark.slow
def test_the_panels_hold_the_cholesky_factor(laplacian):
    system = plus(laplacian, 0.5)
    found = SOLVER.factorize(system)
    its, n, panels = found._analysis, system.shape[0], panels_of(found)
    lower = np.zeros((n, n))
    for s in range(len(its.parents)):
        columns = slice(its.first[s], its.first[s + 1])
        rows = its.rows[its.row_starts[s] : its.row_starts[s + 1]]
        panel = panels[its.panels[s] : its.panels[s + 1]]
        lower[rows, columns] = panel.reshape(-1, len(rows)).T
    np.fill_diagonal(lower, 1 / np.diagonal(lower))
    exact = np.linalg.cholesky(system.toarray()[np.ix_(its.order, its.order)])
    np.testing.assert_allclose(np.tril(lower), exact, atol=1e-12 * np.abs(exact).max())
    assert not panels[found.nnz :].any()  # what is read behind the last column
    assert not panels.flags.writeable
    assert found.nbytes == 8 * len(panels)
    assert repr(found) == f"SupernodalFactor({n} unknowns, {found.nnz} entries)"


# -- right-hand sides ------------------------------------------------------------------------------


@pytest.mark.parametrize("columns", [1, 2, 3, 15, 16, 17, 40])
def test_a_block_is_solved_as_its_columns_are(laplacian, columns):
    found = SOLVER.factorize(plus(laplacian, 0.1))
    load = np.random.default_rng(2).normal(size=(laplacian.shape[0], columns))
    together = found.solve(load)
    assert together.shape == load.shape
    for k in range(columns):
        alone = found.solve(load[:, k])
        np.testing.assert_allclose(together[:, k], alone, atol=1e-13 * np.abs(alone).max())


def test_a_column_does_not_depend_on_its_place_in_a_block(laplacian):
    found = SOLVER.factorize(plus(laplacian, 0.1))
    load = np.random.default_rng(3).normal(size=(laplacian.shape[0], 20))
    turned = found.solve(np.roll(load, 7, axis=1))
    np.testing.assert_array_equal(np.roll(turned, -7, axis=1), found.solve(load))


@pytest.mark.parametrize("columns", [0, 1, 2, 7, 16, 20])
def test_a_solution_may_take_the_place_of_its_load(laplacian, columns):
    found = SOLVER.factorize(plus(laplacian, 0.1))
    load = np.random.default_rng(4).normal(size=(laplacian.shape[0], columns)[: 1 + (columns > 0)])
    expected, given = found.solve(load), load.copy()
    np.testing.assert_array_equal(found.solve_over(given), expected)
    np.testing.assert_array_equal(given, expected)
    np.testing.assert_array_equal(found.solve_over(freeze(load.copy())), expected)
    turned = np.asfortranarray(np.column_stack([load, load]))
    kept = turned.copy()
    np.testing.assert_array_equal(found.solve_over(turned), found.solve(kept))


def test_a_load_of_another_kind_of_double_is_left_as_it_was(laplacian):
    found = SOLVER.factorize(plus(laplacian, 0.1))
    kind = np.dtype(np.float64, metadata={"unit": "m"})
    load = np.random.default_rng(4).normal(size=laplacian.shape[0]).astype(kind)
    before = load.copy()
    found.solve(load)
    np.testing.assert_array_equal(load, before)


def test_solutions_whose_sum_overflows_are_solutions():
    matrix = csr_array(np.diag([1.0, 1.0, 1.0]))
    load = np.array([1.5e308, 1.5e308, 1.0])
    np.testing.assert_array_equal(SOLVER.factorize(matrix).solve(load), load)


def test_an_empty_block_has_an_empty_solution(laplacian):
    n = laplacian.shape[0]
    assert SOLVER.factorize(plus(laplacian, 1.0)).solve(np.empty((n, 0))).shape == (n, 0)


@pytest.mark.parametrize("kind", ["icosphere", "several parts", "wide on much", "star"])
def test_a_unit_vector_at_every_vertex_is_solved_as_a_full_column(kind):
    """Zeros save work; a number too small to count, everywhere, makes all of it be done."""
    system = plus(LAPLACIANS[kind](), 0.1)
    found, unit = SOLVER.factorize(system), np.eye(system.shape[0])
    full = np.where(unit == 0, 1e-250, unit)
    by_block = found.solve(unit)
    np.testing.assert_allclose(by_block, found.solve(full), rtol=1e-12, atol=1e-200)
    np.testing.assert_allclose(by_block, np.linalg.inv(system.toarray()), atol=1e-11)
    for k in range(system.shape[0]):
        alone = found.solve(unit[k])
        np.testing.assert_array_equal(alone, found.solve(full[k]) * (by_block[:, k] != 0))


def test_parts_that_no_load_touches_stay_exactly_zero():
    matrix = plus(LAPLACIANS["several parts"](), 1.0)
    load = np.zeros(matrix.shape[0])
    load[0] = 1.0
    solution = SOLVER.factorize(matrix).solve(load)
    part = shapes.icosphere(2).n_vertices
    assert (solution[:part] != 0).all()
    assert (solution[part:] == 0).all()


def test_memory_order_and_type_of_a_load_do_not_matter(laplacian):
    found = SOLVER.factorize(plus(laplacian, 1.0))
    whole = np.random.default_rng(4).integers(-9, 9, size=(laplacian.shape[0], 8))
    load = whole.astype(np.float64)
    expected = found.solve(load)
    for same in (np.asfortranarray(load), load.astype(np.float32), whole, load.tolist()):
        np.testing.assert_array_equal(found.solve(same), expected)
    np.testing.assert_array_equal(found.solve(load[:, ::2]), expected[:, ::2])
    np.testing.assert_array_equal(found.solve(load[:, 3]), found.solve(load[:, 3].copy()))
    load.flags.writeable = False
    np.testing.assert_array_equal(found.solve(load), expected)


# -- every entry, however small --------------------------------------------------------------------


def chain_in_decimals(matrix, load):
    """Solve a tridiagonal system in sixty digits."""
    dense = matrix.tocsr()
    n = len(load)
    diagonal = [Decimal(float(x)) for x in dense.diagonal()]
    beside = [Decimal(float(x)) for x in dense.diagonal(1)]
    x = [Decimal(float(value)) for value in load]
    with localcontext(prec=60):
        for k in range(1, n):
            ratio = beside[k - 1] / diagonal[k - 1]
            diagonal[k] -= ratio * beside[k - 1]
            x[k] -= ratio * x[k - 1]
        for k in range(n - 1, -1, -1):
            x[k] = (x[k] - (beside[k] * x[k + 1] if k + 1 < n else 0)) / diagonal[k]
    return np.array([float(value) for value in x])


def dense_in_long_doubles(matrix, load):
    """Eliminate without pivoting, as is right for an M-matrix, in more digits."""
    a, x = matrix.toarray().astype(np.longdouble), load.astype(np.longdouble)
    n = len(x)
    for k in range(n - 1):
        below = a[k + 1 :, k] / a[k, k]
        a[k + 1 :, k + 1 :] -= below[:, None] * a[k, k + 1 :]
        x[k + 1 :] -= below * x[k]
    for k in range(n - 1, -1, -1):
        x[k] = (x[k] - a[k, k + 1 :] @ x[k + 1 :]) / a[k, k]
    return x.astype(np.float64)


@pytest.mark.parametrize(("n", "time"), [(700, 1.0), (140, 0.01), (3000, 20.0)])
def test_heat_on_a_chain_is_right_in_every_entry_down_to_1e_300(n, time):
    rng = np.random.default_rng(n)
    weights = rng.uniform(0.8, 1.2, n - 1)
    heat = plus(time * graph_laplacian(n, list(pairwise(range(n))), weights), 1.0)
    load = np.zeros(n)
    load[0] = 1.0
    exact = chain_in_decimals(heat, load)
    assert 1e-306 < exact.min() < 1e-240
    shuffle = rng.permutation(n)
    shuffled = csr_array(heat[shuffle][:, shuffle])
    for system, order in ((heat, np.arange(n)), (shuffled, shuffle)):
        found = SOLVER.factorize(system)
        np.testing.assert_allclose(found.solve(load[order]), exact[order], rtol=1e-12)
        block = found.solve(np.stack([load[order], 2 * load[order]], axis=1))
        np.testing.assert_allclose(block, np.outer(exact, [1, 2])[order], rtol=1e-12)


@pytest.mark.parametrize(
    ("laplacian", "time"),
    [(grid(20, 20), 1e-7), (grid(6, 60), 2e-5), (arrow(8, 30), 1e-3)],
    ids=["grid", "strip", "cliques"],
)
def test_heat_is_right_in_every_entry_on_graphs(laplacian, time):
    """The supernodes of these are of several columns."""
    heat = plus(time * laplacian, 1.0)
    load = np.zeros(heat.shape[0])
    load[0] = 1.0
    exact = dense_in_long_doubles(heat, load)
    found = SOLVER.factorize(heat)
    np.testing.assert_allclose(found.solve(load), exact, rtol=1e-12)
    np.testing.assert_allclose(found.solve(load[:, None] * [1, 1])[:, 1], exact, rtol=1e-12)


def test_heat_on_a_long_tube_is_right_in_every_entry():
    tube = gt.CotanLaplacian().assemble(shapes.tube(70, 6))
    heat = plus(1e-3 * tube.stiffness, tube.mass)
    load = np.zeros(heat.shape[0])
    load[:6] = 1.0
    exact = dense_in_long_doubles(heat, load)
    assert 0 < exact.min() < 1e-150
    np.testing.assert_allclose(SOLVER.factorize(heat).solve(load), exact, rtol=1e-12)


@settings(max_examples=30)
@given(graphs(), st.integers(0, 2**32 - 1))
def test_any_pattern_made_diagonally_dominant_is_solved(pattern, seed):
    rng = np.random.default_rng(seed)
    half = pattern.copy()
    half.data = rng.normal(size=half.nnz)
    matrix = csr_array(half + half.T)
    dominant = np.abs(matrix).sum(axis=1) + rng.uniform(0.5, 1, matrix.shape[0])
    matrix = plus(matrix - diags_array(matrix.diagonal()), dominant)
    load = rng.normal(size=matrix.shape[0])
    np.testing.assert_allclose(matrix @ SOLVER.factorize(matrix).solve(load), load, atol=1e-12)
