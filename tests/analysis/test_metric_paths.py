"""Shortest paths under costs, metric tensors and edge lengths: closed forms and laws."""

import pickle
from itertools import pairwise

import numpy as np
import pytest
from closed_forms import by_snell
from hypothesis import given, settings
from hypothesis import strategies as st

import geodesic_toolkit as gt
from geodesic_toolkit.analysis.paths.edges import path_along_edges
from geodesic_toolkit.errors import (
    InvalidSourceError,
    UnreachableError,
    UnsupportedDomainError,
)
from geodesic_toolkit.testing import shapes

pytestmark = pytest.mark.filterwarnings("ignore::geodesic_toolkit.errors.CoarseMeshWarning")

ROUNDING = 1e-10
"""Relative error of lengths that are exact: a strip is left when a turn shortens it by less than
1e-12."""

SQUARE = shapes.grid(21)


def nearest(mesh, *place):
    return int(np.linalg.norm(mesh.vertices[:, : len(place)] - place, axis=1).argmin())


def middles(mesh):
    return mesh.vertices[mesh.faces].mean(axis=1)


def solver_of(mesh, **metric):
    return gt.GeodesicSolver(gt.MetricMesh(mesh, **metric))


def along_edges(solver, source, target):
    places = (solver.locate(source, "source"), solver.locate(target, "target"))
    return path_along_edges(solver, *places).length


def pairs_of(mesh, count, seed=0):
    rng = np.random.default_rng(seed)
    return [tuple(map(int, rng.choice(mesh.n_vertices, 2, replace=False))) for _ in range(count)]


def is_sound(path):
    """Check that each segment of a path is in a face that has its length."""
    steps = path.segment_lengths
    assert steps.sum() == pytest.approx(path.length, rel=1e-12)
    assert (steps > 0).all() or len(path.faces) == 1
    np.testing.assert_allclose(path.barycentric.sum(axis=1), 1.0, rtol=1e-12)
    return True


@pytest.mark.parametrize(
    "mesh",
    [
        SQUARE,
        shapes.torus(30, 16),
        shapes.icosphere(2),
    ],
    ids=["plane", "torus", "sphere"],
)
def test_with_a_constant_cost_paths_are_those_without(mesh):
    plain, costly = gt.GeodesicSolver(mesh), solver_of(mesh, cost=2.5)
    for source, target in pairs_of(mesh, 8):
        path, same = (gt.geodesic_path(solver, source, target) for solver in (costly, plain))
        assert is_sound(path)
        assert path.length == pytest.approx(2.5 * same.length, rel=2e-4)  # two paths of one length
        assert path.length_in_space == pytest.approx(path.length / 2.5, rel=1e-12)


def test_a_constant_cost_leaves_straight_lines_between_points_in_faces_and_on_edges():
    solver = solver_of(SQUARE, cost=np.full(SQUARE.n_vertices, 3.0), on="vertices")
    for start, end in (
        [[0.13, 0.22, 0.0], [0.83, 0.47, 0.0]],
        [[0.125, 0.2, 0.0], [0.9, 0.9, 0.0]],
        [[0.2, 0.2, 0.0], [0.21, 0.22, 0.0]],
    ):
        path = gt.geodesic_path(solver, start, end)
        np.testing.assert_allclose(path.points[[0, -1]], [start, end], atol=1e-12)
        assert path.length == pytest.approx(3 * np.linalg.norm(np.subtract(end, start)), rel=1e-12)


TENSOR = np.array([[4.0, 1.5, 0.0], [1.5, 1.0, 0.0], [0.0, 0.0, 7.0]])


def test_a_constant_tensor_leaves_straight_lines():
    solver = solver_of(SQUARE, tensor=np.tile(TENSOR, (SQUARE.n_faces, 1, 1)))
    for source, target in pairs_of(SQUARE, 6):
        path = gt.geodesic_path(solver, source, target)
        ends = SQUARE.vertices[[source, target]]
        step = ends[1] - ends[0]
        assert path.length == pytest.approx(np.sqrt(step @ TENSOR @ step), rel=ROUNDING)
        off = np.cross(path.points - ends[0], step / np.linalg.norm(step))
        assert np.abs(off).max() < 1e-6


@pytest.mark.parametrize("costs", [(1.0, 2.0), (2.0, 1.0), (5.0, 1.0), (1.0, 100.0)], ids=str)
def test_paths_across_a_jump_of_the_cost_have_the_length_of_snells_law(costs):
    cost = np.where(middles(SQUARE)[:, 0] < 0.5, *costs)
    solver = solver_of(SQUARE, cost=cost)
    source = nearest(SQUARE, 0.2, 0.3)
    exact = by_snell(SQUARE, source, *costs)
    for target in range(3, SQUARE.n_vertices, 97):
        path = gt.geodesic_path(solver, source, target)
        assert is_sound(path)
        assert path.length == pytest.approx(exact[target], rel=ROUNDING)
        assert path.length <= along_edges(solver, source, target) * (1 + ROUNDING)


def test_a_path_is_refracted_by_the_ratio_of_the_costs():
    solver = solver_of(SQUARE, cost=np.where(middles(SQUARE)[:, 0] < 0.5, 1.0, 2.0))
    points = gt.geodesic_path(solver, [0.11, 0.13, 0.0], [0.87, 0.91, 0.0]).points
    crossing = int(np.abs(points[:, 0] - 0.5).argmin())
    assert points[crossing, 0] == pytest.approx(0.5, abs=1e-12)
    into, out = points[crossing] - points[0], points[-1] - points[crossing]
    sines = [step[1] / np.linalg.norm(step) for step in (into, out)]
    assert sines[0] == pytest.approx(2 * sines[1], rel=1e-5)  # where the length is stationary


def test_a_path_leads_to_a_cheap_edge_along_it_and_back():
    corners = [[0.0, 0, 0], [1, 0, 0], [0.5, 1, 0], [0.5, -1, 0]]
    two = gt.TriangleMesh(corners, [[0, 1, 2], [1, 0, 3]])
    path = gt.geodesic_path(solver_of(two, cost=[5.0, 1.0]), [0.3, 0.1, 0.0], [0.7, 0.1, 0.0])
    critical = np.arcsin(1 / 5)
    exact = 5 * 0.2 / np.cos(critical) + 0.4 - 0.2 * np.tan(critical)
    assert path.length == pytest.approx(exact, rel=ROUNDING)
    along = path.points[np.abs(path.points[:, 1]) < 1e-12, 0]
    np.testing.assert_allclose(
        sorted(along), [0.3, 0.7] + 0.1 * np.tan(critical) * np.array([1, -1])
    )


def test_an_expensive_wall_is_walked_around():
    x, y, _ = middles(SQUARE).T
    wall = (np.abs(x - 0.5) < 0.1) & (y < 0.75)
    solver = solver_of(SQUARE, cost=np.where(wall, 1e6, 1.0))
    path = gt.geodesic_path(solver, nearest(SQUARE, 0.2, 0.2), nearest(SQUARE, 0.8, 0.2))
    assert path.length == pytest.approx(2 * np.hypot(0.2, 0.55) + 0.2, rel=ROUNDING)


def test_in_a_linear_velocity_paths_are_arcs_and_second_order():
    errors = []
    for n in (11, 21, 41):
        mesh = shapes.grid(n)
        source = nearest(mesh, 0.2, 0.5)
        velocity = 1.0 + 3.0 * mesh.vertices[:, 0]
        solver = solver_of(mesh, cost=1 / velocity)
        excess = []
        for place in ((0.8, 0.9), (1.0, 0.5), (0.0, 1.0)):
            target = nearest(mesh, *place)
            square = ((mesh.vertices[target] - mesh.vertices[source]) ** 2).sum()
            exact = np.arccosh(1 + 9 * square / (2 * velocity[target] * velocity[source])) / 3
            excess.append(gt.geodesic_path(solver, source, target).length / exact - 1)
        assert min(excess) > 0
        errors.append(np.mean(excess))
    assert errors[-1] < 5e-4  # measured: 3.4e-3, 1.1e-3, 2.9e-4
    assert all(after < 0.4 * before for before, after in pairwise(errors))
    arc = gt.geodesic_path(solver, source, nearest(mesh, 0.2, 0.1)).points
    # the centre is where the velocity vanishes, at the same distance from both ends
    radii = np.linalg.norm(arc[:, :2] - [-1 / 3, 0.3], axis=1)
    np.testing.assert_allclose(radii, radii[0], rtol=3e-3)


COARSE = shapes.grid(11)


def random_metric(kind, ratio, rng):
    if kind == "vertices":
        return {"cost": ratio ** rng.random(COARSE.n_vertices), "on": "vertices"}
    if kind == "faces":
        return {"cost": ratio ** rng.random(COARSE.n_faces), "on": "faces"}
    blocks = (middles(COARSE)[:, :2] * 5).astype(int)
    return {"cost": (ratio ** rng.random((5, 5)))[tuple(blocks.T)], "on": "faces"}


@settings(max_examples=6, deadline=None)
@given(
    st.sampled_from(["vertices", "faces", "blocks"]),
    st.sampled_from([2.0, 10.0, 100.0]),
    st.integers(0, 1000),
)
def test_paths_are_symmetric_scale_and_are_never_longer_than_along_edges(kind, ratio, seed):
    metric = random_metric(kind, ratio, np.random.default_rng(seed))
    solver = solver_of(COARSE, **metric)
    source, target = pairs_of(COARSE, 1, seed)[0]
    path, back = gt.geodesic_path(solver, source, target), gt.geodesic_path(solver, target, source)
    assert is_sound(path)
    assert path.faces.max() < COARSE.n_faces
    assert path.length <= along_edges(solver, source, target) * (1 + ROUNDING)
    assert back.length == pytest.approx(path.length, rel=0.01)  # another path, almost as long
    scaled = solver_of(COARSE, **{**metric, "cost": 1e-7 * metric["cost"]})
    assert gt.geodesic_path(scaled, source, target).length == pytest.approx(
        1e-7 * path.length, rel=1e-8
    )


def test_paths_are_as_long_as_distances_say():
    hills = 1 + np.sin(5 * SQUARE.vertices[:, 0]) ** 2 + SQUARE.vertices[:, 1]
    solver = solver_of(SQUARE, cost=hills)
    distance = solver.distance(30)
    for target in range(7, SQUARE.n_vertices, 83):
        length = gt.geodesic_path(solver, 30, target).length
        assert length == pytest.approx(distance[target], rel=0.01)


def test_a_surface_without_positions_has_the_same_paths():
    torus = shapes.torus(30, 16)
    weighted = gt.MetricMesh(torus, cost=3.0)
    solver = gt.GeodesicSolver(gt.IntrinsicMesh(torus.faces, weighted.lengths))
    path = gt.geodesic_path(solver, 0, 200)
    assert path.length == pytest.approx(
        gt.geodesic_path(gt.GeodesicSolver(weighted), 0, 200).length, rel=ROUNDING
    )
    assert repr(path) == f"GeodesicPath({len(path.faces)} points, length {path.length:.6g})"
    between = gt.geodesic_path(solver, path.surface_points[3], path.surface_points[5])
    assert between.length == pytest.approx(path.segment_lengths[3:5].sum(), rel=ROUNDING)
    for missing in ("points", "length_in_space"):
        with pytest.raises(UnsupportedDomainError, match="positions"):
            getattr(path, missing)


def test_paths_begin_at_the_source_that_is_first():
    solver = solver_of(SQUARE, cost=2.0)
    target = nearest(SQUARE, 0.5, 0.5)
    assert gt.geodesic_path(solver, [0, target, 440], target).length == 0
    late = gt.geodesic_path(solver, gt.OffsetSources([0, 440], [1.0, 0.0]), target)
    np.testing.assert_allclose(late.points[0], SQUARE.vertices[440])
    middle = gt.geodesic_path(solver, [0, 420], 20 + 21 * 3)
    np.testing.assert_allclose(middle.points[0], SQUARE.vertices[0])
    again = pickle.loads(pickle.dumps(middle))
    assert again.length == middle.length


@pytest.mark.parametrize(
    ("arguments", "options"),
    [
        ((0, 440), {"via": [20]}),
        ((0, 440), {"via": [20], "through": True}),
        (([0, 20, 440],), {}),
        (([0, 25, 400],), {"closed": True}),
        (([[0.1, 0.1, 0.0]], [[0.9, 0.5, 0.0]]), {"via": [20, 440]}),
    ],
    ids=["via", "through", "way points", "closed", "inside faces"],
)
def test_way_points_are_as_on_plain_meshes(arguments, options):
    path = gt.geodesic_path(solver_of(SQUARE, cost=3.0), *arguments, **options)
    plain = gt.geodesic_path(gt.GeodesicSolver(SQUARE), *arguments, **options)
    assert is_sound(path)
    assert path.closed == plain.closed
    assert path.length == pytest.approx(3 * plain.length, rel=ROUNDING)


def test_a_path_via_a_place_stays_on_its_side():
    torus = shapes.torus(48, 24)
    solver = solver_of(torus, cost=2.0)
    far = gt.geodesic_path(solver, 0, 240, via=[720])
    plain = gt.geodesic_path(gt.GeodesicSolver(torus), 0, 240, via=[720])
    assert far.length == pytest.approx(2 * plain.length, rel=1e-6)
    loop = gt.geodesic_loop(solver, [0, 8, 16], through=True)
    assert loop.closed
    with pytest.raises(UnsupportedDomainError, match="through=True"):
        gt.geodesic_loop(solver, [0, 8, 16])


def test_masked_vertices_are_walked_around():
    wall = (np.abs(SQUARE.vertices[:, 0] - 0.5) < 0.01) & (SQUARE.vertices[:, 1] < 0.9)
    lengths = [
        gt.geodesic_path(gt.GeodesicSolver(shape, mask=wall), 0, 20).length
        for shape in (SQUARE, gt.MetricMesh(SQUARE, cost=3.0))
    ]
    assert lengths[1] == pytest.approx(3 * lengths[0], rel=ROUNDING)


def test_places_that_nothing_connects_are_errors():
    wall = np.abs(SQUARE.vertices[:, 0] - 0.5) < 0.01
    solver = gt.GeodesicSolver(gt.MetricMesh(SQUARE, cost=3.0), mask=wall)
    with pytest.raises(UnreachableError, match="target 20"):
        gt.geodesic_path(solver, 0, 20)
    with pytest.raises(UnreachableError, match="place 2 with place 1"):
        gt.geodesic_path(solver, 0, 20, via=[5])
    with pytest.raises(UnreachableError, match="place 2 with place 1"):
        gt.geodesic_path(solver, 0, 20, via=[5], through=True)
    with pytest.raises(UnreachableError, match="way point 2"):
        gt.geodesic_path(solver, [0, 5, 20])
    lonely = gt.TriangleMesh([*SQUARE.vertices, [5.0, 5, 5]], SQUARE.faces)
    with pytest.raises(UnreachableError):
        gt.geodesic_path(solver_of(lonely, cost=2.0), 441, 441)


def test_paths_go_through_vertices_where_sheets_meet():
    corners = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]
    bow = gt.TriangleMesh(corners, [[0, 1, 2], [0, 3, 4]])
    path = gt.geodesic_path(solver_of(bow, cost=[2.0, 3.0]), [0.5, 0.1, 0.0], [-0.5, -0.1, 0.0])
    assert is_sound(path)
    assert path.length == pytest.approx(5 * np.hypot(0.5, 0.1), rel=ROUNDING)


def test_paths_cross_edges_of_three_faces():
    corners = [[0.0, 0, 0], [0, 1, 0], [1, 0.5, 0], [-1, 0.5, 0], [0, 0.5, 1]]
    book = gt.TriangleMesh(corners, [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    solver = solver_of(book, cost=[1.0, 2.0, 4.0])
    assert gt.geodesic_path(solver, 2, 3).length == pytest.approx(3.0, rel=ROUNDING)
    assert gt.geodesic_path(solver, 3, 4).length == pytest.approx(6.0, rel=ROUNDING)


def test_of_faces_with_the_same_corners_the_first_counts():
    twice = gt.TriangleMesh([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [2, 1, 0]])
    path = gt.geodesic_path(solver_of(twice, cost=[5.0, 2.0]), 0, [0.5, 0.5, 0.0])
    assert path.length == pytest.approx(5 * np.sqrt(0.5), rel=1e-9)


def test_a_polyline_that_leaves_its_faces_has_no_length():
    domain = gt.MetricMesh(SQUARE, cost=2.0)
    middle = (1 / 3, 1 / 3, 1 / 3)
    apart = gt.GeodesicPath(domain, [gt.SurfacePoint(0, middle), gt.SurfacePoint(50, middle)])
    with pytest.raises(InvalidSourceError, match="points 0 and 1"):
        _ = apart.length


def test_a_plain_path_has_lengths_of_segments():
    path = gt.geodesic_path(gt.GeodesicSolver(SQUARE), [0, 20, 440], closed=True)
    assert path.segment_lengths.shape == (len(path.points),)
    assert path.length == path.length_in_space == pytest.approx(path.segment_lengths.sum())


def test_paths_across_slivers_are_straight():
    stretched = gt.TriangleMesh(SQUARE.vertices * [1.0, 1e-3, 1.0], SQUARE.faces)
    solver = solver_of(stretched, cost=2.0)
    for source, target in pairs_of(stretched, 5):
        straight = np.linalg.norm(np.subtract(*stretched.vertices[[source, target]]))
        path = gt.geodesic_path(solver, source, target)
        assert path.length == pytest.approx(2 * straight, rel=1e-8)
