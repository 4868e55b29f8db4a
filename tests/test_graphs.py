"""Graphs through the same heat method: closed forms, dimension, hostile input."""

import numpy as np
import pytest
from closed_forms import bent_path, mean_relative_error, on_sphere
from scipy.sparse import csr_array
from scipy.sparse.csgraph import minimum_spanning_tree

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.geometry.dimension import graph_dimension
from geodesic_toolkit.testing import shapes

# Mean relative errors allowed, from what was measured: paths 0.003 % at 100 vertices, square grids
# 2.9 % at 41 x 41, cube grids 4.3 % at 25³, the edges of a level-4 icosphere 0.83 %.
PATH_TOLERANCE = 0.01
GRID_TOLERANCE = 0.05
SPHERE_TOLERANCE = 0.05
HALVING = 0.75


def lattice(n, dim):
    """The grid graph of n^dim vertices and its positions."""
    index = np.arange(n**dim).reshape((n,) * dim)
    edges = [
        np.column_stack(
            [
                np.take(index, range(n - 1), axis).ravel(),
                np.take(index, range(1, n), axis).ravel(),
            ]
        )
        for axis in range(dim)
    ]
    positions = np.stack(np.unravel_index(np.arange(n**dim), (n,) * dim), axis=1)
    return gt.Graph(n**dim, np.concatenate(edges)), positions.astype(float)


def edges_of(mesh):
    edges = np.unique(np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    lengths = np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)
    return gt.Graph(mesh.n_vertices, edges, lengths)


def lattice_error(n, dim, operator="uniform"):
    graph, positions = lattice(n, dim)
    exact = np.linalg.norm(positions - positions[0], axis=1)
    return mean_relative_error(gt.geodesic_distance(graph, 0, operator=operator), exact)


@pytest.mark.parametrize("spacing", [1.0, 0.001, 7e5])
def test_distance_along_a_path_is_its_length(spacing):
    graph, exact = bent_path(100, spacing)
    assert mean_relative_error(gt.geodesic_distance(graph, 0), exact) < PATH_TOLERANCE


def test_a_square_grid_graph_measures_euclidean_distance():
    errors = [lattice_error(n, 2, gt.UniformLaplacian(dim=2)) for n in (11, 21, 41)]
    assert errors[2] < GRID_TOLERANCE
    assert errors[2] < HALVING * errors[1] < HALVING**2 * errors[0]


def test_a_cube_grid_graph_measures_euclidean_distance():
    errors = [lattice_error(n, 3, gt.UniformLaplacian(dim=3)) for n in (7, 13, 25)]
    assert errors[2] < GRID_TOLERANCE
    assert errors[2] < HALVING * errors[1] < HALVING**2 * errors[0]


def test_the_edges_of_a_sphere_measure_the_sphere():
    mesh = shapes.icosphere(4)
    distance = gt.geodesic_distance(edges_of(mesh), 0)
    assert mean_relative_error(distance, on_sphere(mesh, 0)) < SPHERE_TOLERANCE


def test_the_graph_of_a_long_tube_is_right_at_its_far_end():
    rings, around = 1200, 48
    distance = gt.geodesic_distance(edges_of(shapes.tube(rings, around)), 0)
    assert abs(distance[-around:].mean() / ((rings - 1) * np.sqrt(3) / 2) - 1) < 0.03


@pytest.mark.parametrize(
    ("graph", "dim"),
    [
        (bent_path(50)[0], 1),
        (bent_path(3)[0], 1),
        (lattice(12, 2)[0], 2),
        (lattice(40, 2)[0], 2),
        (lattice(9, 3)[0], 3),
        (lattice(25, 3)[0], 3),
        (edges_of(shapes.icosphere(3)), 2),
        (edges_of(shapes.tube(30, 12)), 2),
        (gt.Graph(4, []), 1),
    ],
    ids=["path", "3-path", "square", "large square", "cube", "large cube", "sphere",
         "tube", "no edges"],
)  # fmt: skip
def test_the_dimension_is_read_off_the_growth_of_balls(graph, dim):
    assert graph_dimension(graph.n_vertices, graph.edges) == dim


def test_loops_and_parallel_edges_change_nothing():
    plain = gt.Graph(4, [[0, 1], [1, 2], [2, 3]], [1.0, 2.0, 1.0])
    untidy = gt.Graph(4, [[1, 0], [2, 1], [1, 2], [2, 2], [3, 2]], [1.0, 5.0, 2.0, 0.1, 1.0])
    operator = gt.UniformLaplacian(dim=1)
    np.testing.assert_array_equal(
        gt.geodesic_distance(plain, 0, operator=operator),
        gt.geodesic_distance(untidy, 0, operator=operator),
    )


def test_separate_parts_and_isolated_vertices_are_infinitely_far():
    distance = gt.geodesic_distance(gt.Graph(5, [[0, 1], [2, 3]]), 0)
    assert np.isfinite(distance[:2]).all()
    assert (distance[2:] == np.inf).all()
    assert gt.geodesic_distance(gt.Graph(2, []), 1).tolist() == [np.inf, 0.0]


def test_on_a_tree_of_uneven_edges_order_follows_the_path():
    rng = np.random.default_rng(2)
    lengths = np.triu(rng.uniform(0.5, 1.5, (40, 40)), 1)
    tree = minimum_spanning_tree(csr_array(lengths)).tocoo()
    graph = gt.Graph(40, np.column_stack(tree.coords), tree.data)
    distance = gt.geodesic_distance(graph, 0, operator=gt.UniformLaplacian(dim=1))
    assert np.isfinite(distance).all()
    assert distance.argmin() == 0


@pytest.mark.parametrize("lengths", [[0.5, 1e-7, 1.0], [3e6, 1.0, 2.0], [1e-60, 1.0, 1e60]])
def test_lengths_too_far_apart_for_floats_are_refused_by_name(lengths):
    graph = gt.Graph(4, [[0, 1], [2, 1], [2, 3]], lengths)
    short, long = np.argmin(lengths), np.argmax(lengths)
    named = [f"{min(graph.edges[edge])} to {max(graph.edges[edge])}" for edge in (short, long)]
    message = f"from vertex {named[0]} is .* that from {named[1]}, connected to it, .* merge"
    with pytest.raises(UnsupportedDomainError, match=message):
        gt.GeodesicSolver(graph)


def test_lengths_a_million_times_apart_still_have_a_distance():
    rng = np.random.default_rng(0)
    lengths = np.where(rng.random(60) < 0.5, 1.0, 1e-6)
    graph, exact = gt.Graph(61, bent_path(61)[0].edges, lengths), np.cumsum([0.0, *lengths])
    distance = gt.geodesic_distance(graph, 0, operator=gt.UniformLaplacian(dim=1))
    away = exact > 0.5
    assert (np.abs(distance - exact)[away] / exact[away]).mean() < 0.2


def test_lengths_of_separate_parts_may_be_as_far_apart_as_they_like():
    rng = np.random.default_rng(1)
    alone = gt.Graph(20, bent_path(20)[0].edges, rng.uniform(0.5, 1.5, 19))
    for ratio in (3.0, 1e-12, 1e12):
        both = gt.Graph(
            41,
            np.concatenate([alone.edges, alone.edges + 20]),
            np.concatenate([alone.lengths, ratio * alone.lengths]),
        )
        found = gt.GeodesicSolver(both, operator=gt.UniformLaplacian(dim=1)).distances([4, 24])
        expected = gt.geodesic_distance(alone, 4, operator=gt.UniformLaplacian(dim=1))
        np.testing.assert_allclose(found[0, :20], expected, rtol=1e-9)
        np.testing.assert_allclose(found[1, 20:40], ratio * expected, rtol=1e-9)
        assert (found[:, 40] == np.inf).all()


@pytest.mark.parametrize("length", [1e-200, 1e200])
def test_lengths_without_a_square_in_floats_are_refused(length):
    with pytest.raises(UnsupportedDomainError, match="take another unit of length"):
        gt.GeodesicSolver(gt.Graph(3, [[0, 1], [1, 2]], [length, length]))


@pytest.mark.parametrize(
    "options", [{"dim": 0}, {"dim": 1.5}, {"dim": "2"}, {"dim": True}, {"mass": "unit"}]
)
def test_options_outside_their_values_are_refused(options):
    with pytest.raises(InvalidOptionError):
        gt.UniformLaplacian(**options)
