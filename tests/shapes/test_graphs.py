"""Heat on graphs, and the paths along their edges."""

import numpy as np
import pytest
from closed_forms import bent_path, mean_relative_error, on_sphere
from graph_shapes import boxes, lattice
from sample_shapes import edge_graph
from scipy.sparse import csr_array
from scipy.sparse.csgraph import minimum_spanning_tree

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.testing import shapes

# Mean relative errors allowed, from what was measured: paths 0.003 % at 100 vertices, square grids
# 2.9 % at 41 x 41, cube grids 4.3 % at 25³, the edges of a level-4 icosphere 0.83 %.
PATH_TOLERANCE = 0.01
GRID_TOLERANCE = 0.05
SPHERE_TOLERANCE = 0.05
HALVING = 0.75


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


@pytest.mark.slow
def test_a_cube_grid_graph_measures_euclidean_distance():
    errors = [lattice_error(n, 3, gt.UniformLaplacian(dim=3)) for n in (7, 13, 25)]
    assert errors[2] < GRID_TOLERANCE
    assert errors[2] < HALVING * errors[1] < HALVING**2 * errors[0]


def test_the_edges_of_a_sphere_measure_the_sphere():
    mesh = shapes.icosphere(4)
    distance = gt.geodesic_distance(edge_graph(mesh), 0)
    assert mean_relative_error(distance, on_sphere(mesh, 0)) < SPHERE_TOLERANCE


@pytest.mark.slow
def test_the_graph_of_a_long_tube_is_right_at_its_far_end():
    rings, around = 1200, 48
    flat = gt.UniformLaplacian(dim=2)  # no edge runs along the tube, which would show the dimension
    distance = gt.geodesic_distance(edge_graph(shapes.tube(rings, around)), 0, operator=flat)
    assert abs(distance[-around:].mean() / ((rings - 1) * np.sqrt(3) / 2) - 1) < 0.03


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
def test_lengths_too_far_apart_for_heat_are_measured_along_edges(lengths):
    graph = gt.Graph(4, [[0, 1], [2, 1], [2, 3]], lengths)
    np.testing.assert_allclose(gt.geodesic_distance(graph, 0), np.cumsum([0, *lengths]))


def test_plain_heat_refuses_lengths_too_far_apart_by_name():
    square, _ = lattice(5, 2)
    lengths = np.ones(square.n_edges)
    lengths[7] = 3e6
    graph = gt.Graph(25, square.edges, lengths)
    one, other = sorted(graph.edges[7])
    named = f"the edge from {one} to {other} of the same component .* refine=True"
    with pytest.raises(UnsupportedDomainError, match=named):
        gt.GeodesicSolver(graph, refine=False)
    solver = gt.GeodesicSolver(graph)
    assert solver.method.refine
    assert "too large for double" in solver.diagnosis.reason


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
    with pytest.raises(UnsupportedDomainError, match="use another unit of length"):
        gt.GeodesicSolver(gt.Graph(3, [[0, 1], [1, 2]], [length, length]))


@pytest.mark.parametrize(
    "options", [{"dim": 0}, {"dim": 1.5}, {"dim": "2"}, {"dim": True}, {"mass": "unit"}]
)
def test_options_outside_their_values_are_refused(options):
    with pytest.raises(InvalidOptionError):
        gt.UniformLaplacian(**options)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "options"),
    [
        ((300, 4), {}),
        ((60, 60), {}),
        ((60, 40), {"diagonals": True}),
        ((200, 2, 2), {}),
        ((120, 5, 5), {}),
        ((100, 5, 5), {"diagonals": True}),
        ((50, 40, 2), {}),
        ((18, 18, 18), {}),
        ((25, 25, 12), {"spacing": (1, 1, 8)}),
    ],
)
def test_heat_on_bars_plates_and_boxes_of_any_aspect_measures_euclidean_distance(shape, options):
    graph, positions = boxes(*shape, **options)
    solver = gt.GeodesicSolver(graph, refine=False)
    assert not solver.method.refine
    errors = []
    for source in (0, graph.n_vertices // 2, graph.n_vertices // 3):
        exact = np.linalg.norm(positions - positions[source], axis=1)
        errors.append(mean_relative_error(solver.distance(source), exact))
    assert np.mean(errors) < 0.06  # of which the method has 4 % on boxes, whatever the scale


@pytest.mark.slow
@pytest.mark.parametrize("children", [1, 2, 3, 6])
def test_on_trees_of_any_branching_the_default_is_the_path_along_edges(children):
    parents = (np.arange(1, 800) - 1) // children
    lengths = np.random.default_rng(children).uniform(0.3, 2.0, 799)
    exact = np.zeros(800)
    for child, parent in enumerate(parents, start=1):
        exact[child] = exact[parent] + lengths[child - 1]
    graph = gt.Graph(800, np.column_stack([np.arange(1, 800), parents]), lengths)
    solver = gt.GeodesicSolver(graph)
    np.testing.assert_allclose(solver.distance(0), exact)
    assert solver.diagnosis.refined
    assert "one-dimensional" in solver.diagnosis.reason
    assert solver.method.nbytes == 0
    plain = gt.GeodesicSolver(graph, refine=False).distance(0)
    assert mean_relative_error(plain, exact) < 0.1
    assert (plain <= exact).all()


def test_a_sheet_and_the_chain_that_hangs_from_it_have_each_their_own_scale():
    sheet, positions = lattice(40, 2)
    chain = np.column_stack([np.arange(1599, 1899), np.arange(1600, 1900)])
    graph = gt.Graph(1900, np.concatenate([sheet.edges, chain]))
    exact = np.linalg.norm(positions - positions[-1], axis=1)
    exact = np.concatenate([exact, np.arange(1, 301)])
    distance = gt.geodesic_distance(graph, 1599)
    assert mean_relative_error(distance[:1600], exact[:1600]) < 0.05
    assert mean_relative_error(distance[1599:], exact[1599:]) < 0.05


@pytest.mark.slow
def test_distances_across_edges_are_bounded_by_paths_along_them_and_sources_read_their_offsets():
    graph, _ = boxes(30, 20, diagonals=True)
    solver = gt.GeodesicSolver(graph)
    along = gt.GeodesicSolver(graph, refine=True)
    for sources in (7, [0, 44, 599], gt.OffsetSources([3, 300], [0.0, 2.5])):
        distance, bound = solver.distance(sources), along.distance(sources)
        assert (distance >= 0).all()
        assert (distance <= bound).all()
    np.testing.assert_array_equal(solver.distance([0, 44, 599])[[0, 44, 599]], 0)
    np.testing.assert_array_equal(distance[[3, 300]], [0.0, 2.5])


def test_refinement_on_a_graph_is_the_path_along_edges_with_offsets_masks_and_rows():
    graph, _ = lattice(6, 2)
    mask = np.zeros(36, dtype=bool)
    mask[[7, 13, 19, 25, 31]] = True  # a wall with a gap at its top
    solver = gt.GeodesicSolver(graph, refine=True, mask=mask)
    distance = solver.distance(6)
    assert distance[8] == 4.0
    assert (distance[mask] == np.inf).all()
    late = gt.GeodesicSolver(graph, refine=True).distance(gt.OffsetSources([0, 35], [0.0, 8.5]))
    np.testing.assert_array_equal(late[[35, 34, 30]], [8.5, 9.0, 5.0])
    rows = gt.GeodesicSolver(graph, refine=True).distances([0, [0, 35]])
    np.testing.assert_array_equal(rows[:, 35], [10.0, 0.0])


@pytest.mark.slow
@pytest.mark.parametrize("short", [0.0, 1e-12])
@pytest.mark.parametrize("refine", [True, False])
def test_vertices_at_one_place_read_alike(short, refine):
    sheet, _ = lattice(20, 2)
    twins = np.column_stack([np.arange(0, 400, 10), np.arange(400, 440)])
    lengths = np.concatenate([np.ones(sheet.n_edges), np.full(40, short)])
    graph = gt.Graph(440, np.concatenate([sheet.edges, twins]), lengths)
    distance = gt.GeodesicSolver(graph, refine=refine).distance(405)
    plain = gt.GeodesicSolver(sheet, refine=refine).distance(50)
    np.testing.assert_allclose(distance[:400], plain, rtol=0.02, atol=1e-9)
    np.testing.assert_allclose(distance[400:], distance[twins[:, 0]], atol=1e-9)
    assert distance[405] == 0
    assert distance[50] <= short
    assert gt.GeodesicSolver(graph).diagnosis.isolated_vertices == 0


def test_a_graph_whose_factor_would_take_too_long_is_measured_along_edges():
    rng = np.random.default_rng(0)
    edges = rng.integers(3000, size=(24000, 2))
    solver = gt.GeodesicSolver(gt.Graph(3000, edges, rng.uniform(0.5, 1.0, 24000)))
    assert solver.method.nbytes == 0
    assert "take too long" in solver.diagnosis.reason
    assert np.isfinite(solver.distance(0)).all()


# -- networks of streets ---------------------------------------------------------------------------


def street_plan(blocks, rng, closed=0.0, spread=8.0):
    """Return the junctions of a town, the streets between them, and how long they are."""
    n = blocks + 1
    places = 100.0 * np.indices((n, n)).reshape(2, -1).T + rng.normal(scale=spread, size=(n * n, 2))
    number = np.arange(n * n).reshape(n, n)
    streets = np.concatenate(
        [
            np.column_stack([number[:-1].ravel(), number[1:].ravel()]),
            np.column_stack([number[:, :-1].ravel(), number[:, 1:].ravel()]),
        ]
    )
    streets = streets[rng.uniform(size=len(streets)) >= closed]
    return places, streets, np.linalg.norm(np.diff(places[streets], axis=1)[:, 0], axis=1)


@pytest.mark.parametrize(("blocks", "closed"), [(8, 0.0), (20, 0.0), (30, 0.1), (50, 0.25)])
def test_junctions_of_streets_are_measured_along_the_streets(blocks, closed):
    places, streets, lengths = street_plan(blocks, np.random.default_rng(blocks), closed)
    solver = gt.GeodesicSolver(gt.Graph(len(places), streets, lengths))
    assert solver.diagnosis.refined
    assert "street network" in solver.diagnosis.reason or "one-dim" in solver.diagnosis.reason


def test_lattices_quadrangles_and_samples_are_not_streets():
    places, streets, lengths = street_plan(20, np.random.default_rng(0), 0.1)
    lattice = gt.Graph(len(places), streets, np.full(len(streets), 100.0))
    assert not gt.GeodesicSolver(lattice).diagnosis.refined
    assert not gt.GeodesicSolver(
        gt.Graph(len(places), streets, lengths), operator=gt.UniformLaplacian(dim=2)
    ).diagnosis.refined
    ring, tube = 30, np.arange(900)
    quads = np.concatenate(
        [
            np.column_stack([tube, tube - tube % ring + (tube + 1) % ring]),
            np.column_stack([tube, (tube + ring) % 900]),
        ]
    )
    torus = gt.Graph(900, quads, np.random.default_rng(1).uniform(0.9, 1.1, len(quads)))
    assert not gt.GeodesicSolver(torus).diagnosis.refined
    mesh = shapes.icosphere(3)
    edges = np.unique(np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    sphere = np.linalg.norm(np.diff(mesh.vertices[edges], axis=1)[:, 0], axis=1)
    assert not gt.GeodesicSolver(gt.Graph(mesh.n_vertices, edges, sphere)).diagnosis.refined
