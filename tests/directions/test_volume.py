"""Signed distance in a volume, from surfaces with holes and from oriented clouds."""

import numpy as np
import pytest
from curved_shapes import irregular_sphere

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError

SPHERE = irregular_sphere(1500)


def errors(volume):
    """The errors in cells, and the exact distance from the unit sphere in cells."""
    cells = np.moveaxis(np.indices(volume.values.shape), 0, -1)
    exact = np.linalg.norm(volume.origin + volume.spacing * cells, axis=-1) - 1
    return (volume.values - exact) / volume.spacing, exact / volume.spacing


@pytest.mark.parametrize("kind", ["mesh", "cloud", "with holes"])
def test_from_a_sphere(kind):
    shape = SPHERE
    if kind == "cloud":
        shape = gt.PointCloud(SPHERE.vertices, normals=SPHERE.vertices)
    if kind == "with holes":
        centres = SPHERE.vertices[SPHERE.faces].mean(axis=1)
        holes = np.linalg.norm(centres[:, None] - np.eye(3), axis=2).min(axis=1) < 0.3
        shape = gt.TriangleMesh(SPHERE.vertices, SPHERE.faces[~holes])
    off, exact = errors(gt.signed_distance_volume(shape, resolution=24))
    assert np.abs(off).mean() < 0.3
    assert ((off + exact) * exact < 0)[np.abs(exact) > 1].mean() < 0.002


def test_faces_turned_over_have_the_opposite_sign():
    inward = gt.TriangleMesh(SPHERE.vertices, SPHERE.faces[:, ::-1])
    one, other = (gt.signed_distance_volume(m, resolution=12) for m in (SPHERE, inward))
    np.testing.assert_allclose(one.values, -other.values, atol=1e-9)


def test_scaled_and_shifted_it_is_the_same():
    far = gt.TriangleMesh(1e-3 * SPHERE.vertices + 5.0, SPHERE.faces)
    one, other = (gt.signed_distance_volume(m, resolution=12) for m in (SPHERE, far))
    np.testing.assert_allclose(1e3 * other.values, one.values, atol=1e-6)


@pytest.mark.parametrize("resolution", [3, 2.5, "fine", True])
def test_a_resolution_is_a_whole_number(resolution):
    with pytest.raises(InvalidOptionError, match="whole number of 4 or more"):
        gt.signed_distance_volume(SPHERE, resolution=resolution)


def test_what_has_no_sides_in_space_is_refused():
    with pytest.raises(UnsupportedDomainError, match="PointCloud without normals has no sides"):
        gt.signed_distance_volume(gt.PointCloud(SPHERE.vertices))
    with pytest.raises(UnsupportedDomainError, match="a Graph has no sides"):
        gt.signed_distance_volume(gt.Graph(2, [[0, 1]]))
    with pytest.raises(UnsupportedDomainError, match="single place"):
        gt.signed_distance_volume(gt.TriangleMesh(np.ones((3, 3)), [[0, 1, 2]]))
    line = gt.TriangleMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])
    with pytest.raises(UnsupportedDomainError, match="no area"):
        gt.signed_distance_volume(line)
