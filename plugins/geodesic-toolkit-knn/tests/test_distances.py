"""Are distances of samples those of the space that they are drawn from, in any dimension?"""

import numpy as np
import pytest
from scipy.sparse.csgraph import dijkstra

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit_knn import HighDimensionWarning, KNNGraph, KNNLaplacian, intrinsic_dimension

CLOSE = 0.005
"""Mean error of 1,000 samples without noise: 0.01 to 0.3 % are measured."""

NOISY = 0.04
"""The same with noise: 1 to 2.7 %."""

GRAPH = 0.05
"""The same across the graph, in three dimensions: 1.7 %."""


def in_ten_dimensions(points, noise=0.0):
    """Return points turned at random in ten dimensions, with noise in mean nearest distances."""
    rng = np.random.default_rng(7)
    wide = np.zeros((len(points), 10))
    wide[:, : points.shape[1]] = points
    steps = np.linalg.norm(points[:, None] - points[None], axis=2)
    np.fill_diagonal(steps, np.inf)
    turned = wide @ np.linalg.qr(rng.standard_normal((10, 10)))[0]
    return turned + noise * steps.min(axis=1).mean() * rng.standard_normal(wide.shape)


def torus(count=1000):
    angles = 2 * np.pi * np.random.default_rng(0).random((count, 2))
    steps = np.abs(angles - angles[0])
    truth = np.linalg.norm(np.minimum(steps, 2 * np.pi - steps), axis=1)
    return np.concatenate([np.cos(angles), np.sin(angles)], axis=1), truth


def roll(count=1000):
    rng = np.random.default_rng(1)
    angle, height = 1.5 * np.pi * (1 + 2 * rng.random(count)), 21 * rng.random(count)
    arc = (angle * np.sqrt(1 + angle**2) + np.arcsinh(angle)) / 2
    points = np.column_stack([angle * np.cos(angle), height, angle * np.sin(angle)])
    return points, np.hypot(arc - arc[0], height - height[0])


def helix(count=1000):
    angle = 6 * np.pi * np.random.default_rng(2).random(count)
    points = np.column_stack([np.cos(angle), np.sin(angle), angle / 4])
    return points, np.abs(angle - angle[0]) * np.sqrt(1 + 1 / 16)


def cube(dimension, count=1000):
    points = np.random.default_rng(3).random((count, dimension))
    return points, np.linalg.norm(points - points[0], axis=1)


def mean_error(found, truth):
    return (np.abs(found - truth)[truth > 0] / truth[truth > 0]).mean()


@pytest.mark.parametrize("shape", [torus, roll, helix])
def test_samples_in_ten_dimensions_have_the_distances_of_their_space(shape):
    points, truth = shape()
    found = gt.geodesic_distance(KNNGraph(in_ten_dimensions(points)), 0)
    assert mean_error(found, truth) < CLOSE


@pytest.mark.parametrize("shape", [torus, roll, helix])
def test_noise_in_ten_dimensions_lengthens_them_less_than_isomap(shape):
    points, truth = shape()
    domain = KNNGraph(in_ten_dimensions(points, noise=0.2))
    found = gt.geodesic_distance(domain, 0)
    isomap = dijkstra(domain.distances, directed=False, indices=0)
    assert mean_error(found, truth) < min(NOISY, mean_error(isomap, truth))


def test_errors_on_a_torus_decrease_as_samples_grow():
    errors = []
    for count in (500, 2000, 8000):
        points, truth = torus(count)
        errors.append(mean_error(gt.geodesic_distance(KNNGraph(points), 0), truth))
    assert errors[0] > 2 * errors[1] > 4 * errors[2]


def test_fronts_cross_the_graph_in_three_dimensions():
    points, truth = cube(3)
    solver = gt.GeodesicSolver(KNNGraph(in_ten_dimensions(points)))
    assert solver.diagnosis.notes["why"].startswith("the dimension is 3")
    assert mean_error(solver.distance(0), truth) < GRAPH


def test_more_dimensions_are_warned_of():
    points, _ = cube(6, 400)
    with pytest.warns(HighDimensionWarning, match="too long"):
        gt.geodesic_distance(KNNGraph(points), 0)


@pytest.mark.parametrize(
    ("points", "dimension"),
    [(helix()[0], 1), (roll()[0], 2), (torus()[0], 2), (cube(3, 3000)[0], 3)],
)
def test_neighbours_show_the_dimension(points, dimension):
    assert round(intrinsic_dimension(in_ten_dimensions(points[:2000]))) == dimension
    assert KNNGraph(points).dimension == dimension


def test_sheets_of_a_roll_are_not_connected_though_samples_beyond_are_neighbours():
    points, truth = roll(600)
    found = gt.geodesic_distance(KNNGraph(points), 0)
    assert mean_error(found, truth) < CLOSE


def test_parts_that_the_graph_connects_are_connected():
    square = np.random.default_rng(4).random((300, 2))
    bridge = np.column_stack([np.linspace(1.05, 1.95, 12), np.full(12, 0.5)])
    points = np.concatenate([square, bridge, square + np.array([2.0, 0.0])])
    domain = KNNGraph(points, k=6, dimension=2)
    found = gt.geodesic_distance(domain, 0)
    straight = np.linalg.norm(points - points[0], axis=1)
    assert np.isfinite(found).all()
    assert (found >= straight * (1 - 1e-9)).all()


@pytest.mark.parametrize("shape", [torus, helix])
def test_samples_at_one_place_read_the_same(shape):
    points, _ = shape(300)
    twice = np.concatenate([points, points[::-1]])
    found = gt.geodesic_distance(KNNGraph(twice), 0)
    np.testing.assert_allclose(found[300:], found[:300][::-1], atol=1e-12)
    np.testing.assert_allclose(found[:300], gt.geodesic_distance(KNNGraph(points), 0), atol=1e-9)


@pytest.mark.parametrize("k", [1, 2, 5, 12, 30])
@pytest.mark.parametrize("shape", [torus, roll, helix])
def test_charts_are_as_accurate_with_any_number_of_neighbours(shape, k):
    points, truth = shape()
    domain = KNNGraph(points, k=k, dimension=1 if shape is helix else 2)
    assert mean_error(gt.geodesic_distance(domain, 0), truth) < CLOSE


@pytest.mark.parametrize("scale", [1e-58, 1e-9, 1e9, 1e58])
def test_distances_scale_with_the_samples(scale):
    points, _ = torus(300)
    found = gt.geodesic_distance(KNNGraph(points * scale), 0)
    np.testing.assert_allclose(found / scale, gt.geodesic_distance(KNNGraph(points), 0), rtol=1e-9)


def test_coordinates_that_are_constant_change_nothing():
    points, _ = torus(300)
    wide = np.column_stack([points, np.full(300, 7.0), np.zeros(300)])
    usual = gt.geodesic_distance(KNNGraph(points), 0)
    np.testing.assert_allclose(gt.geodesic_distance(KNNGraph(wide), 0), usual, atol=1e-9)


def test_whole_numbers_are_samples_too():
    lattice = np.indices((15, 15)).reshape(2, -1).T
    found = gt.geodesic_distance(KNNGraph(lattice), 0)
    np.testing.assert_allclose(found, np.linalg.norm(lattice, axis=1), rtol=1e-3)


@pytest.mark.parametrize("shape", [torus, helix, lambda n: cube(3, n)])
def test_parts_that_nothing_connects_are_infinitely_far(shape):
    points, _ = shape(150)
    found = gt.geodesic_distance(KNNGraph(np.concatenate([points, points + 100.0])), 0)
    assert np.isfinite(found[:150]).all()
    assert np.isinf(found[150:]).all()


def test_the_way_can_be_chosen():
    points, truth = torus()
    graph = gt.GeodesicSolver(KNNGraph(points), operator=KNNLaplacian(way="graph"))
    assert graph.diagnosis.notes["way"] == "graph"
    assert mean_error(graph.distance(0), truth) < GRAPH
    with pytest.raises(UnsupportedDomainError, match="the dimension is 3"):
        KNNLaplacian(way="charts").assemble(KNNGraph(cube(3)[0]))
    with pytest.raises(InvalidOptionError, match="way must be"):
        KNNLaplacian(way="other")


def test_another_metric_is_measured_on_the_graph():
    points, _ = torus(300)
    solver = gt.GeodesicSolver(KNNGraph(points, metric="manhattan"))
    assert "manhattan" in solver.diagnosis.notes["why"]
    assert np.isfinite(solver.distance(0)).all()


def test_a_surface_of_samples_on_one_line_is_refused():
    line = np.linspace(0, 1, 50)[:, None] * [1.0, 2.0, 3.0]
    with pytest.raises(UnsupportedDomainError, match="dimension=1"):
        KNNLaplacian().assemble(KNNGraph(line, dimension=2))
