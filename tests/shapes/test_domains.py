"""Meshes, clouds and graphs: accepted input, refused input, and immutability."""

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidDomainError, InvalidSourceError
from geodesic_toolkit.sources.surface_point import barycentric_rows

TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.int32, np.uint8, np.longdouble])
@pytest.mark.parametrize("index", [np.int32, np.uint32, np.int64, np.uint64, np.float32, np.int8])
def test_any_real_dtype_makes_the_same_mesh(dtype, index):
    mesh = gt.TriangleMesh(np.array(TRIANGLE, dtype), np.array([[0, 1, 2]], index))
    assert mesh.vertices.dtype == np.float64
    assert mesh.faces.dtype == np.int64
    np.testing.assert_array_equal(mesh.vertices, TRIANGLE)
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2]])


def test_any_memory_layout_makes_the_same_mesh():
    vertices = np.asfortranarray(TRIANGLE, dtype=float)
    strided = np.array([[0, 9, 1, 9, 2, 9]])[:, ::2]
    mesh = gt.TriangleMesh(vertices, strided)
    assert mesh.vertices.flags.c_contiguous
    assert mesh.faces.flags.c_contiguous
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2]])


def test_a_domain_does_not_share_memory_with_its_input():
    vertices = np.array(TRIANGLE, dtype=float)
    mesh = gt.TriangleMesh(vertices, [[0, 1, 2]])
    vertices[0] = 7
    assert mesh.vertices[0, 0] == 0


@pytest.mark.parametrize(
    "domain",
    [
        gt.TriangleMesh(TRIANGLE, [[0, 1, 2]]),
        gt.PointCloud(TRIANGLE, normals=[[0, 0, 1]] * 3),
        gt.Graph(3, [[0, 1]]),
    ],
    ids=lambda domain: type(domain).__name__,
)
@pytest.mark.parametrize(
    "through",
    [lambda x: x, copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))],
    ids=["itself", "copy", "deepcopy", "pickle"],
)
def test_arrays_are_read_only_also_after_copying(domain, through):
    arrays = [value for value in vars(through(domain)).values() if isinstance(value, np.ndarray)]
    assert arrays
    for array in arrays:
        assert not array.flags.writeable
    with pytest.raises(AttributeError):
        domain.vertices = None


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (np.zeros((4, 2)), [[0, 1, 2]], r"vertices must have shape \(n, 3\), not \(4, 2\)"),
        (np.zeros(3), [[0, 1, 2]], r"not \(3,\)"),
        (np.zeros((0, 3)), [[0, 1, 2]], "no vertices"),
        (TRIANGLE, np.zeros((0, 3)), "no faces"),
        (TRIANGLE, [], "no faces"),
        (TRIANGLE, [[0, 1]], r"faces must have shape \(n, 3\), not \(1, 2\)"),
        (TRIANGLE, [0, 1, 2], r"not \(3,\)"),
        (TRIANGLE, [[0, 1, 2], [0, 1, 3]], "face 1 refers to vertex 3; there are 3"),
        (TRIANGLE, [[0, 1, 10**9]], "face 0 refers to vertex 1000000000"),
        (TRIANGLE, [[0, 1, -1]], "face 0 refers to vertex -1"),
        (TRIANGLE, [[1, 2, 3]], "one-based"),
        (TRIANGLE, [[0, 1, 1.5]], "face 0 of faces .*not whole numbers"),
        (TRIANGLE, [[0, 1, float("nan")]], "not whole numbers"),
        (TRIANGLE, [[0, 1, float("inf")]], "not whole numbers"),
        (TRIANGLE, np.array([[0, 1, 2**64 - 1]], np.uint64), "too large"),
        (TRIANGLE, [[True, False, True]], "dtype bool"),
        ([[0, 0, 0], [1, float("nan"), 0], [0, 1, 0]], [[0, 1, 2]], "vertex 1 is not finite"),
        ([[0, 0, 0], [1, 0, 0], [0, float("inf"), 0]], [[0, 1, 2]], "vertex 2 is not finite"),
        ([["a", "b", "c"]] * 3, [[0, 1, 2]], "dtype"),
        (np.array([[None, 1, 2]] * 3), [[0, 1, 2]], "dtype object"),
        ([[0, 0, 0], [1, 0]], [[0, 1, 2]], "cannot be read as an array"),
        (np.zeros((3, 3), complex), [[0, 1, 2]], "dtype complex"),
    ],
)
def test_a_mesh_that_cannot_be_one_is_refused(vertices, faces, message):
    with pytest.raises(InvalidDomainError, match=message):
        gt.TriangleMesh(vertices, faces)


def test_degenerate_duplicate_and_unreferenced_parts_are_not_errors():
    vertices = [*TRIANGLE, [0, 0, 0], [5, 5, 5], [2, 0, 0]]
    faces = [[0, 1, 2], [0, 0, 1], [0, 1, 5], [0, 1, 2], [0, 1, 3], [2, 1, 0]]
    assert gt.TriangleMesh(vertices, faces).n_faces == 6


@pytest.mark.parametrize(
    ("points", "normals", "message"),
    [
        (np.zeros((4, 2)), None, r"points must have shape \(n, 3\)"),
        (np.zeros((0, 3)), None, "no points"),
        (np.full((2, 3), np.nan), None, "the point cloud has no finite points"),
        (TRIANGLE, [[0, 0, 1]], r"normals must have shape \(3, 3\), not \(1, 3\)"),
        (TRIANGLE, [[0, 0, 1], [0, 0, 0], [0, 0, 1]], "normal 1 is zero"),
        (TRIANGLE, [[0, 0, 1], [0, 0, 1], [0, np.nan, 1]], "normal 2 is zero or not finite"),
        (np.array([["x"] * 3]), None, "dtype"),
    ],
)
def test_a_cloud_that_cannot_be_one_is_refused(points, normals, message):
    with pytest.raises(InvalidDomainError, match=message):
        gt.PointCloud(points, normals)


def test_a_cloud_keeps_points_that_are_not_finite_as_missing():
    cloud = gt.PointCloud([[0, 0, 0], [np.nan, 0, 0], [0, np.inf, 0]], normals=[[0, 0, 2]] * 3)
    assert cloud.present.tolist() == [True, False, False]
    assert cloud.n_vertices == 3
    np.testing.assert_array_equal(cloud.normals[0], [0, 0, 1])
    assert repr(cloud) == "PointCloud(3 points, 2 missing, with normals)"


def test_normals_of_any_length_become_unit():
    normals = np.array([[0, 0, 1e-200], [0, 1e200, 0], [3, 4, 0]])
    unit = gt.PointCloud(TRIANGLE, normals).normals
    np.testing.assert_allclose(np.linalg.norm(unit, axis=1), 1)


@pytest.mark.parametrize(
    ("n_vertices", "edges", "lengths", "message"),
    [
        (0, [], None, "no vertices"),
        (2.0, [[0, 1]], None, "must be an integer"),
        (True, [[0, 0]], None, "must be an integer"),
        (2, [[0, 2]], None, "edge 0 refers to vertex 2"),
        (2, [[0, 1, 1]], None, r"edges must have shape \(n, 2\)"),
        (2, [[0, 1]], [1.0, 2.0], r"lengths must have shape \(1,\), not \(2,\)"),
        (2, [[0, 1]], [-0.5], "edge 0 has length -0.5"),
        (2, [[0, 1]], [-1.0], "edge 0 has length -1.0"),
        (2, [[0, 1]], [np.nan], "edge 0 has length nan"),
    ],
)
def test_a_graph_that_cannot_be_one_is_refused(n_vertices, edges, lengths, message):
    with pytest.raises(InvalidDomainError, match=message):
        gt.Graph(n_vertices, edges, lengths)


def test_a_graph_without_edges_is_a_graph():
    assert gt.Graph(3, []).n_edges == 0


@pytest.mark.slow
@given(
    hnp.arrays(
        dtype=st.one_of(
            hnp.floating_dtypes(),
            hnp.integer_dtypes(),
            hnp.unicode_string_dtypes(),
            st.just(object),
        ),
        shape=hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4),
    )
)
def test_whatever_faces_are_the_answer_is_a_mesh_or_a_typed_error(faces):
    try:
        mesh = gt.TriangleMesh(TRIANGLE, faces)
    except InvalidDomainError:
        return
    assert mesh.faces.min() >= 0
    assert mesh.faces.max() < 3


@pytest.mark.parametrize(
    ("face", "barycentric"),
    [
        (True, (1, 0, 0)),
        (0.0, (1, 0, 0)),
        (0, (1, 0)),
        (0, (0.5, 0.6, 0.5)),
        (0, (1.5, -0.5, 0)),
        (0, (np.nan, 0, 1)),
        (0, "abc"),
    ],
)
def test_a_surface_point_that_cannot_be_one_is_refused(face, barycentric):
    with pytest.raises(InvalidSourceError):
        gt.SurfacePoint(face, barycentric)


def test_surface_points_made_at_once_are_those_made_one_by_one():
    rows = np.array([[0.2, 0.3, 0.5 + 1e-8], [1.0, -1e-10, 0.0]])
    points = gt.SurfacePoint.from_rows(np.array([4, 7]), barycentric_rows(rows))
    assert points == (gt.SurfacePoint(4, tuple(rows[0])), gt.SurfacePoint(7, tuple(rows[1])))
    for wrong in ([0.5, 0.6, 0.0], [1.5, -0.5, 0.0], [np.nan, 0.5, 0.5]):
        with pytest.raises(InvalidSourceError, match="three non-negative numbers with sum 1"):
            barycentric_rows(np.array([rows[0], wrong]))


@pytest.mark.parametrize("missing", [np.nan, np.inf, -np.inf])
def test_vertices_that_no_face_uses_may_be_missing(missing):
    mesh = gt.testing.shapes.grid(9)
    hole = np.linalg.norm(mesh.vertices - [0.5, 0.5, 0], axis=1) < 0.2
    faces = mesh.faces[~hole[mesh.faces].any(axis=1)]
    vertices = mesh.vertices.copy()
    vertices[hole, 2] = missing
    holed, expected = gt.TriangleMesh(vertices, faces), gt.TriangleMesh(mesh.vertices, faces)
    np.testing.assert_array_equal(holed.used, ~hole)
    for options in ({"refine": True}, {"refine": True, "mask": np.arange(81) == 8}):
        solver = gt.GeodesicSolver(holed, **options)
        other = gt.GeodesicSolver(expected, **options)
        for source in (0, [0.1, 0.2, 0.0], gt.Curve([[0, 0, 0], [0, 1, 0]])):
            distance = solver.distance(source)
            np.testing.assert_array_equal(distance, other.distance(source))
            assert np.isinf(distance[hole]).all()
        np.testing.assert_array_equal(
            solver.query([[0.9, 0.8, 0.01]], 0), other.query([[0.9, 0.8, 0.01]], 0)
        )
        path = gt.geodesic_path(solver, 0, [0.9, 0.9, 0.0])
        np.testing.assert_array_equal(
            path.points, gt.geodesic_path(other, 0, [0.9, 0.9, 0.0]).points
        )
        assert np.isfinite(gt.farthest_point_sampling(solver, 4, return_radii=True)[1]).all()
    np.testing.assert_array_equal(gt.exact_distance(holed, 0), gt.exact_distance(expected, 0))


def test_a_face_of_a_missing_vertex_is_named_with_the_cure():
    vertices = gt.testing.shapes.grid(5).vertices.copy()
    vertices[12] = np.nan
    faces = gt.testing.shapes.grid(5).faces
    with pytest.raises(InvalidDomainError, match=r"vertex 12 is not finite.*face \d+ refers to it"):
        gt.TriangleMesh(vertices, faces)
    whole = faces[np.isfinite(vertices[faces]).all(axis=(1, 2))]  # as the message says
    assert gt.TriangleMesh(vertices, whole).n_vertices == 25
