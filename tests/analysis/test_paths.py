"""Shortest paths: their length, what they run through, where they end."""

import gc
import pickle
import weakref

import numpy as np
import pytest
from closed_forms import on_plane, on_sphere, on_tube
from hypothesis import given, settings
from hypothesis import strategies as st

import geodesic_toolkit as gt
from geodesic_toolkit.analysis.paths.prepared import PreparedMesh
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    UnreachableError,
)
from geodesic_toolkit.testing import shapes

TOLERANCE = 0.005


def lies_in_faces(path):
    """Check that each piece of a path runs through one face."""
    mesh = path.mesh
    for here, there in zip(path.surface_points, path.surface_points[1:], strict=False):
        sets = []
        for point in (here, there):
            weights = np.array(point.barycentric)
            used = mesh.faces[point.face][weights > 1e-9]
            around = np.isin(mesh.faces, used).sum(axis=1) == len(used)
            sets.append(set(np.flatnonzero(around)))
        assert sets[0] & sets[1]
    return True


def test_a_path_on_a_plane_is_straight():
    mesh = shapes.grid(12)
    solver = gt.GeodesicSolver(mesh)
    for target in (5, 77, 143):
        path = gt.geodesic_path(solver, 40, target)
        assert path.length == pytest.approx(on_plane(mesh, 40)[target], rel=1e-12)
        np.testing.assert_allclose(path.points[0], mesh.vertices[40], atol=1e-12)
        np.testing.assert_allclose(path.points[-1], mesh.vertices[target], atol=1e-12)
        assert lies_in_faces(path)


PLANE = gt.GeodesicSolver(shapes.grid(6))


@settings(max_examples=50)
@given(st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4))
def test_a_path_between_any_points_of_a_plane_is_straight(places):
    x0, y0, x1, y1 = places
    solver = PLANE
    path = gt.geodesic_path(solver, [x0, y0, 0.0], [x1, y1, 0.0])
    assert path.length == pytest.approx(np.hypot(x1 - x0, y1 - y0), abs=1e-7)


@pytest.mark.parametrize("target", [7, 33, 300, 641])
def test_a_path_on_a_sphere_is_as_long_as_the_arc(target):
    mesh = shapes.icosphere(3)
    solver = gt.GeodesicSolver(mesh)
    length = gt.geodesic_path(solver, 100, target).length
    assert length == pytest.approx(on_sphere(mesh, 100)[target], rel=TOLERANCE)
    assert length >= gt.exact_distance(mesh, 100)[target] * (1 - 1e-9)


def test_a_path_around_a_tube_takes_the_shorter_side():
    mesh = shapes.tube(10, 12)
    solver = gt.GeodesicSolver(mesh)
    expected = on_tube(10, 12)
    exact = gt.exact_distance(mesh, 0)
    for target in (4, 60, 87, 119):
        path = gt.geodesic_path(solver, 0, target)
        assert path.length == pytest.approx(expected[target], rel=0.02)
        assert path.length == pytest.approx(exact[target], rel=TOLERANCE)


def test_a_path_bends_around_an_inner_corner():
    mesh = shapes.grid(9, spacing=1.0)
    centres = mesh.vertices[mesh.faces].mean(axis=1)
    notch = (centres[:, :2] > 4).all(axis=1)
    notched = gt.TriangleMesh(mesh.vertices, mesh.faces[~notch])
    path = gt.geodesic_path(gt.GeodesicSolver(notched), 8, 8 * 9 + 2)
    assert path.length == pytest.approx(np.hypot(4, 4) + np.hypot(2, 4), rel=1e-12)
    assert lies_in_faces(path)


def test_a_path_has_the_length_of_the_exact_distance_on_a_torus():
    mesh = shapes.torus(30, 12)
    solver = gt.GeodesicSolver(mesh, refine=True)
    exact = gt.exact_distance(mesh, 17)
    for target in np.random.default_rng(0).integers(mesh.n_vertices, size=20):
        length = gt.geodesic_path(solver, 17, int(target)).length
        assert exact[target] * (1 - 1e-9) <= length <= exact[target] * (1 + TOLERANCE)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["igltut__bunny.off", "jacobson__spot.obj", "igltut__3holes.off"])
def test_paths_on_real_meshes_have_the_length_of_the_exact_distance(shared_data, name):
    mesh = gt.read(shared_data(name))
    solver = gt.GeodesicSolver(mesh, refine=True)
    rng = np.random.default_rng(3)
    for source in rng.integers(mesh.n_vertices, size=4):
        exact = gt.exact_distance(mesh, int(source))
        for target in rng.integers(mesh.n_vertices, size=5):
            length = gt.geodesic_path(solver, int(source), int(target)).length
            assert exact[target] * (1 - 1e-9) <= length <= exact[target] * (1 + TOLERANCE)


@pytest.mark.parametrize(("source", "target"), [(173, 78), (223, 40), (15, 130), (278, 78)])
def test_a_path_passes_spikes_on_the_shorter_side(shared_data, source, target):
    # Straight down the refined distance alone, these are 1 to 3 % too long.
    mesh = gt.read(shared_data("geomcentral__fox.ply"))
    length = gt.geodesic_path(gt.GeodesicSolver(mesh, refine=True), source, target).length
    exact = gt.exact_distance(mesh, source)[target]
    assert exact * (1 - 1e-9) <= length <= exact * (1 + TOLERANCE)


def test_paths_over_a_crumpled_sheet_are_a_few_per_cent_too_long_at_most():
    grid = shapes.grid(25)
    height = 0.05 * np.random.default_rng(0).normal(size=grid.n_vertices)
    mesh = gt.TriangleMesh(np.column_stack([grid.vertices[:, :2], height]), grid.faces)
    solver, exact = gt.GeodesicSolver(mesh, refine=True), gt.exact_distance(mesh, 0)
    targets = np.random.default_rng(1).integers(1, mesh.n_vertices, size=12)
    lengths = np.array([gt.geodesic_path(solver, 0, int(target)).length for target in targets])
    excess = lengths / exact[targets] - 1
    assert excess.min() > -1e-9
    assert excess.max() < 0.03
    assert excess.mean() < 0.01


def test_the_path_leads_from_the_nearest_source():
    mesh = shapes.grid(9)
    path = gt.geodesic_path(gt.GeodesicSolver(mesh), [0, 80], 79)
    assert path.length == pytest.approx(0.125)
    np.testing.assert_allclose(path.points[0], mesh.vertices[80])


def test_a_path_does_not_depend_on_those_found_before():
    mesh = gt.testing.shapes.torus(32, 16)
    solver, pairs = gt.GeodesicSolver(mesh), [(0, 300), (300, 0), (7, 300), (0, 41), (0, 300)]
    for source, target in [*pairs, *[(k, 200) for k in range(6)], *pairs]:
        path = gt.geodesic_path(solver, source, target)
        alone = gt.geodesic_path(gt.GeodesicSolver(mesh), source, target)
        assert path.surface_points == alone.surface_points


def test_paths_in_one_part_of_a_mesh_after_another_stay_in_theirs():
    ball = gt.testing.shapes.icosphere(2)
    count = ball.n_vertices
    two = gt.TriangleMesh(
        np.concatenate([ball.vertices, ball.vertices + 3.0]),
        np.concatenate([ball.faces, ball.faces + count]),
    )
    solver = gt.GeodesicSolver(two)
    lengths = [gt.geodesic_path(solver, 2 + k, 90 + k).length for k in (0, count, 0)]
    np.testing.assert_allclose(lengths, lengths[0], rtol=1e-12)


def hills(n):
    """Return a square of n by n vertices with nine hills."""
    flat = shapes.grid(n)
    x, y = flat.vertices.T[:2]
    heights = 0.15 * np.sin(3 * np.pi * x) * np.sin(3 * np.pi * y)
    return gt.TriangleMesh(np.column_stack([x, y, heights]), flat.faces)


@pytest.mark.parametrize("mesh", [shapes.icosphere(4), shapes.torus(40, 20), hills(32)])
def test_the_way_back_is_swept_where_paths_run_and_gives_paths_as_short(mesh, monkeypatch):
    solver = gt.GeodesicSolver(mesh)
    pairs = np.random.default_rng(5).choice(mesh.n_vertices, (25, 2)).tolist()
    found = [gt.geodesic_path(solver, *pair) for pair in pairs]
    monkeypatch.setattr(PreparedMesh, "near_path", lambda self, goal, _: self.distance(goal))
    for pair, path in zip(pairs, found, strict=True):
        assert path.length <= gt.geodesic_path(solver, *pair).length * (1 + 1e-12)


def test_a_path_made_of_its_points_is_the_same_path():
    solver = gt.GeodesicSolver(shapes.grid(9))
    path = gt.geodesic_path(solver, 0, 71)
    for again in (
        gt.GeodesicPath(path.mesh, path.surface_points),
        pickle.loads(pickle.dumps(path)),
    ):
        assert again.surface_points == path.surface_points
        np.testing.assert_array_equal(again.points, path.points)
        assert not again.closed
        assert not again.faces.flags.writeable
        assert not again.barycentric.flags.writeable


def test_a_solver_is_released_with_what_its_paths_keep():
    solver = gt.GeodesicSolver(gt.testing.shapes.grid(5))
    gt.geodesic_path(solver, 0, 23)
    released = weakref.ref(solver)
    del solver
    gc.collect()
    assert released() is None


def test_a_path_serves_as_a_source():
    mesh = shapes.grid(11)
    solver = gt.GeodesicSolver(mesh, refine=True)
    path = gt.geodesic_path(solver, 0, 120)  # the diagonal
    expected = np.abs(mesh.vertices[:, 0] - mesh.vertices[:, 1]) / np.sqrt(2)
    np.testing.assert_allclose(solver.distance(gt.Curve(path.surface_points)), expected, atol=0.03)
    points = solver.distance(path.surface_points)  # between its points a polyline is forgotten
    np.testing.assert_allclose(points, expected, atol=0.05)


def test_a_path_of_no_length_is_a_point():
    path = gt.geodesic_path(gt.GeodesicSolver(shapes.grid(4)), 5, 5)
    assert len(path.surface_points) == 1
    assert path.length == 0
    assert repr(path) == "GeodesicPath(1 points, length 0)"


def test_paths_need_no_triangles_of_the_operator():
    mesh = shapes.grid(9)
    path = gt.geodesic_path(gt.GeodesicSolver(mesh, operator="uniform"), 0, 80)
    assert path.length == pytest.approx(np.sqrt(2))


def test_a_path_crosses_where_sheets_touch_in_a_vertex():
    one = shapes.grid(3, spacing=1.0)
    other = one.vertices + np.array([2.0, 2.0, 0.0])
    joined = np.where(np.arange(9) == 0, 8, np.arange(9) + 9)
    vertices = np.vstack([one.vertices, other])
    mesh = gt.TriangleMesh(vertices, np.vstack([one.faces, joined[one.faces]]))
    path = gt.geodesic_path(gt.GeodesicSolver(mesh), 0, 17)
    assert path.length == pytest.approx(4 * np.sqrt(2))


def test_a_point_in_a_mask_moves_to_where_paths_may_go():
    mesh = shapes.grid(11)
    solver = gt.GeodesicSolver(mesh, mask=(np.arange(121) % 11 == 5) & (np.arange(121) < 80))
    path = gt.geodesic_path(solver, 0, mesh.vertices[5 + 11 * 3] + [0.01, 0, 0])
    np.testing.assert_allclose(path.points[-1], mesh.vertices[6 + 11 * 3], atol=1e-9)


@pytest.mark.parametrize("refine", [False, True])
@pytest.mark.parametrize("kind", ["mesh", "cloud"])
@pytest.mark.parametrize(("late", "first"), [(0.0, 440), (0.25, 440), (0.35, 0), (5.0, 0)])
def test_the_path_leads_from_the_source_whose_offset_and_way_are_least(kind, refine, late, first):
    mesh = shapes.grid(21)
    cloud = gt.PointCloud(mesh.vertices, np.tile([0.0, 0.0, 1.0], (441, 1)))
    solver = gt.GeodesicSolver(mesh if kind == "mesh" else cloud, refine=refine)
    target = 12 + 21 * 12  # at 0.6, 0.6: 0.85 from the one corner, 0.57 from the other
    path = gt.geodesic_path(solver, gt.OffsetSources([0, 440], [0.0, late]), target)
    np.testing.assert_allclose(path.points[0], mesh.vertices[first], atol=1e-12)
    way = np.linalg.norm(mesh.vertices[target] - mesh.vertices[first])
    assert path.length == pytest.approx(way, rel=1e-6)


def test_a_source_that_starts_too_late_is_a_target_like_any_other():
    solver = gt.GeodesicSolver(shapes.grid(9))
    point = gt.SurfacePoint(127, (0.2, 0.3, 0.5))
    for place, places in (
        (80, [0, 80]),
        (point, [gt.SurfacePoint(0, (1.0, 0.0, 0.0)), point]),
    ):
        overtaken = gt.geodesic_path(solver, gt.OffsetSources(places, [0.0, 9.0]), place)
        np.testing.assert_allclose(overtaken.points[0], [0, 0, 0], atol=1e-12)
        assert overtaken.length > 1
        first = gt.geodesic_path(solver, gt.OffsetSources(places, [0.0, 0.5]), place)
        assert first.length == 0


def test_a_path_may_start_on_a_curve():
    mesh = shapes.grid(9)
    side = gt.Curve(mesh.vertices[[0, 72]])
    path = gt.geodesic_path(gt.GeodesicSolver(mesh), side, 8 + 9 * 3)
    assert path.length == pytest.approx(1.0, rel=0.001)  # from the nearest of its samples
    np.testing.assert_allclose(path.points[0, 0], 0.0, atol=1e-9)


def test_an_unreachable_target_is_refused():
    mesh = shapes.disjoint_union(shapes.grid(4), shapes.grid(3))
    with pytest.raises(UnreachableError, match="no face connects the target 20"):
        gt.geodesic_path(gt.GeodesicSolver(mesh), 0, 20)
    lonely = gt.TriangleMesh(np.vstack([mesh.vertices, [[9.0, 9, 9]]]), mesh.faces)
    with pytest.raises(UnreachableError):
        gt.geodesic_path(gt.GeodesicSolver(lonely), 25, 25)


def test_paths_refuse_what_they_cannot_follow():
    solver = gt.GeodesicSolver(shapes.grid(4))
    with pytest.raises(InvalidSourceError, match="ends at one point, not at 2"):
        gt.geodesic_path(solver, 0, [1, 2])
    with pytest.raises(InvalidSourceError, match="target: vertex 16"):
        gt.geodesic_path(solver, 0, 16)
    with pytest.raises(InvalidSourceError, match="offsets are for sources"):
        gt.geodesic_path(solver, 2, gt.OffsetSources([0], [1.0]))
    masked = gt.GeodesicSolver(shapes.grid(9), mask=np.arange(81) == 40)
    with pytest.raises(InvalidSourceError, match="source: vertex 40 is masked"):
        gt.geodesic_path(masked, 40, 0)
    with pytest.raises(UnreachableError, match="behind masked vertices"):
        gt.geodesic_path(masked, 0, 40)
    with pytest.raises(InvalidOptionError, match="a path needs a GeodesicSolver, not a Triangle"):
        gt.geodesic_path(shapes.grid(4), 0, 1)


@pytest.mark.parametrize("operator", ["cotan", "uniform"])
def test_a_path_leads_around_masked_vertices(operator):
    mesh = shapes.grid(11, spacing=1.0)
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    wall = (x == 5) & (y < 8)
    solver = gt.GeodesicSolver(mesh, operator=operator, mask=wall)
    path = gt.geodesic_path(solver, 0, 10)
    corner = np.hypot(4, 8)  # faces that touch the wall do not conduct: from x = 4 to x = 6
    assert path.length == pytest.approx(2 * corner + 2, rel=1e-9)
    closed = gt.GeodesicSolver(mesh, operator=operator, mask=x == 5)
    with pytest.raises(UnreachableError, match="behind masked vertices"):
        gt.geodesic_path(closed, 0, 10)
