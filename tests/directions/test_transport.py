"""Parallel transport along the shortest geodesics from the nearest of some sources."""

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
    InvalidOptionError,
    InvalidSourceError,
    UnsupportedDomainError,
)

shapes = gt.testing.shapes
PLATE = irregular_plate(15)


def carried(mesh, sources, vectors, **options):
    return gt.parallel_transport(gt.GeodesicSolver(mesh), sources, vectors, refine=True, **options)


@pytest.mark.parametrize("source", [0, 100, gt.SurfacePoint(200, (0.5, 0.5, 0.0))])
@pytest.mark.parametrize("mesh", [PLATE, shapes.grid(15, shear=3.0)])
def test_in_the_plane_vectors_stay_as_they_are(mesh, source):
    vector = np.array([1.0, -2.0, 0.0])
    got = carried(mesh, source, vector)
    np.testing.assert_allclose(got, np.tile(vector, (mesh.n_vertices, 1)), rtol=0, atol=1e-4)


@pytest.mark.parametrize(
    "sources",
    [
        [0, 224, 112],
        [gt.SurfacePoint(5, (0.3, 0.3, 0.4)), gt.SurfacePoint(200, (0.5, 0.5, 0.0))],
    ],
)
def test_where_the_cells_of_sources_meet_the_angle_is_nearly_right(sources):
    vector = np.array([1.0, -2.0, 0.0])
    got = carried(PLATE, sources, np.tile(vector, (len(sources), 1)))
    off = degrees_between(got, np.tile(vector, (225, 1)))
    assert np.median(off) < 1e-3
    assert off.mean() < 1.0


def test_far_along_a_tube_it_is_exact_where_fronts_from_both_sides_meet():
    tube = shapes.tube(400, 48)
    x, y, _ = tube.vertices.T
    around = np.column_stack([-y, x, 0 * x]) / np.hypot(x, y)[:, None]
    assert degrees_between(carried(tube, 5, around[5]), around).max() < 1e-6


def test_behind_a_hole_vectors_do_not_turn_as_the_paths_around_it_do():
    grid = shapes.grid(25)
    middle = grid.vertices[grid.faces].mean(axis=1) / grid.vertices.max(axis=0).max()
    beside = (np.abs(middle[:, :2] - 0.5) > 0.2).any(axis=1)
    used, faces = np.unique(grid.faces[beside], return_inverse=True)
    mesh = gt.TriangleMesh(grid.vertices[used], faces.reshape(-1, 3))
    vector = np.array([1.0, 0.3, 0.0])
    got = carried(mesh, 0, vector)
    np.testing.assert_allclose(got, np.tile(vector, (mesh.n_vertices, 1)), rtol=0, atol=1e-9)


def test_on_spheres_it_goes_along_great_circles_with_second_order():
    errors = []
    for n in (600, 2400):
        mesh = irregular_sphere(n)
        vector = np.cross(mesh.vertices[0], [0.2, 0.5, -0.6])
        want = transported_on_sphere(mesh.vertices, 0, vector)
        near = mesh.vertices @ mesh.vertices[0] > np.cos(2.5)
        errors.append(degrees_between(carried(mesh, 0, vector)[near], want[near]).mean())
    assert errors[1] < 0.2
    assert errors[0] / errors[1] > 2.5


def test_vectors_keep_their_lengths_and_stay_tangent():
    mesh = irregular_sphere(900)
    solver = gt.GeodesicSolver(mesh)
    frames = gt.tangent_frames(solver)
    vectors = 3.0 * frames.x_axes[[0, 10]]
    got = gt.parallel_transport(solver, [0, 10], vectors, refine=True)
    np.testing.assert_allclose(np.linalg.norm(got, axis=1), 3.0)
    np.testing.assert_allclose(np.einsum("nd,nd->n", got, frames.normals), 0.0, atol=1e-12)
    np.testing.assert_allclose(got[[0, 10]], vectors)


def test_along_the_sides_of_a_pyramid_nothing_turns():
    mesh = shapes.pyramid(6, rings=8)
    source = 1 + 3 * 6
    along = mesh.vertices[1 + 4 * 6] - mesh.vertices[source]
    got = carried(mesh, source, along)
    for ring in range(4, 8):
        assert degrees_between(got[1 + ring * 6], along) < 0.5


def test_where_nothing_connects_there_is_no_vector():
    both = shapes.disjoint_union(shapes.grid(3), shapes.grid(3))
    got = carried(both, 0, [1.0, 0.0, 0.0])
    assert (got[9:] == 0).all()
    np.testing.assert_allclose(got[:9], np.tile([1.0, 0, 0], (9, 1)), atol=1e-6)


def test_the_source_that_starts_late_loses_ground():
    square = shapes.grid(9)
    late = gt.OffsetSources([0, 80], [0.0, 10.0])
    got = carried(square, late, [[1.0, 0, 0], [0, 1.0, 0]])
    np.testing.assert_allclose(got, np.tile([1.0, 0, 0], (81, 1)), atol=1e-6)


def test_plain_transport_is_that_of_vector_heat():
    solver = gt.GeodesicSolver(PLATE, refine=False)
    got = gt.parallel_transport(solver, 0, [1.0, 0.0, 0.0])
    np.testing.assert_allclose(got, np.tile([1.0, 0, 0], (225, 1)), atol=1e-6)


@pytest.mark.parametrize(
    ("sources", "vectors", "error", "message"),
    [
        ([0, 1], [1.0, 0, 0], InvalidOptionError, r"shape \(2, 3\)"),
        (0, [1.0, 0.0], InvalidOptionError, "shape"),
        (0, ["a"], InvalidOptionError, "numbers"),
        (0, [np.nan, 0, 0], InvalidOptionError, "vector 0 is not finite"),
        ([0, 1], [[1.0, 0, 0], [0, 0, 0]], InvalidSourceError, "vector 1"),
        (0, [0.0, 0, 1], InvalidSourceError, "right angle"),
        (10**6, [1.0, 0, 0], InvalidSourceError, "does not exist"),
        (gt.Curve([[0, 0, 0], [1, 0, 0]]), [1.0, 0, 0], InvalidSourceError, "curve"),
    ],
)
def test_what_cannot_be_carried_is_named(sources, vectors, error, message):
    with pytest.raises(error, match=message):
        carried(PLATE, sources, vectors)


def test_a_graph_has_no_vectors():
    with pytest.raises(UnsupportedDomainError, match="an edge has no angle"):
        carried(gt.Graph(2, [[0, 1]]), 0, [1.0, 0, 0])
