"""Shortest paths on point clouds: their length, what they run through, where they end."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from sample_shapes import random_sphere

import geodesic_toolkit as gt
from geodesic_toolkit.analysis.paths import reach
from geodesic_toolkit.analysis.paths.star_paths import stars_connect
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.errors import InvalidSourceError, UnreachableError
from geodesic_toolkit.testing import shapes

PCA = gt.PointCloudLaplacian(normals="pca")


def solver_of(points, **options):
    return gt.GeodesicSolver(gt.PointCloud(points), operator=PCA, **options)


def runs_through_triangles(solver, path):
    """Check that both ends of each piece of a path lie in one triangle of a star."""
    stars = {frozenset(element) for element in solver.method.metric.gradient.elements.tolist()}
    support = [
        set(corners[weights > 1e-9].tolist())
        for corners, weights in zip(path.corners, path.weights, strict=True)
    ]
    pieces = [here | there for here, there in pairwise(support)]
    return all(any(piece <= star for star in stars) for piece in pieces)


@pytest.mark.slow
@pytest.mark.parametrize("refine", [True, False])
def test_a_path_on_a_sphere_is_as_long_as_the_great_circle(refine):
    points, _ = random_sphere(2500)
    solver = solver_of(points, refine=refine)
    for target in (17, 800, 1203, 2499):
        path = gt.geodesic_path(solver, 0, target)
        arc = np.arccos(np.clip(points[0] @ points[target], -1, 1))
        assert path.length == pytest.approx(arc, rel=0.005)
        np.testing.assert_array_equal(path.points[[0, -1]], points[[0, target]])
        assert runs_through_triangles(solver, path)


RANDOM = np.random.default_rng(5).uniform(size=(600, 2))
PLANE = solver_of(np.column_stack([RANDOM, np.zeros(600)]), refine=True)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 599), st.integers(0, 599))
@example(121, 227)  # 0.82 % too long; of 1,711 pairs three are over 0.5 %, the worst 0.85 %
def test_a_path_on_a_plane_is_straight(source, target):
    path = gt.geodesic_path(PLANE, source, target)
    straight = np.linalg.norm(RANDOM[source] - RANDOM[target])
    assert path.length == pytest.approx(straight, rel=0.01, abs=1e-12)
    assert path.length >= straight * (1 - 1e-9)


def test_nearly_all_paths_on_a_plane_are_within_half_a_per_cent():
    excess = []
    for source, target in np.random.default_rng(1).choice(600, size=(60, 2)):
        straight = np.linalg.norm(RANDOM[source] - RANDOM[target])
        excess.append(gt.geodesic_path(PLANE, source, target).length / straight - 1)
    assert np.quantile(excess, 0.95) <= 0.005


def test_a_path_follows_a_folded_sheet_instead_of_jumping_its_gap():
    leg, gap, width = 30.0, 4.0, 10
    radius = gap / 2
    length = 2 * leg + np.pi * radius
    s, y = np.meshgrid(
        np.linspace(0, length, round(length) + 1), np.arange(width + 1.0), indexing="ij"
    )
    rng = np.random.default_rng(0)
    s = np.clip(s + 0.5 * rng.uniform(-0.5, 0.5, s.shape), 0, length).ravel()
    y = (y + 0.5 * rng.uniform(-0.5, 0.5, y.shape)).ravel()
    turn = np.clip((s - leg) / radius, 0, np.pi)
    along = np.minimum(s, leg) - np.maximum(s - leg - np.pi * radius, 0)
    points = np.column_stack([along + radius * np.sin(turn), y, radius - radius * np.cos(turn)])
    source, target = int(s.argmin()), int(s.argmax())
    path = gt.geodesic_path(solver_of(points, refine=True), source, target)
    true = np.hypot(s[target] - s[source], y[target] - y[source])
    assert path.length == pytest.approx(true, rel=0.01)
    assert np.linalg.norm(np.diff(path.points, axis=0), axis=1).max() < 2.5


@pytest.mark.slow
def test_noise_makes_a_path_longer_by_the_noise_alone():
    points, true = random_sphere(16_000, noise=0.01)
    path = gt.geodesic_path(solver_of(points, refine=True), 0, 500)
    arc = np.arccos(np.clip(true[0] @ true[500], -1, 1))
    assert 1 < path.length / arc < 1.08  # it runs through the points as they are
    unit = path.points / np.linalg.norm(path.points, axis=1, keepdims=True)
    smooth = np.linalg.norm(np.diff(unit, axis=0), axis=1).sum()
    assert smooth == pytest.approx(arc, rel=0.02)


def test_the_path_leads_from_the_nearest_source_and_targets_in_space_are_snapped():
    grid = shapes.grid(9).vertices
    path = gt.geodesic_path(solver_of(grid), [0, 80], [1.0, 0.88, 0.001])
    assert path.length == pytest.approx(0.125)
    np.testing.assert_array_equal(path.points[[0, -1]], grid[[80, 71]])
    back = gt.geodesic_path(solver_of(grid), [1.0, 0.89, 0.001], 80)  # between 71 and 80
    assert back.length == pytest.approx(0.125)


def test_a_path_serves_as_a_curve_and_carries_values():
    grid = shapes.grid(21).vertices
    solver = solver_of(grid, refine=True)
    path = gt.geodesic_path(solver, 0, 440)  # the diagonal
    expected = np.abs(grid[:, 0] - grid[:, 1]) / np.sqrt(2)
    np.testing.assert_allclose(solver.distance(gt.Curve(path.points)), expected, atol=0.03)
    height = (path.weights * grid[path.corners][:, :, 0]).sum(axis=1)
    np.testing.assert_allclose(height, path.points[:, 0], atol=1e-12)


def test_a_path_runs_along_links_where_there_are_no_triangles():
    along = np.random.default_rng(0).permutation(np.cumsum(np.arange(1, 60)) / 100)
    solver = solver_of(along[:, None] * [1.0, -2.0, 2.0])
    path = gt.geodesic_path(solver, 0, 1)
    assert path.length == pytest.approx(3 * abs(along[0] - along[1]))
    assert runs_through_triangles(solver, path)
    sheet = shapes.grid(15).vertices
    hair = np.linspace(1.07, 2, 14)[:, None] * [1.0, 0, 0]
    solver = solver_of(np.concatenate([sheet, hair]))
    path = gt.geodesic_path(solver, 14 * 15, 15 * 15 + 13)
    assert path.length == pytest.approx(np.hypot(1, 1) + 1, rel=0.03)


def test_a_path_between_duplicates_has_no_length():
    grid = shapes.grid(5).vertices
    path = gt.geodesic_path(solver_of(np.concatenate([grid, grid[:3]])), 1, 26)
    assert path.length == 0
    one = gt.geodesic_path(solver_of(grid), 3, 3)
    assert repr(one) == "CloudPath(1 points, length 0)"


def test_what_is_masked_or_in_another_part_is_unreachable():
    grid = shapes.grid(12).vertices
    apart = solver_of(np.concatenate([grid, grid + np.array([7.0, 0, 0])]))
    with pytest.raises(UnreachableError, match="connects point 200 with a source"):
        gt.geodesic_path(apart, 0, 200)
    with pytest.raises(UnreachableError, match="masked"):
        gt.geodesic_path(solver_of(grid, mask=np.arange(144) == 50), 0, 50)


def test_a_path_leads_around_masked_points():
    grid = shapes.grid(21).vertices
    wall = (np.abs(grid[:, 0] - 0.5) < 0.33) & (grid[:, 1] < 0.7)
    path = gt.geodesic_path(solver_of(grid, mask=wall, refine=True), 0, 20)
    assert 1.9 < path.length < 2.2  # straight it would be 1
    assert not wall[path.corners[path.weights > 0]].any()


def test_a_path_on_a_cloud_needs_points_that_are_there():
    solver = solver_of(np.vstack([shapes.grid(5).vertices, [[np.nan] * 3]]))
    with pytest.raises(InvalidSourceError, match="target: point 25 of the PointCloud is missing"):
        gt.geodesic_path(solver, 0, 25)
    with pytest.raises(InvalidSourceError, match="a SurfacePoint needs a TriangleMesh"):
        gt.geodesic_path(solver, 0, gt.SurfacePoint(0, (1.0, 0.0, 0.0)))


# -- bands, thousands of points long ---------------------------------------------------------------


@pytest.mark.parametrize(("height", "kind"), [(0.05, "cylinder"), (0.3, "sphere")])
def test_a_path_along_a_narrow_band_is_the_arc_and_stays_on_the_points(height, kind):
    rng = np.random.default_rng(0)
    angle, z = rng.uniform(0, 2 * np.pi, 6000), rng.uniform(-height / 2, height / 2, 6000)
    radius = np.sqrt(1 - z**2) if kind == "sphere" else np.ones(6000)
    angle[:2], z[:2], radius[:2] = (0, np.pi), 0.0, 1.0
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])
    path = gt.geodesic_path(solver_of(points), 0, 1)
    assert path.length == pytest.approx(np.pi, rel=2e-3)
    np.testing.assert_array_equal(path.points[[0, -1]], points[:2])
    assert np.abs(np.linalg.norm(path.points, axis=1) - 1).max() < height**2 / 8 + 1e-3
    spacing = np.sqrt(2 * np.pi * height / len(points))
    gap = np.linalg.norm(path.points[:, None] - points[path.corners], axis=2).min(axis=1).max()
    assert gap < 1.5 * spacing


# -- large clouds: points away from the path are not visited ---------------------------------------

SQUARE = np.random.default_rng(3).uniform(size=(6000, 2))
LARGE = solver_of(np.column_stack([SQUARE, np.zeros(6000)]))


def nearest(x, y):
    """Return the point of the square nearest to a place."""
    return int(np.argmin(np.linalg.norm(SQUARE - [x, y], axis=1)))


@pytest.fixture
def swept(monkeypatch):
    """Take clouds of 600 points for large, and count the regions that fronts are swept over."""
    monkeypatch.setattr(reach, "MAX_POINTS_OF_REGION", 600)
    monkeypatch.setattr(reach, "AT_ENDS", 50)
    regions = []
    part_of = reach._Part.of

    def counted(metric, within):
        regions.append(within)
        return part_of(metric, within)

    monkeypatch.setattr(reach._Part, "of", counted)
    return regions


@pytest.mark.slow
def test_a_path_on_a_large_plane_is_straight_and_looks_at_a_part_of_it(swept):
    for source, target in np.random.default_rng(1).choice(6000, size=(12, 2), replace=False):
        path = gt.geodesic_path(LARGE, source, target)
        straight = np.linalg.norm(SQUARE[source] - SQUARE[target])
        assert straight * (1 - 1e-9) <= path.length <= straight * 1.002
        np.testing.assert_array_equal(path.points[[0, -1], :2], SQUARE[[source, target]])
        assert runs_through_triangles(LARGE, path)
    assert len(swept) >= 12
    assert all(within.sum() < 1200 for within in swept)


def test_a_path_on_a_large_sphere_is_the_great_circle(swept):
    points, _ = random_sphere(5000)
    solver = solver_of(points)
    antipode = int(np.argmin(points @ points[0]))
    for target in (17, 800, antipode):
        arc = np.arccos(np.clip(points[0] @ points[target], -1, 1))
        assert gt.geodesic_path(solver, 0, target).length == pytest.approx(arc, rel=0.003)
    assert swept


def test_where_heat_misleads_the_region_moves_to_the_path(swept, monkeypatch):
    """Heat that decays with the distance from a corner to the side draws the region off."""
    method = LARGE.method
    source, target = nearest(0.1, 0.5), nearest(0.9, 0.5)
    detour = np.abs(SQUARE[:, 1] - 0.55)
    true_heat = type(method).log_heat
    monkeypatch.setattr(
        type(method), "log_heat", lambda self, places: true_heat(self, places) - 20 * detour
    )
    path = gt.geodesic_path(LARGE, source, target)
    assert path.length == pytest.approx(np.linalg.norm(SQUARE[source] - SQUARE[target]), rel=1e-3)
    assert swept


def test_the_nearest_of_many_sources_is_found_on_a_large_cloud(swept):
    rng = np.random.default_rng(8)
    for sources in (rng.choice(6000, 2), rng.choice(6000, 20), rng.choice(6000, 300)):
        target = int(rng.integers(6000))
        straight = np.linalg.norm(SQUARE[sources] - SQUARE[target], axis=1).min()
        path = gt.geodesic_path(LARGE, sources, target)
        assert path.length == pytest.approx(straight, rel=0.005)


def test_a_path_leads_to_a_curve_and_from_late_sources_on_a_large_cloud(swept):
    curve = gt.Curve(np.array([[0.2, 0.1, 0.0], [0.2, 0.9, 0.0]]))
    target = nearest(0.8, 0.5)
    path = gt.geodesic_path(LARGE, curve, target)
    assert path.length == pytest.approx(SQUARE[target, 0] - 0.2, abs=0.02)
    late = gt.OffsetSources([0, 1], [0.0, 9.0])
    assert gt.geodesic_path(LARGE, late, target).length == pytest.approx(
        np.linalg.norm(SQUARE[0] - SQUARE[target]), rel=0.005
    )


@pytest.mark.slow
def test_large_clouds_lead_around_masks_and_refuse_what_is_not_connected(swept):
    wall = (np.abs(SQUARE[:, 0] - 0.5) < 0.05) & (SQUARE[:, 1] < 0.9)
    masked = solver_of(LARGE.domain.points, mask=wall)
    source, target = nearest(0.1, 0.2), nearest(0.9, 0.2)
    corners = [SQUARE[source], [0.45, 0.9], [0.55, 0.9], SQUARE[target]]
    around = np.linalg.norm(np.diff(corners, axis=0), axis=1).sum()
    path = gt.geodesic_path(masked, source, target)
    assert path.length == pytest.approx(around, rel=0.03)
    assert not wall[path.corners[path.weights > 0]].any()
    closed = solver_of(LARGE.domain.points, mask=np.abs(SQUARE[:, 0] - 0.5) < 0.05)
    with pytest.raises(UnreachableError, match=f"connects point {target} with a source"):
        gt.geodesic_path(closed, source, target)


def test_any_path_between_opposite_places_of_a_large_sphere_is_accepted(swept):
    points, _ = random_sphere(5000)
    points[:2] = [0, 0, 1], [0, 0, -1]
    path = gt.geodesic_path(solver_of(points), 0, 1)
    assert path.length == pytest.approx(np.pi, rel=0.003)
    assert len(swept) <= reach.MAX_MOVES_OF_REGION + 1


def test_a_triangle_of_one_star_alone_connects_nothing_that_a_region_could_rely_on():
    grid = shapes.grid(12).vertices
    metric = solver_of(np.concatenate([grid, grid + np.array([7.0, 0, 0])])).method.metric
    gradient = metric.gradient
    for bridges, connects in (
        ([[143, 142, 150]], False),
        ([[143, 142, 150], [142, 143, 150]], True),
    ):
        joined = ElementGradient(
            np.concatenate([gradient.elements, bridges]),
            np.concatenate([gradient.coefficients, gradient.coefficients[: len(bridges)]]),
            np.concatenate([gradient.measure, gradient.measure[: len(bridges)]]),
            gradient.n_vertices,
            stars=True,
        )
        bridged = gt.Discretization(
            mass=metric.mass,
            stiffness=joined.stiffness(),
            gradient=joined,
            spacing=metric.spacing,
            boundary=metric.boundary,
        )
        assert stars_connect(bridged, np.array([0]), 140)
        assert stars_connect(bridged, np.array([0, 1]), 200) is connects
