"""Does it agree with the default solver, and refuse heat by name?"""

import numpy as np
import pytest
from scipy.sparse import csr_array

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, SolverError
from geodesic_toolkit_amg import AMG

AGREEMENT = 1e-6
"""Difference of distances from those of the default solver, relative to the largest."""


@pytest.mark.parametrize(
    "domain",
    [gt.testing.shapes.icosphere(4), gt.PointCloud(gt.testing.shapes.icosphere(4).vertices)],
    ids=repr,
)
def test_distances_agree_with_those_of_the_default_solver(domain):
    ours = gt.GeodesicSolver(domain, solver="amg", refine=False).distance(0)
    default = gt.GeodesicSolver(domain, refine=False).distance(0)
    assert np.abs(ours - default).max() < AGREEMENT * default.max()


def test_obtuse_triangles_do_not_keep_it_from_the_solution():
    sheared = gt.testing.shapes.grid(60, shear=3.0)
    operator = gt.CotanLaplacian(intrinsic_delaunay=False)
    options = {"operator": operator, "refine": False, "diffusion": "uniform"}
    ours = gt.GeodesicSolver(sheared, solver="amg", **options).distance(0)
    default = gt.GeodesicSolver(sheared, **options).distance(0)
    assert np.abs(ours - default).max() < AGREEMENT * default.max()


def test_heat_is_refused_unless_it_is_insisted_on():
    sphere = gt.testing.shapes.icosphere(2)
    with pytest.raises(InvalidOptionError, match="heat"):
        gt.GeodesicSolver(sphere, solver={"heat": "amg"}, refine=False).distance(0)
    studied = gt.GeodesicSolver(sphere, solver=AMG(allow_heat=True), refine=False)
    assert np.isfinite(studied.distance(0)).all()


def test_a_matrix_with_a_negative_diagonal_is_refused():
    with pytest.raises(SolverError, match="diagonal entry 1 is -2"):
        AMG().factorize(csr_array([[1.0, 0.0], [0.0, -2.0]]))


def test_too_few_iterations_are_an_error_that_says_so():
    plane = gt.CotanLaplacian().assemble(gt.testing.shapes.grid(60))
    matrix = plane.stiffness + csr_array(np.diag(plane.mass * 1e-3))
    with pytest.raises(SolverError, match=r"residual .* after 1 iterations"):
        AMG(max_iterations=1).factorize(csr_array(matrix))


@pytest.mark.parametrize(
    ("option", "value"), [("rtol", 0.0), ("strength", 1.0), ("max_iterations", 0)]
)
def test_an_option_out_of_range_is_refused(option, value):
    with pytest.raises(InvalidOptionError, match=option):
        AMG(**{option: value})
