"""Tangent frames at vertices, and the turns from them into elements."""

import pickle

import numpy as np
import pytest
from curved_shapes import irregular_plate, irregular_sphere, moebius

import geodesic_toolkit as gt
from geodesic_toolkit import _native
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.geometry.frames import fans_of
from geodesic_toolkit.geometry.intrinsic import delaunay_triangles
from geodesic_toolkit.geometry.normals import oriented_normals
from geodesic_toolkit.geometry.triangles import face_edge_lengths
from geodesic_toolkit.laplacians.tangents import default_frames

SHEARED = gt.testing.shapes.grid(12, shear=4.0)


def frames_of(mesh, **options):
    operator = gt.CotanLaplacian(**options)
    metric = operator.assemble(mesh)
    return operator.frames(mesh, metric), metric


def test_normals_of_a_sphere_are_its_radii():
    mesh = irregular_sphere(400)
    frames, _ = frames_of(mesh)
    np.testing.assert_allclose(frames.normals, mesh.vertices, atol=1e-12)


def test_axes_are_orthonormal_and_right_handed():
    frames, _ = frames_of(irregular_sphere(200))
    triad = np.stack([frames.x_axes, frames.y_axes, frames.normals], axis=1)
    np.testing.assert_allclose(
        triad @ triad.transpose(0, 2, 1), np.tile(np.eye(3), (200, 1, 1)), atol=1e-14
    )
    np.testing.assert_allclose(np.linalg.det(triad), 1.0)


@pytest.mark.parametrize("delaunay", [False, True])
@pytest.mark.parametrize("mesh", [irregular_plate(12), SHEARED])
def test_in_the_plane_turns_take_edges_to_where_elements_have_them(mesh, delaunay):
    frames, metric = frames_of(mesh, intrinsic_delaunay=delaunay)
    surface = metric.on_surface
    p, q, r = surface.inverse_frames.T
    corners = np.stack([0 * p, 1 / p, -q / (p * r) + 1j / r], axis=1)
    places = mesh.vertices[surface.elements]
    for c in range(3):
        step = places[:, (c + 1) % 3] - places[:, c]
        at = frames.to_frames(step, surface.elements[:, c])
        np.testing.assert_allclose(
            at * frames.surface_turns[:, c], corners[:, (c + 1) % 3] - corners[:, c], atol=1e-12
        )


@pytest.mark.parametrize("delaunay", [False, True])
def test_in_the_plane_all_turns_of_an_element_are_one(delaunay):
    frames, metric = frames_of(SHEARED, intrinsic_delaunay=delaunay)
    assert (metric.surface is not None) == delaunay  # trapezoids along the rim
    np.testing.assert_allclose(frames.turns, np.tile(frames.turns[:, :1], (1, 3)), atol=1e-12)


def test_directions_of_trapezoids_are_those_of_the_rim_that_they_are_along():
    frames, metric = frames_of(SHEARED, intrinsic_delaunay=True)
    elements = metric.gradient.elements
    flat = elements[:, 1] == elements[:, 2]
    assert flat.sum() > 10
    # A linear function that changes along each rim alone has its slope there.
    for vertices, turns, slopes in zip(
        elements[flat], frames.turns[flat], metric.gradient.inverse_frames[flat], strict=True
    ):
        along = frames.to_space(turns[:1].conj(), vertices[:1])[0]  # the first axis, in space
        step = SHEARED.vertices[vertices[1]] - SHEARED.vertices[vertices[0]]
        assert along @ step == pytest.approx(1 / slopes[0], rel=1e-9)


def test_flips_that_carry_directions_are_the_same_flips():
    mesh = SHEARED
    lengths = face_edge_lengths(mesh.vertices, mesh.faces)
    _, _, (fans,) = fans_of(mesh.vertices, [(mesh.faces, lengths)])
    flipped = fans.delaunay()
    for own, other in zip(
        (flipped.elements, flipped.lengths, flipped.twin),
        delaunay_triangles(mesh.faces, lengths),
        strict=True,
    ):
        np.testing.assert_array_equal(own, other)
    assert (flipped.elements != mesh.faces).any()


def test_the_least_rotations_and_the_angles_about_vertices_are_alike_on_a_smooth_surface():
    mesh = irregular_sphere(1500)
    frames, metric = frames_of(mesh)
    other = default_frames(mesh, metric)
    np.testing.assert_array_equal(other.x_axes, frames.x_axes)
    off = np.degrees(np.abs(np.angle(frames.turns / other.turns)))
    assert off.mean() < 0.5
    assert off.max() < 5


def test_holonomy_round_the_tip_of_a_pyramid_is_what_its_angles_lack():
    sides = 7
    mesh = gt.testing.shapes.pyramid(sides, 4, height=0.8)
    frames, metric = frames_of(mesh)
    elements = metric.gradient.elements
    round_trip = 1.0
    for j in range(sides):
        (row,) = np.flatnonzero(
            (elements == 0).any(axis=1)
            & (elements == 1 + j).any(axis=1)
            & (elements == 1 + (j + 1) % sides).any(axis=1)
        )
        one = frames.turns[row, np.flatnonzero(elements[row] == 1 + j)[0]]
        other = frames.turns[row, np.flatnonzero(elements[row] == 1 + (j + 1) % sides)[0]]
        round_trip *= one * other.conj()
    defect = _native.angle_defects(elements, metric.gradient.inverse_frames, metric.boundary)[0]
    assert np.angle(round_trip) == pytest.approx(defect, abs=1e-9)


def test_a_face_turned_over_has_the_frames_of_its_neighbours():
    mesh = irregular_sphere(300)
    faces = mesh.faces.copy()
    faces[::3] = faces[::3, ::-1]
    frames, _ = frames_of(gt.TriangleMesh(mesh.vertices, faces))
    whole, _ = frames_of(mesh)
    np.testing.assert_array_equal(frames.mirrored, np.arange(len(faces)) % 3 == 0)
    np.testing.assert_allclose(frames.normals, whole.normals, atol=1e-12)
    assert np.abs(np.abs(frames.turns) - 1).max() < 1e-12


@pytest.mark.parametrize("delaunay", [False, True])
def test_a_one_sided_surface_is_refused_with_the_face_that_closes_it(delaunay):
    operator = gt.CotanLaplacian(intrinsic_delaunay=delaunay)
    strip = moebius()
    metric = operator.assemble(strip)
    with pytest.raises(UnsupportedDomainError, match=r"one-sided.*face of vertices"):
        operator.frames(strip, metric)
    with pytest.raises(UnsupportedDomainError, match="one-sided"):
        default_frames(strip, metric)


def test_a_graph_is_refused_because_an_edge_has_no_angle():
    solver = gt.GeodesicSolver(gt.Graph(3, [[0, 1], [1, 2]]))
    with pytest.raises(UnsupportedDomainError, match="an edge has no angle"):
        gt.tangent_frames(solver)


def test_the_edges_of_a_mesh_have_frames():
    mesh = irregular_plate(6)
    frames = gt.GeodesicSolver(mesh, operator="uniform").frames
    assert frames.turns.shape[1] == 2
    np.testing.assert_allclose(frames.turns[:, 0], frames.turns[:, 1], atol=1e-12)


def test_normals_of_a_cloud_look_outwards_whatever_signs_they_came_with():
    points = irregular_sphere(600).vertices
    frames = gt.GeodesicSolver(gt.PointCloud(points)).frames
    assert np.einsum("nd,nd->n", frames.normals, points).min() > 0.95


def test_given_normals_of_a_cloud_are_taken_as_they_are():
    points = irregular_sphere(600).vertices
    frames = gt.GeodesicSolver(gt.PointCloud(points, normals=-points)).frames
    np.testing.assert_allclose(frames.normals, -points, atol=1e-12)
    assert frames.mirrored.sum() == 0  # stars run counterclockwise, seen from their normals


def test_signs_of_normals_go_along_the_tree_of_each_part():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [9, 0, 0]])
    normals = np.array([[0.0, 0, -1], [0, 0, 1], [0, 0.8, -0.6], [0, 0, -1]])
    told = oriented_normals(points, normals, np.array([[0, 1], [1, 2], [2, 1]]))
    np.testing.assert_array_equal(told, [[0, 0, 1], [0, 0, 1], [0, -0.8, 0.6], [0, 0, 1]])


def test_missing_and_repeated_points_have_frames():
    points = irregular_sphere(300).vertices
    cloud = gt.PointCloud(np.concatenate([points, points[:5], [[np.nan] * 3]]))
    frames = gt.GeodesicSolver(cloud).frames
    assert np.isfinite(frames.turns).all()
    np.testing.assert_allclose(frames.normals[300:305], frames.normals[:5], atol=1e-9)


def test_zero_area_faces_and_unused_vertices_have_frames():
    mesh = gt.TriangleMesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0.5, 0], [5, 5, 5]],
        [[0, 1, 2], [1, 2, 3], [0, 0, 1], [1, 0, 2]],
    )
    frames, metric = frames_of(mesh)
    assert np.abs(np.abs(frames.turns) - 1).max() < 1e-12
    np.testing.assert_array_equal(frames.normals[4], [0, 0, 1])
    assert frames.turns.shape == metric.gradient.elements.shape


def test_tangent_frames_turn_numbers_into_vectors_and_back():
    solver = gt.GeodesicSolver(irregular_sphere(200))
    frames = gt.tangent_frames(solver)
    given = np.random.default_rng(0).normal(size=(200, 2))
    vectors = frames.to_space(given)
    np.testing.assert_allclose(np.einsum("nd,nd->n", vectors, frames.normals), 0, atol=1e-12)
    np.testing.assert_allclose(frames.to_frame(vectors + 3 * frames.normals), given, atol=1e-12)
    again = pickle.loads(pickle.dumps(frames))
    np.testing.assert_array_equal(again.x_axes, frames.x_axes)
    assert not again.x_axes.flags.writeable


@pytest.mark.parametrize("values", [np.ones((3, 2)), "abc", None])
def test_something_else_than_a_table_of_vectors_is_refused(values):
    frames = gt.tangent_frames(gt.GeodesicSolver(irregular_plate(5)))
    with pytest.raises(InvalidOptionError, match="coordinates must"):
        frames.to_space(values)


def test_something_else_than_a_solver_is_refused():
    with pytest.raises(InvalidOptionError, match="tangent_frames needs a GeodesicSolver"):
        gt.tangent_frames(irregular_plate(5))
