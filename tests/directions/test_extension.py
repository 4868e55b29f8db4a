"""Values of sources extended along shortest geodesics."""

import numpy as np
import pytest
from curved_shapes import irregular_plate, irregular_sphere

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError

shapes = gt.testing.shapes
SPHERE = irregular_sphere(1500)
SITES = np.array([3, 100, 512, 700, 999, 1400])


def extended(shape, sources, values, **options):
    return gt.extend(gt.GeodesicSolver(shape), sources, values, refine=True, **options)


def test_labels_are_those_of_the_nearest_source():
    labels = extended(SPHERE, SITES, np.arange(len(SITES)))
    assert labels.dtype == np.int64
    distances = np.arccos(np.clip(SPHERE.vertices @ SPHERE.vertices[SITES].T, -1, 1))
    wrong = np.flatnonzero(labels != distances.argmin(axis=1))
    assert len(wrong) < 0.02 * len(labels)
    nearest, second = np.sort(distances[wrong], axis=1)[:, :2].T
    assert (second - nearest < 0.05).all()


def test_values_are_none_but_those_that_were_given():
    values = np.array([0.5, -1.0, 2.0, 7.0, 3.0, 4.0])
    assert set(extended(SPHERE, SITES, values)) == set(values)


def test_several_values_come_side_by_side():
    table = np.column_stack([np.arange(6.0), np.arange(6.0) ** 2])
    got = extended(SPHERE, SITES, table)
    assert got.shape == (1500, 2)
    np.testing.assert_array_equal(got[:, 1], got[:, 0] ** 2)


def test_where_nothing_connects_there_is_no_value():
    both = shapes.disjoint_union(shapes.grid(3), shapes.grid(3))
    assert (extended(both, [0], [5])[9:] == -1).all()
    got = extended(both, [0], [5.0])
    assert np.isnan(got[9:]).all()
    assert (got[:9] == 5.0).all()


def test_sources_that_start_late_get_less():
    line = shapes.grid(11)
    early = extended(line, [0, 120], [1, 2])
    late = extended(line, gt.OffsetSources([0, 120], [0.0, 0.5]), [1, 2])
    assert (late == 2).sum() < (early == 2).sum()


def test_along_a_straight_curve_values_are_linear():
    plate = irregular_plate(25)
    curve = gt.Curve([[0.0, 0.5, 0.0], [0.5, 0.5, 0.0], [1.0, 0.5, 0.0]])
    got = extended(plate, curve, [0.0, 1.0, 4.0])
    x = plate.vertices[:, 0]
    off = np.abs(got - np.interp(x, [0, 0.5, 1], [0.0, 1.0, 4.0]))
    assert off.mean() < 0.03
    assert off.max() < 0.4  # beside the end, where fronts are circles
    nearest = extended(plate, curve, [10, 20, 30])
    inside = (np.abs(x - 0.25) > 0.02) & (np.abs(x - 0.75) > 0.02)
    want = np.select([x < 0.25, x < 0.75], [10, 20], 30)
    np.testing.assert_array_equal(nearest[inside], want[inside])


def test_beyond_the_ends_of_a_curve_values_are_those_of_the_ends():
    plate = irregular_plate(25)
    got = extended(plate, gt.Curve([[0.3, 0.5, 0.0], [0.7, 0.5, 0.0]]), [0.0, 1.0])
    x = plate.vertices[:, 0]
    off = np.abs(got - np.clip((x - 0.3) / 0.4, 0, 1))
    assert np.median(off) < 0.02
    assert off.max() < 0.3


def test_around_a_closed_curve_values_come_back():
    turn = 2 * np.pi * np.arange(60) / 60
    circle = 0.7 * np.column_stack([np.cos(turn), np.sin(turn), np.zeros(60)])
    circle = np.column_stack([circle[:, :2], np.full(60, np.sqrt(1 - 0.49))])
    got = extended(
        SPHERE, gt.Curve(circle, closed=True), np.column_stack([np.cos(turn), np.sin(turn)])
    )
    x, y, z = SPHERE.vertices.T
    far = np.abs(z) < 0.98
    size = np.hypot(x, y)[far]
    off = np.hypot(got[far, 0] - x[far] / size, got[far, 1] - y[far] / size)
    assert off.mean() < 0.02


def test_along_surface_points_too():
    plate = irregular_plate(15)
    solver = gt.GeodesicSolver(plate)
    path = gt.geodesic_path(solver, 0, 224)
    values = np.linspace(0.0, 1.0, len(path.surface_points))
    got = gt.extend(solver, gt.Curve(path.surface_points), values, refine=True)
    assert np.isfinite(got).all()
    assert got.min() >= 0.0
    assert got.max() <= 1.0


def test_plain_values_are_a_ramp():
    solver = gt.GeodesicSolver(SPHERE, refine=False)
    got = gt.extend(solver, [0, 700], [0, 1])
    assert got.dtype == np.float64
    assert ((got > 0.01) & (got < 0.99)).any()
    along = gt.extend(solver, gt.Curve([[1.0, 0, 0], [0.0, 1, 0]]), [2.0, 3.0])
    assert along.min() >= 2.0 - 1e-9
    assert along.max() <= 3.0 + 1e-9


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ([1.0], "values must have shape"),
        (np.zeros((6, 2, 2)), "values must have shape"),
        (["a"] * 6, "real numbers"),
        ([1.0, 2, 3, 4, 5, np.nan], "value 5 is not finite"),
        ([[1.0], [2.0, 3.0]], "cannot be read as an array"),
    ],
)
def test_values_that_do_not_fit_are_named(values, message):
    with pytest.raises(InvalidOptionError, match=message):
        extended(SPHERE, SITES, values)


def test_labels_on_a_graph_take_another_way():
    with pytest.raises(UnsupportedDomainError, match="an edge has no angle"):
        extended(gt.Graph(2, [[0, 1]]), [0], [1])
