import numpy as np
import pytest
from scipy.sparse import csr_array, diags_array

import geodesic_toolkit as gt
from geodesic_toolkit.errors import SolverError

pytest.importorskip("petsc4py", reason="petsc4py is not installed: see the README")

from geodesic_toolkit_petsc import MUMPS, PETSc, peak_memory

SOLVERS = [PETSc(), PETSc(preconditioner="gamg"), MUMPS()]
EXACT = gt.Supernodal(compact=False)


def bumpy_torus():
    return gt.testing.shapes.bumpy_torus(rng=np.random.default_rng(0))


def shapes():
    sphere = gt.testing.shapes.icosphere(4)
    torus = bumpy_torus()
    return {
        "mesh": torus,
        "two parts": gt.testing.shapes.disjoint_union(sphere, torus),
        "cloud": gt.PointCloud(sphere.vertices),
        "graph": gt.Graph(sphere.n_vertices, sphere.faces[:, :2]),
    }


@pytest.mark.parametrize("solver", SOLVERS, ids=repr)
@pytest.mark.parametrize("shape", shapes().values(), ids=shapes().keys())
def test_plain_distances_agree_with_the_default_solver(shape, solver):
    expected = gt.GeodesicSolver(shape, refine=False, solver=EXACT).distances([0, 9])
    found = gt.GeodesicSolver(shape, refine=False, solver=solver).distances([0, 9])
    reached = np.isfinite(expected)
    assert (np.isfinite(found) == reached).all()
    assert found[reached] == pytest.approx(
        expected[reached], rel=0, abs=1e-6 * expected[reached].max()
    )


def test_refined_distances_agree_with_the_default_solver():
    torus = bumpy_torus()
    expected = gt.geodesic_distance(torus, 3)
    assert np.abs(gt.geodesic_distance(torus, 3, solver="petsc") - expected).max() < 1e-6


def test_heat_far_from_the_source_is_right():
    strip = gt.testing.shapes.grid(1500, 2)
    far = gt.GeodesicSolver(strip, refine=False, solver="petsc").method.log_heat(0)
    expected = gt.GeodesicSolver(strip, refine=False, solver=EXACT).method.log_heat(0)
    assert expected.min() < -800  # floats end at -745
    assert np.abs(far - expected).max() < 1e-9 * abs(expected.min())


def test_heat_is_left_to_mumps_unless_asked_otherwise():
    sphere = gt.testing.shapes.icosphere(2)
    method = gt.GeodesicSolver(sphere, solver="petsc").method
    assert (method.heat_solver, method.poisson_solver) == (MUMPS(), PETSc())
    by_iteration = PETSc(heat="cg")
    assert gt.GeodesicSolver(sphere, solver=by_iteration).method.heat_solver == by_iteration


def test_iterations_are_counted_and_do_not_grow_much():
    counts = []
    for level in (3, 5):
        discretization = gt.CotanLaplacian().assemble(gt.testing.shapes.icosphere(level))
        ground = np.zeros(discretization.n_vertices)
        ground[0] = discretization.stiffness.diagonal()[0]
        factor = PETSc().factorize(csr_array(discretization.stiffness + diags_array(ground)))
        factor.solve(np.random.default_rng(0).normal(size=(discretization.n_vertices, 2)))
        counts += factor.iterations
    assert len(counts) == 4
    assert max(counts) <= 20


def test_a_right_hand_side_of_zeros_gives_zeros():
    matrix = csr_array(diags_array(np.arange(1.0, 6.0)))
    for solver in SOLVERS:
        assert (solver.factorize(matrix).solve(np.zeros((5, 2))) == 0).all()


def test_columns_of_a_matrix_need_not_be_sorted():
    matrix = csr_array(([-1.0, 2.0, 2.0, -1.0], [1, 0, 1, 0], [0, 2, 4]), shape=(2, 2))
    for solver in SOLVERS:
        assert solver.factorize(matrix).solve(np.array([1.0, 1.0])) == pytest.approx([1.0, 1.0])


def test_a_matrix_that_is_not_positive_definite_is_refused():
    matrix = csr_array([[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    with pytest.raises(SolverError, match="positive definite"):
        MUMPS().factorize(matrix)


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan])
def test_a_bad_diagonal_entry_is_named(bad):
    with pytest.raises(SolverError, match="diagonal entry 2 is"):
        MUMPS().factorize(csr_array(diags_array([1.0, 1.0, bad])))


def test_too_few_iterations_are_an_error_that_says_what_to_do():
    ball = gt.CotanLaplacian().assemble(gt.testing.shapes.icosphere(4))
    matrix = csr_array(ball.stiffness + diags_array(np.full(ball.n_vertices, 1e-6)))
    factor = PETSc(max_iterations=1).factorize(matrix)
    with pytest.raises(SolverError, match="raise max_iterations"):
        factor.solve(np.random.default_rng(0).normal(size=ball.n_vertices))


def test_a_right_hand_side_that_is_not_finite_is_an_error():
    matrix = csr_array(diags_array([1.0, 2.0]))
    for solver in SOLVERS:
        with pytest.raises(SolverError):
            solver.factorize(matrix).solve(np.array([np.nan, 1.0]))


def test_factors_work_after_an_error_and_after_others_are_gone():
    matrix = csr_array(diags_array([1.0, 2.0]))
    kept = MUMPS().factorize(matrix)
    for _ in range(3):
        PETSc().factorize(matrix)  # gone at once
    with pytest.raises(SolverError):
        kept.solve(np.array([np.inf, 1.0]))
    assert kept.solve(np.array([1.0, 1.0])).tolist() == [1.0, 0.5]


def test_peak_memory_is_that_of_each_process():
    assert [peak > 1e7 for peak in peak_memory()] == [True]
