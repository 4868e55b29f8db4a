"""Distances inside voxels against closed forms."""

import pickle
import re

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidDomainError, InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit_volume import VoxelImage, VoxelLaplacian

ALL = np.ones((12, 10, 8), dtype=bool)


def mean_error(found, exact):
    far = exact > 0
    return float(np.mean(np.abs(found[far] / exact[far] - 1)))


@pytest.mark.parametrize("spacing", [(1.0, 1.0, 1.0), (0.5, 1.0, 3.0)])
def test_in_a_box_distances_are_straight_whatever_the_spacing(spacing):
    image = VoxelImage(ALL, spacing)
    for source in (0, 333):
        straight = np.linalg.norm(image.positions - image.positions[source], axis=1)
        assert mean_error(gt.GeodesicSolver(image).distance(source), straight) < 0.001


def test_a_point_between_centres_is_a_source():
    image, place = VoxelImage(ALL), np.array([4.3, 5.1, 2.2])
    straight = np.linalg.norm(image.positions - place, axis=1)
    assert mean_error(gt.GeodesicSolver(image).distance(place), straight) < 0.002


def test_an_image_of_two_axes_is_a_sheet():
    image = VoxelImage(np.ones((20, 15), dtype=bool), (1.0, 2.0))
    distance = gt.GeodesicSolver(image).distance(0).reshape(image.shape)
    assert distance[3, 2] == pytest.approx(5.0)


def test_the_second_order_shows_where_speed_is_linear():
    errors = []
    for n in (11, 21, 41):
        x = np.linspace(0, 1, n)
        speed = (0.5 + 2 * x)[:, None, None] * np.ones((n, 5, n))
        image = VoxelImage(np.ones((n, 5, n), dtype=bool), [1 / (n - 1)] * 3, 1 / speed)
        source = int(np.ravel_multi_index((n // 2, 2, n // 2), image.shape))
        flat = speed.ravel()
        squared = ((image.positions - image.positions[source]) ** 2).sum(axis=1)
        exact = np.arccosh(1 + 4 * squared / (2 * flat * flat[source])) / 2
        errors.append(mean_error(gt.GeodesicSolver(image).distance(source), exact))
    assert errors[2] < 0.005
    assert errors[2] < 0.5 * errors[1] < 0.3 * errors[0]


def test_paths_surround_a_wall():
    mask = np.ones((21, 21, 5), dtype=bool)
    mask[10, :15] = False
    image = VoxelImage(mask)
    source = int(np.ravel_multi_index((5, 5, 2), mask.shape))
    distance = gt.GeodesicSolver(image).distance(source).reshape(mask.shape)
    around = 2 * np.hypot(4.5, 9.5) + 1  # by the corners of the wall, which voxels keep away from
    assert around <= distance[15, 5, 2] <= 1.08 * around
    assert np.isinf(distance[10, 3, 2])


def test_parts_are_infinitely_far_and_masks_cut():
    image = VoxelImage(ALL)
    wall = np.zeros(ALL.shape, dtype=bool)
    wall[5] = True
    distance = gt.GeodesicSolver(image, mask=wall.ravel()).distance(0).reshape(image.shape)
    assert np.isfinite(distance[:5]).all()
    assert np.isinf(distance[5:]).all()


def test_costs_scale_distances_and_their_offsets_do_not():
    image, twice = VoxelImage(ALL), VoxelImage(ALL, costs=np.full(ALL.shape, 2.0))
    one, two = gt.GeodesicSolver(image), gt.GeodesicSolver(twice)
    place = [4.3, 5.1, 2.2]
    np.testing.assert_allclose(two.distance(place), 2 * one.distance(place), rtol=1e-9)
    shifted = gt.OffsetSources([7], [3.0])
    np.testing.assert_allclose(two.distance(shifted), 2 * one.distance(7) + 3, rtol=1e-9)


def test_an_affine_gives_positions_and_sides():
    affine = np.diag([-2.0, 1.0, 0.5, 1.0])
    affine[:3, 3] = [10, 20, 30]
    image = VoxelImage(ALL, affine=affine)
    assert image.spacing == (2.0, 1.0, 0.5)
    assert image.positions[-1].tolist() == [-12.0, 29.0, 33.5]
    at = image.closest(np.array([[9.0, 20.5, 30.25]]))
    np.testing.assert_allclose(at.positions(image), [[9.0, 20.5, 30.25]])


def test_heat_on_voxels_is_left_to_refine_false():
    image = VoxelImage(ALL)
    straight = np.linalg.norm(image.positions - image.positions[333], axis=1)
    assert mean_error(gt.GeodesicSolver(image, refine=False).distance(333), straight) < 0.15


def test_a_solver_that_was_pickled_gives_the_same():
    solver = gt.GeodesicSolver(VoxelImage(ALL))
    again = pickle.loads(pickle.dumps(solver))
    np.testing.assert_array_equal(again.distance(0), solver.distance(0))


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        ((np.ones((2, 2, 2)),), {}, "mask must be booleans"),
        ((np.ones(3, dtype=bool),), {}, "it must be (X, Y, Z) or (X, Y)"),
        ((np.zeros((2, 2, 2), dtype=bool),), {}, "0 voxels in the body"),
        ((ALL, (1.0, 2.0)), {}, "spacing must have shape (3,)"),
        ((ALL, (1.0, 2.0, 0.0)), {}, "it must be positive"),
        ((ALL, (1.0, np.nan, 1.0)), {}, "it must be positive"),
        ((ALL, (1.0, np.inf, 1.0)), {}, "positive and finite"),
        (([[True], [True, False]],), {}, "mask cannot be read as an array"),
        ((np.ma.array(ALL, mask=ALL),), {}, "mask is a masked array"),
        ((ALL, None, -np.ones(ALL.shape)), {}, "voxel 0, 0, 0 has the cost -1.0"),
        ((ALL, (1.0, 1.0, 1.0)), {"affine": np.eye(4)}, "spacing or affine, not both"),
        ((ALL,), {"affine": np.triu(np.ones((4, 4)))}, "not at right angles"),
        ((ALL,), {"affine": np.zeros((4, 4))}, "sides of a voxel"),
    ],
)
def test_arrays_that_are_not_an_image_are_refused(arguments, options, message):
    with pytest.raises(InvalidDomainError, match=re.escape(message)):
        VoxelImage(*arguments, **options)


def test_a_lone_voxel_and_a_mask_of_everything_are_refused():
    with pytest.raises(UnsupportedDomainError, match="no two voxels"):
        VoxelLaplacian().assemble(VoxelImage(np.ones((1, 1, 1), dtype=bool)))
    with pytest.raises(InvalidOptionError, match="leaves no voxel"):
        VoxelImage(ALL).without(np.ones(ALL.size, dtype=bool))


def test_a_click_on_the_page_is_a_voxel_at_the_front():
    from geodesic_toolkit.viz.live.session import Session

    body = ALL.copy()
    body[:, :, -1] = False
    image = VoxelImage(body)
    session = Session(image)
    for x, y in ((3.0, 4.0), (3.4, 4.4), (3.5, 4.5)):  # on a centre, and between centres
        above = (np.array([x, y, 50.0]) - session.scene.centre) / session.scene.radius
        session.click(session.pick(above, [0.0, 0.0, -1.0]))
        place = image.positions[session.sources[0].vertices[0]]
        assert np.abs(place - [x, y, 6.0]).max() <= 0.5
    assert np.isfinite(session.distances).sum() == body.sum()
    assert session.sizes == [body.sum()]
