"""Input that meshes with a cost or a metric tensor, and surfaces by edge lengths, accept."""

import pickle

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidDomainError, InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.testing import shapes

SQUARE = shapes.grid(3)  # 9 vertices, 8 faces
FACES = SQUARE.faces


def costs(at=None, value=1.0, count=8):
    array = np.ones(count)
    if at is not None:
        array[at] = value
    return array


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
@pytest.mark.parametrize(("count", "where"), [(8, "face"), (9, "vertex")])
def test_a_cost_that_is_not_positive_is_named(value, count, where):
    with pytest.raises(InvalidDomainError, match=rf"the cost of {where} 5 is .*must be positive"):
        gt.MetricMesh(SQUARE, cost=costs(5, value, count))
    with pytest.raises(InvalidDomainError, match="the cost of face 0"):
        gt.MetricMesh(SQUARE, cost=value)


def test_a_vertex_without_faces_may_have_any_cost():
    mesh = gt.TriangleMesh(np.vstack([SQUARE.vertices, [[9, 9, 9]], [[8, 8, 8]]]), FACES)
    assert gt.MetricMesh(mesh, cost=costs(9, np.nan, 11)).n_vertices == 11


@pytest.mark.parametrize("count", [7, 10])
def test_a_cost_of_another_length_says_the_lengths(count):
    with pytest.raises(InvalidDomainError, match=rf"cost has {count} values; the mesh has 8 faces"):
        gt.MetricMesh(SQUARE, cost=np.ones(count))
    with pytest.raises(InvalidDomainError, match="the values belong to vertices"):
        gt.MetricMesh(SQUARE, cost=np.ones(8), on="vertices")


def test_as_many_faces_as_vertices_need_a_word():
    tetrahedron = gt.TriangleMesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    )
    with pytest.raises(InvalidOptionError, match="4 faces and as many vertices"):
        gt.MetricMesh(tetrahedron, cost=[1.0, 1.1, 1.2, 1.3])
    of_faces = gt.MetricMesh(tetrahedron, cost=[1.0, 1.1, 1.2, 1.3], on="faces")
    of_vertices = gt.MetricMesh(tetrahedron, cost=[1.0, 1.1, 1.2, 1.3], on="vertices")
    assert not of_faces.edges_agree
    assert of_vertices.edges_agree


def test_other_options_are_refused():
    with pytest.raises(InvalidOptionError, match="either a cost or a tensor"):
        gt.MetricMesh(SQUARE)
    with pytest.raises(InvalidOptionError, match="either a cost or a tensor"):
        gt.MetricMesh(SQUARE, cost=1.0, tensor=np.tile(np.eye(3), (8, 1, 1)))
    with pytest.raises(InvalidOptionError, match="on must be"):
        gt.MetricMesh(SQUARE, cost=1.0, on="edges")
    with pytest.raises(InvalidDomainError, match="not a PointCloud"):
        gt.MetricMesh(gt.PointCloud(SQUARE.vertices), cost=1.0)
    with pytest.raises(InvalidDomainError, match="real numbers"):
        gt.MetricMesh(SQUARE, cost=["a"] * 8)


@pytest.mark.parametrize(
    ("tensor", "message"),
    [
        (np.diag([1.0, -1.0]), "face 3 is not positive definite"),
        (np.zeros((2, 2)), "face 3 is not positive definite"),
        (np.array([[1.0, 0.5], [0.0, 1.0]]), "face 3 is not symmetric"),
        (np.full((2, 2), np.nan), "face 3 is not symmetric and finite"),
        (np.diag([1.0, 0.0, 1.0]), "face 3 is not positive definite"),
    ],
)
def test_a_tensor_that_is_not_a_metric_is_named(tensor, message):
    size = len(tensor)
    tensors = np.tile(np.eye(size), (8, 1, 1))
    tensors[3] = tensor
    with pytest.raises(InvalidDomainError, match=message):
        gt.MetricMesh(SQUARE, tensor=tensors)


def test_only_the_part_of_a_tensor_in_the_plane_counts():
    flat = np.tile(np.diag([1.0, 1.0, 0.0]), (8, 1, 1))
    np.testing.assert_allclose(
        gt.MetricMesh(SQUARE, tensor=flat).lengths, gt.MetricMesh(SQUARE, cost=1.0).lengths
    )
    with pytest.raises(InvalidDomainError, match="vertex 0 is not positive definite"):
        gt.MetricMesh(SQUARE, tensor=np.tile(np.diag([1.0, 1.0, 0.0]), (9, 1, 1)))


@pytest.mark.parametrize(
    ("shape", "message"),
    [((8, 3), "must have shape"), ((8, 4, 4), "must have shape"), ((5, 3, 3), "has 5 values")],
)
def test_tensors_of_another_shape_are_refused(shape, message):
    with pytest.raises(InvalidDomainError, match=message):
        gt.MetricMesh(SQUARE, tensor=np.ones(shape))


def test_tensors_of_vertices_are_in_space():
    with pytest.raises(InvalidDomainError, match="tensors of vertices"):
        gt.MetricMesh(SQUARE, tensor=np.tile(np.eye(2), (9, 1, 1)), on="vertices")


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_a_length_that_is_not_positive_is_named(value):
    lengths = gt.MetricMesh(SQUARE, cost=1.0).lengths.copy()
    lengths[2, 1] = value
    with pytest.raises(InvalidDomainError, match="face 2 has the edge lengths"):
        gt.IntrinsicMesh(FACES, lengths)


def test_lengths_must_make_triangles_that_agree():
    lengths = gt.MetricMesh(SQUARE, cost=1.0).lengths
    with pytest.raises(InvalidDomainError, match="of face 0 make no triangle"):
        gt.IntrinsicMesh([[0, 1, 2]], [[1.0, 1.0, 2.1]])
    with pytest.raises(InvalidDomainError, match="faces disagree about the edge between"):
        gt.IntrinsicMesh(FACES, lengths * np.linspace(1, 2, 8)[:, None])
    rounded = lengths.astype(np.float32)
    assert gt.IntrinsicMesh(FACES, rounded).edges_agree
    with pytest.raises(InvalidDomainError, match="lengths must have shape"):
        gt.IntrinsicMesh(FACES, lengths[:-1])
    with pytest.raises(InvalidDomainError, match="no faces"):
        gt.IntrinsicMesh([], np.zeros((0, 3)))
    with pytest.raises(InvalidDomainError, match="refers to vertex"):
        gt.IntrinsicMesh(FACES, lengths, n_vertices=4)
    with pytest.raises(InvalidDomainError, match="n_vertices must be an integer"):
        gt.IntrinsicMesh(FACES, lengths, n_vertices=9.5)


def test_measures_out_of_range_are_refused():
    lengths = gt.MetricMesh(SQUARE, cost=1.0).lengths
    with pytest.raises(UnsupportedDomainError, match="out of the range"):
        gt.GeodesicSolver(gt.IntrinsicMesh(FACES, lengths * 1e200))


def test_masking_everything_is_refused():
    mask = np.arange(9) == 4
    for domain in (
        gt.MetricMesh(SQUARE, cost=1.0),
        gt.IntrinsicMesh(FACES, gt.MetricMesh(SQUARE, cost=1.0).lengths),
    ):
        assert domain.without(np.arange(9) == 0).n_faces < 8
        with pytest.raises(InvalidOptionError, match="leaves no faces"):
            domain.without(mask | (np.arange(9) % 2 == 0))


def test_arrays_are_read_only_also_after_pickling():
    domain = gt.MetricMesh(SQUARE, cost=2.0)
    assert domain.edges_agree
    again = pickle.loads(pickle.dumps(domain))
    for one in (domain, again):
        assert repr(one) == "MetricMesh(9 vertices, 8 faces)"
        for array in (one.lengths, one.faces, one.vertices):
            assert not array.flags.writeable
    np.testing.assert_array_equal(again.lengths, domain.lengths)
