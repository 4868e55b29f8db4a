"""Thinned clouds: what is kept, and distances carried back to all that was there."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

import geodesic_toolkit as gt
from geodesic_toolkit.analysis import thinning
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    UnsupportedDomainError,
)
from geodesic_toolkit.testing import shapes


def plane(n=8000, noise=0.0, seed=0):
    """Random points of the unit square, and their distances from the first, in the middle."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(0, 1, (n, 3)) * [1, 1, 0]
    points[0] = [0.5, 0.5, 0]
    exact = np.linalg.norm(points - points[0], axis=1)
    points[1:, 2] = noise * rng.normal(size=n - 1)
    return points, exact


def sphere(n=8000, noise=0.0, seed=0):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    exact = np.arccos(np.clip(points @ points[0], -1, 1))
    return points * (1 + noise * rng.normal(size=(n, 1))), exact


@pytest.fixture(scope="module")
def flat():
    points, exact = plane()
    thinned = gt.thin(gt.PointCloud(points), 0.06, keep=0)
    return thinned, gt.GeodesicSolver(thinned.cloud), exact


@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_points_are_the_spacing_apart_and_leave_no_gap(data):
    rng = np.random.default_rng(data.draw(st.integers(0, 99)))
    flatness = data.draw(st.sampled_from([1.0, 0.1, 0.0]))
    points = rng.uniform(-1, 1, (data.draw(st.integers(2, 600)), 3)) * [1, 1, flatness]
    points += data.draw(st.sampled_from([0.0, 5e5]))
    spacing = data.draw(st.floats(0.01, 0.9)) * np.ptp(points, axis=0).max()
    thinned = gt.thin(gt.PointCloud(points), spacing)
    tree = cKDTree(thinned.cloud.points)
    if thinned.cloud.n_vertices > 1:
        assert tree.query(thinned.cloud.points, k=2)[0][:, 1].min() >= spacing * (1 - 1e-12)
    assert tree.query(points)[0].max() <= spacing
    np.testing.assert_array_equal(thinned.cloud.points, points[thinned.index])
    assert (np.diff(thinned.index) > 0).all()


def test_the_same_cloud_gives_the_same_points_whatever_its_unit():
    points, _ = plane(2000)
    first = gt.thin(gt.PointCloud(points), 0.1).index
    np.testing.assert_array_equal(gt.thin(gt.PointCloud(points), 0.1).index, first)
    np.testing.assert_array_equal(gt.thin(gt.PointCloud(points * 2**20), 0.1 * 2**20).index, first)


def test_lookups_in_batches_change_nothing(monkeypatch):
    points, _ = plane(2000)
    whole = gt.thin(gt.PointCloud(points), 0.1).index
    monkeypatch.setattr(thinning, "POINTS_PER_BATCH", 97)
    np.testing.assert_array_equal(gt.thin(gt.PointCloud(points), 0.1).index, whole)


def test_what_must_stay_stays_however_close():
    points, _ = plane(2000)
    near = np.argsort(np.linalg.norm(points - points[0], axis=1))[:5]
    thinned = gt.thin(gt.PointCloud(points), 0.1, keep=near)
    np.testing.assert_array_equal(thinned.index[thinned.vertices_of(near)], near)
    others = np.setdiff1d(thinned.index, near)
    assert cKDTree(points[near]).query(points[others])[0].min() >= 0.1


def test_normals_and_missing_points_go_along():
    points, _ = plane(2000)
    points[[3, 500]] = np.nan
    normals = np.random.default_rng(1).normal(size=(2000, 3))
    cloud = gt.PointCloud(points, normals)
    thinned = gt.thin(cloud, 0.1)
    assert thinned.cloud.present.all()
    np.testing.assert_allclose(thinned.cloud.normals, cloud.normals[thinned.index], atol=1e-15)
    distance = thinned.carry_back(gt.GeodesicSolver(thinned.cloud).distance(0))
    np.testing.assert_array_equal(np.isinf(distance), ~cloud.present)


def test_repeated_points_are_one():
    points = np.repeat(shapes.grid(5).vertices, 3, axis=0)
    assert gt.thin(gt.PointCloud(points), 0.1).cloud.n_vertices == 25
    assert gt.thin(gt.PointCloud(points[:3]), 0.1).cloud.n_vertices == 1


# -- the way back ----------------------------------------------------------------------------------


def test_distances_on_a_plane_come_back(flat):
    thinned, solver, exact = flat
    assert thinned.cloud.n_vertices < 300
    source = thinned.vertices_of(0)
    kept = solver.distance(source)
    found = thinned.carry_back(kept, solver, sources=source)
    np.testing.assert_array_equal(found[thinned.index], kept)
    inside = np.abs(thinned.full.points[:, :2] - 0.5).max(axis=1) < 0.5 - 0.06
    error = np.abs(found - exact)
    assert error[inside].max() < 0.1 * 0.06  # of interpolation, five edges from the source
    assert error.max() < 0.06  # beside the outermost points that were kept


@pytest.mark.parametrize(
    ("points", "spacing", "bound"),
    [
        (sphere(), 0.1, 0.003),
        (sphere(noise=0.01), 0.1, 0.008),
        (plane(noise=0.005), 0.06, 0.01),
    ],
    ids=["sphere", "noisy sphere", "noisy plane"],
)
def test_distances_carried_back_are_as_accurate_as_on_the_thinned_cloud(points, spacing, bound):
    points, exact = points
    thinned = gt.thin(gt.PointCloud(points), spacing, keep=0)
    solver = gt.GeodesicSolver(thinned.cloud)
    source = thinned.vertices_of(0)
    found = thinned.carry_back(solver.distance(source), solver, sources=source)
    far = exact > 2 * spacing
    assert np.mean(np.abs(found - exact)[far] / exact[far]) < bound
    assert np.abs(found - exact)[~far].max() < 0.3 * spacing


def test_without_a_solver_the_triangles_are_made_once(flat, monkeypatch):
    thinned, solver, _ = flat
    height = thinned.cloud.points @ [1.0, 2.0, 0.0]
    expected = thinned.carry_back(height, solver)
    again = pickle.loads(pickle.dumps(thinned))
    np.testing.assert_allclose(again.carry_back(height), expected, atol=1e-12)
    monkeypatch.setattr(gt.PointCloudLaplacian, "assemble", lambda *_: pytest.fail("again"))
    np.testing.assert_allclose(again.carry_back(height), expected, atol=1e-12)


def test_many_fields_come_back_row_by_row(flat):
    thinned, solver, _ = flat
    rows = solver.distances([0, 5, 9])
    seen = []
    found = thinned.carry_back(rows, solver, progress=lambda *counts: seen.append(counts))
    for row, expected in zip(found, rows, strict=True):
        np.testing.assert_array_equal(row, thinned.carry_back(expected, solver))
    rest = thinned.full.n_vertices - thinned.cloud.n_vertices
    assert seen == [(rest, rest)] * 3


def test_what_is_not_reached_stays_so():
    points, _ = plane(1500)
    two = gt.PointCloud(np.concatenate([points, np.add(points, [3, 0, 0]), [[9.0, 9, 9]]]))
    thinned = gt.thin(two, 0.1, keep=0)
    solver = gt.GeodesicSolver(thinned.cloud)
    found = thinned.carry_back(solver.distance(thinned.vertices_of(0)), solver)
    np.testing.assert_array_equal(np.isfinite(found), np.arange(3001) < 1500)


# -- what cannot be --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("spacing", "message"),
    [
        (0, "positive and finite"),
        (-1.0, "positive and finite"),
        (np.nan, "positive and finite"),
        (np.inf, "positive and finite"),
        ("wide", "must be a length"),
        (True, "must be a length"),
        (7.0, "leaves nothing of its shape; are the units the same"),
        (1e-13, "leaves all points; are the units the same"),
    ],
)
def test_a_spacing_that_is_none_is_refused(spacing, message):
    with pytest.raises(InvalidOptionError, match=message):
        gt.thin(gt.PointCloud(plane(100)[0]), spacing)


def test_points_to_keep_must_be_there():
    points, _ = plane(100)
    points[3] = np.nan
    cloud = gt.PointCloud(points)
    with pytest.raises(InvalidSourceError, match="keep: vertex 100 does not exist"):
        gt.thin(cloud, 0.1, keep=100)
    with pytest.raises(InvalidSourceError, match="keep: point 3 of the cloud is missing"):
        gt.thin(cloud, 0.1, keep=[2, 3])


def test_a_mesh_is_not_thinned():
    with pytest.raises(UnsupportedDomainError, match="not a TriangleMesh"):
        gt.thin(shapes.grid(4), 0.1)


def test_a_point_that_was_not_kept_is_named(flat):
    thinned, _, _ = flat
    lost = int(np.setdiff1d(np.arange(50), thinned.index)[0])
    with pytest.raises(InvalidSourceError, match=rf"point {lost} was not kept: .*keep=\[{lost}\]"):
        thinned.vertices_of([0, lost])
    with pytest.raises(InvalidSourceError, match="points: vertex 8000 does not exist"):
        thinned.vertices_of(8000)


def test_distances_and_solvers_must_be_of_the_thinned_cloud(flat):
    thinned, solver, _ = flat
    with pytest.raises(InvalidOptionError, match=r"one number for each point that was kept"):
        thinned.carry_back(np.zeros(8000), solver)
    with pytest.raises(InvalidOptionError, match="the solver is of another shape"):
        thinned.carry_back(np.zeros(thinned.cloud.n_vertices), gt.GeodesicSolver(shapes.grid(4)))
    with pytest.raises(InvalidOptionError, match="sources need their solver"):
        thinned.carry_back(np.zeros(thinned.cloud.n_vertices), sources=0)
