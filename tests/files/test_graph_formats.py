"""Files of matrices and of edges are graphs, or refused."""

import numpy as np
import pytest
from sample_files import EDGES, LENGTHS, check_octahedron, place
from scipy import sparse

import geodesic_toolkit as gt
from geodesic_toolkit.errors import ReadError

# -- graphs ---------------------------------------------------------------------------------------


def test_both_triangles_of_a_matrix_may_be_stored_and_the_shorter_length_counts(tmp_path):
    matrix = sparse.coo_array(([2.0, 3.0, 5.0, 9.0], ([0, 1, 1, 2], [1, 0, 2, 2])), shape=(4, 4))
    sparse.save_npz(tmp_path / "g.npz", matrix)
    graph = gt.read(tmp_path / "g.npz")
    assert graph.n_vertices == 4
    np.testing.assert_array_equal(graph.edges, [[0, 1], [1, 2]])
    np.testing.assert_array_equal(graph.lengths, [2.0, 5.0])


@pytest.mark.parametrize("form", ["csr", "csc", "coo", "bsr", "dia"])
def test_a_sparse_matrix_of_any_format_is_a_graph(form, tmp_path):
    matrix = sparse.coo_array((LENGTHS, tuple(EDGES.T)), shape=(6, 6)).asformat(form)
    if form == "dia":  # which stores the zeros of its diagonals too
        matrix = sparse.dia_array((np.ones((1, 6)), [1]), shape=(6, 6))
        sparse.save_npz(tmp_path / "g.npz", matrix)
        assert gt.read(tmp_path / "g.npz").n_edges == 5
    else:
        sparse.save_npz(tmp_path / "g.npz", matrix)
        check_octahedron(gt.read(tmp_path / "g.npz"))


def banner(kind):
    return f"%%MatrixMarket matrix {kind}\n% a comment\n"


@pytest.mark.parametrize(
    ("kind", "body", "lengths"),
    [
        ("coordinate real symmetric", "3 3 2\n2 1 0.5\n3 2 4\n", [0.5, 4.0]),
        ("coordinate pattern symmetric", "3 3 2\n2 1\n3 2\n", [1.0, 1.0]),
        ("coordinate integer general", "3 3 3\n2 1 7\n1 2 5\n2 3 4\n", [5.0, 4.0]),
        ("array real general", "3 3\n0\n0.5\n0\n0.5\n0\n4\n0\n4\n0\n", [0.5, 4.0]),
        ("array real symmetric", "3 3\n0\n0.5\n0\n0\n4\n0\n", [0.5, 4.0]),
    ],
)
def test_a_matrix_market_file_of_any_kind_is_a_graph(kind, body, lengths, tmp_path):
    graph = gt.read(place(tmp_path, "g.mtx", banner(kind) + body))
    np.testing.assert_array_equal(graph.edges, [[0, 1], [1, 2]])
    np.testing.assert_array_equal(graph.lengths, lengths)


def test_a_matrix_market_file_without_entries_is_a_graph_without_edges(tmp_path):
    graph = gt.read(place(tmp_path, "g.mtx", banner("coordinate real general") + "3 3 0\n"))
    assert (graph.n_vertices, graph.n_edges) == (3, 0)


@pytest.mark.parametrize(
    ("kind", "body", "says"),
    [
        ("coordinate complex general", "2 2 1\n1 2 1 0\n", "complex general matrix cannot hold"),
        ("coordinate real skew-symmetric", "2 2 1\n2 1 1\n", "skew-symmetric matrix cannot hold"),
        ("coordinate real general", "2 3 1\n1 2 1\n", "square, not 2 x 3"),
        ("coordinate real general", "2 2\n1 2 1\n", "the sizes of the matrix are '2 2'"),
        ("coordinate real general", "2 2 2\n1 2 1\n", "2 entries are announced, but 1 follow"),
        ("coordinate real general", "2 2 1\n1 2\n", "entries have 2 columns, not 3"),
        ("coordinate real general", "2 2 1\n1 3 1\n", "entry 0 lies outside a matrix of 2 x 2"),
        ("coordinate real general", "2 2 1\n0 1 1\n", "entry 0 lies outside"),
        ("coordinate real general", "2 2 1\n1 2 -4\n", "edge 0 has length -4"),
        ("coordinate real general", "2 2 1\n1.5 2 1\n", "must be whole numbers"),
        ("array real general", "2 2\n1\n1\n1\n", "2 x 2 entries are announced, but 3 follow"),
        ("array real general", "1 1\n1 1\n", "entries have 2 columns, not 1"),
        ("array real general", "0 0\n", "0 x 0 entries"),
    ],
)
def test_a_matrix_market_file_that_is_not_a_graph_is_refused(kind, body, says, tmp_path):
    with pytest.raises(ReadError, match=says):
        gt.read(place(tmp_path, "g.mtx", banner(kind) + body))


def test_an_explicit_zero_of_a_matrix_market_file_is_an_edge_of_length_0(tmp_path):
    body = banner("coordinate real general") + "3 3 2\n1 2 0\n2 3 4\n"
    graph = gt.read(place(tmp_path, "g.mtx", body))
    np.testing.assert_array_equal(gt.geodesic_distance(graph, 0), [0.0, 0.0, 4.0])


@pytest.mark.parametrize(
    ("text", "lengths"),
    [
        ("0 1\n1 2\n", [1, 1]),
        ("0,1,0.5\n1,2,2\n", [0.5, 2]),
        ("# i j\n0 1 3 # x\n% y\n1 2 4\n", [3, 4]),
    ],
)
@pytest.mark.parametrize("suffix", ["edges", "edgelist"])
def test_an_edge_list_is_a_graph(suffix, text, lengths, tmp_path):
    graph = gt.read(place(tmp_path, f"g.{suffix}", text))
    np.testing.assert_array_equal(graph.edges, [[0, 1], [1, 2]])
    np.testing.assert_array_equal(graph.lengths, lengths)
