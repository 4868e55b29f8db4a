"""Distances up to a limit are to the bit those without one, whatever measures them."""

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.core.near import NearRows
from geodesic_toolkit.discretization.fronts import Fronts
from geodesic_toolkit.errors import InvalidOptionError, InvalidSourceError
from geodesic_toolkit.testing import shapes
from tests.helpers.graph_shapes import boxes, lattice
from tests.helpers.sample_shapes import edge_graph, random_sphere


def two_spheres():
    one = shapes.icosphere(3)
    return gt.TriangleMesh(
        np.concatenate([one.vertices, one.vertices + 5]),
        np.concatenate([one.faces, one.faces + one.n_vertices]),
    )


def wall(mesh):
    """Return a solver of a mesh whose middle paths may not cross."""
    middle = np.abs(mesh.vertices[:, 0] - np.median(mesh.vertices[:, 0]))
    return gt.GeodesicSolver(mesh, mask=middle < 0.1 * middle.max())


def measured(mesh):
    ends = mesh.vertices[mesh.faces]
    lengths = np.linalg.norm(np.roll(ends, -1, axis=1) - np.roll(ends, -2, axis=1), axis=2)
    return gt.IntrinsicMesh(mesh.faces, lengths, n_vertices=mesh.n_vertices)


def slow_to_the_right(mesh):
    return gt.MetricMesh(mesh, cost=1 + mesh.vertices[:, 0])


def repeated_points():
    points = random_sphere(1400)[0]
    return gt.PointCloud(np.concatenate([points, points[:50]]))


def random_lengths():
    rng = np.random.default_rng(0)
    edges = rng.integers(0, 400, (1600, 2))
    edges = edges[edges[:, 0] != edges[:, 1]]
    return gt.Graph(400, edges, 0.1 + rng.random(len(edges)))


SOLVERS = {
    "mesh": lambda: gt.GeodesicSolver(shapes.icosphere(4)),
    "small mesh": lambda: gt.GeodesicSolver(shapes.icosphere(2)),
    "tiny mesh": lambda: gt.GeodesicSolver(shapes.icosphere(0)),
    "knot": lambda: gt.GeodesicSolver(shapes.knot()),
    "grid": lambda: gt.GeodesicSolver(shapes.grid(40)),
    "two components": lambda: gt.GeodesicSolver(two_spheres()),
    "mask": lambda: wall(shapes.icosphere(4)),
    "intrinsic mesh": lambda: gt.GeodesicSolver(measured(shapes.icosphere(4))),
    "metric mesh": lambda: gt.GeodesicSolver(slow_to_the_right(shapes.grid(40))),
    "plain mesh": lambda: gt.GeodesicSolver(shapes.icosphere(4), refine=False),
    "cloud": lambda: gt.GeodesicSolver(gt.PointCloud(random_sphere(1500)[0])),
    "cloud with repeated points": lambda: gt.GeodesicSolver(repeated_points()),
    "plain cloud": lambda: gt.GeodesicSolver(gt.PointCloud(random_sphere(600)[0]), refine=False),
    "lattice": lambda: gt.GeodesicSolver(lattice(20, 2)[0]),
    "voxels": lambda: gt.GeodesicSolver(boxes(8, 8, 8)[0]),
    "graph across": lambda: gt.GeodesicSolver(edge_graph(shapes.icosphere(4)), refine="across"),
    "graph along": lambda: gt.GeodesicSolver(edge_graph(shapes.icosphere(3)), refine=True),
    "graph by heat": lambda: gt.GeodesicSolver(edge_graph(shapes.icosphere(3)), refine=False),
    "random graph": lambda: gt.GeodesicSolver(random_lengths(), refine="across"),
}


@pytest.fixture(scope="module", params=SOLVERS)
def solver(request):
    return SOLVERS[request.param]()


def table(near, n_vertices):
    """Return rows with infinity where they have no entry."""
    full = np.full((len(near.begins) - 1, n_vertices), np.inf)
    full[near.rows, near.vertices] = near.distances
    assert np.isfinite(near.distances).all()
    assert (np.diff(near.rows * n_vertices + near.vertices) > 0).all()  # ascending, each once
    return full


def assert_near(solver, sets, limits):
    expected = solver.distances(sets)
    expected[~(expected <= np.reshape(limits, (-1, 1)))] = np.inf
    found = table(solver.near(sets, limits), solver.domain.n_vertices)
    np.testing.assert_array_equal(found, expected)


def some_vertices(solver, count=20):
    free = np.arange(solver.domain.n_vertices)
    if solver.mask is not None:
        free = free[~solver.mask]
    return np.random.default_rng(1).choice(free, min(count, len(free)), replace=False)


@pytest.mark.filterwarnings("ignore::geodesic_toolkit.errors.CoarseMeshWarning")
def test_distances_up_to_a_limit_are_those_without_one(solver):
    vertices = some_vertices(solver)
    reach = solver.distance(vertices[0])
    farthest = reach[np.isfinite(reach)].max()
    for share in (0.0, 0.05, 0.2, 0.6):
        assert_near(solver, vertices, share * farthest)
    assert_near(solver, vertices, np.inf)
    assert_near(solver, vertices, np.linspace(0, farthest, len(vertices)))


@pytest.mark.filterwarnings("ignore::geodesic_toolkit.errors.CoarseMeshWarning")
def test_sources_may_be_repeated_several_or_late(solver):
    first, second, third = some_vertices(solver, 3).tolist()
    between = solver.distance(first)[second]
    limit = 0.3 * between if np.isfinite(between) else 0.3
    late = gt.OffsetSources([second, third], [limit / 2, limit / 3])
    assert_near(solver, [[first], [first], [second, first], late, [third, third]], limit)


def test_sources_inside_faces_and_curves_have_limits_too():
    sphere = shapes.icosphere(4)
    solver = gt.GeodesicSolver(sphere)
    curve = gt.Curve(sphere.vertices[[0, 12, 40]])
    assert_near(solver, [gt.SurfacePoint(7, (0.2, 0.3, 0.5)), curve, [0.1, 0.2, 0.9]], 0.4)


def test_rows_do_not_depend_on_the_other_sets():
    solver = gt.GeodesicSolver(shapes.icosphere(5))  # more vertices than one thread takes
    together = solver.near(np.arange(40), 0.3)
    for vertex in (0, 17, 39):
        alone = solver.near([vertex], 0.3)
        own = slice(together.begins[vertex], together.begins[vertex + 1])
        np.testing.assert_array_equal(together.vertices[own], alone.vertices)
        np.testing.assert_array_equal(together.distances[own], alone.distances)


def test_fronts_of_a_kind_need_no_way_of_their_own():
    class Straight(Fronts):
        def distances(self, begins, vertices, known, starts):
            far = np.abs(np.arange(5.0) - vertices[:, None]) + known[:, None]
            return np.minimum.reduceat(far, begins[:-1])

    found = Straight().near(
        np.array([0, 1]), np.array([2]), np.zeros(1), np.zeros(1), np.array([1.0])
    )
    np.testing.assert_array_equal(found.vertices, [1, 2, 3])


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ("near", "limits must be numbers, not 'near'"),
        ([1.0, 2.0], "one for each of 3 source sets, not of shape \\(2,\\)"),
        ([1.0, np.nan, 2.0], "limit 1 is not a number"),
    ],
)
def test_limits_that_are_none_are_refused(limits, message):
    solver = gt.GeodesicSolver(shapes.icosphere(1))
    with pytest.raises(InvalidOptionError, match=message):
        solver.near([0, 1, 2], limits)
    with pytest.raises(InvalidSourceError, match="there are no source sets"):
        solver.near([], 1.0)


def test_a_limit_before_the_first_front_leaves_nothing():
    solver = gt.GeodesicSolver(lattice(6, 2)[0])
    late = gt.OffsetSources([0], [2.0])
    assert_near(solver, [late, [3]], 1.0)
    assert_near(solver, [late, [3]], -0.5)


# -- sparse rows -----------------------------------------------------------------------------------

TABLE = np.array([[0.0, 3.0, 1.0, 2.0], [np.inf, 0.0, 5.0, 1.0], [2.0, 2.0, 2.0, 0.0]])


def test_sparse_rows_are_chosen_replaced_and_put_together():
    near = NearRows.of_table(TABLE, np.array([2.0, 1.0, 0.0]))
    np.testing.assert_array_equal(near.begins, [0, 3, 5, 6])
    np.testing.assert_array_equal(near.within(np.ones(3)).vertices, [0, 2, 1, 3, 3])
    np.testing.assert_array_equal(near.chosen(np.array([0, 2])).vertices, [0, 2, 3, 3])
    whole = NearRows.of_table(TABLE, np.full(3, 9.0))
    both = near.replaced(np.array([0, 2]), whole.chosen(np.array([0, 2])))
    np.testing.assert_array_equal(both.begins, [0, 4, 6, 10])
    np.testing.assert_array_equal(both.distances[4:6], [0.0, 1.0])
    again = NearRows.together([near, whole])
    np.testing.assert_array_equal(np.diff(again.begins), [3, 2, 1, 4, 3, 4])


def test_vertices_read_the_distance_of_their_representative():
    representatives = np.array([0, 1, 0, 1])
    near = NearRows.of_table(TABLE, np.full(3, 2.5)).taken_from(representatives)
    expected = np.where(TABLE <= 2.5, TABLE, np.inf)[:, representatives]
    np.testing.assert_array_equal(table(near, 4), expected)
