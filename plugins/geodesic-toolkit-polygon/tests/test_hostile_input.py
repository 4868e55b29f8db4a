"""Is bad input refused by name, and odd input measured right?"""

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidDomainError,
    InvalidOptionError,
    UnsupportedDomainError,
)
from geodesic_toolkit_polygon import PolygonLaplacian, PolygonMesh
from geodesic_toolkit_polygon.samples import quads

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
BESIDE = np.concatenate([SQUARE, [[2.0, 0, 0], [2, 1, 0]]])


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (SQUARE, [[0, 1, 2, 3], [0, 1]], "face 1 has 2 different corners"),
        (SQUARE, [[0, 1, 2, 3], []], "face 1 has 0 different corners"),
        (SQUARE, [[0, 0, 1, 1]], "face 0 has 2 different corners"),
        (SQUARE, [[0, 1, 2, 0, 3]], "face 0 comes back to vertex 0"),
        (SQUARE, [[0, 1, 2, 4]], "face 0 refers to vertex 4; there are 4"),
        (SQUARE, [[0, 1, 2, -1]], "face 0 refers to vertex -1"),
        (SQUARE, [[0, 2, 1, 3]], "face 0 crosses itself"),
        (SQUARE, [], "no faces"),
        (SQUARE, [[0, 1, 2.5, 3]], "entry 2 is 2.5"),
        (SQUARE, [["a", "b", "c"]], "row of integers"),
        (SQUARE, [[0, [1, 2], 3]], "rows of indices"),
        (SQUARE, [0, 1, 2], "face 0 must be a row"),
        (SQUARE, 3, "rows of indices"),
        (SQUARE, np.arange(4), r"shape \(F, k\)"),
        (np.zeros((0, 3)), [[0, 1, 2]], "no vertices"),
        (SQUARE[:, :2], [[0, 1, 2, 3]], r"shape \(N, 3\)"),
        ([[0, 0, "x"]], [[0, 0, 0]], "vertices cannot be read"),
        (np.where(SQUARE == 1, np.nan, SQUARE), [[0, 1, 2, 3]], "vertex 1 of face 0 is not finite"),
    ],
)
def test_what_is_not_a_polygon_mesh_is_refused_with_its_place(vertices, faces, message):
    with pytest.raises(InvalidDomainError, match=message):
        PolygonMesh(vertices, faces)


def test_sizes_that_do_not_add_up_are_refused():
    with pytest.raises(InvalidDomainError, match="there are 4 corners"):
        PolygonMesh.of_corners(SQUARE, [3], [0, 1, 2, 3])
    with pytest.raises(InvalidDomainError, match="sizes must be one row of integers"):
        PolygonMesh.of_corners(SQUARE, [[4]], [0, 1, 2, 3])
    with pytest.raises(InvalidDomainError, match="sizes cannot be read"):
        PolygonMesh.of_corners(SQUARE, [[4], [1, 2]], [0, 1, 2, 3])


def test_a_corner_that_follows_itself_counts_once():
    mesh = PolygonMesh(SQUARE, [[0, 1, 1, 2, 3, 0]])
    assert [face.tolist() for face in mesh.faces] == [[1, 2, 3, 0]] or mesh.sizes.tolist() == [4]
    assert gt.geodesic_distance(mesh, 0)[2] == pytest.approx(np.sqrt(2))


def test_front_and_back_of_a_face_count_once():
    once = PolygonLaplacian().assemble(PolygonMesh(SQUARE, [[0, 1, 2, 3]]))
    twice = PolygonLaplacian().assemble(PolygonMesh(SQUARE, [[0, 1, 2, 3], [2, 1, 0, 3]]))
    assert np.array_equal(once.stiffness.toarray(), twice.stiffness.toarray())
    assert np.array_equal(once.mass, twice.mass)


def test_pages_on_a_spine_are_crossed():
    pages = np.array([[0.0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 0, 0], [-1, 1, 0], [-1, 0, 0]])
    pages = np.concatenate([pages, [[0, 1, 1], [0, 0, 1]]])
    mesh = PolygonMesh(pages, [[0, 1, 2, 3], [0, 1, 4, 5], [0, 1, 6, 7]])
    distance = gt.geodesic_distance(mesh, 3)
    assert distance[[0, 5, 7]] == pytest.approx([1.0, 2.0, 2.0])
    assert distance[4] == pytest.approx(np.sqrt(5))


def test_unreferenced_vertices_are_infinitely_far_whatever_they_are():
    mesh = PolygonMesh(np.concatenate([SQUARE, [[np.nan, 0, 0], [5, 5, 5]]]), [[0, 1, 2, 3]])
    distance = gt.geodesic_distance(mesh, 0)
    assert np.isinf(distance[4:]).all()
    assert np.isfinite(distance[:4]).all()


def test_faces_without_an_area_connect_their_corners():
    line = np.array([[0.0, 1, 0], [0, 0, 0], [0.5, 1, 0], [1, 0, 0], [1, 1, 0]])
    mesh = PolygonMesh(line, [[0, 1, 3, 4], [0, 2, 4]])
    assert gt.geodesic_distance(mesh, 0)[[2, 4]] == pytest.approx([0.5, 1.0], abs=1e-3)


def test_a_mesh_of_one_place_is_refused():
    with pytest.raises(UnsupportedDomainError, match="zero area"):
        gt.GeodesicSolver(PolygonMesh(np.ones((4, 3)), [[0, 1, 2, 3]]))


def test_a_face_that_no_place_sees_all_of_is_split_inside():
    pytest.importorskip("manifold3d")  # an extra of the core
    u = [[0, 0], [5, 0], [5, 4], [4, 4], [4, 1], [1, 1], [1, 4], [0, 4]]
    mesh = PolygonMesh(np.column_stack([u, np.zeros(8)]), [range(8)])
    discretization = PolygonLaplacian().assemble(mesh)
    assert discretization.notes["split_faces"] == 1
    assert discretization.mass.sum() == pytest.approx(11)
    around = np.hypot(1, 3) + 3 + np.hypot(1, 3)
    assert gt.geodesic_distance(mesh, 7)[2] == pytest.approx(around, rel=1e-9)


def test_a_concave_face_with_a_centre_is_a_fan():
    l_shape = np.array([[0.0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]])
    mesh = PolygonMesh(np.column_stack([l_shape, np.zeros(6)]), [range(6)])
    assert PolygonLaplacian().assemble(mesh).notes["split_faces"] == 0
    assert mesh.surface.vertices[6] == pytest.approx([0.5, 0.5, 0.0], abs=1e-3)
    turned = np.hypot(1, 1) * 2
    assert gt.geodesic_distance(mesh, 2)[4] == pytest.approx(np.hypot(1, 1), abs=2)
    assert gt.geodesic_distance(mesh, 5)[1] == pytest.approx(turned, rel=1e-9)


def test_a_deep_arrow_has_weights_that_are_not_negative():
    arrow = np.array([[0.0, 0, 0], [1, -1, 0], [0.05, 0, 0], [1, 1, 0]])
    mesh = PolygonMesh(arrow, [[0, 1, 2, 3]])
    assert (mesh.weights.data > 0).all()
    distance = gt.geodesic_distance(mesh, 1)
    assert distance[3] == pytest.approx(2 * np.hypot(0.95, 1), rel=1e-9)


def test_a_mask_that_leaves_no_face_is_refused():
    with pytest.raises(InvalidOptionError, match="leaves no face"):
        gt.GeodesicSolver(quads(2), mask=np.arange(9) == 4)


def test_other_kinds_are_refused_by_name():
    with pytest.raises(UnsupportedDomainError, match="PolygonMesh, not TriangleMesh"):
        gt.GeodesicSolver(gt.testing.shapes.grid(3), operator="polygon")
