"""Fronts across the corners of graphs that sample something measure straight lines."""

import numpy as np
import pytest
from closed_forms import mean_relative_error
from graph_shapes import boxes, lattice
from sample_shapes import edge_graph

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.testing import shapes

# -- fronts across corners -------------------------------------------------------------------------


def error_of(solver, sources, exact):
    """Return the mean over sources of the mean relative error; `exact` is a function of one."""
    return np.mean([mean_relative_error(solver.distance(s), exact(s)) for s in sources])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "options"),
    [
        ((300, 4), {}),
        ((11, 11), {"spacing": (1, 3)}),
        ((40, 30), {"diagonals": True, "spacing": (1, 3)}),
        ((150, 2, 2), {}),
        ((40, 30, 2), {"spacing": (1, 1, 3)}),
        ((6, 6, 6), {}),
        ((12, 12, 12), {"spacing": (1, 2, 5)}),
        ((8, 8, 8), {"diagonals": True, "spacing": (1, 1, 3)}),
        ((60, 4, 4), {"diagonals": True}),
    ],
)
def test_grids_and_voxels_of_any_aspect_are_measured_in_straight_lines(shape, options):
    graph, positions = boxes(*shape, **options)
    solver = gt.GeodesicSolver(graph)
    assert solver.diagnosis.across
    assert not solver.diagnosis.refined
    assert "fronts can cross" in solver.diagnosis.reason
    assert solver.method.nbytes == 0
    sources = (0, graph.n_vertices // 2, graph.n_vertices // 3)
    error = error_of(solver, sources, lambda s: np.linalg.norm(positions - positions[s], axis=1))
    assert error < (0.002 if options.get("diagonals") else 1e-9)


def voxels(inside, spacing=(1, 1, 1)):
    """The graph of the voxels of a mask, neighbours along the axes, and their positions."""
    whole, positions = boxes(*inside.shape, spacing=spacing)
    number = np.cumsum(inside.ravel()) - 1
    kept = inside.ravel()[whole.edges].all(axis=1)
    graph = gt.Graph(int(inside.sum()), number[whole.edges[kept]], whole.lengths[kept])
    return graph, positions[inside.ravel()]


@pytest.mark.parametrize("direction", [(1, 1, 0), (1, 1, 1), (3, 2, 1), (1, 1, 5)])
@pytest.mark.parametrize(
    ("radius", "spacing"), [(1.5, (1, 1, 1)), (2.5, (1, 1, 1)), (3.0, (1, 1, 2)), (4.5, (1, 1, 3))]
)
def test_thin_vessels_of_voxels_along_any_direction_are_as_long_as_they_are(
    direction, radius, spacing
):
    along = np.array(direction) / np.linalg.norm(direction)
    shape = np.ceil((45 * along + 2 * radius + 2) / spacing).astype(int)
    places = np.stack(np.indices(shape), axis=-1) * spacing - radius - 1
    height = places @ along
    off = np.linalg.norm(places - height[..., None] * along, axis=-1)
    graph, positions = voxels((off <= radius) & (height >= 0) & (height <= 45), spacing)
    distance = gt.geodesic_distance(graph, 0)
    straight = np.linalg.norm(positions - positions[0], axis=1)
    reached = np.isfinite(distance)
    assert reached.mean() > 0.95
    assert mean_relative_error(distance[reached], straight[reached]) < 0.05


@pytest.mark.parametrize("spacing", [(1, 1, 1), (1, 1, 2), (1, 1, 3)])
def test_a_bent_vessel_is_as_long_as_between_its_inner_wall_and_its_middle(spacing):
    places = np.stack(np.indices((32, 9, 32 // spacing[2])), axis=-1) * np.array(spacing)
    ring = np.hypot(places[..., 0], places[..., 2])
    graph, positions = voxels(np.hypot(ring - 25, places[..., 1] - 4) < 3.2, spacing)
    start = int(np.linalg.norm(positions - [25, 4, 0], axis=1).argmin())
    end = int(np.linalg.norm(positions - [0, 4, 25], axis=1).argmin())
    inner = 22.0
    shortest = 2 * np.sqrt(25**2 - inner**2) + inner * (np.pi / 2 - 2 * np.arccos(inner / 25))
    assert shortest < gt.geodesic_distance(graph, start)[end] < 25 * np.pi / 2


def test_a_front_bends_round_the_corner_of_a_lattice():
    inside = np.ones((40, 40, 1), dtype=bool)
    inside[20:, 20:] = False
    graph, positions = voxels(inside)
    start = int(np.flatnonzero((positions == [39, 0, 0]).all(axis=1))[0])
    end = int(np.flatnonzero((positions == [0, 39, 0]).all(axis=1))[0])
    assert gt.geodesic_distance(graph, start)[end] == pytest.approx(
        2 * np.hypot(19.5, 19.5), rel=0.01
    )


def test_a_chain_that_turns_is_not_cut_short_and_a_hole_is_gone_round():
    spiral = np.zeros((9, 9, 1), dtype=bool)
    spiral[0], spiral[:, -1], spiral[-1] = True, True, True
    graph, positions = voxels(spiral)
    end = int(np.flatnonzero((positions == [8, 0, 0]).all(axis=1))[0])
    assert gt.geodesic_distance(graph, 0)[end] == 24
    ring = np.ones((15, 15, 1), dtype=bool)
    ring[3:12, 3:12] = False
    graph, positions = voxels(ring)
    end = int(np.flatnonzero((positions == [14, 14, 0]).all(axis=1))[0])
    way = 2 * np.hypot(11.5, 2.5)  # past the corner of the voxel that is missing
    assert gt.geodesic_distance(graph, 0)[end] == pytest.approx(way, rel=0.02)


@pytest.mark.slow
def test_the_edges_of_tubes_and_spheres_measure_what_they_are_the_edges_of():
    for mesh in (
        shapes.tube(150, 12),
        shapes.tube(40, 24),
        shapes.icosphere(3),
        shapes.grid(25),
    ):
        solver = gt.GeodesicSolver(edge_graph(mesh))
        assert solver.diagnosis.across
        assert error_of(solver, (0, 200), lambda s, m=mesh: gt.exact_distance(m, s)) < 0.01


def graph_of_nearest(samples, k):
    from sklearn.neighbors import kneighbors_graph

    return gt.as_domain(kneighbors_graph(samples, k, mode="distance"))


def neighbour_graph(samples, k, noise, rng):
    turned = samples @ np.linalg.qr(rng.normal(size=(10, 10)))[0][: samples.shape[1]]
    return graph_of_nearest(turned + noise * rng.normal(size=turned.shape), k)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.05, 0.1])
@pytest.mark.parametrize(("count", "k"), [(500, 10), (500, 15), (2000, 8), (2000, 12)])
def test_neighbour_graphs_of_noisy_samples_measure_the_sphere_and_the_square(count, k, noise):
    rng = np.random.default_rng(count + k)
    square = rng.random((count, 2))
    graph = neighbour_graph(square, k, noise / np.sqrt(count), rng)
    solver = gt.GeodesicSolver(graph)
    assert solver.diagnosis.across
    sources = (3, count // 2)
    error = error_of(solver, sources, lambda s: np.linalg.norm(square - square[s], axis=1))
    assert error < 0.05
    if noise == 0:
        assert solver.diagnosis.notes["noise"] == 0
    sphere = rng.normal(size=(count, 3))
    sphere /= np.linalg.norm(sphere, axis=1)[:, None]
    graph = neighbour_graph(sphere, k, noise * np.sqrt(4 * np.pi / count), rng)
    arcs = error_of(
        gt.GeodesicSolver(graph), sources, lambda s: np.arccos(np.clip(sphere @ sphere[s], -1, 1))
    )
    assert arcs < 0.05


@pytest.mark.slow
def test_a_cloud_of_tetrahedra_is_crossed_and_sparse_neighbours_in_a_cube_are_left_to_heat():
    from scipy.spatial import Delaunay

    rng = np.random.default_rng(0)
    cube = rng.random((600, 3))
    cells = np.sort(Delaunay(cube).simplices, axis=1)
    pairs = np.concatenate([cells[:, [i, j]] for j in range(4) for i in range(j)])
    edges = np.unique(pairs, axis=0).astype(np.int64)
    lengths = np.linalg.norm(np.diff(cube[edges], axis=1)[:, 0], axis=1)
    solver = gt.GeodesicSolver(gt.Graph(600, edges, lengths))
    assert solver.diagnosis.across
    assert error_of(solver, (0, 300), lambda s: np.linalg.norm(cube - cube[s], axis=1)) < 0.02
    sparse = gt.GeodesicSolver(neighbour_graph(cube, 8, 0.0, rng))
    assert not sparse.diagnosis.across
    assert "heat" in sparse.diagnosis.reason


@pytest.mark.slow
@pytest.mark.parametrize(
    ("dimension", "count", "k", "reason"),
    [(4, 10_000, 20, "fronts can cross the corners of the graph"), (5, 6000, 16, "too late")],
)
def test_fronts_cross_samples_for_which_a_factor_would_be_too_wide(dimension, count, k, reason):
    cube = np.random.default_rng(0).random((count, dimension))
    graph = graph_of_nearest(cube, k)
    solver = gt.GeodesicSolver(graph)
    assert solver.diagnosis.across
    assert solver.method.nbytes == 0
    assert reason in solver.diagnosis.reason

    def straight(source):
        return np.linalg.norm(cube - cube[source], axis=1)

    along = gt.GeodesicSolver(graph, refine=True)
    assert error_of(solver, (0, 9), straight) < 0.75 * error_of(along, (0, 9), straight)


def test_samples_in_many_dimensions_are_left_to_heat_though_triangles_are_few():
    samples = np.random.default_rng(0).random((500, 20))
    solver = gt.GeodesicSolver(graph_of_nearest(samples, 8))
    assert not solver.diagnosis.across
    assert "heat" in solver.diagnosis.reason


def test_fronts_across_edges_keep_to_the_bounds_offsets_masks_and_other_parts():
    graph, positions = boxes(30, 20, diagonals=False)
    solver = gt.GeodesicSolver(graph)
    along = gt.GeodesicSolver(graph, refine=True)
    for sources in (7, [0, 44, 599], gt.OffsetSources([3, 300], [0.0, 2.5])):
        distance, bound = solver.distance(sources), along.distance(sources)
        assert (distance >= 0).all()
        assert (distance <= bound).all()
    np.testing.assert_array_equal(distance[[3, 300]], [0.0, 2.5])
    straight = np.linalg.norm(positions[:, None] - positions[[3, 300]], axis=2)
    np.testing.assert_allclose(distance, (straight + np.array([0.0, 2.5])).min(axis=1), rtol=0.02)
    rows = solver.distances([0, [0, 599], 300])
    np.testing.assert_array_equal(rows[0], solver.distance(0))
    np.testing.assert_array_equal(rows[2], solver.distance(300))
    mask = np.zeros(600, dtype=bool)
    mask[10:600:20][:-3] = True
    masked = gt.GeodesicSolver(graph, mask=mask).distance(0)
    assert (masked[mask] == np.inf).all()
    assert masked[19] > 1.5 * np.hypot(*positions[19])
    apart = gt.Graph(1201, np.concatenate([graph.edges, graph.edges + 600]))
    distance = gt.geodesic_distance(apart, 5)
    assert np.isfinite(distance[:600]).all()
    assert (distance[600:] == np.inf).all()


def test_a_copied_solver_across_edges_answers_alike():
    import copy
    import pickle

    graph, _ = boxes(9, 8, 7)
    solver = gt.GeodesicSolver(graph)
    expected = solver.distance(11)
    for other in (copy.copy(solver), pickle.loads(pickle.dumps(solver))):
        np.testing.assert_array_equal(other.distance(11), expected)
    assert "across=True" in repr(solver)


@pytest.mark.slow
def test_options_of_heat_mean_heat_and_across_can_be_insisted_on():
    graph, _ = boxes(20, 20)
    for options in ({"time": 2.0}, {"time_factor": 3.0}, {"diffusion": "uniform"}):
        assert not gt.GeodesicSolver(graph, **options).diagnosis.across
    assert not gt.GeodesicSolver(graph, operator=gt.UniformLaplacian(dim=2)).diagnosis.across
    tree = gt.Graph(4, [[0, 1], [1, 2], [1, 3]])
    assert gt.GeodesicSolver(tree, refine="across").distance(0).tolist() == [0, 1, 2, 2]
    with pytest.raises(InvalidOptionError, match="for graphs"):
        gt.GeodesicSolver(shapes.icosphere(2), refine="across")
    with pytest.raises(InvalidOptionError, match="across"):
        gt.GeodesicSolver(graph, refine="through")
    method = gt.GeodesicSolver(graph).method
    with pytest.raises(UnsupportedDomainError, match=r"across=True needs .* a graph with corners"):
        gt.HeatMethod(
            method.metric,
            heat_solver=method.heat_solver,
            poisson_solver=method.poisson_solver,
            refine=True,
            across=True,
        )


@pytest.mark.slow
def test_graphs_without_corners_are_left_to_heat():
    rng = np.random.default_rng(1)
    m = 24
    row, column = np.indices((m, m)).reshape(2, -1)
    places = np.column_stack(
        [column * np.sqrt(3) / 2, row * 1.5 + 0.5 * ((row + column) % 2)]
    )  # a honeycomb
    edges = np.argwhere(np.triu(np.linalg.norm(places[:, None] - places, axis=2) < 1.01, 1))
    honeycomb = gt.GeodesicSolver(gt.Graph(m * m, edges))
    assert not honeycomb.diagnosis.across
    sheet, _ = lattice(40, 2)
    torn = gt.Graph(1600, sheet.edges[rng.random(sheet.n_edges) > 0.3])
    assert not gt.GeodesicSolver(torn).diagnosis.across


def odd_graphs():
    rng = np.random.default_rng(0)
    pairs = np.argwhere(np.triu(np.ones((70, 70)), 1))
    rim = np.arange(1, 200)
    wheel = np.concatenate([np.column_stack([0 * rim, rim]), np.column_stack([rim, rim % 199 + 1])])
    sides = np.array([(i, 40 + j) for i in range(40) for j in range(40)])
    ring = np.arange(300)[:, None] + [0, 1, 2]
    jumps = np.concatenate([ring[:, :2], ring[:, ::2], rng.integers(300, size=(40, 2))]) % 300
    cube = np.array([(i, i ^ (1 << b)) for i in range(64) for b in range(6) if i < i ^ (1 << b)])
    return {
        "one with edges between all": gt.Graph(70, pairs),
        "one with lengths that no space has": gt.Graph(70, pairs, rng.uniform(0.1, 1, len(pairs))),
        "a wheel, whose hub has 199 neighbours": gt.Graph(200, wheel),
        "one of two sides": gt.Graph(80, sides, rng.uniform(0.5, 1, len(sides))),
        "a ring with short cuts": gt.Graph(300, jumps),
        "a cube of six dimensions": gt.Graph(64, cube),
        "a triangle that is too long": gt.Graph(3, [[0, 1], [1, 2], [0, 2]], [1, 1, 5]),
    }


@pytest.mark.slow
@pytest.mark.parametrize("name", odd_graphs())
def test_fronts_stay_within_bounds_on_graphs_that_sample_nothing(name):
    graph = odd_graphs()[name]
    across = gt.GeodesicSolver(graph, refine="across").distances([0, [1, 2]])
    along = gt.GeodesicSolver(graph, refine=True).distances([0, [1, 2]])
    assert (across <= along).all()
    assert (across >= 0).all()
    np.testing.assert_array_equal(across[:, :3] == 0, along[:, :3] == 0)


def test_corners_are_checked_where_they_come_in():
    from geodesic_toolkit import _native

    edges, lengths = np.array([[0, 1], [1, 2], [0, 2]]), np.ones(3)
    corners = _native.GraphCorners(3, edges, lengths)
    assert corners.n_corners == 3
    assert corners.nbytes > 0
    for wrong in ((2, edges, lengths), (3, edges, lengths[:2]), (3, edges, 0 * lengths)):
        with pytest.raises(ValueError, match="arrays do not fit together"):
            _native.GraphCorners(*wrong)
    begins, sources, starts = np.array([0, 1]), np.array([0]), np.zeros(1)
    for wrong_cross in (
        (begins, sources, starts, np.empty((2, 3)), 1),
        (begins, sources, starts, np.empty((1, 2)), 1),
        (begins, sources, np.zeros(2), np.empty((1, 3)), 1),
        (np.array([0, 2]), sources, starts, np.empty((1, 3)), 1),
        (begins, np.array([3]), starts, np.empty((1, 3)), 1),
    ):
        with pytest.raises(ValueError, match="arrays do not fit together"):
            corners.cross(*wrong_cross)
