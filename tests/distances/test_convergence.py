"""Closed forms: errors of plain heat, and that they fall as the mesh is refined."""

from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from closed_forms import (
    around_torus_ring,
    mean_relative_error,
    on_plane,
    on_sphere,
    on_tube,
)

import geodesic_toolkit as gt
from geodesic_toolkit.testing import shapes

# Mean relative error allowed on the finest mesh of each family, from what was measured
# (0.98 %, 0.70 %, 0.40 %, 3.3 %), and the factor by which it must fall per halving of h
# (measured 0.62-0.66, 0.52-0.62, 0.44-0.50, 0.63-0.70; the heat method is first order at best).
SQUARE_TOLERANCE = 0.012
SPHERE_TOLERANCE = 0.009
CYLINDER_TOLERANCE = 0.006
TORUS_RING_TOLERANCE = 0.04
HALVING = 0.75


# The coarsest of the meshes are warned of, and their errors are what is measured here.
pytestmark = pytest.mark.filterwarnings("ignore::geodesic_toolkit.errors.CoarseMeshWarning")

plain_heat = partial(gt.geodesic_distance, refine=False)


def square_errors():
    for n in (11, 21, 41, 81):
        mesh = shapes.grid(n)
        centre = n * (n // 2) + n // 2
        yield mean_relative_error(plain_heat(mesh, centre), on_plane(mesh, centre))


def sphere_errors():
    for level in (2, 3, 4, 5):
        mesh = shapes.icosphere(level)
        yield mean_relative_error(plain_heat(mesh, 0), on_sphere(mesh, 0))


def cylinder_errors():
    for around in (8, 16, 32, 64):
        rings = 3 * around // 2
        distance = plain_heat(shapes.tube(rings, around), 0)
        yield mean_relative_error(distance, on_tube(rings, around))


def torus_ring_errors():
    for m in (12, 24, 48):
        distance = plain_heat(shapes.torus(5 * m, m, minor=0.5), 0)[:m]
        yield mean_relative_error(distance, around_torus_ring(m, 0.5))


@pytest.mark.parametrize(
    ("errors", "tolerance"),
    [
        (square_errors, SQUARE_TOLERANCE),
        (sphere_errors, SPHERE_TOLERANCE),
        (cylinder_errors, CYLINDER_TOLERANCE),
        (torus_ring_errors, TORUS_RING_TOLERANCE),
    ],
)
def test_the_error_falls_under_refinement_and_ends_small(errors, tolerance):
    sequence = list(errors())
    assert sequence[-1] < tolerance
    assert all(fine < HALVING * coarse for coarse, fine in pairwise(sequence))


@pytest.mark.parametrize("boundary", ["neumann", "dirichlet", "average"])
def test_every_boundary_condition_converges_on_the_square(boundary):
    errors = []
    for n in (11, 21, 41):
        mesh = shapes.grid(n)
        centre = n * (n // 2) + n // 2
        distance = plain_heat(mesh, centre, boundary=boundary)
        errors.append(mean_relative_error(distance, on_plane(mesh, centre)))
    assert errors[2] < HALVING * errors[1] < HALVING**2 * errors[0]
    assert errors[2] < 0.016


def test_the_averaged_boundary_condition_is_the_best_on_the_square():
    mesh = shapes.grid(41)
    centre = 41 * 20 + 20
    error = {
        boundary: mean_relative_error(
            plain_heat(mesh, centre, boundary=boundary), on_plane(mesh, centre)
        )
        for boundary in ("neumann", "dirichlet", "average")
    }
    assert error["average"] < error["dirichlet"] < error["neumann"]


def test_a_smaller_time_step_is_sharper_than_a_larger_one():
    mesh = shapes.grid(41)
    exact = on_plane(mesh, 840)
    sharp, smooth = (
        mean_relative_error(plain_heat(mesh, 840, time_factor=factor), exact)
        for factor in (1.0, 100.0)
    )
    assert sharp < 0.5 * smooth


@pytest.mark.parametrize("shear", [1.0, 3.0])
def test_auto_cures_a_sheared_grid_that_plain_cotan_gets_wrong(shear):
    mesh = shapes.grid(40, shear=shear)
    exact = on_plane(mesh, 820)
    assert mean_relative_error(plain_heat(mesh, 820), exact) < 0.035
    with pytest.warns(gt.errors.NonPositiveHeatWarning, match="intrinsic_delaunay=True"):
        plain = plain_heat(mesh, 820, operator="cotan")
    assert mean_relative_error(plain, exact) > 0.2


def test_scaling_the_mesh_scales_the_distance():
    mesh = shapes.icosphere(3)
    distance = plain_heat(mesh, 0)
    for scale in (1e-6, 1e12):
        scaled = gt.TriangleMesh(scale * mesh.vertices, mesh.faces)
        np.testing.assert_allclose(
            plain_heat(scaled, 0), scale * distance, rtol=1e-9, atol=1e-9 * scale
        )


def test_a_rigid_motion_far_from_the_origin_changes_nothing():
    mesh = shapes.icosphere(3)
    rotation, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))
    moved = gt.TriangleMesh(mesh.vertices @ rotation.T + 1e6, mesh.faces)
    np.testing.assert_allclose(plain_heat(moved, 0), plain_heat(mesh, 0), atol=1e-7)
