"""Distance at points off the vertices: on meshes, on clouds, past their reach."""

import copy
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    ReadError,
    UnsupportedDomainError,
)
from geodesic_toolkit.geometry.closest import TriangleTree
from geodesic_toolkit.io import read_points, write
from geodesic_toolkit.solver import queries
from geodesic_toolkit.solver import solver as solver_module
from geodesic_toolkit.solver.queries import interpolate
from geodesic_toolkit.sources import ground
from geodesic_toolkit.sources.locate import locate_sources
from geodesic_toolkit.testing import shapes

GRID = shapes.grid(17)
H = 1 / 16


def scattered_plane(n=20, seed=3):
    """A cloud in the plane z = 0 that covers the unit square: a grid with every point shifted."""
    rng = np.random.default_rng(seed)
    points = shapes.grid(n).vertices + rng.uniform(-0.3, 0.3, (n * n, 3)) / (n - 1) * [1, 1, 0]
    return gt.PointCloud(points, normals=np.tile([0.0, 0, 1], (n * n, 1)))


@pytest.fixture(scope="module")
def flat():
    """Flat domains over the unit square, with their solvers."""
    return {
        "mesh": gt.GeodesicSolver(GRID),
        "cloud of a grid": gt.GeodesicSolver(
            gt.PointCloud(GRID.vertices, normals=np.tile([0.0, 0, 1], (GRID.n_vertices, 1)))
        ),
        "scattered cloud": gt.GeodesicSolver(scattered_plane()),
    }


@pytest.fixture(scope="module")
def sphere():
    return gt.GeodesicSolver(shapes.icosphere(3))


def positions_of(solver):
    domain = solver.domain
    return domain.vertices if isinstance(domain, gt.TriangleMesh) else domain.points


@pytest.mark.parametrize("kind", ["mesh", "cloud of a grid", "scattered cloud"])
@settings(max_examples=15, deadline=None)
@given(data=st.data())
def test_linear_functions_are_interpolated_exactly(flat, kind, data):
    solver = flat[kind]
    inside = st.floats(0.1, 0.9)
    points = np.array(data.draw(st.lists(st.tuples(inside, inside), min_size=1, max_size=20)))
    points = np.column_stack([points, np.full(len(points), data.draw(st.floats(-0.5, 0.5)) * H)])
    slope = np.array([data.draw(st.floats(-9, 9)), data.draw(st.floats(-9, 9)), 0.0])
    field = positions_of(solver) @ slope + 2.0
    found = interpolate(solver.domain, solver.method.metric, field, points)
    np.testing.assert_allclose(found, points @ slope + 2.0, atol=1e-9)


@pytest.mark.parametrize("kind", ["mesh", "cloud of a grid", "scattered cloud"])
def test_a_query_at_a_vertex_gives_its_distance(flat, kind):
    solver = flat[kind]
    np.testing.assert_allclose(
        solver.query(positions_of(solver), 140), solver.distance(140), atol=1e-9
    )


@pytest.mark.parametrize("kind", ["mesh", "cloud of a grid", "scattered cloud"])
def test_a_query_at_a_source_point_is_zero(flat, kind):
    solver = flat[kind]
    place = np.array([0.43, 0.52, 0.0])
    assert solver.query(place, place) == pytest.approx(0.0, abs=1e-9)


def test_next_to_a_source_distance_is_round():
    exact = np.linalg.norm(GRID.vertices - GRID.vertices[144], axis=1)
    solver = gt.GeodesicSolver(GRID)
    angle = np.linspace(0, 2 * np.pi, 50)
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    sources = locate_sources(GRID, 144)
    for radius in (0.2 * H, 0.9 * H, 1.5 * H):
        around = GRID.vertices[144] + radius * ring
        found = interpolate(GRID, solver.method.metric, exact, around, sources=sources)
        np.testing.assert_allclose(found, radius, rtol=1e-9)
    linear = interpolate(GRID, solver.method.metric, exact, GRID.vertices[144] + 0.9 * H * ring)
    assert np.abs(linear - 0.9 * H).max() > 0.05 * H


@pytest.mark.parametrize("domain", ["mesh", "cloud"])
def test_queries_on_a_sphere_are_as_accurate_as_vertices(sphere, domain):
    solver = sphere
    if domain == "cloud":
        solver = gt.GeodesicSolver(gt.PointCloud(sphere.domain.vertices))
    rng = np.random.default_rng(0)
    points = rng.normal(size=(3000, 3))
    points *= (1 + 0.05 * rng.uniform(-1, 1, (3000, 1))) / np.linalg.norm(
        points, axis=1, keepdims=True
    )
    directions = points / np.linalg.norm(points, axis=1, keepdims=True)
    source = sphere.domain.vertices[0]
    exact = np.arccos(np.clip(directions @ source, -1, 1))
    error = np.abs(solver.query(points, 0) - exact)
    at_vertices = np.arccos(np.clip(sphere.domain.vertices @ source, -1, 1))
    vertex_error = np.abs(solver.distance(0) - at_vertices)
    between = interpolate(solver.domain, solver.method.metric, at_vertices, points)
    assert error.mean() < vertex_error.mean() + np.abs(between - exact).mean()


@pytest.mark.parametrize("kind", ["mesh", "cloud of a grid"])
def test_past_the_reach_there_is_no_distance(flat, kind):
    solver = flat[kind]
    spacing = solver.method.metric.spacing
    heights = np.array([0, 1.9, -1.9, 2.1, 50, 1e12, 1e300]) * spacing
    points = np.column_stack([np.full((7, 2), 0.41), heights])
    np.testing.assert_array_equal(
        np.isfinite(solver.query(points, 0)), [True, True, True, False, False, False, False]
    )
    near = solver.query(points, 0, reach=0.5 * spacing)
    assert np.isfinite(near).tolist() == [True] + 6 * [False]
    everywhere = solver.query(points, 0, reach=np.inf)
    np.testing.assert_allclose(everywhere[:5], everywhere[0], rtol=1e-6)


def test_beside_the_surface_the_edge_counts(flat):
    for solver in flat.values():
        beside = solver.query([0.5, -1.5 * H, 0.0], 2)
        assert beside == pytest.approx(solver.query([0.5, 0.0, 0.0], 2), rel=0.05)


def test_where_no_source_connects_a_query_is_infinite():
    mesh = shapes.grid(5)
    two = shapes.disjoint_union(mesh, gt.TriangleMesh(mesh.vertices + np.eye(3)[0] * 5, mesh.faces))
    lonely = gt.TriangleMesh(np.vstack([two.vertices, [[9.0, 9, 9]]]), two.faces)
    solver = gt.GeodesicSolver(lonely)
    found = solver.query([[0.3, 0.3, 0], [5.3, 0.3, 0], [9, 9, 9]], 0)
    assert np.isfinite(found).tolist() == [True, False, False]


def test_a_corner_without_distance_spoils_only_what_it_counts_for():
    mesh = shapes.grid(2)
    metric = gt.CotanLaplacian().assemble(mesh)
    values = [0.0, 1.0, 1.0, np.inf]
    on_edge, inside = [0.5, 0.0, 0.0], [0.7, 0.7, 0.0]
    np.testing.assert_array_equal(
        np.isfinite(interpolate(mesh, metric, values, [on_edge, inside])), [True, False]
    )


def test_batches_give_what_single_points_give(flat, monkeypatch):
    rng = np.random.default_rng(1)
    for solver in flat.values():
        points = np.column_stack([rng.uniform(-0.1, 1.1, (40, 2)), rng.uniform(-0.2, 0.2, 40)])
        together = solver.query(points, [0, 200])
        alone = np.concatenate([solver.query(point, [0, 200]) for point in points])
        np.testing.assert_array_equal(together, alone)
        with monkeypatch.context() as patch:
            patch.setattr(queries, "POINTS_PER_BATCH", 7)
            np.testing.assert_array_equal(solver.query(points, [0, 200]), together)


def test_one_point_gives_one_number_and_none_gives_none(flat):
    solver = flat["mesh"]
    assert solver.query([0.5, 0.5, 0.0], 0).shape == (1,)
    assert solver.query([1, 0, 0], 0).shape == (1,)
    assert solver.query(np.zeros((0, 3)), 0).shape == (0,)


def test_missing_points_of_a_cloud_do_no_harm():
    points = scattered_plane().points.copy()
    missing = np.insert(points, [10, 100], np.nan, axis=0)
    normals = np.tile([0.0, 0, 1], (len(missing), 1))
    solver = gt.GeodesicSolver(gt.PointCloud(missing, normals))
    whole = gt.GeodesicSolver(gt.PointCloud(points, normals[2:]))
    places = np.random.default_rng(5).uniform(0.1, 0.9, (50, 3)) * [1, 1, 0]
    np.testing.assert_allclose(solver.query(places, 0), whole.query(places, 0), atol=1e-9)


def test_points_along_a_curve_are_joined_by_segments():
    line = np.column_stack([np.arange(12.0), np.zeros((12, 2))])
    solver = gt.GeodesicSolver(gt.PointCloud(line))
    field = line[:, 0] * 3
    found = interpolate(solver.domain, solver.method.metric, field, [[4.25, 0.1, 0], [7.5, 0, 0]])
    np.testing.assert_allclose(found, [12.75, 22.5], atol=1e-9)


def test_the_unit_does_not_matter():
    points = np.array([[0.31, 0.42, 0.0], [0.9, 0.1, 0.01], [0.5, 0.5, 0.3]])
    for unit in (1e-150, 1e-9, 1e9, 1e150):
        mesh = gt.TriangleMesh(GRID.vertices * unit, GRID.faces)
        metric = gt.CotanLaplacian().assemble(GRID)
        scaled = gt.Discretization(
            mass=metric.mass,
            stiffness=metric.stiffness,
            gradient=metric.gradient,
            spacing=metric.spacing * unit,
            boundary=metric.boundary,
        )
        found = interpolate(mesh, scaled, GRID.vertices[:, 0], points * unit)
        np.testing.assert_allclose(found, [0.31, 0.9, np.inf], rtol=1e-9)


def test_a_mesh_of_degenerate_faces_has_no_surface_to_query():
    mesh = gt.TriangleMesh(np.eye(3), [[0, 0, 1], [2, 2, 2]])
    metric = gt.CotanLaplacian().assemble(shapes.grid(2))
    assert interpolate(mesh, metric, np.zeros(3), [1.0, 0, 0]) == np.inf


def test_a_flat_triangle_is_interpolated_along_its_longest_edge():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [4, 0, 0]])
    for faces in ([[0, 1, 2]], [[2, 0, 1]], [[1, 0, 2]], [[2, 0, 0]]):
        face, barycentric = TriangleTree(vertices, np.array(faces)).closest(np.array([[3.0, 1, 0]]))
        assert face[0] == 0
        np.testing.assert_allclose(barycentric[0] @ vertices[faces[0]], [3, 0, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([[0, 0, 0], [0, np.nan, 0]], "point 1 of the points is not finite"),
        ([[np.inf, 0, 0]], "point 0 of the points is not finite"),
        ([0.0, 0.0], r"must have shape \(Q, 3\) or \(3,\), not \(2,\)"),
        (np.zeros((2, 2, 3)), r"not \(2, 2, 3\)"),
        (0.5, r"not \(\)"),
        ([], r"not \(0,\)"),
        ([["a", "b", "c"]], "real numbers"),
        ([[0, 0, 0], [1]], "cannot be read as an array"),
        (None, "real numbers"),
    ],
)
def test_points_that_are_none_are_refused_by_name(flat, points, message):
    with pytest.raises(InvalidOptionError, match=message):
        flat["mesh"].query(points, 0)


@pytest.mark.parametrize("reach", [0, -1.0, np.nan, "far", True])
def test_a_reach_that_is_not_a_length_is_refused(flat, reach):
    with pytest.raises(InvalidOptionError, match="reach must be a positive length"):
        flat["mesh"].query([0.5, 0.5, 0], 0, reach=reach)


def test_distances_of_another_shape_are_refused(flat):
    solver = flat["mesh"]
    with pytest.raises(InvalidOptionError, match=r"distance must have shape \(289,\)"):
        interpolate(solver.domain, solver.method.metric, np.zeros(7), [0.5, 0.5, 0])


def test_bad_sources_of_a_query_are_refused(flat):
    with pytest.raises(InvalidSourceError, match="vertex 900 does not exist"):
        flat["mesh"].query([0.5, 0.5, 0], 900)


def test_a_graph_has_no_place_for_a_query():
    solver = gt.GeodesicSolver(gt.Graph(3, [[0, 1], [1, 2]]))
    with pytest.raises(UnsupportedDomainError, match="a Graph has no positions"):
        solver.query([0.0, 0.0, 0.0], 0)


def test_a_cloud_discretized_by_edges_has_no_triangles(flat):
    edges = gt.UniformLaplacian(dim=2).assemble(gt.Graph(400, [[0, 1]]))
    with pytest.raises(UnsupportedDomainError, match="has no triangles to interpolate in"):
        interpolate(flat["scattered cloud"].domain, edges, np.zeros(400), [0.5, 0.5, 0])


# -- many points, many sources ---------------------------------------------------------------------


def test_progress_counts_points_and_ends_with_all_of_them(flat, monkeypatch):
    monkeypatch.setattr(queries, "POINTS_PER_BATCH", 7)
    points = np.random.default_rng(2).uniform(-2, 2, (40, 3))  # most of them out of reach
    for solver in flat.values():
        seen = []
        solver.query(points, 0, progress=lambda *counts, seen=seen: seen.append(counts))
        assert seen == [(done, 40) for done in (7, 14, 21, 28, 35, 40)]


def test_points_of_any_real_kind_are_not_copied_whole(flat, tmp_path):
    points = np.random.default_rng(2).uniform(0, 1, (500, 3)) * [1, 1, 0]
    np.save(tmp_path / "points.npy", points.astype(np.float32))
    on_disk = np.load(tmp_path / "points.npy", mmap_mode="r")
    assert np.shares_memory(queries.as_points(on_disk), on_disk)
    for solver in flat.values():
        np.testing.assert_allclose(solver.query(on_disk, 0), solver.query(points, 0), atol=1e-6)


def test_the_tree_is_built_once_for_all_threads(monkeypatch):
    built = []

    class Counted(queries.Surface):
        def __init__(self, *arguments, **named):
            built.append(1)
            super().__init__(*arguments, **named)

    monkeypatch.setattr(queries, "Surface", Counted)
    solver = gt.GeodesicSolver(scattered_plane())
    points = np.random.default_rng(3).uniform(0.1, 0.9, (3000, 3)) * [1, 1, 0]
    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda _: solver.query(points, 5), range(8)))
    assert built == [1]
    for answer in answers:
        np.testing.assert_array_equal(answer, answers[0])


def test_points_as_sources_are_snapped_with_one_tree(monkeypatch):
    built = []

    class Counted(ground.TriangleTree):
        def __init__(self, *arguments):
            built.append(1)
            super().__init__(*arguments)

    monkeypatch.setattr(ground, "TriangleTree", Counted)
    monkeypatch.setattr(queries, "TriangleTree", Counted)
    solver = gt.GeodesicSolver(GRID)
    places = np.random.default_rng(4).uniform(0, 1, (9, 3)) * [1, 1, 0]
    solver.distances(places)
    solver.query(places, places[0])
    assert built == [1]


def test_a_solver_that_was_asked_pickles_and_answers_alike(flat):
    points = np.random.default_rng(5).uniform(0.1, 0.9, (50, 3)) * [1, 1, 0]
    for solver in flat.values():
        asked = solver.query(points, [0.2, 0.3, 0.0])
        again = pickle.loads(pickle.dumps(solver))
        np.testing.assert_array_equal(again.query(points, [0.2, 0.3, 0.0]), asked)
        np.testing.assert_array_equal(copy.copy(solver).query(points, [0.2, 0.3, 0.0]), asked)


def test_a_solver_interpolates_given_distances(flat):
    points = np.random.default_rng(6).uniform(0.1, 0.9, (50, 3)) * [1, 1, 0]
    for solver in flat.values():
        found = solver.interpolate(solver.distance(7), points, sources=7)
        np.testing.assert_array_equal(found, solver.query(points, 7))
        height = positions_of(solver)[:, 1]
        np.testing.assert_allclose(solver.interpolate(height, points), points[:, 1], atol=1e-9)


def test_between_many_vertices_as_sources_each_corner_has_its_own():
    solver = gt.GeodesicSolver(GRID)
    row = np.flatnonzero(GRID.vertices[:, 1] == 0)
    points = np.column_stack([np.linspace(0.3, 0.7, 40), np.full(40, 1.3 * H), np.zeros(40)])
    exact = np.hypot(points[:, 0] - np.round(points[:, 0] / H) * H, points[:, 1])
    np.testing.assert_allclose(solver.query(points, row), exact, atol=0.02 * H)


def test_next_to_a_curve_nothing_is_taken_for_round():
    solver = gt.GeodesicSolver(GRID)
    points = np.column_stack([np.linspace(0.3, 0.7, 9), np.linspace(0.001, 0.1, 9), np.zeros(9)])
    edge = gt.Curve([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    np.testing.assert_allclose(solver.query(points, edge), points[:, 1], atol=1e-3)


@pytest.mark.parametrize("kind", ["mesh", "cloud of a grid", "scattered cloud"])
@pytest.mark.parametrize("batch", [7, 100_000])
def test_the_nearest_source_is_that_of_the_least_query(flat, kind, batch, monkeypatch):
    monkeypatch.setattr(queries, "POINTS_PER_BATCH", batch)
    monkeypatch.setattr(solver_module, "MOST_ROWS", 4)
    solver, rng = flat[kind], np.random.default_rng(7)
    points = rng.uniform(-0.2, 1.2, (300, 3)) * [1, 1, 0.1]
    sources = rng.choice(200, 11, replace=False)
    rows = np.array([solver.query(points, source) for source in sources.tolist()])
    seen = []
    labels, distances = solver.nearest_source(
        points, sources, progress=lambda *counts: seen.append(counts)
    )
    reached = np.isfinite(rows.min(axis=0))
    assert 0 < reached.sum() < 300
    np.testing.assert_array_equal(distances, rows.min(axis=0))
    np.testing.assert_array_equal(labels, np.where(reached, rows.argmin(axis=0), -1))
    assert seen[-4:] == [(0, 11), (4, 11), (8, 11), (11, 11)]


def test_sources_closer_than_the_vertices_are_distinguished():
    solver = gt.GeodesicSolver(GRID)
    middle = GRID.vertices[GRID.faces[100]].mean(axis=0)
    sources = middle + 0.1 * H * np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0]])
    labels, distances = solver.nearest_source(sources + 1e-4 * H * np.eye(3)[0], sources)
    np.testing.assert_array_equal(labels, [0, 1, 2])
    np.testing.assert_allclose(distances, 1e-4 * H, rtol=1e-3)


def test_the_nearest_source_of_a_vertex_is_that_of_its_voronoi_cell(flat):
    for solver in flat.values():
        labels, distances = gt.geodesic_voronoi(solver, [3, 90, 150], return_distances=True)
        there, far = solver.nearest_source(positions_of(solver), [3, 90, 150])
        np.testing.assert_allclose(far, distances, atol=1e-9)
        assert (there == labels).mean() > 0.97  # all but those that are equally far


def test_sources_are_sets_and_curves_and_points(flat):
    left = gt.Curve([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    right = np.flatnonzero(GRID.vertices[:, 0] == 1)
    labels, distances = flat["mesh"].nearest_source([[0.2, 0.5, 0], [0.9, 0.4, 0]], [left, right])
    np.testing.assert_array_equal(labels, [0, 1])
    np.testing.assert_allclose(distances, [0.2, np.hypot(0.1, 0.025)], atol=0.002)


def test_where_no_source_connects_there_is_no_nearest():
    mesh = shapes.grid(5)
    two = shapes.disjoint_union(mesh, gt.TriangleMesh(mesh.vertices + np.eye(3)[0] * 5, mesh.faces))
    labels, distances = gt.GeodesicSolver(two).nearest_source(
        [[0.3, 0.3, 0], [5.3, 0.3, 0]], [9, 3]
    )
    np.testing.assert_array_equal(labels >= 0, [True, False])
    np.testing.assert_array_equal(np.isfinite(distances), [True, False])


@pytest.mark.parametrize("ask", ["query", "nearest_source", "interpolate"])
def test_what_is_wrong_with_points_is_said_before_the_work(flat, ask, monkeypatch):
    monkeypatch.setattr(gt.HeatMethod, "distances", lambda *_: pytest.fail("worked"))
    monkeypatch.setattr(gt.HeatMethod, "distance", lambda *_: pytest.fail("worked"))

    def asked(points, **options):
        if ask == "interpolate":
            return flat["mesh"].interpolate(np.zeros(289), points, **options)
        return getattr(flat["mesh"], ask)(points, [0], **options)

    with pytest.raises(InvalidOptionError, match="point 1 of the points is not finite"):
        asked([[0, 0, 0], [0, np.nan, 0]])
    with pytest.raises(InvalidOptionError, match="reach must be a positive length"):
        asked([0, 0, 0], reach=-1)


def test_bad_sources_are_refused_with_their_number(flat):
    with pytest.raises(InvalidSourceError, match="source set 1: vertex 900 does not exist"):
        flat["mesh"].nearest_source([0.5, 0.5, 0], [0, 900])
    with pytest.raises(UnsupportedDomainError, match="a Graph has no positions"):
        gt.GeodesicSolver(gt.Graph(3, [[0, 1], [1, 2]])).nearest_source([0.0, 0, 0], [0])


def test_points_are_read_from_tables_and_shapes(tmp_path):
    table = np.array([[0.0, 1, 2], [3, 4, 5]])
    np.save(tmp_path / "a.npy", table)
    np.save(tmp_path / "one.npy", table[1])
    (tmp_path / "a.csv").write_text("0,1,2\n3,4,5\n")
    (tmp_path / "named.csv").write_text('"Z",label,X,Y\n2,7,0,1\n5,7,3,4\n')
    (tmp_path / "a.xyz").write_text("0 1 2\n3 4 5\n")
    (tmp_path / "mesh.off").write_text("OFF 3 1 0   0 0 0  1 0 0  0 1 0   3 0 1 2")
    for name in ("a.npy", "a.csv", "named.csv", "a.xyz"):
        np.testing.assert_array_equal(read_points(tmp_path / name).points, table, err_msg=name)
    assert read_points(tmp_path / "one.npy").n_vertices == 1
    assert read_points(tmp_path / "mesh.off").n_vertices == 3


def test_what_was_written_can_be_asked_for_again(tmp_path):
    write(tmp_path / "d.csv", GRID, np.zeros(GRID.n_vertices))
    np.testing.assert_array_equal(read_points(tmp_path / "d.csv").points, GRID.vertices)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("none.npy", None, "does not exist"),
        ("a.npy", b"no array", "a.npy: "),
        ("a.npy", b"\x93NUMPY", "a.npy: "),
        ("a.csv", b"\n\n", "no numbers in the file"),
        ("a.csv", b"x,y,z\n", "no numbers in the file, only 'x,y,z'"),
        ("a.csv", b"0,0,0\n1,1\n", "number of columns changed from 3 to 2"),
        ("a.csv", b"a,b,c,d\n0,0,0,0\n", "columns are named a, b, c, d: which are x, y and z"),
        ("a.csv", b"nan,0,0\n", "the point cloud has no finite points"),
        ("a.edges", b"0 1\n", "a Graph has no positions"),
    ],
)
def test_a_file_without_points_is_refused_by_name(tmp_path, name, content, message):
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ReadError, match=message):
        read_points(path)


def test_an_array_of_another_shape_is_not_a_list_of_points(tmp_path):
    for number, table in enumerate([np.zeros((4, 2)), np.zeros((2, 2, 3)), np.array(["a"])]):
        np.save(tmp_path / f"{number}.npy", table)
        with pytest.raises(ReadError, match=f"{number}.npy: points must"):
            read_points(tmp_path / f"{number}.npy")
    np.savez(tmp_path / "archive", np.zeros((2, 3)))
    (tmp_path / "archive.npz").rename(tmp_path / "archive.npy")
    with pytest.raises(ReadError, match="an archive"):
        read_points(tmp_path / "archive.npy")


# -- masks -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [11, 21])
def test_a_point_in_a_face_that_a_mask_cuts_is_reached_from_the_other_corners(n):
    square = shapes.grid(n)
    h = 1 / (n - 1)
    x, y, _ = square.vertices.T
    wall = (abs(x - 0.5) < h / 2) & (y < 0.75)
    solver = gt.GeodesicSolver(square, mask=wall)
    assert solver.query([0.5, 0.5, 0.0], 0)[0] == pytest.approx(np.sqrt(0.5), rel=1e-6)
    places = np.random.default_rng(0).uniform([0.5 - h, 0, 0], [0.5, 0.5, 0], (500, 3))
    straight = np.linalg.norm(places, axis=1)
    found = solver.query(places, 0)
    assert (found >= straight - 1e-9).all()
    assert (found - straight < 2 * h).all()  # at worst round the one corner that is free
    behind = places + np.array([h, 0, 0])
    around = np.hypot(0.5, 0.75) + 0.25
    assert (solver.query(behind, 0) > around - behind[:, 1].max() + 0.25).all()


def test_points_between_masked_vertices_have_no_distance_as_these_have_none():
    mask = GRID.vertices[:, 0] > 0.6
    solver = gt.GeodesicSolver(GRID, mask=mask)
    np.testing.assert_array_equal(solver.query([[0.9, 0.5, 0], [1.0, 1.0, 0]], 0), np.inf)
    np.testing.assert_array_equal(solver.query(GRID.vertices[~mask], 0), solver.distance(0)[~mask])
