"""Are distances right where a closed form is known, and on real meshes?"""

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit_polygon import PolygonLaplacian, PolygonMesh
from geodesic_toolkit_polygon.samples import hexagons, l_shapes, quad_sphere, quads

FLAT = {"quadrangles": quads(6), "hexagons": hexagons(5), "L shapes": l_shapes(2)}

SWEPT_ON_PLANES = 0.002
"""Mean relative error of fronts on a plane: they are exact but where two rows of triangles meet."""

TARGET = 0.005
"""Mean relative error on real meshes; measured: 0.02 to 0.2 %."""

REAL = (
    "igltut__horse_quad.obj",
    "igltut__inspired_mesh_quads_Smooth.off",
    "potpourri3d__bunny_poly.ply",
    "odedstein__spot_control_mesh.obj",
)

SOURCES = 5


def mean_error(distance, exact):
    known = np.isfinite(exact) & (exact > 0)
    return np.abs(distance[known] / exact[known] - 1).mean()


@pytest.mark.parametrize("mesh", FLAT.values(), ids=FLAT)
def test_the_gradient_of_a_linear_function_is_exact_on_planes(mesh):
    gradient = PolygonLaplacian().assemble(mesh).gradient
    direction = np.array([0.3, -0.8, 0.0])
    slopes = (gradient.matrix @ (mesh.positions @ direction)).reshape(-1, 2)
    assert np.linalg.norm(slopes, axis=1) == pytest.approx(np.linalg.norm(direction), rel=1e-12)


@pytest.mark.parametrize("mesh", FLAT.values(), ids=FLAT)
def test_linear_functions_are_harmonic_inside_of_planes(mesh):
    discretization = PolygonLaplacian().assemble(mesh)
    pull = discretization.stiffness @ mesh.positions[:, :2]
    assert np.abs(pull[~discretization.boundary]).max() < 1e-12


@pytest.mark.parametrize("mesh", FLAT.values(), ids=FLAT)
def test_distances_on_a_plane_are_straight(mesh):
    inner = int(np.abs(mesh.positions - mesh.positions.mean(axis=0)).sum(axis=1).argmin())
    exact = np.linalg.norm(mesh.positions - mesh.positions[inner], axis=1)
    clear = slice(None)
    if mesh is FLAT["hexagons"]:  # its rim is not straight: lines leave the plane near it
        clear = np.abs(mesh.positions - mesh.positions[inner]).max(axis=1) < 0.5
    assert mean_error(gt.geodesic_distance(mesh, inner)[clear], exact[clear]) < SWEPT_ON_PLANES


def test_on_spheres_of_quadrangles_errors_fall_with_the_square_of_the_edge():
    errors = []
    for n in (8, 16, 32):
        mesh = quad_sphere(n)
        exact = np.arccos(np.clip(mesh.positions @ mesh.positions[0], -1, 1))
        errors.append(mean_error(gt.geodesic_distance(mesh, 0), exact))
    order = np.log2(errors[0] / errors[2]) / 2
    assert order > 1.7
    assert errors[2] < 0.001


def test_plain_heat_on_a_sphere_of_quadrangles_is_better_than_on_its_triangles():
    mesh = quad_sphere(12)
    exact = np.arccos(np.clip(mesh.positions @ mesh.positions[0], -1, 1))
    split = gt.TriangleMesh(mesh.positions, mesh.triangles)
    polygons = gt.GeodesicSolver(mesh, refine=False).distance(0)
    triangles = gt.GeodesicSolver(split, refine=False).distance(0)
    assert mean_error(polygons, exact) < 0.7 * mean_error(triangles, exact)


@pytest.mark.parametrize("refine", [True, False])
def test_distances_do_not_depend_on_the_corner_that_a_face_begins_with(refine):
    mesh = quad_sphere(12)
    turned = PolygonMesh(mesh.positions, [np.roll(face, k) for k, face in enumerate(mesh.faces)])
    one, other = (gt.GeodesicSolver(m, refine=refine).distance(7) for m in (mesh, turned))
    assert np.abs(one - other).max() < 1e-4


def test_triangles_are_what_they_are_as_a_triangle_mesh():
    ball = gt.testing.shapes.icosphere(2)
    mesh = PolygonMesh.of(ball)
    ours = PolygonLaplacian().assemble(mesh)
    theirs = gt.CotanLaplacian().assemble(ball)
    assert np.abs((ours.stiffness - theirs.stiffness).toarray()).max() < 1e-12
    assert ours.mass == pytest.approx(theirs.mass, rel=1e-12)
    assert gt.geodesic_distance(mesh, 0) == pytest.approx(gt.geodesic_distance(ball, 0), rel=1e-9)


def test_small_meshes_are_exact():
    mesh = quad_sphere(4)
    exact = gt.exact_distance(mesh.surface, 0)[: mesh.n_vertices]
    assert gt.geodesic_distance(mesh, 0) == pytest.approx(exact, abs=1e-12)


@pytest.mark.parametrize("name", REAL)
def test_real_meshes_are_within_half_a_per_cent(shared_data, name):
    mesh = PolygonMesh.from_file(shared_data(name))
    solver, count = gt.GeodesicSolver(mesh), mesh.n_vertices
    errors = [
        mean_error(solver.distance(int(s)), gt.exact_distance(mesh.surface, int(s))[:count])
        for s in np.linspace(0, count - 1, SOURCES).astype(int)
    ]
    assert np.mean(errors) < TARGET


@pytest.mark.parametrize("mesh", [quads(12), quad_sphere(8)], ids=["plane", "sphere"])
def test_plain_heat_is_closer_than_that_of_potpourri3d(mesh):
    peer = pytest.importorskip("potpourri3d")
    other = peer.PolygonMeshHeatSolver(mesh.positions, [face.tolist() for face in mesh.faces])
    exact = gt.exact_distance(mesh.surface, 0)[: mesh.n_vertices]
    ours = gt.GeodesicSolver(mesh, refine=False).distance(0)
    assert mean_error(ours, exact) < mean_error(other.compute_distance([0]), exact)
