"""Logarithmic maps, transport and labels on point clouds."""

import numpy as np
import pytest
from curved_shapes import degrees_between, irregular_sphere, transported_on_sphere
from geodesics import log_on_sphere

import geodesic_toolkit as gt

POINTS = irregular_sphere(2000).vertices
SOLVER = gt.GeodesicSolver(gt.PointCloud(POINTS))


def test_logarithms_of_a_sphere_are_those_of_a_mesh():
    found = gt.log_map(SOLVER, 0)
    want = log_on_sphere(POINTS, 0)
    near = (found.distance > 0) & (found.distance < 2.5)
    assert degrees_between(found.vectors[near], want[near]).mean() < 0.3
    length = np.linalg.norm(want[near], axis=1)
    assert np.abs(found.distance[near] / length - 1).mean() < 1e-3


def test_vectors_are_carried_along_great_circles():
    frames = gt.tangent_frames(SOLVER)
    vector = frames.x_axes[0]
    got = gt.parallel_transport(SOLVER, 0, vector)
    want = transported_on_sphere(POINTS, 0, vector)
    near = POINTS @ POINTS[0] > np.cos(2.5)
    assert degrees_between(got[near], want[near]).mean() < 1.5


def test_labels_are_those_of_the_nearest_point():
    sites = [3, 500, 1200]
    labels = gt.extend(SOLVER, sites, [0, 1, 2])
    want = (POINTS @ POINTS[sites].T).argmax(axis=1)
    assert (labels != want).mean() < 0.02


@pytest.mark.parametrize("noise", [0.1, 0.25])
def test_noise_turns_angles_by_degrees_only(noise):
    rng = np.random.default_rng(0)
    spacing = np.sqrt(4 * np.pi / len(POINTS))
    noisy = POINTS * (1 + noise * spacing * rng.normal(size=(len(POINTS), 1)))
    found = gt.log_map(gt.GeodesicSolver(gt.PointCloud(noisy)), 0)
    want = log_on_sphere(POINTS, 0)
    near = (found.distance > 0.3) & (found.distance < 2.5)
    frame = found.frame
    angle = np.arctan2(*(want[near] @ frame.T).T[::-1])
    off = np.angle(np.exp(1j * (found.angle[near] - angle)))
    assert np.degrees(np.abs(off - np.median(off))).mean() < 6.0


def test_lifted_points_beside_a_source_do_not_turn_directions():
    rng = np.random.default_rng(0)
    spacing = np.sqrt(4 * np.pi / len(POINTS))
    noisy = POINTS * (1 + 0.25 * spacing * rng.normal(size=(len(POINTS), 1)))
    noisy = np.concatenate([noisy, noisy[:9], [[np.nan] * 3]])
    solver = gt.GeodesicSolver(gt.PointCloud(noisy))
    for source in (0, 600, 1400, 1560):
        found, want = gt.log_map(solver, source), log_on_sphere(POINTS, source)
        got = found.coordinates[: len(POINTS)] @ [1, 1j]
        beside = np.flatnonzero((got != 0) & (np.linalg.norm(want, axis=1) < 3 * spacing))
        off = np.angle(got[beside] / (want[beside] @ found.frame.T @ [1, 1j]))
        assert np.degrees(np.abs(off)).mean() < 1.5  # 10 to 13 degrees by the stars alone


def test_points_that_are_there_twice_or_missing_do_no_harm():
    points = np.concatenate([POINTS[:600], POINTS[:5], [[np.nan] * 3]])
    solver = gt.GeodesicSolver(gt.PointCloud(points))
    found = gt.log_map(solver, 300)
    np.testing.assert_allclose(found.distance[600:605], found.distance[:5], atol=0.2)
    assert np.isinf(found.distance[605])
    assert np.isnan(found.angle[605])
    assert np.isfinite(found.angle[:600]).all()
