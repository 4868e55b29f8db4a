"""The exponential map: straightest lines from a point."""

import pickle

import numpy as np
import pytest
from curved_shapes import degrees_between, irregular_plate, irregular_sphere, moebius

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    UnsupportedDomainError,
)

RNG = np.random.default_rng(0)


def tangent_vectors(n, longest=1.0):
    angle, length = RNG.uniform(0, 2 * np.pi, n), RNG.uniform(0, longest, n)
    return length[:, None] * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])


@pytest.mark.parametrize("source", [210, [0.52, 0.47, 0.0], gt.SurfacePoint(333, (0.2, 0.5, 0.3))])
def test_in_the_plane_lines_are_straight(source):
    solver = gt.GeodesicSolver(irregular_plate(20))
    places = solver.locate(source)
    start = places.shares @ solver.domain.vertices[places.vertices]
    vectors = tangent_vectors(200, 0.6)
    lines = gt.exp_map(solver, source, vectors)
    ends = start + vectors
    inside = ((ends > 0) & (ends < 1))[:, :2].all(axis=1)
    np.testing.assert_allclose(lines.positions[inside], ends[inside], atol=1e-9)
    np.testing.assert_array_equal(lines.missing[inside], 0)
    assert (lines.missing[~inside] > 0).all()
    cut = (
        vectors[~inside]
        * (1 - lines.missing[~inside] / np.linalg.norm(vectors[~inside], axis=1))[:, None]
    )
    np.testing.assert_allclose(lines.positions[~inside], start + cut, atol=1e-9)
    moved = np.linalg.norm(lines.positions - start, axis=1) > 1e-9
    assert degrees_between(lines.arrival, vectors)[moved].max() < 1e-4


def test_a_line_through_a_vertex_and_one_along_an_edge_go_on():
    solver = gt.GeodesicSolver(gt.testing.shapes.grid(5))
    lines = gt.exp_map(solver, 0, [[1.0, 1.0, 0], [1.0, 0, 0], [0, 0.6, 0], [0, 0, 1.0]])
    np.testing.assert_allclose(
        lines.positions, [[1.0, 1.0, 0], [1.0, 0, 0], [0, 0.6, 0], [0, 0, 0]], atol=1e-9
    )
    np.testing.assert_allclose(lines.arrival[3], 0)


def test_on_a_sphere_lines_are_great_circles():
    mesh = irregular_sphere(3000)
    solver = gt.GeodesicSolver(mesh)
    frames = gt.tangent_frames(solver)
    angle = np.linspace(0, 6, 60)
    out = np.cos(angle)[:, None] * frames.x_axes[7] + np.sin(angle)[:, None] * frames.y_axes[7]
    lines = gt.exp_map(solver, 7, 1.5 * out)
    exact = np.cos(1.5) * mesh.vertices[7] + np.sin(1.5) * out
    assert np.linalg.norm(lines.positions - exact, axis=1).mean() < 0.02


def test_it_undoes_the_logarithm_on_a_pyramid():
    # The tip scales angles; beyond it the faces of one side are flat.
    mesh = gt.testing.shapes.pyramid(7, 4, height=0.8)
    solver = gt.GeodesicSolver(mesh)
    frames = solver.frames
    edge = frames.to_frames(mesh.vertices[1:8] - mesh.vertices[0], np.zeros(7, dtype=int))
    vectors = frames.to_space(edge / np.abs(edge) * 2.5, np.zeros(7, dtype=int))
    lines = gt.exp_map(solver, 0, vectors)
    along = mesh.vertices[1:8] / np.linalg.norm(mesh.vertices[1:8], axis=1, keepdims=True)
    np.testing.assert_allclose(lines.positions, 2.5 * along, atol=1e-6)


def test_faces_turned_over_change_nothing():
    mesh = irregular_sphere(400)
    faces = mesh.faces.copy()
    faces[::3] = faces[::3, ::-1]
    vectors = 2 * gt.GeodesicSolver(mesh).frames.x_axes[:1]
    own, other = (
        gt.exp_map(gt.GeodesicSolver(m), 0, vectors)
        for m in (mesh, gt.TriangleMesh(mesh.vertices, faces))
    )
    np.testing.assert_allclose(other.positions, own.positions, atol=1e-9)
    assert other.path(0).length == pytest.approx(2, rel=1e-9)


def test_paths_are_as_long_as_their_vectors_and_may_be_sources():
    solver = gt.GeodesicSolver(irregular_sphere(400))
    vectors = np.array([[0.5], [2.0]]) * solver.frames.x_axes[3]
    lines = gt.exp_map(solver, 3, vectors)
    assert [lines.path(i).length for i in range(2)] == pytest.approx([0.5, 2.0], rel=1e-9)
    assert np.isfinite(solver.distance(list(lines.points))).all()
    np.testing.assert_allclose(lines.path(1).points[-1], lines.positions[1], atol=1e-12)
    again = pickle.loads(pickle.dumps(lines))
    np.testing.assert_array_equal(again.positions, lines.positions)
    assert repr(lines) == "ExpMap(2 lines, 0 cut short)"
    with pytest.raises(InvalidOptionError, match="line 2 does not exist; there are 2"):
        lines.path(2)


def test_lines_end_at_a_mask_and_in_faces_of_the_whole_mesh():
    mesh = irregular_plate(20)
    wall = (np.abs(mesh.vertices[:, 0] - 0.5) < 0.06) & (mesh.vertices[:, 1] < 2)
    solver = gt.GeodesicSolver(mesh, mask=wall)
    source = int(np.abs(mesh.vertices - [0.1, 0.5, 0]).sum(axis=1).argmin())
    lines = gt.exp_map(solver, source, [[0.8, 0.0, 0.0], [0.05, 0, 0]])
    assert lines.missing[0] > 0.3
    corners = mesh.vertices[mesh.faces[lines.faces]]
    np.testing.assert_allclose(
        np.einsum("qc,qcd->qd", lines.barycentric, corners), lines.positions, atol=1e-12
    )


def test_lines_end_where_more_than_two_faces_meet():
    book = gt.TriangleMesh(
        [[0, 0, 0], [0, 0, 1], [1, 0, 0], [-1, 1, 0], [-1, -1, 0]],
        [[0, 1, 2], [0, 1, 3], [0, 1, 4]],
    )
    lines = gt.exp_map(gt.GeodesicSolver(book), gt.SurfacePoint(0, (0.4, 0.2, 0.4)), [[-1.0, 0, 0]])
    assert lines.missing[0] == pytest.approx(0.6)


@pytest.mark.parametrize(
    ("vectors", "message"),
    [
        ([[np.nan, 0, 0]], "vector 0 is .*not finite"),
        ([[1.0, 0, 0], [1e9, 0, 0]], "vector 1 is .*longer than 1e.06 mean edges"),
        ([[1.0, 0]], r"shape \(Q, 3\)"),
        ("abc", "must hold real numbers"),
    ],
)
def test_vectors_without_an_end_are_refused(vectors, message):
    with pytest.raises(InvalidOptionError, match=message):
        gt.exp_map(gt.GeodesicSolver(irregular_plate(5)), 0, vectors)


@pytest.mark.parametrize("source", [[0, 1], -1, 10**6, gt.Curve([[0, 0, 0], [1, 0, 0]])])
def test_what_is_not_one_place_is_refused(source):
    with pytest.raises(InvalidSourceError):
        gt.exp_map(gt.GeodesicSolver(irregular_plate(5)), source, [[1.0, 0, 0]])


def test_a_vertex_of_no_face_is_refused():
    mesh = gt.TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 9, 9]], [[0, 1, 2]])
    with pytest.raises(InvalidSourceError, match="vertex 3 belongs to no face"):
        gt.exp_map(gt.GeodesicSolver(mesh), 3, [[1.0, 0, 0]])


def test_clouds_graphs_and_one_sided_surfaces_are_refused():
    cloud = gt.GeodesicSolver(gt.PointCloud(irregular_sphere(100).vertices))
    with pytest.raises(UnsupportedDomainError, match="not over a PointCloud"):
        gt.exp_map(cloud, 0, [[1.0, 0, 0]])
    with pytest.raises(UnsupportedDomainError, match="one-sided"):
        gt.exp_map(gt.GeodesicSolver(moebius()), 0, [[1.0, 0, 0]])
    with pytest.raises(InvalidOptionError, match="exp_map needs a GeodesicSolver"):
        gt.exp_map(irregular_plate(5), 0, [[1.0, 0, 0]])
