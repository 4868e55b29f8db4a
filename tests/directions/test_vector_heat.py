"""Vectors in heat: the connection Laplacian, parallel transport, extension, logarithms."""

import dataclasses
import pickle

import numpy as np
import pytest
from curved_shapes import (
    degrees_between,
    irregular_plate,
    irregular_sphere,
    transported_on_sphere,
)

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidDiscretizationError,
    InvalidSourceError,
    NotEnoughMemoryError,
    UnsupportedDomainError,
)
from geodesic_toolkit.vector_heat import VectorHeatMethod, connection
from geodesic_toolkit.vector_heat.connection import connection_along_edges, connection_laplacian

AXIS = np.array([1.0, 0.0, 0.0])


def transported(solver, sources, vectors):
    """Vectors of the nearest source at all vertices, in space."""
    heat = solver.vector_heat
    return heat.frames.to_space(heat.transport(solver.locate(sources), vectors))


def two_balls():
    ball = irregular_sphere(200)
    vertices = np.concatenate([ball.vertices, ball.vertices + np.array([5.0, 0, 0])])
    return gt.TriangleMesh(vertices, np.concatenate([ball.faces, ball.faces + 200]))


SHAPES = {
    "sphere": irregular_sphere(150),
    "sheared": gt.testing.shapes.grid(8, shear=4.0),
    "cloud": gt.PointCloud(irregular_sphere(150).vertices),
}


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("operator", ["auto", "robust"])
def test_the_connection_laplacian_is_hermitian_and_semidefinite(name, operator):
    if operator == "robust":
        pytest.importorskip("geodesic_toolkit_robust")
    matrix = gt.GeodesicSolver(SHAPES[name], operator=operator).connection.toarray()
    assert np.abs(matrix - matrix.conj().T).max() < 1e-12 * np.abs(matrix).max()
    lowest = np.linalg.eigvalsh(matrix)
    assert lowest[0] > -1e-10 * lowest[-1]


@pytest.mark.parametrize("name", SHAPES)
def test_without_turning_it_is_the_laplacian(name):
    solver = gt.GeodesicSolver(SHAPES[name])
    metric = solver.method.metric
    trivial = dataclasses.replace(solver.frames, turns=np.ones_like(solver.frames.turns))
    difference = connection_laplacian(metric, trivial).scipy - metric.stiffness
    assert np.abs(difference.toarray()).max() < 1e-10 * np.abs(metric.stiffness.data).max()


def test_turned_axes_turn_its_entries():
    solver = gt.GeodesicSolver(SHAPES["sphere"])
    frames, elements = solver.frames, solver.method.metric.gradient.elements
    gauge = np.exp(1j * np.random.default_rng(0).uniform(0, 6, len(frames.normals)))
    turned = dataclasses.replace(frames, turns=frames.turns * gauge[elements])
    own = connection_laplacian(solver.method.metric, frames).scipy.toarray()
    other = connection_laplacian(solver.method.metric, turned).scipy.toarray()
    np.testing.assert_allclose(gauge.conj()[:, None] * own * gauge, other, atol=1e-12)


def test_turns_of_other_elements_are_refused():
    solver = gt.GeodesicSolver(SHAPES["sphere"])
    other = gt.GeodesicSolver(irregular_sphere(100)).frames
    with pytest.raises(InvalidDiscretizationError, match=r"turns .* must be one for each corner"):
        connection_laplacian(solver.method.metric, other)


def test_elements_of_a_solid_are_refused():
    metric = gt.GeodesicSolver(SHAPES["sphere"]).method.metric
    solid = gt.ElementGradient(np.array([[0, 1, 2, 3]]), np.zeros((1, 3, 4)), np.ones(1), 150)
    with pytest.raises(InvalidDiscretizationError, match="needs triangles or edges"):
        connection_laplacian(dataclasses.replace(metric, gradient=solid), None)


def test_more_entries_than_32_bits_count_are_refused(monkeypatch):
    monkeypatch.setattr(connection, "MOST_ENTRIES", 1000)
    solver = gt.GeodesicSolver(SHAPES["sphere"])
    with pytest.raises(NotEnoughMemoryError, match="vector heat of 150 vertices"):
        solver.vector_heat.prepare()


# -- parallel transport ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "mesh",
    [irregular_plate(20), *(gt.testing.shapes.grid(20, shear=shear) for shear in (2.0, 4.0))],
)
@pytest.mark.parametrize("delaunay", [False, True, "auto"])
def test_in_the_plane_transport_changes_nothing(mesh, delaunay):
    # Without flips heat is negative on sheared plates, and directions would be turned over.
    solver = gt.GeodesicSolver(mesh, operator=gt.CotanLaplacian(intrinsic_delaunay=delaunay))
    got = transported(solver, 210, [AXIS])
    np.testing.assert_allclose(got, np.tile(AXIS, (mesh.n_vertices, 1)), atol=1e-9)


def test_on_a_sphere_it_is_that_along_great_circles():
    mesh = irregular_sphere(1500)
    solver = gt.GeodesicSolver(mesh)
    vector = solver.frames.x_axes[7]
    off = degrees_between(
        transported(solver, 7, [vector]), transported_on_sphere(mesh.vertices, 7, vector)
    )
    near = mesh.vertices @ mesh.vertices[7] > -0.9
    assert off[near].mean() < 0.7  # 0.53


def test_from_within_a_face_it_is_as_good():
    mesh = irregular_sphere(1500)
    solver = gt.GeodesicSolver(mesh)
    vector = solver.frames.x_axes[mesh.faces[11, 0]]
    got = transported(solver, gt.SurfacePoint(11, (0.4, 0.3, 0.3)), [vector])
    exact = transported_on_sphere(mesh.vertices, mesh.faces[11, 0], vector)
    near = mesh.vertices @ mesh.vertices[mesh.faces[11, 0]] > 0
    assert degrees_between(got, exact)[near].mean() < 1.0


def test_on_a_cloud_it_is_nearly_as_good():
    points = irregular_sphere(1500).vertices
    solver = gt.GeodesicSolver(gt.PointCloud(points))
    vector = solver.frames.x_axes[7]
    off = degrees_between(
        transported(solver, 7, [vector]), transported_on_sphere(points, 7, vector)
    )
    assert off[points @ points[7] > -0.9].mean() < 1.5  # 0.9


@pytest.mark.parametrize("options", [{"operator": "robust"}, {"diffusion": "robust"}])
def test_it_goes_through_the_operator_of_a_plugin(options):
    pytest.importorskip("geodesic_toolkit_robust")
    mesh = irregular_sphere(800)
    solver = gt.GeodesicSolver(mesh, **options)
    vector = solver.frames.x_axes[7]
    off = degrees_between(
        transported(solver, 7, [vector]), transported_on_sphere(mesh.vertices, 7, vector)
    )
    assert off[mesh.vertices @ mesh.vertices[7] > -0.9].mean() < 1.5


def test_it_reaches_the_far_end_of_a_tube():
    mesh = gt.testing.shapes.tube(1200, 24)
    solver = gt.GeodesicSolver(mesh)
    x, y, _ = mesh.vertices.T
    around = np.column_stack([-y, x, 0 * x])
    around /= np.linalg.norm(around, axis=1, keepdims=True)
    got = transported(solver, 5, [around[5]])
    assert degrees_between(got, around).max() < 1e-6


def test_each_vertex_takes_the_vector_of_the_nearest_source_with_its_length():
    mesh = irregular_plate(20)
    solver = gt.GeodesicSolver(mesh)
    corners = [int(np.abs(mesh.vertices[:, :2] - c).sum(axis=1).argmin()) for c in (0.0, 1.0)]
    got = transported(solver, corners, [[1.0, 0, 0], [0, 2.0, 0]])
    middle = mesh.vertices[:, :2].sum(axis=1)
    first, last = middle < 0.6, middle > 1.4
    np.testing.assert_allclose(got[first], np.tile([1.0, 0, 0], (first.sum(), 1)), atol=0.1)
    np.testing.assert_allclose(got[last], np.tile([0, 2.0, 0], (last.sum(), 1)), atol=0.1)


def test_nothing_comes_to_what_is_not_connected():
    solver = gt.GeodesicSolver(two_balls())
    got = transported(solver, 0, solver.frames.x_axes[:1])
    np.testing.assert_array_equal(got[200:], 0)
    np.testing.assert_allclose(np.linalg.norm(got[:200], axis=1), 1)


@pytest.mark.parametrize("vector", [[0.0, 0, 0], [0, 0, 3.0], [np.nan, 0, 0]])
def test_a_vector_without_a_direction_is_refused_by_its_number(vector):
    solver = gt.GeodesicSolver(irregular_plate(6))
    with pytest.raises(InvalidSourceError, match=r"vector 1, .*no direction along the surface"):
        transported(solver, [0, 5], [AXIS, vector])


def test_a_solver_that_does_not_resolve_small_values_makes_one_solve():
    mesh = irregular_plate(12)
    solver = gt.GeodesicSolver(mesh, solver=gt.CG(allow_heat=True, rtol=1e-12))
    got = transported(solver, 40, [AXIS])
    near = np.linalg.norm(mesh.vertices - mesh.vertices[40], axis=1) < 0.3
    np.testing.assert_allclose(got[near], np.tile(AXIS, (near.sum(), 1)), atol=1e-6)


def test_boundaries_are_insulated_whatever_holds_for_distances():
    mesh = irregular_plate(10)
    solver = gt.GeodesicSolver(mesh, boundary="dirichlet")
    got = transported(solver, [0, 50], [AXIS, 2 * AXIS])
    np.testing.assert_allclose(got[:, 1:], 0, atol=1e-9)
    assert (got[:, 0] >= 1 - 1e-9).all()


def test_a_solver_travels_without_its_vector_heat_and_makes_it_again():
    solver = gt.GeodesicSolver(irregular_plate(6))
    own = transported(solver, 0, [AXIS])
    other = pickle.loads(pickle.dumps(solver))
    np.testing.assert_array_equal(transported(other, 0, [AXIS]), own)
    assert solver.vector_heat.nbytes > 0


# -- extension -------------------------------------------------------------------------------------


def test_values_are_extended_to_the_cells_of_their_sources():
    mesh = irregular_plate(20)
    solver = gt.GeodesicSolver(mesh)
    corners = [int(np.abs(mesh.vertices[:, :2] - c).sum(axis=1).argmin()) for c in (0.0, 1.0)]
    got = solver.vector_heat.extend(solver.locate(corners), np.array([[1.0, -3.0], [2.0, -3.0]]))
    middle = mesh.vertices[:, :2].sum(axis=1)
    assert np.abs(got[middle < 0.6, 0] - 1).max() < 0.05
    assert np.abs(got[middle > 1.4, 0] - 2).max() < 0.05
    np.testing.assert_array_equal(got[:, 1], -3.0)
    assert got[:, 0].min() >= 1
    assert got[:, 0].max() <= 2


def test_no_value_is_extended_to_what_is_not_connected():
    solver = gt.GeodesicSolver(two_balls())
    got = solver.vector_heat.extend(solver.locate([0, 50]), np.array([4.0, 5.0]))
    assert np.isnan(got[200:]).all()
    assert (got[:200] >= 4).all()


def test_values_are_extended_in_positive_heat_where_the_own_turns_negative():
    mesh = gt.testing.shapes.grid(20, shear=4.0)
    solver = gt.GeodesicSolver(mesh, operator=gt.CotanLaplacian(intrinsic_delaunay=False))
    got = solver.vector_heat.extend(solver.locate([0, 399]), np.array([0.0, 1.0]))
    assert np.isfinite(got).all()
    assert 0 <= got.min() < got.max() <= 1


def bent_tube(rings, *, twisted=0):
    """A tube with some obtuse angles, each of the last rings turned by three more sides."""
    mesh = gt.testing.shapes.tube(rings, 24)
    x, y, z = mesh.vertices.T
    ring = np.arange(mesh.n_vertices) // 24
    turned = (x + 1j * y) * np.exp(2j * np.pi / 8 * np.maximum(ring - (rings - twisted), 0))
    shift = np.random.default_rng(0).uniform(-0.45, 0.45, mesh.n_vertices)
    height = z + shift * np.ptp(z) / (rings - 1)
    return gt.TriangleMesh(np.column_stack([turned.real, turned.imag, height]), mesh.faces)


WITH_WRONG_SIGNS = {
    "positive": (bent_tube(30), True),
    "negative": (gt.testing.shapes.grid(20, shear=4.0), False),
    "positive beyond floats": (bent_tube(1200), True),
    "negative beyond floats": (bent_tube(1200, twisted=20), False),
}


@pytest.mark.parametrize("case", WITH_WRONG_SIGNS)
def test_heat_is_found_positive_where_no_vertex_has_other_heat(case):
    mesh, is_positive = WITH_WRONG_SIGNS[case]
    method = gt.GeodesicSolver(
        mesh, operator=gt.CotanLaplacian(intrinsic_delaunay=False), refine=False
    ).method
    load = np.zeros(mesh.n_vertices)
    load[5] = 1.0
    rows = method.diffusion.rows
    assert (rows.data[rows.row_of_entry != rows.indices] > 0).any()
    assert (method.heat_report(5).non_positive == 0) == is_positive
    assert method.stays_positive(load) == is_positive


# -- the logarithm ---------------------------------------------------------------------------------


@pytest.mark.parametrize("source", [7, gt.SurfacePoint(11, (0.4, 0.3, 0.3)), "edge"])
def test_angles_of_the_logarithm_on_a_sphere(source):
    mesh = irregular_sphere(1500)
    if source == "edge":
        source = gt.SurfacePoint(11, (0.5, 0.5, 0.0))
    solver = gt.GeodesicSolver(mesh)
    places = solver.locate(source)
    centre = (places.shares[:, None] * mesh.vertices[places.vertices]).sum(axis=0)
    centre /= np.linalg.norm(centre)
    its = solver.vector_heat.log_map(places, solver.distance(source))
    got = its.coordinates.real[:, None] * its.axes[0] + its.coordinates.imag[:, None] * its.axes[1]
    away = mesh.vertices - (mesh.vertices @ centre)[:, None] * centre
    good = (mesh.vertices @ centre > -0.9) & (mesh.vertices @ centre < 0.99)
    assert degrees_between(got, away)[good].mean() < 3.0  # 0.7 from a vertex, 2.4 from an edge
    outward = solver.frames.to_space(its.arrival)
    exact = transported_on_sphere(mesh.vertices, int(places.nearest_vertices[0]), AXIS)
    assert exact.shape == outward.shape
    along = mesh.vertices * (mesh.vertices @ centre)[:, None] - centre
    assert degrees_between(outward, along)[good].mean() < 2.5


def test_the_logarithm_is_unknown_where_nothing_connects_and_zero_at_the_source():
    solver = gt.GeodesicSolver(two_balls())
    its = solver.vector_heat.log_map(solver.locate(3), solver.distance(3))
    assert its.coordinates[3] == 0
    assert np.isnan(its.coordinates[200:]).all()
    assert np.isfinite(its.coordinates[:200]).all()


def test_a_logarithm_needs_triangles():
    solver = gt.GeodesicSolver(irregular_plate(6), operator="uniform")
    with pytest.raises(UnsupportedDomainError, match="need triangles"):
        solver.vector_heat.log_map(solver.locate(0), solver.distance(0))


def test_turns_along_edges_that_no_element_has_are_the_least_rotations():
    mesh = irregular_sphere(300)
    solver = gt.GeodesicSolver(mesh)
    metric, frames = solver.method.metric, solver.frames
    some = dataclasses.replace(
        frames,
        turns=frames.turns[:1],
        mirrored=frames.mirrored[:1],
    )
    gradient = metric.gradient
    few = gt.ElementGradient.of_triangles(
        gradient.elements[:1], gradient.inverse_frames[:1], gradient.measure[:1], 300
    )
    lone = dataclasses.replace(metric, gradient=few)
    by_normals = connection_along_edges(metric, lone, some).scipy.toarray()
    by_elements = connection_along_edges(metric, metric, frames).scipy.toarray()
    assert np.abs(by_normals - by_elements).max() < 0.05 * np.abs(by_elements).max()


def test_the_method_says_what_its_factors_take():
    solver = gt.GeodesicSolver(irregular_plate(6))
    heat = VectorHeatMethod(solver.method, solver.frames)
    assert heat.nbytes == 0
    assert heat.prepare().nbytes > 0
