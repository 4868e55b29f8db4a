"""The options, and points that coincide, which the contract does not cover."""

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit_example import KernelLaplacian


@pytest.mark.parametrize("option", ["k", "width", "dim"])
def test_an_option_that_is_not_positive_is_refused(option):
    with pytest.raises(gt.errors.InvalidOptionError, match=option):
        KernelLaplacian(**{option: 0})


def test_points_that_are_all_one_place_are_refused():
    with pytest.raises(gt.errors.UnsupportedDomainError, match="one place"):
        KernelLaplacian().assemble(gt.PointCloud(np.ones((5, 3))))


def test_a_duplicate_is_as_far_as_the_point_that_it_repeats():
    points = gt.testing.shapes.icosphere(2).vertices
    twice = gt.PointCloud(np.concatenate([points, points]))
    distance = gt.geodesic_distance(twice, 3, operator="example")
    np.testing.assert_allclose(distance[len(points) :], distance[: len(points)], atol=1e-9)


def test_a_wider_neighbourhood_is_another_recipe():
    assert KernelLaplacian(k=20) != KernelLaplacian()
    assert repr(KernelLaplacian(k=20)) == "KernelLaplacian(k=20, width=0.7, dim=2)"
