"""Do charts of a surface give the distances of its triangles, and are bad charts refused?"""

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidDiscretizationError

CLOSE = 0.005
"""Mean relative error on 500 samples of a square: 0.1 % is measured."""


def square(count=500, k=24):
    """Return samples, their neighbours and where these lie in the chart of each."""
    points = np.random.default_rng(0).random((count, 2))
    steps = points[None] - points[:, None]
    near = np.linalg.norm(steps, axis=2).argsort()[:, 1 : k + 1]
    return points, near, np.take_along_axis(steps, near[:, :, None], 1)


def solve(metric, source):
    solver = {"heat_solver": gt.Supernodal(), "poisson_solver": gt.Supernodal()}
    diffusion = gt.positive_part(metric)
    return gt.HeatMethod(metric, diffusion=diffusion, refine=True, **solver).distance(source)


@pytest.mark.parametrize("in_space", [False, True])
def test_distances_on_a_square_are_straight(in_space):
    points, near, charts = square()
    positions = points if in_space else None
    metric = gt.discretization_of_charts(near, charts, n_vertices=500, positions=positions)
    truth = np.linalg.norm(points - points[3], axis=1)
    error = np.abs(solve(metric, 3) - truth)[truth > 0] / truth[truth > 0]
    assert error.mean() < CLOSE


def test_a_neighbour_on_another_sheet_is_in_no_triangle():
    _, near, charts = square()
    charts = np.where((near == 7)[:, :, None], np.nan, charts)
    metric = gt.discretization_of_charts(
        near[np.arange(500) != 7],
        charts[np.arange(500) != 7],
        centres=np.delete(np.arange(500), 7),
        n_vertices=500,
    )
    assert metric.mass[7] == 0
    assert np.isinf(solve(metric, 3)[7])


def test_a_link_connects_what_triangles_do_not():
    _, near, charts = square(200)
    metric = gt.discretization_of_charts(
        near,
        charts,
        centres=np.arange(200),
        n_vertices=201,
        links=np.array([[5, 200]]),
        link_lengths=np.array([0.25]),
    )
    found = solve(metric, 5)
    assert found[200] == pytest.approx(0.25)
    assert metric.notes["links"] == 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda near, charts: (near[:-1], charts), "must be"),
        (lambda near, charts: (near + 1, charts), "refers to vertex 500"),
        (lambda near, charts: (near, charts * np.nan), "neither triangles nor links"),
    ],
)
def test_charts_that_cannot_be_are_refused(change, message):
    _, near, charts = square()
    with pytest.raises(InvalidDiscretizationError, match=message):
        gt.discretization_of_charts(*change(near, charts), n_vertices=500)
