"""Does a page to click follow clicks? Its state, without a browser."""

import json
import re

import numpy as np
import pytest
from solids import Solid, SolidLaplacian, cube

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    UnreachableError,
    UnsupportedDomainError,
)
from geodesic_toolkit.testing import shapes
from geodesic_toolkit.viz.live.coding import HIDDEN, LARGEST_CODE, NO_VALUE, coded
from geodesic_toolkit.viz.live.marks import balls, tube
from geodesic_toolkit.viz.live.picking import Picker
from geodesic_toolkit.viz.live.readout import in_digits, legend, warnings_as_html
from geodesic_toolkit.viz.live.session import MOST_PARTS, MOST_SOLVERS, Mode, Session
from geodesic_toolkit.viz.scene import make_scene

REFINED = 0.01  # relative; 0.003 was measured on this sphere of 2562 vertices
AT_A_KINK = 0.07  # an edge: linear in a face, a distance is cut off at the point farthest away
FAR = 10.0  # where the camera is


@pytest.fixture(scope="module")
def sphere():
    return shapes.icosphere(4)


@pytest.fixture
def session(sphere):
    return Session(sphere)


@pytest.fixture(scope="module")
def pair():
    """A large sphere before a small one, as seen along x from positive x."""
    large, small = shapes.icosphere(4), shapes.icosphere(3)
    shifted = gt.TriangleMesh(0.5 * small.vertices - [4.0, 0, 0], small.faces)
    return shapes.disjoint_union(large, shifted)


def unit(direction):
    return np.asarray(direction, dtype=float) / np.linalg.norm(direction)


def seen_from(session, direction):
    """The place in the middle of a page whose camera looks from a direction."""
    return session.pick(FAR * unit(direction), -unit(direction))


def angles(sphere, direction):
    return np.arccos(np.clip(sphere.vertices @ unit(direction), -1, 1))


# -- picking -------------------------------------------------------------------------------------


def test_a_ray_meets_the_nearest_face_where_it_passes(session):
    for direction in np.random.default_rng(0).normal(size=(50, 3)):
        place = seen_from(session, direction)
        hit = place.of(session.scene.points)
        assert np.linalg.norm(np.cross(hit, unit(direction))) < 1e-9
        assert hit @ unit(direction) > 0.5 * np.linalg.norm(session.scene.points[0])


def test_rays_through_vertices_and_through_edges_meet_the_near_side(sphere, session):
    middles = sphere.vertices[sphere.faces[:, :2]].mean(axis=1)
    for direction in np.vstack([sphere.vertices[:300], middles[:300]]):
        assert seen_from(session, direction).of(session.scene.points) @ direction > 0


def test_a_ray_beside_the_shape_and_one_away_from_it_meet_nothing(session):
    assert session.pick([FAR, 2.0, 0.0], [-1.0, 0.0, 0.0]) is None
    assert session.pick([FAR, 0.0, 0.0], [1.0, 0.0, 0.0]) is None


@pytest.mark.parametrize("direction", [[0.0, 0.0, 0.0], [np.nan, 0.0, 0.0], [np.inf, 0.0, 0.0]])
def test_a_ray_without_a_direction_meets_nothing(session, direction):
    assert session.pick([FAR, 0.0, 0.0], direction) is None


def test_large_faces_among_small_ones_are_met():
    square = shapes.grid(30)
    far = [[-50.0, -50, -1], [50, -50, -1], [0, 80, -1]]
    whole = gt.TriangleMesh(
        np.vstack([square.vertices, far]), np.vstack([square.faces, [[900, 901, 902]]])
    )
    scene = make_scene(whole, np.zeros(903))
    picker = Picker(scene)
    for x, y, corner in ((0.31, 0.52, 0), (5.0, 5.0, 900)):
        place = (np.array([x, y, 9.0]) - scene.centre) / scene.radius
        vertices, weights = picker.pick(place, np.array([0.0, 0, -1]))
        assert (vertices.min() >= 900) == (corner == 900)
        met = weights @ whole.vertices[vertices]
        np.testing.assert_allclose(met[:2], [x, y], atol=1e-9)


def test_a_ray_passes_hidden_parts(pair):
    session = Session(pair)
    assert session.sizes == [2562, 642]
    first = seen_from(session, [1.0, 0.01, 0.02])
    assert session.parts[first.vertices[0]] == 0
    session.hide(frozenset({0}))
    behind = seen_from(session, [1.0, 0.01, 0.02])
    assert session.parts[behind.vertices[0]] == 1


def test_of_points_the_front_one_near_the_ray_is_met(sphere):
    session = Session(gt.PointCloud(sphere.vertices))
    place = seen_from(session, [0.3, 0.5, 0.9])
    assert len(place.vertices) == 1
    assert angles(sphere, [0.3, 0.5, 0.9])[place.vertices[0]] < 0.1
    session.hide(frozenset({0}))
    assert seen_from(session, [0.3, 0.5, 0.9]) is None


# -- clicks --------------------------------------------------------------------------------------


def test_a_click_moves_the_source_into_a_face_and_distances_follow(sphere, session):
    direction = [0.3, 0.5, 0.9]
    session.click(seen_from(session, direction))
    assert len(session.sources) == 1
    exact = angles(sphere, direction)
    assert np.abs(session.distances - exact).max() < REFINED * np.pi
    assert session.limits == (0.0, session.distances.max())


def test_a_click_with_shift_adds_a_source(sphere, session):
    session.click(seen_from(session, [1, 0.1, 0.2]))
    session.click(seen_from(session, [-0.2, 1, 0.1]), add=True)
    exact = np.minimum(angles(sphere, [1, 0.1, 0.2]), angles(sphere, [-0.2, 1, 0.1]))
    assert np.abs(session.distances - exact).max() < REFINED * np.pi


def test_two_clicks_draw_the_shortest_path_and_a_third_begins_another(session):
    session.set_mode(Mode.PATH)
    session.click(seen_from(session, [1, 0, 0.001]))
    assert session.path is None
    assert session.waits_for_target
    session.click(seen_from(session, [0.001, 1, 0]))
    assert session.path.length == pytest.approx(np.pi / 2, rel=REFINED)
    line = session.line()
    assert np.linalg.norm(np.diff(line, axis=0), axis=1).sum() * session.scene.radius == (
        pytest.approx(session.path.length)
    )
    session.click(seen_from(session, [0, 0.001, 1]))
    assert session.path is None
    assert session.waits_for_target


def test_a_path_to_another_component_is_an_error_that_changes_nothing(pair):
    session = Session(pair)
    session.set_mode(Mode.PATH)
    session.click(seen_from(session, [1, 0, 0.01]))
    other = session.pick([-3.0, 0.0, 0.0], [1.0, 0.0, 0.0])
    with pytest.raises(UnreachableError):
        session.click(other)
    assert session.path is None
    assert session.waits_for_target
    assert session.n_unreached == 642


def test_the_antipode_is_half_a_turn_away(session):
    session.click(seen_from(session, [0.3, 0.5, 0.9]))
    session.set_mode(Mode.MEASURE)
    session.click(seen_from(session, [-0.3, -0.5, -0.9]))
    place, distance = session.measured
    assert distance == pytest.approx(np.pi, abs=AT_A_KINK)
    assert place.of(session.scene.points) @ unit([0.3, 0.5, 0.9]) < 0


def test_a_distance_within_the_face_of_the_source_is_the_straight_line(session):
    session.click(seen_from(session, [0.3, 0.5, 0.9]))
    session.set_mode(Mode.MEASURE)
    session.click(seen_from(session, [0.301, 0.5, 0.9]))
    ends = session.positions_of((session.sources[0], session.measured[0]))
    straight = np.linalg.norm(ends[1] - ends[0]) * session.scene.radius
    assert session.measured[1] == pytest.approx(straight, rel=1e-6)


def test_a_place_that_no_source_reaches_is_infinitely_far(pair):
    session = Session(pair)
    session.set_mode(Mode.MEASURE)
    session.click(session.pick([-3.0, 0.0, 0.0], [1.0, 0.0, 0.0]))
    assert session.measured[1] == np.inf


def test_a_click_between_the_points_of_a_grid_meets_the_nearest_front_point():
    side = np.arange(6.0)
    places = np.stack(np.meshgrid(side, side, [0.0, 1.0], indexing="ij"), axis=-1).reshape(-1, 3)
    apart = np.abs(places[:, None] - places).sum(axis=2)
    session = Session(gt.Graph(72, np.argwhere(np.triu(apart == 1))), positions=places)
    above = (np.array([2.5, 2.5, 9.0]) - session.scene.centre) / session.scene.radius
    place = session.pick(above, [0.0, 0.0, -1.0])
    assert places[place.vertices[0], 2] == 1.0
    assert np.abs(places[place.vertices[0], :2] - 2.5).max() == 0.5
    outside = (np.array([8.0, 2.5, 9.0]) - session.scene.centre) / session.scene.radius
    assert session.pick(outside, [0.0, 0.0, -1.0]) is None


# -- masks and costs -----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def masked_cap(sphere):
    return sphere.vertices[:, 2] > 0.8


def test_masked_vertices_have_no_value_and_are_not_a_part(sphere, masked_cap):
    session = Session(sphere, mask=masked_cap)
    expected = gt.GeodesicSolver(sphere, mask=masked_cap).distance(
        int(np.flatnonzero(~masked_cap)[0])
    )
    np.testing.assert_array_equal(session.distances, expected)
    assert session.sizes == [np.count_nonzero(~masked_cap)]
    assert (session.parts[masked_cap] == -1).all()
    assert session.n_unreached == 0
    assert np.isfinite(session.limits).all()
    codes = numbers(coded(session.distances, session.limits))
    np.testing.assert_array_equal(codes == NO_VALUE, masked_cap)
    assert f"<b>{masked_cap.sum()} vertices</b>" in legend(session, np.zeros((64, 3)), unit="")


@pytest.mark.parametrize("mode", [Mode.SOURCE, Mode.PATH])
@pytest.mark.parametrize("add", [False, True])
def test_a_click_on_masked_vertices_is_refused_and_changes_nothing(sphere, masked_cap, mode, add):
    session = Session(sphere, mask=masked_cap)
    session.set_mode(mode)
    before = session.sources
    with pytest.raises(InvalidSourceError, match=r"vertex \d+ is masked.*click where"):
        session.click(seen_from(session, [0.01, 0.02, 1.0]), add=add)
    assert session.sources is before
    session.click(seen_from(session, [0.01, 0.02, -1.0]), add=add)
    assert len(session.sources) == 1 + add


def test_a_path_does_not_end_on_masked_vertices_and_goes_around_them(sphere):
    ring = (np.abs(sphere.vertices[:, 0]) < 0.1) & (sphere.vertices[:, 2] < 0.5)
    session = Session(sphere, mask=ring)
    session.set_mode(Mode.PATH)
    session.click(seen_from(session, [-0.3, 0, -1.0]))
    with pytest.raises(InvalidSourceError):
        session.click(seen_from(session, [0, 0.01, -1.0]))
    assert session.waits_for_target
    session.click(seen_from(session, [0.3, 0, -1.0]))
    assert session.path.length > np.pi


def test_the_distance_of_masked_vertices_is_infinite(sphere, masked_cap):
    session = Session(sphere, mask=masked_cap)
    session.set_mode(Mode.MEASURE)
    session.click(seen_from(session, [0.01, 0.02, 1.0]))
    assert session.measured[1] == np.inf


def test_points_of_a_cloud_are_masked_with_those_at_the_same_position(sphere, masked_cap):
    cloud = gt.PointCloud(np.vstack([sphere.vertices, sphere.vertices[:1]]))
    mask = np.append(np.zeros(sphere.n_vertices, dtype=bool), True)
    session = Session(cloud, mask=mask)
    assert np.flatnonzero(session.masked).tolist() == [0, sphere.n_vertices]
    assert session.shown.all()
    mask[:] = True  # the session has its own
    session.set_method(refine=False, time_factor=1.0)
    assert np.isfinite(session.distances).sum() == sphere.n_vertices - 1


def test_a_mask_that_does_not_fit_is_refused(sphere):
    with pytest.raises(InvalidOptionError, match="mask"):
        Session(sphere, mask=[True, False])


def test_costs_make_distances_and_paths_longer(sphere):
    session = Session(gt.MetricMesh(sphere, cost=np.full(sphere.n_vertices, 3.0)))
    session.set_mode(Mode.PATH)
    session.click(seen_from(session, [1, 0, 0.001]))
    assert session.largest == pytest.approx(3 * np.pi, rel=REFINED)
    session.click(seen_from(session, [0.001, 1, 0]))
    assert session.path.length == pytest.approx(3 * np.pi / 2, rel=0.1)  # it follows edges


# -- options -------------------------------------------------------------------------------------


def test_the_method_at_the_beginning_may_be_chosen(sphere):
    session = Session(sphere, refine=False, time_factor=3.0)
    assert not session.refined
    expected = gt.GeodesicSolver(sphere, refine=False, time_factor=3.0).distance(0)
    np.testing.assert_array_equal(session.distances, expected)
    session.set_method(refine=True, time_factor=3.0)
    assert session.refined
    with pytest.raises(InvalidOptionError):
        Session(sphere, time_factor=-1.0)


def test_fronts_across_a_graph_are_refined_at_any_time_step():
    places = shapes.grid(8).vertices
    edges = np.argwhere(np.triu(np.linalg.norm(places[:, None] - places, axis=2) < 0.15, 1))
    graph = gt.Graph(64, edges)
    session = Session(graph, positions=places)
    fronts = session.distances
    assert session.refined
    session.set_method(refine=True, time_factor=4.0)
    np.testing.assert_array_equal(session.distances, fronts)
    session.set_method(refine=False, time_factor=4.0)
    expected = gt.GeodesicSolver(graph, refine=False, time_factor=4.0).distance(0)
    np.testing.assert_array_equal(session.distances, expected)


def test_another_mode_is_refused_and_a_known_one_may_be_a_string(session):
    session.set_mode("measure")
    assert session.mode is Mode.MEASURE
    with pytest.raises(InvalidOptionError, match='"source", "path" or "measure"'):
        session.set_mode("look")


def test_plain_heat_and_another_time_step_are_a_solver_of_their_own(sphere, session):
    assert session.refined
    for refine, factor in ((False, 1.0), (False, 10.0), (True, 1.0), (False, 2.0)):
        session.set_method(refine=refine, time_factor=factor)
        expected = gt.GeodesicSolver(sphere, refine=refine, time_factor=factor).distance(0)
        np.testing.assert_array_equal(session.distances, expected)
    assert len(session._solvers) == MOST_SOLVERS


def test_what_was_measured_is_measured_again_by_another_method(session):
    session.set_mode(Mode.MEASURE)
    session.click(seen_from(session, [-0.3, -0.5, -0.9]))
    before = session.measured[1]
    session.set_method(refine=False, time_factor=100.0)
    assert session.measured[1] != before


def test_the_first_choice_is_the_same_again_when_it_is_chosen_back():
    places = shapes.grid(8).vertices
    edges = np.argwhere(np.triu(np.linalg.norm(places[:, None] - places, axis=2) < 0.15, 1))
    session = Session(gt.Graph(64, edges), positions=places)  # measured across its squares
    first = session.distances
    session.set_method(refine=not session.refined, time_factor=1.0)
    session.set_method(refine=not session.refined, time_factor=1.0)
    np.testing.assert_array_equal(session.distances, first)


def test_options_that_are_refused_change_nothing(session):
    before = session.distances
    with pytest.raises(InvalidOptionError):
        session.set_method(refine=False, time_factor=-1.0)
    assert session.refined
    assert session.time_factor == 1.0
    assert session.distances is before


def test_the_colours_end_at_the_largest_distance_that_is_shown(pair):
    session = Session(pair, sources=[0, 2562])
    whole = session.limits[1]
    session.hide(frozenset({0}))
    assert 0 < session.limits[1] < whole


def test_many_components_share_the_last_part():
    tetrahedron = gt.TriangleMesh(
        np.vstack([np.zeros(3), np.eye(3)]), [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    )
    many = shapes.disjoint_union(shapes.icosphere(1), *[tetrahedron] * 12)
    session = Session(many)
    assert session.sizes == [42, *[4] * (MOST_PARTS - 1), 4 * (12 - (MOST_PARTS - 1))]
    assert session.parts.max() == MOST_PARTS


def test_vertices_without_a_face_are_of_no_part(sphere):
    spare = gt.TriangleMesh(np.vstack([[[5.0, 5, 5]], sphere.vertices]), sphere.faces + 1)
    session = Session(spare)
    assert session.parts[0] == -1
    assert session.sizes == [2562]
    assert session.sources[0].vertices.tolist() == [1]


# -- kinds of shape ------------------------------------------------------------------------------


def test_a_graph_is_clicked_at_its_vertices():
    ring = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    places = np.column_stack([np.cos(ring), np.sin(ring)])
    edges = np.column_stack([np.arange(12), np.roll(np.arange(12), -1)])
    session = Session(gt.Graph(12, edges), positions=places)
    session.set_mode(Mode.PATH)
    for vertex in (3, 8):
        top = np.append(places[vertex], 5.0)
        session.click(session.pick((top - session.scene.centre) / session.scene.radius, [0, 0, -1]))
    assert session.distances[8] == 5
    assert session.path.vertices.tolist() == [3, 4, 5, 6, 7, 8]
    assert session.line().shape == (6, 3)
    name, content = session.table()
    assert name == "shape.csv"
    assert content.startswith(b"vertex,distance")


def test_a_graph_needs_positions():
    with pytest.raises(UnsupportedDomainError, match="positions"):
        Session(gt.Graph(2, [[0, 1]]))


def test_a_kind_of_a_plugin_is_clicked_on_its_triangles(register):
    register(gt.operators, "solid", SolidLaplacian)
    solid = cube(5)
    assert isinstance(solid, Solid)
    session = Session(solid)
    session.click(seen_from(session, [1.0, 0.02, 0.03]))
    assert len(session.sources[0].vertices) == 3
    assert session.distances.min() < session.distances.max() < np.inf
    session.set_mode(Mode.MEASURE)
    session.click(seen_from(session, [-1.0, 0.02, 0.03]))
    assert 0 < session.measured[1] < np.inf


def test_points_of_a_cloud_are_sources_and_ends_of_paths(sphere):
    session = Session(gt.PointCloud(sphere.vertices))
    session.set_mode(Mode.PATH)
    session.click(seen_from(session, [1, 0, 0.001]))
    session.click(seen_from(session, [0.001, 1, 0]))
    assert session.path.length == pytest.approx(np.pi / 2, rel=0.05)  # the points are snapped to


# -- files ---------------------------------------------------------------------------------------


def test_the_sources_in_json_are_sources_again(session, sphere):
    session.click(seen_from(session, [0.3, 0.5, 0.9]))
    session.click(seen_from(session, [-0.3, 0.5, 0.9]), add=True)
    content = json.loads(session.as_json())
    assert content["n_vertices"] == 2562
    assert content["path_length"] is None
    sources = content["sources"]
    located = gt.Located([one["vertices"] for one in sources], [one["weights"] for one in sources])
    distances = gt.GeodesicSolver(sphere).distance(located)
    np.testing.assert_allclose(distances, session.distances, rtol=1e-12)
    in_space = np.array([one["position"] for one in sources])
    np.testing.assert_allclose(located.positions(sphere), in_space, atol=1e-12)


def test_the_length_of_a_path_is_in_the_json(session):
    session.set_mode(Mode.PATH)
    session.click(seen_from(session, [1, 0, 0.001]))
    session.click(seen_from(session, [0.001, 1, 0]))
    assert json.loads(session.as_json())["path_length"] == session.path.length


def test_the_saved_file_has_the_distances_and_the_name(session, sphere, tmp_path):
    name, content = session.table()
    assert name == "shape.ply"
    file = tmp_path / name
    file.write_bytes(content)
    assert gt.read(file).n_vertices == sphere.n_vertices
    assert b"property double distance" in content or b"property float distance" in content


# -- what goes to the page -----------------------------------------------------------------------


@pytest.mark.parametrize("size", [1e-7, 1e-3, 1.0, 1234.5, 1e5, 3.3e6, 1e9])
def test_numbers_under_the_colour_bar_do_not_overlap(size):
    session = Session(gt.TriangleMesh(size * shapes.grid(6).vertices, shapes.grid(6).faces))
    shown = re.findall(
        r"left:([0-9.]+)%[^>]*>([^<]+)<", legend(session, np.zeros((64, 3)), unit="")
    )
    places = [float(place) for place, _ in shown]
    assert len(shown) >= 2
    for place, (left, text), (right, after) in zip(
        np.diff(places), shown[:-1], shown[1:], strict=True
    ):
        assert float(left) < float(right)
        assert 0.38 * place > (len(text) + len(after)) / 2  # characters of 1/38 of the bar


def test_numbers_are_written_in_full_where_that_is_short():
    assert in_digits(200_000.0, 4) == "200000"
    assert in_digits(31.25512, 4) == "31.26"
    assert in_digits(2e8, 4) == "2e+08"


def test_a_warning_is_shown_as_text():
    shown = warnings_as_html([("SeamWarning", "a < b")])
    assert "SeamWarning" in shown
    assert "a &lt; b" in shown


def numbers(codes):
    return codes.astype(np.int64) @ [1, 256, 65536]


def test_values_become_whole_numbers_between_the_ends():
    values = np.array([0.0, 0.25, 1.0, 2.0, np.inf, np.nan, 0.5])
    hidden = np.array([False] * 6 + [True])
    codes = numbers(coded(values, (0.0, 1.0), hidden))
    quarter = round(LARGEST_CODE / 4)
    assert codes.tolist() == [
        0, quarter, LARGEST_CODE, LARGEST_CODE, NO_VALUE, NO_VALUE, HIDDEN,
    ]  # fmt: skip


def test_special_codes_are_apart_in_single_precision_with_a_number_between():
    codes = np.array([LARGEST_CODE, LARGEST_CODE + 1, NO_VALUE, NO_VALUE + 1, HIDDEN])
    assert (np.diff(codes.astype(np.float32)) > 0).all()


def test_a_tube_has_its_radius_around_the_line_and_a_volume():
    line = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 0], [2, 0, 0], [2, 0, 0]])
    points, faces = tube(line, 0.1)
    np.testing.assert_allclose(np.linalg.norm(points[:, 1:], axis=1), 0.1)
    assert points[:, 0].min() == 0.0
    assert points[:, 0].max() == 2.0
    normals = np.cross(
        points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]]
    )
    assert (np.einsum("fd,fd->f", normals[:, 1:], points[faces].mean(axis=1)[:, 1:]) > 0).all()


@pytest.mark.parametrize("line", [np.zeros((0, 3)), np.ones((1, 3)), np.ones((3, 3))])
def test_a_line_without_a_length_has_no_tube(line):
    points, faces = tube(line, 0.1)
    assert points.shape == (0, 3)
    assert faces.shape == (0, 3)


def test_a_line_that_turns_back_has_a_tube():
    points, _ = tube(np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, 0]]), 0.1)
    assert np.isfinite(points).all()


def test_balls_are_around_their_centres_and_face_outward():
    centres = np.array([[0.0, 0, 0], [5, 0, 0]])
    points, faces = balls(centres, 0.5)
    which = np.repeat([0, 1], len(points) // 2)
    np.testing.assert_allclose(np.linalg.norm(points - centres[which], axis=1), 0.5)
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    outward = np.einsum(
        "fd,fd->f", np.cross(b - a, c - a), (a + b + c) / 3 - centres[which[faces[:, 0]]]
    )
    assert (outward > -1e-15).all()
    assert faces.max() == len(points) - 1
    assert len(balls(np.zeros((0, 3)), 0.5)[1]) == 0
