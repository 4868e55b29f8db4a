"""Isolines: length and area against closed forms, direction, ends, vertices on the level."""

import numpy as np
import pytest
from closed_forms import on_sphere
from hypothesis import given, settings
from hypothesis import strategies as st

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    UnsupportedDomainError,
)
from geodesic_toolkit.testing import shapes

SQUARE = shapes.grid(9)
SPHERE = shapes.icosphere(3)


def points_of(mesh, curve):
    faces = [point.face for point in curve.points]
    weights = np.array([point.barycentric for point in curve.points])
    return np.einsum("pc,pcd->pd", weights, mesh.vertices[mesh.faces[faces]])


def values_on(mesh, field, curve):
    faces = [point.face for point in curve.points]
    weights = np.array([point.barycentric for point in curve.points])
    return np.einsum("pc,pc->p", weights, field[mesh.faces[faces]])


# -- closed forms --------------------------------------------------------------------------------


@settings(max_examples=40)
@given(st.floats(0.05, 1.5), st.floats(-1.0, 1.0), st.floats(-0.4, 1.4))
def test_the_line_of_a_linear_function_on_a_plane_is_straight(a, b, level):
    field = SQUARE.vertices[:, :2] @ [a, b]
    lines = gt.isolines(SQUARE, field, level)
    # Where a x + b y = level crosses the unit square, by clipping.
    ends = []
    for y in (0.0, 1.0):
        x = (level - b * y) / a
        if 0 <= x <= 1:
            ends.append((x, y))
    if b:
        ends += [(x, y) for x in (0.0, 1.0) for y in [(level - a * x) / b] if 0 <= y <= 1]
    far = max((np.hypot(p[0] - q[0], p[1] - q[1]) for p in ends for q in ends), default=0.0)
    total = sum(gt.curve_length(SQUARE, line) for line in lines)
    if field.min() + 1e-6 < level < field.max() - 1e-6:
        assert len(lines) == 1
        assert not lines[0].closed
        assert total == pytest.approx(far, abs=1e-9)
    for line in lines:
        assert values_on(SQUARE, field, line) == pytest.approx(level, abs=1e-12)


def test_length_and_area_of_circles_on_a_sphere_converge():
    errors = []
    for level in (2, 3, 4):
        mesh = shapes.icosphere(level)
        field = on_sphere(mesh, 0)
        circle = gt.isolines(mesh, field, 1.0)[0]
        length = gt.curve_length(mesh, circle) / (2 * np.pi * np.sin(1)) - 1
        area = gt.area_above(mesh, -field, -1.0) / (2 * np.pi * (1 - np.cos(1))) - 1
        errors.append((abs(length), abs(area)))
    assert np.all(np.array(errors[:-1]) / errors[1:] > 3)
    assert max(errors[-1]) < 2e-3


def test_what_is_above_and_what_is_below_make_up_the_whole():
    field = on_sphere(SPHERE, 0)
    both = gt.area_above(SPHERE, field, 1.3) + gt.area_above(SPHERE, -field, -1.3)
    assert both == pytest.approx(gt.area_above(SPHERE, field, -1.0), rel=1e-12)


# -- direction -----------------------------------------------------------------------------------


def test_larger_values_lie_on_the_left():
    height = SPHERE.vertices[:, 2]
    (line,) = gt.isolines(SPHERE, height, 0.3)
    places = points_of(SPHERE, line)
    turn = np.cross(places, np.roll(places, -1, axis=0))[:, 2]
    assert line.closed
    assert (turn > 0).all()  # counterclockwise seen from above, where values are larger


def test_lines_of_several_levels_come_in_their_order():
    height = SPHERE.vertices[:, 2]
    lines = gt.isolines(SPHERE, height, [0.5, -0.2, 2.0, 0.1])
    assert [round(float(values_on(SPHERE, height, line)[0]), 9) for line in lines] == [
        0.5,
        -0.2,
        0.1,
    ]


# -- vertices on the level, plateaus -------------------------------------------------------------


def test_a_line_along_edges_is_drawn_once():
    (line,) = gt.isolines(SQUARE, SQUARE.vertices[:, 0], 0.5)
    assert gt.curve_length(SQUARE, line) == pytest.approx(1.0)
    assert len(line.points) == 9


def test_a_line_through_vertices_has_each_of_them_once():
    field = SQUARE.vertices[:, 0] - SQUARE.vertices[:, 1]
    (line,) = gt.isolines(SQUARE, field, 0.0)
    assert gt.curve_length(SQUARE, line) == pytest.approx(np.sqrt(2))
    steps = np.linalg.norm(np.diff(points_of(SQUARE, line), axis=0), axis=1)
    assert (steps > 1e-12).all()


@pytest.mark.parametrize("sign", [1, -1])
def test_extrema_on_the_level_have_no_line(sign):
    assert gt.isolines(SPHERE, sign * on_sphere(SPHERE, 0), 0.0) == []


def test_a_plateau_is_bordered_by_its_edges():
    field = np.maximum(np.abs(SQUARE.vertices[:, :2] - 0.5).max(axis=1), 0.25)
    (line,) = gt.isolines(SQUARE, -field, -0.25)
    assert line.closed
    assert gt.curve_length(SQUARE, line) == pytest.approx(2.0)
    assert gt.area_above(SQUARE, -field, -0.25) == pytest.approx(0.25)
    assert gt.isolines(SQUARE, np.ones(SQUARE.n_vertices), 1.0) == []


@settings(max_examples=60)
@given(st.lists(st.integers(0, 2), min_size=42, max_size=42))
def test_lines_on_a_closed_surface_close_whatever_vertices_are_on_the_level(values):
    mesh = shapes.icosphere(1)
    for line in gt.isolines(mesh, np.array(values), 1.0):
        assert line.closed
        assert values_on(mesh, np.array(values, float), line) == pytest.approx(1.0)


# -- where lines end -----------------------------------------------------------------------------


def test_faces_without_a_value_are_left_out():
    field = SQUARE.vertices[:, 1].copy()
    field[40] = np.inf  # the middle
    lines = gt.isolines(SQUARE, field, 0.45)
    assert len(lines) == 2
    assert sum(gt.curve_length(SQUARE, line) for line in lines) < 1.0
    field[:] = np.nan
    assert gt.isolines(SQUARE, field, 0.45) == []


def test_lines_end_at_edges_of_three_faces():
    fin = np.array([[36, 37, 81], [44, 43, 82]])  # on edges that the line crosses, or not
    vertices = np.vstack([SQUARE.vertices, [[0.05, 0.5, 1], [0.95, 0.5, 1]]])
    across = np.abs(vertices[:, 0] - 0.06)
    mesh = gt.TriangleMesh(vertices, np.concatenate([SQUARE.faces, fin]))
    lines = gt.isolines(mesh, vertices[:, 0], 0.06)
    assert across.min() >= 0
    assert len(lines) == 3
    assert not any(line.closed for line in lines)


def test_faces_turned_against_each_other_are_one_line():
    faces = SPHERE.faces.copy()
    faces[::2] = faces[::2, ::-1]
    mesh = gt.TriangleMesh(SPHERE.vertices, np.concatenate([faces, faces[:9], [[0, 0, 1]]]))
    (line,) = gt.isolines(mesh, SPHERE.vertices[:, 2], 0.3)
    (same,) = gt.isolines(SPHERE, SPHERE.vertices[:, 2], 0.3)
    assert line.closed
    assert gt.curve_length(mesh, line) == pytest.approx(gt.curve_length(SPHERE, same))


def test_values_of_any_size_are_taken():
    field = 1.7e308 * SQUARE.vertices[:, 0] - 8e307
    (line,) = gt.isolines(SQUARE, 2 * (field / 2), 0.0)
    assert gt.curve_length(SQUARE, line) == pytest.approx(1.0)
    (line,) = gt.isolines(SQUARE, 5e-320 * SQUARE.vertices[:, 0], 1e-320)
    assert gt.curve_length(SQUARE, line) > 0.9


# -- as sources ----------------------------------------------------------------------------------


def test_the_distance_from_an_isoline_is_the_difference_of_distances():
    mesh = shapes.icosphere(4)
    solver = gt.GeodesicSolver(mesh)
    exact = on_sphere(mesh, 0)
    (circle,) = gt.isolines(mesh, solver.distance(0), 1.0)
    gaps = np.abs(solver.distance(circle) - np.abs(exact - 1.0))
    assert gaps.max() < 0.02
    on_it = np.array([point.barycentric for point in circle.points])
    corners = mesh.faces[[point.face for point in circle.points]]
    assert (on_it * solver.distance(circle)[corners]).sum(axis=1).max() < 0.05


# -- errors --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("values", "level", "words"),
    [
        (np.zeros(3), 0.0, "one real number for each of the 81"),
        (np.zeros((81, 1)), 0.0, "one real number"),
        (np.zeros(81, dtype=complex), 0.0, "complex"),
        (["a"] * 81, 0.0, "must hold real numbers"),
        (np.zeros(81), np.nan, "finite"),
        (np.zeros(81), [0.0, np.inf], "finite"),
        (np.zeros(81), "high", "a level must be a number"),
        (np.zeros(81), [[0.0]], "a level must be a number"),
    ],
)
def test_fields_and_levels_that_are_none_are_refused(values, level, words):
    if words == "a level must be a number" and isinstance(level, list):
        level = [None]
    with pytest.raises(InvalidOptionError, match=words):
        gt.isolines(SQUARE, values, level)


def test_masked_values_are_refused():
    values = np.ma.masked_array(np.zeros(81), mask=np.arange(81) == 3)
    with pytest.raises(InvalidOptionError, match="masked array"):
        gt.area_above(SQUARE, values, 0.0)


def test_isolines_need_faces():
    with pytest.raises(UnsupportedDomainError, match="need a triangle mesh"):
        gt.isolines(gt.PointCloud(SQUARE.vertices), np.zeros(81), 0.0)
    with pytest.raises(UnsupportedDomainError, match="areas need"):
        gt.area_above(gt.Graph(2, [[0, 1]]), np.zeros(2), 0.0)


def test_a_curve_of_another_mesh_has_no_length():
    curve = gt.Curve([gt.SurfacePoint(0, (1, 0, 0)), gt.SurfacePoint(500, (1, 0, 0))])
    with pytest.raises(InvalidSourceError, match="face 500"):
        gt.curve_length(SQUARE, curve)
    with pytest.raises(InvalidSourceError, match="a Curve has a length"):
        gt.curve_length(SQUARE, [[0, 0, 0]])
