"""Real forms of complex Hermitian systems, which the vector heat method solves."""

import numpy as np
import pytest
from scipy.sparse import csr_array

import geodesic_toolkit as gt
from geodesic_toolkit.core.rows import CompressedRows
from geodesic_toolkit.errors import NotEnoughMemoryError, SolverError
from geodesic_toolkit.linear import memory
from geodesic_toolkit.linear.patterns import factorize_pairs

SOLVERS = [gt.Supernodal(), gt.Supernodal(compact=True), gt.solvers["superlu"]()]


def hermitian(n, seed=0):
    """Return a pattern, a complex matrix and its real form."""
    rng = np.random.default_rng(seed)
    upper = np.triu(rng.random((n, n)) < 3 / n, 1)
    entries = upper * np.exp(1j * rng.uniform(0, 6, (n, n)))
    full = entries + entries.conj().T + 12 * np.eye(n)
    pattern = CompressedRows.of(csr_array((full != 0).astype(float)))
    real = np.zeros((2 * n, 2 * n))
    real[::2, ::2] = real[1::2, 1::2] = full.real
    real[1::2, ::2], real[::2, 1::2] = full.imag, -full.imag
    form = csr_array(real)
    blocks = csr_array(np.kron(full != 0, np.ones((2, 2))))
    values = np.asarray(real[blocks.nonzero()])
    form = csr_array((values, blocks.indices, blocks.indptr), shape=blocks.shape)
    return pattern, full, CompressedRows.of(form)


@pytest.mark.parametrize("solver", SOLVERS, ids=repr)
@pytest.mark.parametrize("n", [1, 2, 60, 300])
def test_a_complex_system_is_solved(solver, n):
    pattern, full, form = hermitian(n)
    load = np.exp(1j * np.arange(n))
    solution = factorize_pairs(solver, form, pattern).solve(load.view(np.float64))
    np.testing.assert_allclose(
        solution.view(np.complex128), np.linalg.solve(full, load), rtol=1e-11
    )


def test_several_columns_are_solved_at_once():
    pattern, full, form = hermitian(80)
    loads = np.random.default_rng(1).normal(size=(160, 5))
    found = factorize_pairs(gt.Supernodal(), form, pattern).solve(loads)
    want = np.linalg.solve(full, loads[::2] + 1j * loads[1::2])
    np.testing.assert_allclose(found[::2] + 1j * found[1::2], want, atol=1e-12)


def test_the_analysis_of_a_real_system_of_the_pattern_serves_again():
    pattern, _, form = hermitian(120)
    solver = gt.Supernodal()
    known, other = solver.analyse(pattern), solver.analyse(hermitian(120, seed=1)[0])
    load = np.cos(np.arange(240))
    found = [factorize_pairs(solver, form, pattern, at).solve(load) for at in (None, known, other)]
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])


def test_a_factor_of_complex_numbers_takes_half_the_memory_of_its_real_form():
    vectors = gt.GeodesicSolver(gt.testing.shapes.icosphere(4)).vector_heat
    matrix = vectors.connection.plus_mass(vectors.heat.metric.mass, vectors.heat.times)
    pairs = factorize_pairs(gt.Supernodal(), matrix, vectors.connection.pattern)
    assert pairs.nbytes < 0.6 * gt.Supernodal().factorize(matrix).nbytes


def test_a_complex_matrix_that_is_not_definite_is_refused():
    pattern, _, form = hermitian(30)
    data = form.data - 20 * (form.row_of_entry == form.indices)
    with pytest.raises(SolverError, match="not positive definite"):
        factorize_pairs(gt.Supernodal(), form.with_data(data), pattern)


def test_a_complex_factor_that_would_not_fit_is_not_begun(monkeypatch):
    pattern, _, form = hermitian(300)
    monkeypatch.setattr(memory, "available_memory", lambda: 1e3)
    monkeypatch.setattr(memory, "MIN_BYTES_CHECKED", 0)
    with pytest.raises(NotEnoughMemoryError, match="600 unknowns"):
        factorize_pairs(gt.Supernodal(), form, pattern)
