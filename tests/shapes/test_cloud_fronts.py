"""Do refined distances on clouds know the surface: its lengths, its curvature, its holes?"""

import dataclasses

import numpy as np
import pytest
from closed_forms import mean_relative_error
from sample_shapes import angles_from, random_sphere

import geodesic_toolkit as gt
from geodesic_toolkit import _native
from geodesic_toolkit.errors import InvalidDiscretizationError
from geodesic_toolkit.laplacians.pointcloud.neighbours import nearest_neighbours
from geodesic_toolkit.laplacians.pointcloud.stars import delaunay_stars
from geodesic_toolkit.refinement.wavefronts import WavefrontSweeper
from geodesic_toolkit.testing import shapes

PCA = gt.PointCloudLaplacian(normals="pca")


def sphere_and_angles(count, noise=0.0, radius=1.0):
    """Return noisy points of a sphere, and the true distances from the first."""
    points, true = random_sphere(count, noise)
    return radius * points, radius * angles_from(true, 0)


def refined(points, normals=None):
    return gt.GeodesicSolver(gt.PointCloud(points, normals), operator=PCA, refine=True)


def sweeper_of(points):
    return WavefrontSweeper(PCA.assemble(gt.PointCloud(points)))


# -- lengths and curvature -------------------------------------------------------------------------


@pytest.mark.slow
def test_on_smooth_random_clouds_it_is_nearly_second_order():
    errors = []
    for count in (1000, 4000, 16_000):
        points, true = sphere_and_angles(count)
        errors.append(mean_relative_error(refined(points).distance(0), true))
    assert errors[0] > 3 * errors[1] > 9 * errors[2]
    assert errors[2] < 2e-4


@pytest.mark.parametrize(("noise", "bound"), [(0.001, 0.002), (0.002, 0.003), (0.004, 0.004)])
def test_a_little_noise_costs_little(noise, bound):
    points, true = sphere_and_angles(4000, noise)  # a spacing is 0.06
    assert mean_relative_error(refined(points).distance(0), true) < bound


def test_smooth_clouds_are_measured_in_space():
    points, _ = sphere_and_angles(1000, radius=30.0)
    corners = sweeper_of(points)._corners
    for v in range(0, 1000, 50):
        own = slice(corners.starts[v], corners.ends[v])
        a, b = corners.a[own], corners.b[own]
        for other, length in ((a, corners.to_a), (b, corners.to_b)):
            space = np.linalg.norm(points[other] - points[v], axis=1)
            np.testing.assert_allclose(length[own], space, rtol=1e-9)
        space = np.linalg.norm(points[a] - points[b], axis=1)
        np.testing.assert_allclose(corners.edge[own], space, rtol=1e-9)


@pytest.mark.parametrize("radius", [1.0, 30.0])
def test_the_curvature_of_a_sphere_is_found(radius):
    points, _ = sphere_and_angles(4000, radius=radius)
    curvature = sweeper_of(points)._curvature * radius**2
    assert np.median(curvature) == pytest.approx(1, rel=0.05)
    assert np.percentile(np.abs(curvature - 1), 90) < 0.2


def test_a_plane_has_none_at_its_edges_either():
    curvature = sweeper_of(shapes.grid(15).vertices)._curvature
    np.testing.assert_allclose(curvature, 0, atol=1e-6)


def test_planes_are_smooth_however_they_lie():
    plane = shapes.grid(25).vertices @ np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    sweeper = sweeper_of(plane)
    flat = sweeper.metric.gradient.inverse_frames
    assert len(sweeper.metric.surface_frames) == len(flat)
    np.testing.assert_allclose(sweeper.metric.surface_frames, flat, rtol=1e-6, atol=1e-4)


def test_noisy_clouds_are_measured_in_their_tangent_planes():
    points, _ = sphere_and_angles(4000, noise=0.01)
    sweeper = sweeper_of(points)
    assert len(sweeper.metric.surface_frames) == 0
    np.testing.assert_array_equal(sweeper._curvature, 0)


def test_between_smooth_and_noisy_edges_are_between_both():
    points, _ = sphere_and_angles(4000, noise=0.0025)
    metric = PCA.assemble(gt.PointCloud(points))
    plane = dataclasses.replace(metric, surface_frames=np.zeros((0, 3)))
    first, second = WavefrontSweeper(metric)._corners, WavefrontSweeper(plane)._corners
    starts, ends = second.starts, second.ends
    own = np.concatenate([np.arange(s, e) for s, e in zip(starts, ends, strict=False)])
    vertex = np.repeat(np.arange(len(points)), ends - starts[:-1])
    np.testing.assert_array_equal(first.a[own], second.a[own])
    space = np.linalg.norm(points[first.a[own]] - points[vertex], axis=1)
    between, flat = first.to_a[own], second.to_a[own]
    assert (between >= flat * (1 - 1e-9)).all()
    assert (between <= space * (1 + 1e-9)).all()
    assert flat.sum() < between.sum() < space.sum()


# -- which triangles -------------------------------------------------------------------------------


def test_a_vertex_gets_the_triangles_that_both_others_have():
    own, bridge, missed, known = [(1, 2), (2, 3)], (4, 5), (3, 1), (2, 1)
    others = [bridge, known, missed, known, missed[::-1]]
    stars = np.array([(0, a, b) for a, b in own] + [(a, b, 0) for a, b in others])
    frames = np.tile([1.0, 0.0, 1.0], (len(stars), 1))
    for told, heard in ((False, [(1, 2), (2, 3)]), (True, [(1, 2), (2, 3), (1, 3)])):
        corners = _native.gather_corners(stars, frames, True, told, np.zeros(6, dtype=bool))
        pairs = np.sort(np.column_stack([corners.a, corners.b])[: corners.starts[1]], axis=1)
        pairs = [(int(a), int(b)) for a, b in pairs]
        assert corners.ends[0] == len(heard)
        assert pairs[: len(heard)] == heard
        assert sorted(pairs) == sorted([(1, 2), (2, 3), (4, 5), (1, 2), (1, 3), (1, 2), (1, 3)])


@pytest.mark.parametrize(
    ("height", "k", "smooth", "found"),
    [(1.5, 14, True, True), (2.4, 14, True, False), (2.4, 15, True, True), (2.4, 14, False, True)],
    ids=["near its sheet", "far off it", "but among the nearest", "but in noise"],
)
def test_a_star_that_looks_past_its_nearest_keeps_to_its_sheet(height, k, smooth, found):
    behind = [(x, y, 0.0) for x in (0.0, -1.0, -2.0) for y in (-2.0, -1.0, 0.0, 1.0, 2.0)]
    behind.remove((0.0, 0.0, 0.0))
    points = np.array([(0.0, 0.0, 0.0), *behind, (4.0, 0.1, height)])
    normals = np.tile([0.0, 0.0, 1.0], (16, 1))
    near = nearest_neighbours(points, 15)
    triangles, _, is_open = delaunay_stars(
        points, normals, near, k=k, oriented=False, smooth=smooth
    )
    assert is_open[0] != found
    assert (15 in triangles[triangles[:, 0] == 0]) == found


# -- refusals --------------------------------------------------------------------------------------


def test_surface_frames_are_those_of_stars():
    metric = gt.CotanLaplacian().assemble(shapes.icosphere(1))
    with pytest.raises(InvalidDiscretizationError, match=r"surface_frames \(80, 3\).*of the stars"):
        dataclasses.replace(metric, surface_frames=np.ones((80, 3)))


def test_surface_frames_are_one_for_each_element():
    metric = PCA.assemble(gt.PointCloud(shapes.icosphere(2).vertices))
    with pytest.raises(InvalidDiscretizationError, match=r"surface_frames \(5, 3\)"):
        dataclasses.replace(metric, surface_frames=np.ones((5, 3)))


def test_surface_frames_are_finite():
    metric = PCA.assemble(gt.PointCloud(shapes.icosphere(2).vertices))
    frames = metric.surface_frames.copy()
    frames[7, 1] = np.nan
    with pytest.raises(InvalidDiscretizationError, match="element 7 is not finite"):
        dataclasses.replace(metric, surface_frames=frames)
