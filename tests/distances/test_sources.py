"""Sources: many vertices at once, and sources with offsets."""

from contextlib import nullcontext

import numpy as np
import pytest
from closed_forms import mean_relative_error
from source_shapes import GRID, PCA, SHAPES, SPHERE

import geodesic_toolkit as gt
from geodesic_toolkit.errors import FarSourceWarning, InvalidSourceError
from geodesic_toolkit.testing import shapes

# -- many at once ----------------------------------------------------------------------------------


@pytest.mark.parametrize("spread", [3, 17])
def test_many_refined_sources_read_zero_at_each(spread):
    # The bugs of others: CGAL #9565 (negative distances), libigl #1511 (sources not at zero).
    sources = np.arange(0, SPHERE.n_vertices, spread)
    distance = gt.geodesic_distance(SPHERE, sources, refine=True)
    assert (distance[sources] == 0).all()
    assert (distance >= 0).all()
    others = np.setdiff1d(np.arange(SPHERE.n_vertices), sources)
    assert (distance[others] > 0).all()


@pytest.mark.filterwarnings("ignore::geodesic_toolkit.errors.CoarseMeshWarning")  # rightly
@pytest.mark.parametrize("count", [2, 5, 40, 200])  # a few are pinned in another way than many
@pytest.mark.parametrize("kind", SHAPES)
def test_plain_heat_reads_zero_at_every_source_and_nothing_less(kind, count):
    shape = SHAPES[kind]
    sources = np.random.default_rng(count).choice(shape.n_vertices, count, replace=False)
    solver = gt.GeodesicSolver(shape, operator=PCA if kind == "cloud" else "auto", refine=False)
    distance = solver.distance(sources)
    assert (distance[sources] == 0).all()
    assert distance.min() == 0
    together = solver.distances([[0], sources, sources[:1]])
    np.testing.assert_allclose(together[1], distance, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(together[2], solver.distance(sources[0]), rtol=1e-9, atol=1e-12)


@pytest.mark.filterwarnings("ignore::geodesic_toolkit.errors.CoarseMeshWarning")  # rightly
@pytest.mark.parametrize("count", [3, 60])
def test_pinned_sources_are_no_farther_off_than_one(count):
    sources = np.random.default_rng(count).choice(SPHERE.n_vertices, count, replace=False)
    solver = gt.GeodesicSolver(SPHERE, refine=False)
    exact = gt.exact_distance(SPHERE, sources)
    assert np.abs(solver.distance(sources) - exact).max() < 1.5 * solver.method.metric.spacing


@pytest.mark.parametrize("count", [4, 100])
def test_pinning_gives_the_potential_closest_to_the_field(count):
    """A Schur complement, a new factor and a dense solution of the least squares agree."""
    mesh = shapes.icosphere(2)
    sources = np.random.default_rng(count).choice(mesh.n_vertices, count, replace=False)
    method = gt.GeodesicSolver(mesh, refine=False).method
    gradient = method.metric.gradient
    load = gradient.adjoint(
        gradient.unit(method.log_heat(sources))
    )  # the load of the descent of heat
    free = np.setdiff1d(np.arange(mesh.n_vertices), sources)
    stiffness = method.metric.stiffness.toarray()
    expected = np.zeros(mesh.n_vertices)
    expected[free] = np.linalg.solve(stiffness[np.ix_(free, free)], -load[free])
    found = method.distance(sources)
    np.testing.assert_allclose(found, np.maximum(expected, 0), atol=2e-3 * expected.max())


def test_a_source_given_twice_is_one():
    solver = gt.GeodesicSolver(SPHERE, refine=False)
    np.testing.assert_allclose(solver.distance([7, 7]), solver.distance(7), atol=1e-12)


@pytest.mark.filterwarnings("ignore::geodesic_toolkit.errors.CoarseMeshWarning")  # rightly
def test_regions_and_components_keep_to_themselves():
    other = shapes.icosphere(2)
    both = shapes.disjoint_union(shapes.icosphere(3), other, shapes.icosphere(1))
    cap = np.flatnonzero(shapes.icosphere(3).vertices[:, 2] > 0.5)
    distance = gt.geodesic_distance(both, [*cap, 642], refine=False)
    np.testing.assert_allclose(
        distance[642:804], gt.geodesic_distance(other, 0, refine=False), atol=1e-6
    )
    alone = gt.geodesic_distance(shapes.icosphere(3), cap, refine=False)
    np.testing.assert_allclose(distance[:642], alone, atol=1e-6)
    assert np.isinf(distance[804:]).all()
    everything = gt.geodesic_distance(other, np.arange(other.n_vertices), refine=False)
    assert not everything.any()


def test_points_inside_faces_are_pinned_by_the_corners_around_them():
    points = [gt.SurfacePoint(face, (0.2, 0.3, 0.5)) for face in (10, 700, 1500)]
    distance = gt.geodesic_distance(SPHERE, points, refine=False)
    corners = SPHERE.vertices[SPHERE.faces[10]]
    place = np.array([0.2, 0.3, 0.5]) @ corners
    expected = np.linalg.norm(corners - place, axis=1)
    np.testing.assert_allclose(distance[SPHERE.faces[10]], expected)


@pytest.mark.parametrize("kind", SHAPES)
def test_plain_heat_reads_the_offset_at_every_source_that_is_not_overtaken(kind):
    shape = SHAPES[kind]
    solver = gt.GeodesicSolver(shape, operator=PCA if kind == "cloud" else "auto", refine=False)
    way = solver.distance(0)
    near, far = np.argsort(way)[[len(way) // 3, -1]]
    late = gt.OffsetSources([0, far, near], [0.0, way[far] / 3, 1.5 * way[near]])
    distance = solver.distance(late)
    assert (distance[0], distance[far]) == (0, way[far] / 3)
    assert distance[near] == pytest.approx(way[near], rel=0.1)
    assert distance.min() == 0


def test_the_vertices_of_a_label_are_a_source():
    label = SPHERE.vertices[:, 2] > 0.9
    polar = np.arccos(np.clip(SPHERE.vertices[:, 2], -1, 1))
    distance = gt.geodesic_distance(SPHERE, np.flatnonzero(label), refine=True)
    assert (distance[label] == 0).all()
    rim = polar[label].max()
    spacing = gt.GeodesicSolver(SPHERE).method.metric.spacing
    np.testing.assert_allclose(distance[~label], polar[~label] - rim, atol=spacing)
    with pytest.raises(InvalidSourceError, match=r"use numpy.flatnonzero\(mask\)"):
        gt.geodesic_distance(SPHERE, label)


# -- head starts -----------------------------------------------------------------------------------


@pytest.mark.parametrize("late", [0.3, 1.2, 5.0])
@pytest.mark.parametrize(("refine", "bound"), [(True, 0.01), (False, 0.04)])
def test_the_distance_is_the_least_of_offset_plus_way(late, refine, bound):
    ends = [0, GRID.n_vertices - 1]
    ways = [np.linalg.norm(GRID.vertices - GRID.vertices[end], axis=1) for end in ends]
    expected = np.minimum(ways[0], late + ways[1])
    sources = gt.OffsetSources(ends, [0.0, late])
    distance = gt.geodesic_distance(GRID, sources, refine=refine)
    assert mean_relative_error(distance, expected) < bound


def test_offsets_may_be_hundreds_of_edges_apart():
    path = gt.Graph(3001, np.column_stack([np.arange(3000), np.arange(1, 3001)]))
    sources = gt.OffsetSources([0, 3000], [0.0, 1500.0])
    distance = gt.geodesic_distance(path, sources, operator=gt.UniformLaplacian(dim=1))
    vertex = np.arange(3001)
    np.testing.assert_allclose(distance, np.minimum(vertex, 4500 - vertex), atol=1)


def test_a_source_that_starts_too_late_has_no_effect():
    solver = gt.GeodesicSolver(SPHERE)
    late = solver.distance(gt.OffsetSources([0, 900], [0.0, 1e6]))
    np.testing.assert_allclose(late, solver.distance(0), atol=1e-9)


def test_a_common_offset_is_added_in_each_component():
    two = shapes.disjoint_union(shapes.icosphere(2), shapes.icosphere(2))
    solver = gt.GeodesicSolver(two)
    sources = gt.OffsetSources([0, 170], [3.0, 5000.0])
    alone = solver.distance([0, 170])
    np.testing.assert_allclose(solver.distance(sources)[:162], alone[:162] + 3, atol=1e-9)
    np.testing.assert_allclose(solver.distance(sources)[162:], alone[162:] + 5000, atol=1e-9)
    assert (solver.heat(sources) > 0).all()


@pytest.mark.parametrize(
    "offsets", [[-1.0, 0], [np.nan, 0], [np.inf, 0], ["a", "b"], [[0.0], [1.0]], [[0], [1, 2]]]
)
def test_offsets_that_are_none_are_refused(offsets):
    with pytest.raises(InvalidSourceError, match="offset"):
        gt.OffsetSources([0, 1], offsets)


def test_there_is_one_offset_for_each_source():
    with pytest.raises(InvalidSourceError, match="2 offsets must be one for each source"):
        gt.geodesic_distance(SPHERE, gt.OffsetSources([0, 1, 2], [0.0, 1.0]))
    curve = gt.Curve([[1, 0, 0], [0, 1, 0]])
    with pytest.raises(InvalidSourceError, match="one for each source"):
        gt.geodesic_distance(SPHERE, gt.OffsetSources(curve, [1.0]))


def test_queries_know_curves_and_head_starts():
    solver = gt.GeodesicSolver(GRID, refine=True)
    side = gt.Curve([[0, 0, 0], [0, 1, 0]])
    assert solver.query([0.51, 0.42, 0], side) == pytest.approx(0.51, abs=0.002)
    late = gt.OffsetSources([0], [2.0])
    assert solver.query([0.5, 0.0, 0], late) == pytest.approx(2.5, abs=0.002)


# -- floats that may be indices -------------------------------------------------------------------


@pytest.mark.parametrize("ask", [list, np.array, lambda floats: np.array(floats, dtype=np.float32)])
def test_three_whole_floats_are_refused_with_both_ways_to_say_what_they_are(ask):
    square = shapes.grid(11)
    says = (
        r"sources: \[5.0, 7.0, 9.0\] may be three vertices or one point; give vertices as "
        r"integers, \[5, 7, 9\] \(for an array: sources.astype\(int\)\), and the point as an "
        r"array of shape \(1, 3\), \[\[5.0, 7.0, 9.0\]\]"
    )
    with pytest.raises(InvalidSourceError, match=says):
        gt.geodesic_distance(square, ask([5.0, 7.0, 9.0]))
    with pytest.raises(InvalidSourceError, match="may be three vertices or one point"):
        gt.geodesic_distance(square, gt.OffsetSources(ask([5.0, 7.0, 9.0]), [0.0, 0.0, 0.0]))
    with pytest.raises(InvalidSourceError, match="may be three vertices or one point"):
        gt.geodesic_distance(gt.PointCloud(square.vertices), ask([5.0, 7.0, 9.0]))


def large_square():
    square = shapes.grid(11)
    return gt.TriangleMesh(20 * square.vertices, square.faces)


def test_the_cures_for_three_whole_floats_are_taken():
    square = large_square()
    expected = gt.geodesic_distance(square, [5, 7, 9])
    np.testing.assert_array_equal(
        gt.geodesic_distance(square, np.array([5.0, 7.0, 9.0]).astype(int)), expected
    )
    np.testing.assert_array_equal(
        gt.geodesic_distance(square, [[5.0, 7.0, 9.0]]),
        gt.geodesic_distance(square, [5.0, 7.0, 9.5]),
    )


@pytest.mark.parametrize(
    "point",
    [
        [0.0, 0.0, 1.0],
        [0.0, 0.0, 0.0],
        [1.0, 2.0, -1.0],
        [1.0, 2.0, 121.0],
        [0, 1.5, 2],
        [1e300, 0.0, 0.0],
    ],
)
def test_floats_that_cannot_be_three_vertices_are_a_point(point):
    square = large_square()
    far = pytest.warns(FarSourceWarning) if max(point) > 100 else nullcontext()
    with far:
        distance = gt.geodesic_distance(square, point)
        np.testing.assert_array_equal(distance, gt.geodesic_distance(square, [point]))


def test_floats_as_sources_of_a_graph_get_an_error_about_positions():
    with pytest.raises(InvalidSourceError, match="a Graph has no positions; give vertex indices"):
        gt.geodesic_distance(gt.Graph(11, [[k, k + 1] for k in range(10)]), [5.0, 7.0, 9.0])


# -- places of several kinds -----------------------------------------------------------------------

POINT_ON_FACE = gt.SurfacePoint(0, [0.2, 0.3, 0.5])


@pytest.mark.parametrize(
    ("places", "first", "second"),
    [
        ([[0, 1], 2], "0 a list, [0, 1]", "1 a vertex, 2; several sets are a list of lists"),
        ([0, POINT_ON_FACE], "0 a vertex, 0", "1 a SurfacePoint"),
        ([POINT_ON_FACE, POINT_ON_FACE, 4], "0 a SurfacePoint", "2 a vertex, 4"),
        (np.array([0, POINT_ON_FACE]), "0 a vertex, 0", "1 a SurfacePoint"),
        ([3, [0.0, 0.0, 1.0]], "0 a vertex, 3", "1 a point in space, [0.0, 0.0, 1.0]; give"),
        ([0, 1, None], "0 a vertex, 0", "2 a NoneType, None"),
    ],
)
def test_a_mixture_of_places_is_refused_with_the_first_that_differs(places, first, second):
    sphere = shapes.icosphere(1)
    solver = gt.GeodesicSolver(sphere)
    asks = [
        lambda: solver.distance(places),
        lambda: solver.distances([[5], places]),
        lambda: gt.geodesic_path(solver, places, 7),
        lambda: gt.geodesic_path(solver, 7, places),
        lambda: gt.geodesic_path(solver, 7, 9, via=places),
        lambda: gt.geodesic_loop(solver, places),
    ]
    for ask in asks:
        with pytest.raises(InvalidSourceError, match="mix kinds of places: at position") as caught:
            ask()
        assert f"position {first}" in str(caught.value)
        assert f"position {second}" in str(caught.value)


def test_the_advice_on_a_mixture_gives_the_sources_that_were_meant():
    sphere = shapes.icosphere(1)
    face, weights = POINT_ON_FACE.face, np.array(POINT_ON_FACE.barycentric)
    points = [sphere.vertices[3], weights @ sphere.vertices[sphere.faces[face]]]
    solver = gt.GeodesicSolver(sphere)
    apart = np.minimum(solver.distance(3), solver.distance(POINT_ON_FACE))
    np.testing.assert_allclose(solver.distance(points), apart, atol=0.02)


@pytest.mark.parametrize("sets", [np.array(4), {0: 1}, {0, 1}, "01", 3, None])
def test_sets_of_sources_are_a_sequence(sets):
    with pytest.raises(InvalidSourceError, match="source sets must be a sequence of sets, not"):
        gt.GeodesicSolver(shapes.icosphere(1)).distances(sets)


@pytest.mark.parametrize(
    ("sources", "message"),
    [(None, "not None"), ({}, "not {}"), ([[0, "a"]], "not .*, in a list"), ([None], "None, in a")],
)
def test_what_is_not_a_source_is_named(sources, message):
    with pytest.raises(InvalidSourceError, match=message):
        gt.geodesic_distance(shapes.icosphere(1), sources)
