"""Logarithmic maps by refined fronts: against closed forms, and wherever meshes are odd."""

import pickle

import numpy as np
import pytest
from curved_shapes import degrees_between, irregular_plate, irregular_sphere, moebius
from geodesics import irregular_cylinder, log_on_sphere, shoot_on_ellipsoid
from hypothesis import given, settings
from hypothesis import strategies as st

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    UnsupportedDomainError,
)

shapes = gt.testing.shapes
SWEPT = 1e-6
"""Sweeps leave as much of a mean edge length."""
BLUNT = 1e-5
"""Distance from an edge at which flipped edges hide a source, in squares of side 1."""


def log_of(mesh, source, **options):
    return gt.log_map(gt.GeodesicSolver(mesh, **options), source, refine=True)


def errors_on_sphere(mesh, source, logarithm):
    """Angles in degrees, and relative errors of lengths, short of the antipode."""
    want = log_on_sphere(mesh.vertices, source)
    length = np.linalg.norm(want, axis=1)
    good = (length > 0) & (length < 2.5)
    got = logarithm.vectors[good]
    return degrees_between(got, want[good]), np.abs(np.linalg.norm(got, axis=1) / length[good] - 1)


PLATE = irregular_plate(20)
SHEARED = shapes.grid(15, shear=3.0)
CORNER, MIDDLE = 0, 20 * 10 + 10


@pytest.mark.parametrize("mesh", [PLATE, SHEARED])
@pytest.mark.parametrize("source", [0, 112])
def test_in_the_plane_logarithms_are_differences(mesh, source):
    found = log_of(mesh, source)
    np.testing.assert_allclose(
        found.vectors, mesh.vertices - mesh.vertices[source], rtol=0, atol=SWEPT
    )


@pytest.mark.parametrize("weights", [(0.2, 0.5, 0.3), (0.4, 0.6, 0.0), (0.0, 1.0, 0.0)])
@pytest.mark.parametrize(("mesh", "least"), [(PLATE, SWEPT), (SHEARED, BLUNT)])
def test_in_the_plane_this_is_so_for_points_in_faces_and_on_edges(mesh, least, weights):
    for face in (3, 150, 301):
        place = gt.SurfacePoint(face, weights)
        at = np.asarray(weights) @ mesh.vertices[mesh.faces[face]]
        found = log_of(mesh, place)
        np.testing.assert_allclose(found.vectors, mesh.vertices - at, rtol=0, atol=least)


def test_arrivals_in_the_plane_lead_away_from_the_source():
    found = log_of(PLATE, MIDDLE)
    away = PLATE.vertices - PLATE.vertices[MIDDLE]
    away /= np.maximum(np.linalg.norm(away, axis=1), 1e-300)[:, None]
    np.testing.assert_allclose(found.arrival, away, rtol=0, atol=SWEPT)
    np.testing.assert_allclose(found.spread, found.distance, rtol=0, atol=SWEPT)


def test_angles_on_spheres_are_of_second_order():
    worst = []
    for n in (600, 2400, 9600):
        mesh = irregular_sphere(n)
        angles, lengths = errors_on_sphere(mesh, 0, log_of(mesh, 0))
        worst.append(angles.mean())
        assert lengths.mean() < 2 / n
    # Measured: 0.16, 0.037 and 0.011 degrees.
    assert worst[0] < 0.25
    assert np.log2(worst[0] / worst[2]) / 2 > 1.7


def test_geodesics_of_a_sphere_arrive_and_spread_as_great_circles_do():
    mesh = irregular_sphere(3000)
    found = log_of(mesh, 7)
    p, d = mesh.vertices[7], found.distance
    out = log_on_sphere(mesh.vertices, 7)
    near = (d > 0) & (d < 2.5)
    out = out[near] / np.linalg.norm(out[near], axis=1)[:, None]
    arrival = -np.sin(d[near])[:, None] * p + np.cos(d[near])[:, None] * out
    assert degrees_between(found.arrival[near], arrival).mean() < 0.2
    np.testing.assert_allclose(found.spread[near], np.sin(d[near]), rtol=0, atol=0.05)


def test_from_a_point_in_a_face_of_a_sphere_it_is_as_exact():
    mesh = irregular_sphere(3000)
    at = np.array([0.2, 0.5, 0.3]) @ mesh.vertices[mesh.faces[17]]
    found = log_of(mesh, gt.SurfacePoint(17, (0.2, 0.5, 0.3)))
    want = log_on_sphere(mesh.vertices, at / np.linalg.norm(at))
    good = found.distance < 2.5
    flat = want[good] - (want[good] @ np.cross(*found.frame))[:, None] * np.cross(*found.frame)
    assert degrees_between(found.vectors[good], flat).mean() < 0.15


def test_on_a_cylinder_it_is_that_of_the_plane_from_every_source():
    mesh, flat = irregular_cylinder()
    solver, inside = gt.GeodesicSolver(mesh), np.flatnonzero(np.abs(flat[:, 1] - 1.5) < 1.2)
    for source in np.random.default_rng(0).choice(inside, 12, replace=False):
        found = gt.log_map(solver, source, refine=True)
        turn = (flat[:, 0] - flat[source, 0] + np.pi) % (2 * np.pi) - np.pi
        rise = flat[:, 1] - flat[source, 1]
        t = flat[source, 0]
        want = turn[:, None] * [-np.sin(t), np.cos(t), 0.0] + rise[:, None] * [0.0, 0.0, 1.0]
        good = (np.abs(turn) < 3.0) & (np.hypot(turn, rise) > 0)
        # Measured: 0.02 to 0.05 degrees.
        assert degrees_between(found.vectors[good], want[good]).mean() < 0.1
        length = np.linalg.norm(want[good], axis=1)
        assert (np.abs(found.distance[good] / length - 1)).mean() < 1e-3


def test_geodesics_of_an_ellipsoid_lead_where_logarithms_say():
    axes = np.array([1.0, 0.8, 0.6])
    sphere = irregular_sphere(2500)
    mesh = gt.TriangleMesh(sphere.vertices * axes, sphere.faces)
    found = log_of(mesh, 100)
    near = np.flatnonzero((found.distance < 1.2) & (found.distance > 0))
    normal = mesh.vertices[100] / axes**2
    normal /= np.linalg.norm(normal)
    vectors = found.vectors[near]
    flat = vectors - (vectors @ normal)[:, None] * normal
    flat *= (found.distance[near] / np.linalg.norm(flat, axis=1))[:, None]
    ends = shoot_on_ellipsoid(axes, mesh.vertices[100], flat)
    missed = np.linalg.norm(ends - mesh.vertices[near], axis=1) / found.distance[near]
    assert missed.mean() < 0.005


@pytest.mark.parametrize("sides", [3, 5, 9])
def test_about_a_cone_point_angles_are_scaled_to_a_full_turn(sides):
    mesh = shapes.pyramid(sides, rings=6)
    found = log_of(mesh, 0)
    ring = np.unwrap(found.angle[1 : 1 + sides])
    np.testing.assert_allclose(np.diff(ring), np.diff(ring)[0], atol=1e-6)
    np.testing.assert_allclose(np.abs(np.diff(ring)), 2 * np.pi / sides, atol=1e-6)
    for k in range(1, 6):  # along the edges of the pyramid
        turn = found.angle[1 + k * sides : 1 + (k + 1) * sides] - found.angle[1 : 1 + sides]
        np.testing.assert_allclose(np.exp(1j * turn), 1.0, atol=1e-6)


def straight_tube(rings, around):
    """A prism with regular polygons for rings, and what it is when it is unrolled."""
    angle = np.tile(2 * np.pi * np.arange(around) / around, rings)
    radius = 1 / (2 * np.sin(np.pi / around))
    height = np.repeat(np.arange(rings, dtype=float), around)
    cells = np.arange(rings * around).reshape(rings, around)
    a, b = cells[:-1].ravel(), np.roll(cells[:-1], -1, axis=1).ravel()
    c, d = cells[1:].ravel(), np.roll(cells[1:], -1, axis=1).ravel()
    odd = (np.add.outer(np.arange(rings - 1), np.arange(around)) % 2).ravel()[:, None]
    first = np.where(odd, np.column_stack([a, b, d]), np.column_stack([a, b, c]))
    second = np.where(odd, np.column_stack([a, d, c]), np.column_stack([b, d, c]))
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])
    mesh = gt.TriangleMesh(points, np.concatenate([first, second]))
    return mesh, angle * around / (2 * np.pi) + 1j * height


def test_far_along_a_tube_angles_are_still_right():
    rings, around = 1000, 24
    mesh, flat = straight_tube(rings, around)
    found = log_of(mesh, 5)
    flat = flat - flat[5]
    flat.real = (flat.real + around / 2) % around - around / 2
    good = (np.abs(flat.real) < 0.95 * around / 2) & (flat != 0)
    turn = (found.coordinates @ [1, 1j])[good] / flat[good]
    assert np.isfinite(found.vectors).all()
    off = np.angle(turn / turn[around // 4])  # the frame may be turned
    assert np.degrees(np.abs(off)).mean() < 1e-3
    np.testing.assert_allclose(np.abs(turn), 1.0, rtol=0, atol=1e-6)


def plate_with_notch(n=25):
    """The square of side 2, without the quarter where x and y are above 1."""
    square = shapes.grid(n)
    middle = square.vertices[square.faces].mean(axis=1)
    kept = (middle[:, :2] < 0.5).any(axis=1)
    used, faces = np.unique(square.faces[kept], return_inverse=True)
    return gt.TriangleMesh(2 * square.vertices[used], faces.reshape(-1, 3))


def test_in_the_shadow_of_a_corner_all_leave_towards_that_corner():
    mesh = plate_with_notch()
    places = mesh.vertices
    source = int(np.linalg.norm(places - [0.5, 1.75, 0.0], axis=1).argmin())
    found = log_of(mesh, source)
    corner = np.array([1.0, 1.0, 0.0])
    to_corner = corner - places[source]
    far = places - corner
    hidden = (far[:, 0] > 0.2) & (far[:, 1] < 0)
    beyond = np.cross(to_corner, far)[:, 2] > 0.15 * np.linalg.norm(far, axis=1)
    shadow = hidden & beyond
    assert shadow.sum() > 10
    directions = found.vectors[shadow] / found.distance[shadow][:, None]
    want = to_corner / np.linalg.norm(to_corner)
    assert degrees_between(directions, np.tile(want, (len(directions), 1))).max() < 1e-3
    assert np.isinf(found.spread[shadow]).all()


def test_beside_the_line_where_a_shadow_begins_angles_change_as_they_should():
    mesh = plate_with_notch(49)
    places = mesh.vertices
    source = int(np.linalg.norm(places - [0.5, 1.75, 0.0], axis=1).argmin())
    found = log_of(mesh, source)
    corner = np.array([1.0, 1.0, 0.0])
    away, from_corner = places - places[source], places - corner
    shadow = np.cross(corner - places[source], from_corner)[:, 2] > 0
    shadow &= (from_corner[:, 0] > 0) & (from_corner[:, 1] < 1e-12)
    want = np.where(shadow[:, None], corner - places[source], away)
    there = found.distance > 0
    off = degrees_between(found.vectors[there], want[there])
    assert off.max() < 1.0  # measured: 0.6
    assert off.mean() < 0.02  # measured: 0.012


# -- odd meshes -----------------------------------------------------------------------------------


def test_where_nothing_connects_there_is_no_angle():
    both = shapes.disjoint_union(shapes.grid(4), shapes.grid(5))
    found = log_of(both, 0)
    there = np.arange(16, both.n_vertices)
    assert np.isinf(found.distance[there]).all()
    for values in (found.angle, found.vectors, found.coordinates, found.arrival, found.spread):
        assert np.isnan(values[there]).all()
        assert np.isfinite(values[:16]).all()


def test_faces_turned_over_change_nothing():
    mesh = irregular_sphere(500)
    faces = mesh.faces.copy()
    faces[::3] = faces[::3, ::-1]
    mixed = gt.TriangleMesh(mesh.vertices, faces)
    one, other = log_of(mesh, 3), log_of(mixed, 3)
    far = (one.distance > 0) & (one.distance < 2.5)
    angles = degrees_between(one.vectors[far], other.vectors[far])
    assert angles.mean() < 1.0  # edges are not flipped where neighbours do not agree


def test_sheets_that_meet_in_an_edge_are_all_reached():
    side = shapes.grid(6)
    up = side.vertices[:, [0, 2, 1]]
    down = up * [1, 1, -1]
    points = np.concatenate([side.vertices, up, down])
    mesh = gt.TriangleMesh(points, np.concatenate([side.faces + 36 * k for k in range(3)]))
    mesh = gt.merge_vertices(mesh, tolerance=1e-9)[0]
    found = log_of(mesh, 20)
    assert np.isfinite(found.vectors).all()
    assert np.isfinite(found.arrival).all()


def test_vertices_where_sheets_touch_are_passed():
    one = shapes.grid(4).vertices
    points = np.concatenate([one, one[1:] + np.array([1.0, 1.0, 0.0])])
    number = np.concatenate([[15], 16 + np.arange(15)])
    faces = shapes.grid(4).faces
    mesh = gt.TriangleMesh(points, np.concatenate([faces, number[faces]]))
    found = log_of(mesh, 0)
    assert np.isfinite(found.vectors).all()


def test_faces_without_area_and_repeated_places_do_no_harm():
    square = shapes.grid(6)
    points = np.concatenate([square.vertices, square.vertices[:1], [[9.0, 9.0, 9.0]]])
    flat = [[0, 1, 2], [7, 7, 8], [0, 36, 1]]
    mesh = gt.TriangleMesh(points, np.concatenate([square.faces, flat]))
    found = log_of(mesh, 21)
    got, want = found.vectors[:36], square.vertices - square.vertices[21]
    np.testing.assert_allclose(got, want, atol=0.02)
    assert np.isinf(found.distance[37])
    assert np.isnan(found.angle[37])


def test_masked_vertices_have_no_angle():
    square = shapes.grid(9)
    mask = (square.vertices[:, 0] == 0.5) & (square.vertices[:, 1] < 0.9)
    found = log_of(square, 0, mask=mask)
    assert np.isnan(found.angle[mask]).all()
    assert np.isfinite(found.angle[~mask]).all()


def test_distances_are_those_of_the_solver():
    for mesh in (irregular_sphere(900), SHEARED, shapes.knot(8, 20)):
        solver = gt.GeodesicSolver(mesh)
        assert (gt.log_map(solver, 5).distance == solver.distance(5)).all()


@settings(max_examples=15, deadline=None)
@given(
    st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda q: np.linalg.norm(q) > 0.1),
    st.floats(0.1, 10),
    st.integers(0, 299),
)
def test_logarithms_turn_and_grow_with_the_shape(quaternion, scale, source):
    mesh = irregular_sphere(300)
    a, b, c, d = np.asarray(quaternion) / np.linalg.norm(quaternion)
    turn = np.array(
        [
            [1 - 2 * (c * c + d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)],
            [2 * (b * c + a * d), 1 - 2 * (b * b + d * d), 2 * (c * d - a * b)],
            [2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b * b + c * c)],
        ]
    )
    moved = gt.TriangleMesh(scale * mesh.vertices @ turn.T + [1.0, 2.0, 3.0], mesh.faces)
    before, after = log_of(mesh, source), log_of(moved, source)
    near = before.distance < 2.0
    want = scale * before.vectors[near] @ turn.T
    np.testing.assert_allclose(after.vectors[near], want, rtol=0, atol=1e-6 * scale)


def test_plain_maps_are_those_of_vector_heat():
    solver = gt.GeodesicSolver(irregular_sphere(900), refine=False)
    plain, refined = gt.log_map(solver, 0), gt.log_map(solver, 0, refine=True)
    far = (refined.distance > 0.3) & (refined.distance < 2.5)
    angles = degrees_between(plain.vectors[far], refined.vectors[far])
    assert 0.1 < angles.mean() < 5.0
    assert np.isnan(plain.spread).all()


def test_maps_are_frozen_and_travel():
    found = pickle.loads(pickle.dumps(log_of(PLATE, 3)))
    with pytest.raises(ValueError, match="read-only"):
        found.angle[0] = 1.0
    assert repr(found) == "LogMap(400 of 400 vertices)"


# -- errors ---------------------------------------------------------------------------------------


def test_a_graph_has_no_angles():
    graph = gt.Graph(3, [[0, 1], [1, 2]])
    with pytest.raises(UnsupportedDomainError, match="an edge has no angle"):
        log_of(graph, 0)


def test_a_one_sided_surface_is_refused_with_the_face_that_closes_it():
    with pytest.raises(UnsupportedDomainError, match="closes it"):
        log_of(moebius(), 0)


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ([0, 1], "one source, not 2"),
        (gt.Curve([[0, 0, 0], [1, 0, 0]]), "one source"),
        (10**6, "does not exist"),
        (-1, "does not exist"),
        ([np.nan, 0.0, 0.0], "not finite"),
        (gt.SurfacePoint(10**6, (1, 0, 0)), "face 1000000"),
        ([], "none"),
    ],
)
def test_sources_that_are_not_one_place_are_named(source, message):
    with pytest.raises(InvalidSourceError, match=message):
        log_of(PLATE, source)


def test_refine_is_true_false_or_none():
    with pytest.raises(InvalidOptionError, match="refine"):
        gt.log_map(gt.GeodesicSolver(PLATE), 0, refine="across")


def test_only_solvers_have_maps():
    with pytest.raises(InvalidOptionError, match="GeodesicSolver"):
        gt.log_map(PLATE, 0)
