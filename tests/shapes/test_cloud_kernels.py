"""Do stars and poles of clouds agree with a slow reference, and refuse what they must?"""

import numpy as np
import pytest
from sample_shapes import random_sphere
from scipy.spatial import Delaunay

from geodesic_toolkit import _native
from geodesic_toolkit.geometry.threads import threads_for
from geodesic_toolkit.laplacians.pointcloud.neighbours import nearest_neighbours
from geodesic_toolkit.laplacians.pointcloud.normals import pca_normals
from geodesic_toolkit.laplacians.pointcloud.poles import pole_normals
from geodesic_toolkit.laplacians.pointcloud.stars import delaunay_stars, tie_breakers
from geodesic_toolkit.testing import shapes


def upwards(count):
    return np.tile([0.0, 0.0, 1.0], (count, 1))


def stars_of(points, normals, *, k=20, widest=40, oriented=False, smooth=True):
    neighbours = nearest_neighbours(points, min(widest, len(points) - 1))
    return delaunay_stars(points, normals, neighbours, k=k, oriented=oriented, smooth=smooth)


def limb(count=2000, radius=0.5):
    """Return random points of a tube half as thick as its neighbourhoods, and its true normals."""
    rng = np.random.default_rng(0)
    angle = rng.uniform(0, 2 * np.pi, count)
    normals = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)])
    points = radius * normals
    points[:, 2] = rng.uniform(0, count / 4, count)
    return points, normals


# -- stars ---------------------------------------------------------------------------------------


def tangent_places(centre, normal, others, their_normals):
    """Return where neighbours lie in a tangent plane: their directions, their chords' lengths."""
    steps = others - centre
    helper = np.eye(3)[np.argmin(np.abs(normal))]
    u = np.cross(normal, helper)
    u /= np.linalg.norm(u)
    flat = np.column_stack([steps @ u, steps @ np.cross(normal, u)])
    turned = np.where((their_normals @ normal)[:, None] < 0, -their_normals, their_normals)
    mean = normal + turned
    rise = np.einsum("nd,nd->n", steps, mean) / np.linalg.norm(mean, axis=1)
    across = np.linalg.norm(flat, axis=1)
    chord = np.maximum(across, np.sqrt((steps**2).sum(axis=1) - rise**2))
    return flat * (chord / across)[:, None]


def reference_star(points, normals, neighbours, centre):
    """Return the star of a point as pairs of neighbours, in the whole triangulation of them all."""
    near = neighbours[centre]
    places = tangent_places(points[centre], normals[centre], points[near], normals[near])
    faces = Delaunay(np.concatenate([[[0.0, 0.0]], places])).simplices
    own = faces[(faces == 0).any(axis=1)]
    return {frozenset(near[face[face > 0] - 1].tolist()) for face in own}, places


@pytest.mark.parametrize("widest", [30, 40])
def test_stars_of_a_sphere_are_those_of_planar_triangulations(widest):
    points = random_sphere(1500)[1]
    neighbours = nearest_neighbours(points, widest)
    triangles, frames, is_open = stars_of(points, points, widest=widest)
    assert is_open.sum() < 20
    for centre in np.flatnonzero(~is_open)[::7].tolist():
        star, places = reference_star(points, points, neighbours, centre)
        own = triangles[:, 0] == centre
        assert {frozenset(pair.tolist()) for pair in triangles[own, 1:]} == star
        number = {point: place for place, point in enumerate(neighbours[centre].tolist())}
        first = places[[number[i] for i in triangles[own, 1].tolist()]]
        second = places[[number[i] for i in triangles[own, 2].tolist()]]
        length = np.linalg.norm(first, axis=1)
        across = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
        along = np.einsum("ed,ed->e", first, second)
        expected = np.column_stack([length, along / length, across / length])
        np.testing.assert_allclose(frames[own], expected, rtol=1e-9, atol=1e-12)


def test_closed_stars_of_a_plane_are_its_delaunay_triangles():
    points = np.column_stack([np.random.default_rng(3).random((500, 2)), np.zeros(500)])
    triangles, _, is_open = stars_of(points, upwards(500))
    plane = Delaunay(points[:, :2]).simplices
    true = {(centre, frozenset(face) - {centre}) for face in plane.tolist() for centre in face}
    found = {(centre, frozenset(pair)) for centre, *pair in triangles.tolist()}
    inside = set(np.flatnonzero(~is_open).tolist())
    assert len(inside) > 400
    assert {star for star in found if star[0] in inside} == {
        star for star in true if star[0] in inside
    }


def test_triangles_are_sorted_by_centre_and_run_around_its_normal():
    points = random_sphere(300)[1]
    triangles, _, _ = stars_of(points, points)
    assert (np.diff(triangles[:, 0]) >= 0).all()
    centre, second, third = points[triangles.T]
    turn = np.einsum("ed,ed->e", np.cross(second - centre, third - centre), centre)
    assert (turn > 0).all()


@pytest.mark.parametrize("turned", [False, True])
def test_stars_of_a_square_grid_have_the_same_triangles(turned):
    points = shapes.grid(20).vertices
    normals = upwards(len(points))
    if turned:
        rotation = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
        points, normals = points @ rotation, normals @ rotation
    triangles, _, is_open = stars_of(np.ascontiguousarray(points), np.ascontiguousarray(normals))
    assert is_open.sum() == 76
    inner = triangles[~is_open[triangles].any(axis=1)]
    _, times = np.unique(np.sort(inner, axis=1), axis=0, return_counts=True)
    assert (times == 3).all()


def test_points_at_45_degrees_exactly_are_on_the_sheet():
    angle = np.radians([0, 80, 140, 180, 220, 280])
    ring = np.column_stack([np.cos(angle), np.sin(angle), [1.0, 0, 0, 0, 0, 0]])
    points = np.concatenate([[[0.0, 0.0, 0.0]], ring]) / 3
    triangles, _, is_open = stars_of(points, upwards(7), k=6)
    assert not is_open[0]
    assert 1 in triangles[triangles[:, 0] == 0]


def test_a_point_of_one_neighbour_on_its_sheet_has_no_star():
    points = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.1, 0.0, 1.2)])
    triangles, frames, is_open = stars_of(points, upwards(4), k=3)
    assert 0 not in triangles[:, 0]
    assert is_open[0]
    assert triangles.shape[1] == frames.shape[1] == 3
    triangles, frames, is_open = stars_of(points[:2], upwards(2), k=1)
    assert triangles.shape == frames.shape == (0, 3)
    assert is_open.tolist() == [True, True]


def test_without_neighbours_there_are_no_stars():
    nothing = np.zeros((3, 0), dtype=np.int64)
    points = random_sphere(3)[1]
    triangles, frames, is_open = delaunay_stars(
        points, points, nothing, k=20, oriented=False, smooth=True
    )
    assert triangles.shape == frames.shape == (0, 3)
    assert is_open.all()
    np.testing.assert_array_equal(pole_normals(points, nothing, points), points)


def test_a_star_is_open_where_no_points_surround_its_centre():
    around = np.array(
        [(1.0, 0.0), (0.5, 0.9), (-0.6, 0.8), (-1.0, -0.1), (-0.4, -0.9), (0.6, -0.8)]
    )
    ring = np.column_stack([around, np.zeros(6)])
    closed = stars_of(np.concatenate([[[0.0, 0.0, 0.0]], ring]), upwards(7), k=6)
    half = stars_of(np.concatenate([[[0.0, 0.0, 0.0]], ring[:3]]), upwards(4), k=3)
    assert not closed[2][0]
    assert (closed[0][:, 0] == 0).sum() == 6
    assert half[2].all()
    assert (half[0][:, 0] == 0).sum() == 2


@pytest.mark.parametrize("bad", [0.0, np.nan, np.inf, 1e300])
def test_coordinates_that_make_no_sense_make_no_other_indices(bad):
    points = random_sphere(200)[1]
    points[::3] = bad
    neighbours = np.random.default_rng(0).integers(0, 200, (200, 30))
    triangles, _, _ = delaunay_stars(points, points, neighbours, k=10, oriented=True, smooth=False)
    assert ((triangles >= 0) & (triangles < 200)).all()
    assert pole_normals(points, neighbours, points).shape == (200, 3)


# -- poles ---------------------------------------------------------------------------------------


def directions(count):
    """Return unit vectors all around (Fibonacci's lattice)."""
    i = np.arange(count) + 0.5
    z, angle = 1 - 2 * i / count, np.pi * (1 + 5**0.5) * i
    radius = np.sqrt(1 - z**2)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])


@pytest.mark.slow
def test_poles_point_where_the_foremost_neighbour_is_least_ahead():
    points, _ = limb()
    neighbours = nearest_neighbours(points, 30)
    by_pca = pca_normals(points, neighbours[:, :12])
    poles = pole_normals(points, neighbours, by_pca)
    changed = np.flatnonzero((poles != by_pca).any(axis=1))
    assert len(changed) > 1000
    worse = []
    for point in changed:
        seen = points[neighbours[point]] - points[point]
        length = np.linalg.norm(seen, axis=1)
        images = seen * ((length[0] / length) ** 1.25 / length)[:, None]
        best = (images @ directions(5000).T).max(axis=0).min()
        worse.append((images @ poles[point]).max() - best)
    assert np.percentile(worse, 90) < 0.03  # the descent ends after some steps
    assert max(worse) < 0.3


def test_a_tip_points_away_from_its_neighbours():
    angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    rings = [
        np.column_stack([r * np.cos(angle), r * np.sin(angle), np.full(12, -r / 2)])
        for r in (0.1, 0.2, 0.3)
    ]
    points = np.concatenate([[[0.0, 0.0, 0.0]], *rings])
    normals = np.tile([1.0, 0.0, 0.0], (37, 1))
    result = pole_normals(points, nearest_neighbours(points, 30), normals)
    np.testing.assert_allclose(result[0], [0.0, 0.0, 1.0], atol=1e-12)


# -- threads and refusals ------------------------------------------------------------------------


@pytest.fixture(scope="module")
def cloud():
    """Points, normals, neighbours and weights of a cloud of several pieces, with thin parts."""
    points, _ = limb(5000)
    neighbours = nearest_neighbours(points, 30)
    return (
        points,
        pca_normals(points, neighbours[:, :12]),
        neighbours,
        tie_breakers(points, neighbours),
    )


def native_stars(points, normals, neighbours, weights, n_threads=1):
    centres = np.arange(len(weights))
    return _native.delaunay_stars(
        points,
        normals,
        centres,
        neighbours,
        np.full(len(centres), np.inf),
        weights,
        k=15,
        oriented=False,
        smooth=True,
        n_threads=n_threads,
    )


def native_poles(points, normals, neighbours, _=None, n_threads=1):
    return (_native.pole_normals(points, neighbours, normals, n_threads=n_threads),)


@pytest.mark.parametrize("kernel", [native_stars, native_poles])
@pytest.mark.parametrize("n_threads", [2, 3, 16])
def test_the_number_of_threads_does_not_change_a_bit(cloud, kernel, n_threads):
    for one, several in zip(kernel(*cloud), kernel(*cloud, n_threads=n_threads), strict=True):
        assert one.tobytes() == several.tobytes()


@pytest.mark.parametrize("kernel", [native_stars, native_poles])
@pytest.mark.parametrize("wrong", [0, 1, 2])
def test_arrays_of_another_type_are_refused(cloud, kernel, wrong):
    arrays = list(cloud)
    arrays[wrong] = arrays[wrong].astype(np.float32 if wrong < 2 else np.int32)
    with pytest.raises(TypeError):
        kernel(*arrays)


@pytest.mark.parametrize("kernel", [native_stars, native_poles])
@pytest.mark.parametrize("wrong", [0, 1, 2])
def test_arrays_that_are_not_contiguous_are_refused(cloud, kernel, wrong):
    arrays = list(cloud)
    arrays[wrong] = np.asfortranarray(arrays[wrong])
    with pytest.raises(TypeError):
        kernel(*arrays)


@pytest.mark.parametrize("kernel", [native_stars, native_poles])
@pytest.mark.parametrize("wrong", [0, 1, 2, 3])
def test_arrays_that_do_not_fit_together_are_refused(cloud, kernel, wrong):
    arrays = list(cloud)
    arrays[wrong] = arrays[wrong][:-1]
    if wrong == 3 and kernel is native_poles:
        return  # it takes no weights
    with pytest.raises(ValueError, match="do not fit together"):
        kernel(*arrays)


@pytest.mark.parametrize("kernel", [native_stars, native_poles])
@pytest.mark.parametrize("n_threads", [1, 2])
@pytest.mark.parametrize("index", [-1, 5000, 2**62, -(2**63)])
@pytest.mark.parametrize("place", [(0, 0), (4999, 29)])
def test_neighbours_that_are_not_points_are_refused(cloud, kernel, n_threads, index, place):
    points, normals, neighbours, weights = cloud
    wrong = neighbours.copy()
    wrong[place] = index
    with pytest.raises(ValueError, match="not a point of the cloud, which has 5000"):
        kernel(points, normals, wrong, weights, n_threads=n_threads)


def test_small_clouds_are_worth_one_thread():
    assert threads_for(0) == threads_for(1999) == 1
    assert 1 <= threads_for(10**6) <= 10**6
