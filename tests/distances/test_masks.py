"""Masks of meshes, clouds and graphs, which paths may not cross, and their files."""

import numpy as np
import pytest
from closed_forms import mean_relative_error
from source_shapes import GRID, PCA

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    ReadError,
    UnsupportedDomainError,
)
from geodesic_toolkit.io import read_mask
from geodesic_toolkit.testing import shapes

# -- what paths may not cross ----------------------------------------------------------------------

WALL = (np.abs(GRID.vertices[:, 0] - 0.5) < 1e-9) & (GRID.vertices[:, 1] < 0.79)


def around_the_wall(points):
    """Return distances from the corner at the origin around the end of the wall."""
    straight = np.linalg.norm(points, axis=1)
    ends = np.array([[0.475, 0.8, 0], [0.525, 0.8, 0]])
    first = np.linalg.norm(ends[0])
    behind = first + 0.05 + np.linalg.norm(points - ends[1], axis=1)
    return np.where(points[:, 0] < 0.5, straight, behind)


@pytest.mark.parametrize("refine", [False, True])
def test_paths_go_around_a_mask_of_a_mesh(refine):
    solver = gt.GeodesicSolver(GRID, mask=WALL, refine=refine)
    distance = solver.distance(0)
    assert (distance[WALL] == np.inf).all()
    assert np.isfinite(distance[~WALL]).all()
    shadow = (GRID.vertices[:, 0] > 0.55) & (GRID.vertices[:, 1] < 0.5)
    expected = around_the_wall(GRID.vertices)
    assert mean_relative_error(distance[shadow], expected[shadow]) < 0.05
    assert solver.query([0.49, 0.2, 0.0], 0) < 0.6
    assert solver.domain is GRID


def test_paths_go_around_a_mask_of_a_cloud_and_of_a_graph():
    strip = np.abs(GRID.vertices[:, 0] - 0.5) < 0.13
    wall = strip & (GRID.vertices[:, 1] < 0.79)
    cloud = gt.GeodesicSolver(gt.PointCloud(GRID.vertices), operator=PCA, mask=wall)
    path = gt.Graph(5, [[0, 1], [1, 2], [2, 3], [3, 4], [4, 0]])
    far = int(np.argmin(np.linalg.norm(GRID.vertices - [1.0, 0, 0], axis=1)))
    assert cloud.distance(0)[far] > 1.6
    assert (cloud.distance(0)[wall] == np.inf).all()
    ring = gt.GeodesicSolver(path, mask=[False, True, False, False, False])
    distance = ring.distance(0)
    assert distance[1] == np.inf
    assert distance[2] > distance[3] > distance[4] > 0


@pytest.mark.parametrize("half_width", [0.03, 0.06, 0.1])
@pytest.mark.parametrize("refine", [True, False])
def test_stars_of_a_cloud_do_not_close_over_a_wall_of_a_few_points(half_width, refine):
    points = shapes.grid(21).vertices
    wall = (np.abs(points[:, 0] - 0.5) < half_width) & (points[:, 1] < 0.72)
    solver = gt.GeodesicSolver(gt.PointCloud(points), operator=PCA, mask=wall, refine=refine)
    far = int(np.argmin(np.linalg.norm(points - [0.9, 0.1, 0], axis=1)))
    free = 0.05 * np.ceil(half_width / 0.05)  # the next row, and 0.75 over the wall
    around = np.hypot(0.5 - free, 0.75) + 2 * free + np.hypot(0.4 - free, 0.65)
    assert 0.99 * around < solver.distance(0)[far] < around * (1.03 if refine else 1.15)
    assert solver.distance(0)[wall].min() == np.inf
    assert solver.query([0.9, 0.1, 0.0], 0)[0] == pytest.approx(solver.distance(0)[far])
    assert solver.diagnosis.notes["masked"] == wall.sum()


@pytest.mark.parametrize("half_width", [0.06, 0.1])
def test_heat_of_another_operator_does_not_close_over_a_wall_of_a_cloud_either(half_width):
    points = shapes.grid(21).vertices
    wall = (np.abs(points[:, 0] - 0.5) < half_width) & (points[:, 1] < 0.72)
    options = {"operator": PCA, "mask": wall, "refine": False}
    own = gt.GeodesicSolver(gt.PointCloud(points), **options)
    other = gt.GeodesicSolver(gt.PointCloud(points), diffusion=PCA, **options)
    np.testing.assert_allclose(other.heat(0), own.heat(0), rtol=1e-3, atol=1e-12)


def test_a_point_between_masked_points_of_a_cloud_has_no_distance():
    points = shapes.grid(11).vertices
    solver = gt.GeodesicSolver(gt.PointCloud(points), operator=PCA, mask=points[:, 0] > 0.55)
    places = [[0.3, 0.4, 0.0], [0.55, 0.4, 0.0], [0.9, 0.4, 0.0]]
    found = solver.query(places, 0)
    np.testing.assert_allclose(found[:2], np.linalg.norm(places[:2], axis=1), rtol=0.02)
    assert found[2] == np.inf


@pytest.mark.parametrize("copy", [0, 1])
def test_a_place_of_a_cloud_is_masked_where_one_of_the_points_there_is(copy):
    points = shapes.grid(11).vertices
    wall = (np.abs(points[:, 0] - 0.5) < 0.01) & (points[:, 1] < 0.75)
    mask = np.roll(np.concatenate([wall, np.zeros(121, bool)]), 121 * copy)
    twice = gt.PointCloud(np.concatenate([points, points]))
    distance = gt.geodesic_distance(twice, 0, operator=PCA, mask=mask)
    once = gt.geodesic_distance(gt.PointCloud(points), 0, operator=PCA, mask=wall)
    np.testing.assert_allclose(distance, np.concatenate([once, once]), rtol=1e-6, atol=1e-8)


def test_a_mask_of_0_and_1_is_refused_with_the_cure():
    with pytest.raises(InvalidOptionError, match=r"of 0 and 1: mask.astype\(bool\)"):
        gt.GeodesicSolver(GRID, mask=WALL.astype(int))


def test_a_mask_of_a_cloud_may_leave_single_points():
    points = shapes.grid(5).vertices
    distance = gt.geodesic_distance(gt.PointCloud(points), 0, operator=PCA, mask=np.arange(25) > 0)
    assert distance[0] == 0
    np.testing.assert_array_equal(distance[1:], np.inf)


def test_a_mask_that_cuts_leaves_the_other_side_infinite():
    cut = np.abs(GRID.vertices[:, 0] - 0.5) < 1e-9
    distance = gt.geodesic_distance(GRID, 0, mask=cut)
    np.testing.assert_array_equal(np.isfinite(distance), GRID.vertices[:, 0] < 0.49)


def test_no_path_starts_in_a_mask():
    solver = gt.GeodesicSolver(GRID, mask=WALL)
    masked = int(np.flatnonzero(WALL)[0])
    with pytest.raises(InvalidSourceError, match=f"vertex {masked} is masked"):
        solver.distance(masked)
    with pytest.raises(InvalidSourceError, match="source set 1: vertex"):
        solver.distances([0, masked])
    face = int(np.flatnonzero((GRID.faces == masked).any(axis=1))[0])
    with pytest.raises(InvalidSourceError, match="is masked"):
        solver.distance(gt.SurfacePoint(face, (0.3, 0.3, 0.4)))
    beside = solver.distance([0.495, 0.2, 0.0])  # snaps to where paths may go
    assert np.nanmin(beside) <= 0.01


@pytest.mark.parametrize("labels", [np.zeros(1681), np.arange(1681) % 3, np.arange(1681) == 5])
def test_a_label_for_each_vertex_is_not_taken_for_sources(labels):
    with pytest.raises(InvalidSourceError, match=r"seem to be labels or a mask.*flatnonzero"):
        gt.geodesic_distance(GRID, labels.astype(np.uint8))
    gt.geodesic_distance(GRID, np.arange(GRID.n_vertices))  # all of them, each once
    gt.geodesic_distance(GRID, [3, 3, 3])


@pytest.mark.parametrize(
    "mask",
    [np.zeros(7, dtype=bool), np.zeros(1681), [[True]], "none", [0, 5], [[True], [True, False]]],
)
def test_a_mask_that_is_none_is_refused(mask):
    with pytest.raises(InvalidOptionError, match="mask"):
        gt.GeodesicSolver(GRID, mask=mask)


@pytest.mark.parametrize(
    "domain", [GRID, gt.PointCloud(GRID.vertices), gt.Graph(3, [[0, 1], [1, 2]])], ids=repr
)
def test_a_mask_of_everything_is_refused(domain):
    with pytest.raises(InvalidOptionError, match="the mask leaves no"):
        gt.GeodesicSolver(domain, mask=np.ones(domain.n_vertices, dtype=bool))


def test_other_domains_have_no_mask():
    class Line(gt.Domain):
        n_vertices = 2

    with pytest.raises(UnsupportedDomainError, match="a Line cannot be masked"):
        Line().without(np.array([True, False]))


# -- masks in files --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "content", "masked"),
    [
        ("a.npy", np.array([False, True, True, False]), [1, 2]),
        ("a.npy", np.array([0, 1, 1, 0], dtype=np.uint8), [1, 2]),
        ("a.npy", np.array([0.0, 1, 1, 0]), [1, 2]),
        ("a.npy", np.array([3, 1]), [1, 3]),
        ("a.npy", np.array([0, 1]), [0, 1]),
        ("a.npy", np.array([], dtype=np.int64), []),
        ("a.txt", b"0 1 # the wall\n2", [0, 1, 2]),
        ("a.txt", b"False\nTrue\nTRUE\nfalse\n", [1, 2]),
        ("a.csv", b"1,0,0,1", [0, 3]),
        ("a.csv", b"2.0,2.0", [2]),
    ],
)
def test_a_mask_is_booleans_or_indices(tmp_path, name, content, masked):
    mask = read_mask(_written(tmp_path / name, content), 4)
    assert mask.dtype == np.bool_
    assert mask.shape == (4,)
    assert np.flatnonzero(mask).tolist() == masked


@pytest.mark.parametrize(
    ("name", "content", "error", "message"),
    [
        ("a.npy", np.array([True, False]), InvalidOptionError, "2 booleans, but .* 4 vertices"),
        ("a.txt", b"1 0 1", InvalidOptionError, "3 booleans, but the shape has 4 vertices"),
        ("a.txt", b"true true", InvalidOptionError, "2 booleans"),
        ("a.txt", b"3 4", InvalidOptionError, "there is no vertex 4: they are 0 to 3"),
        ("a.npy", np.array([-1, 2]), InvalidOptionError, "no vertex -1"),
        ("a.npy", np.array([2**64 - 1], dtype=np.uint64), ReadError, "must be smaller"),
        ("a.npy", np.zeros((2, 2)), ReadError, "one dimension, not float64 of shape"),
        ("a.npy", np.array(["0"]), ReadError, "one dimension, not <U1"),
        ("a.npy", b"no array", ReadError, "a.npy: "),
        ("a.txt", b"0.5", ReadError, "vertex indices must be whole numbers .found 0.5"),
        ("a.txt", b"nan", ReadError, "whole numbers"),
        ("a.txt", b"true 3", ReadError, "must be numbers .found 'true'"),
        ("a.txt", b"# nothing", ReadError, "no numbers in the file"),
        ("a.txt", b"1\x00", ReadError, "binary"),
        ("a.off", b"1", ReadError, "a mask is read from .npy, .txt, .csv"),
        ("a.txt", None, ReadError, "does not exist"),
    ],
)
def test_a_file_that_is_not_a_mask_is_refused_by_name(tmp_path, name, content, error, message):
    with pytest.raises(error, match=message) as caught:
        read_mask(_written(tmp_path / name, content), 4)
    assert name in str(caught.value)


def test_an_archive_is_not_a_mask(tmp_path):
    np.savez(tmp_path / "a.npz", np.ones(4))
    (tmp_path / "a.npz").rename(tmp_path / "a.npy")
    with pytest.raises(ReadError, match="an archive"):
        read_mask(tmp_path / "a.npy", 4)


def _written(path, content):
    if isinstance(content, bytes):
        path.write_bytes(content)
    elif content is not None:
        np.save(path, content)
    return path
