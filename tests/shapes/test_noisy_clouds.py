"""Noise on point clouds: where distances become unreliable, and the warning there."""

import numpy as np
import pytest
from sample_shapes import random_sphere

import geodesic_toolkit as gt
from geodesic_toolkit.errors import FragmentedCloudWarning, NoisyCloudWarning
from geodesic_toolkit.testing import shapes

PCA = gt.PointCloudLaplacian(normals="pca")


def roughness(cloud):
    return PCA.assemble(cloud).notes["roughness"]


def noisy_torus(noise):
    """Return a bumpy torus of 2,592 points with noise in all directions, in mean edge lengths."""
    rng = np.random.default_rng(0)
    mesh = shapes.bumpy_torus(rng=rng)
    spacing = gt.GeodesicSolver(mesh).method.metric.spacing
    return gt.PointCloud(mesh.vertices + noise * spacing * rng.normal(size=(mesh.n_vertices, 3)))


@pytest.mark.parametrize("noise", [0.0, 0.1, 0.3])
def test_noise_of_a_third_of_the_spacing_causes_no_warning(noise):
    assert roughness(noisy_torus(noise)) < 0.4


@pytest.mark.parametrize("noise", [0.7, 1.0, 2.0])
def test_noise_wider_than_half_of_the_spacing_causes_a_warning_with_the_cure(noise):
    with pytest.warns(NoisyCloudWarning, match=r"by 0\.\d\d of the width .* Smooth .* gt\.thin"):
        assert roughness(noisy_torus(noise)) > 0.5


def test_points_of_a_volume_are_not_a_surface():
    with pytest.warns(NoisyCloudWarning):
        roughness(gt.PointCloud(np.random.default_rng(0).random((2000, 3))))


def test_a_noisy_wire_is_not_a_noisy_surface():
    turn = np.linspace(0, 4, 1500)
    wire = np.column_stack([np.cos(turn), np.sin(turn), turn])
    wire += 0.0005 * np.random.default_rng(0).normal(size=wire.shape)
    assert roughness(gt.PointCloud(wire)) == 0


def test_given_normals_distinguish_two_sides_of_a_sheet_from_noise():
    flat = shapes.grid(30, spacing=1.0).vertices
    points = np.concatenate([flat, flat + np.array([0.5, 0.5, 1.0])])
    normals = np.repeat([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]], len(flat), axis=0)
    with pytest.warns(FragmentedCloudWarning):  # two sheets, and nothing else to warn of
        assert roughness(gt.PointCloud(points, normals)) < 1e-6


def test_thinning_reduces_the_noise_relative_to_the_spacing():
    rng = np.random.default_rng(0)
    sheet = gt.PointCloud(np.column_stack([rng.random((8000, 2)), 0.01 * rng.normal(size=8000)]))
    with pytest.warns(NoisyCloudWarning):
        roughness(sheet)
    assert roughness(gt.thin(sheet, 0.04).cloud) < 0.45


def test_normals_in_strong_noise_come_from_wide_neighbourhoods():
    points, true = random_sphere(4000, noise=0.9 * np.sqrt(4 * np.pi / 4000))
    with pytest.warns(NoisyCloudWarning):
        solver = gt.GeodesicSolver(gt.PointCloud(points), operator=PCA)
    normals = solver.method.metric.normals
    assert np.median(np.abs(np.einsum("nd,nd->n", normals, true))) > 0.98  # 11 degrees


@pytest.mark.parametrize("name", ["geomcentral__fox.ply", "igltut__octopus-low.mesh"])
def test_vertices_of_coarse_animals_are_too_few(shared_data, name):
    vertices = gt.read(shared_data(name)).vertices
    with pytest.warns(NoisyCloudWarning, match="too few for the shape"):
        roughness(gt.PointCloud(vertices))


@pytest.mark.parametrize("name", ["pcl__bun0.pcd", "pcldata__milk.pcd", "pcldata__samp11-utm.pcd"])
def test_scans_cause_no_warning(shared_data, name):
    assert roughness(gt.read(shared_data(name))) < 0.36
