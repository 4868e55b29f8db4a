"""Are clouds as sensors write them right: sweeps, scan lines, heaps, repeated passes?"""

import itertools
import warnings

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit import _native
from geodesic_toolkit.errors import CurveWarning, FragmentedCloudWarning, UnevenCloudWarning
from geodesic_toolkit.laplacians.pointcloud.crowds import representatives, restored
from geodesic_toolkit.laplacians.pointcloud.neighbours import nearest_neighbours
from geodesic_toolkit.laplacians.pointcloud.parts import CloudParts, warn_of_fragments

PCA = gt.PointCloudLaplacian(normals="pca")


def solver_of(points, **options):
    return gt.GeodesicSolver(gt.PointCloud(points), operator=PCA, **options)


def scan_lines(anisotropy, noise=0.0, lines=24):
    """Return points of lines that are so many times as far apart as their points."""
    rng = np.random.default_rng(0)
    along, across = np.meshgrid(np.arange(lines * anisotropy) / anisotropy, np.arange(lines))
    along = along + rng.uniform(0, 1, (lines, 1)) + rng.uniform(-0.1, 0.1, along.shape) / anisotropy
    heights = noise / anisotropy * rng.normal(size=along.size)
    return np.column_stack([along.ravel(), across.ravel(), heights])


def inside(points):
    """Return which points of those lines are not near their ends, which do not lie on one line."""
    return (points[:, 0] > 3) & (points[:, 0] < points[:, 0].max() - 3)


def sphere(count):
    """Return evenly spread points of the unit sphere, and their spacing."""
    i = np.arange(count) + 0.5
    polar, turn = np.arccos(1 - 2 * i / count), np.pi * (1 + 5**0.5) * i
    points = [np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)]
    return np.column_stack(points), np.sqrt(4 * np.pi / count)


def passes(times, noise, count=600):
    """Return a sphere that was hit so many times, and the true points."""
    points, spacing = sphere(count)
    true = np.tile(points, (times, 1))
    shaken = noise * spacing * np.random.default_rng(0).normal(size=true.shape)
    return true + shaken, true


def sweep(beams, lowest, highest, azimuths, noise=0.0, height=1.8):
    """Return the points of flat ground that a spinning scanner writes."""
    elevation = np.radians(np.linspace(lowest, highest, beams))
    angle = np.arange(azimuths) * 2 * np.pi / azimuths
    down, turn = np.meshgrid(elevation, angle, indexing="ij")
    reach = height / np.sin(-down)
    reach = (reach + noise * np.random.default_rng(0).normal(size=reach.shape)).ravel()
    down, turn = down.ravel(), turn.ravel()
    flat = reach * np.cos(down)
    return np.column_stack([flat * np.cos(turn), flat * np.sin(turn), reach * np.sin(down)])


def errors(distance, true, least):
    far = true > least
    assert np.isfinite(distance).all()
    return np.abs(distance - true)[far] / true[far]


# -- what sensors write --------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.5])
@pytest.mark.parametrize("anisotropy", [5, 10, 20, 40])
def test_scan_lines_are_a_surface_however_far_apart(anisotropy, noise):
    points = scan_lines(anisotropy, noise)
    source, inner = len(points) // 3 + 12 * anisotropy, inside(points)
    true = np.linalg.norm(points - points[source], axis=1)
    off = errors(solver_of(points).distance(source)[inner], true[inner], least=2)
    assert off.mean() < 0.006
    assert off.max() < 0.08
    off = errors(solver_of(points, refine=False).distance(source)[inner], true[inner], least=2)
    assert off.mean() < 0.04
    assert off.max() < 0.12


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_one_sweep_of_sixteen_beams_reaches_its_outermost_ring(noise):
    points = sweep(16, -15, -1, 900, noise)
    source = 8 * 900
    true = np.linalg.norm(points - points[source], axis=1)
    ahead = np.abs(np.arctan2(points[:, 1], points[:, 0])) < 0.4  # the blind disc is not in the way
    solver = solver_of(points)
    off = errors(solver.distance(source)[ahead], true[ahead], least=2)
    assert off.mean() < 0.01
    assert off.max() < 0.05
    behind = np.flatnonzero(points[:, 0] < 0)
    inner = behind[np.abs(points[behind, 1]) < 1][0]  # on the far side of the blind disc
    assert solver.distance(source)[inner] > 1.02 * true[inner]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("slope", "degrees", "noise"), [(0.15, 0.2, 0.02), (0.15, 0.1, 0.03), (0.3, 0.1, 0.02)]
)
def test_rings_next_to_a_scanner_on_a_slope_are_ground_and_not_blades(slope, degrees, noise):
    # Noise in range spreads points along the cones of the beams, 33 degrees from the ground.
    # With a point every tenth of a degree such a blade holds all neighbours of its points.
    rng = np.random.default_rng(0)
    down, turn = np.meshgrid(
        np.radians(np.linspace(-25, 15, 32)), np.radians(np.arange(0, 360, degrees))
    )
    down, turn = down.ravel(), turn.ravel()
    rays = np.column_stack([np.cos(down) * np.cos(turn), np.cos(down) * np.sin(turn), np.sin(down)])
    reach = 1.8 / (slope * rays[:, 0] - rays[:, 2])
    rays, reach = rays[(reach > 0) & (reach < 60)], reach[(reach > 0) & (reach < 60)]
    true_points = reach[:, None] * rays
    points = (reach + noise * rng.normal(size=reach.shape))[:, None] * rays
    source = int(np.argmin(np.linalg.norm(true_points[:, :2] - [5.6, 0.7], axis=1)))
    true = np.linalg.norm(true_points - true_points[source], axis=1)
    ahead = np.abs(np.arctan2(true_points[:, 1], true_points[:, 0]) - 0.13) < 0.5
    off = errors(solver_of(points).distance(source)[ahead], true[ahead], least=2)
    assert off.mean() < 0.01
    assert off.max() < 3 * noise  # which moves the points themselves, at 2 m and farther


@pytest.mark.slow
def test_rings_on_a_street_are_connected_although_walls_are_nearer():
    rng = np.random.default_rng(0)
    down, turn = np.meshgrid(
        np.radians(np.linspace(-15, 15, 16)), np.radians(np.arange(-75, 75, 0.1))
    )
    down, turn = down.ravel(), turn.ravel()
    rays = np.column_stack([np.cos(down) * np.cos(turn), np.cos(down) * np.sin(turn), np.sin(down)])
    with np.errstate(divide="ignore"):
        ground = np.where(rays[:, 2] < 0, -1.8 / rays[:, 2], np.inf)
        house = 7 / np.abs(rays[:, 1])
    house[house * rays[:, 2] > 6] = np.inf
    reach = np.minimum(ground, house)
    seen = reach < 60
    points = (reach + 0.02 * rng.normal(size=len(reach)))[seen, None] * rays[seen]
    on_ground = (ground < house)[seen]
    source = int(np.argmin(np.linalg.norm(points - [8, 0, -1.8], axis=1)))
    true = np.linalg.norm(points - points[source], axis=1)
    distance = solver_of(points).distance(source)
    assert errors(distance[on_ground], true[on_ground], least=2).mean() < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.001, 0.03, 0.1])
@pytest.mark.parametrize("times", [2, 5, 10, 20, 40])
def test_repeated_passes_are_one_surface(times, noise):
    points, true_points = passes(times, noise)
    for source in (0, len(points) // 2):
        true = np.arccos(np.clip(true_points @ true_points[source], -1, 1))
        off = errors(solver_of(points).distance(source), true, least=0.9)
        assert off.mean() < 0.03
        assert off.max() < (0.08 if noise < 0.1 else 0.15)


@pytest.mark.slow
def test_heaps_here_and_there_change_nothing_elsewhere():
    points, spacing = sphere(2000)
    rng = np.random.default_rng(0)
    places = points[rng.integers(0, 2000, 60)].repeat(rng.integers(5, 60, 60), axis=0)
    heaps = places + 0.05 * spacing * rng.normal(size=places.shape)
    heaps /= np.linalg.norm(heaps, axis=1, keepdims=True)
    cloud = np.concatenate([points, heaps])
    true = np.arccos(np.clip(cloud @ cloud[0], -1, 1))
    off = errors(solver_of(cloud).distance(0), true, least=0.3)
    assert off.mean() < 0.005
    assert off.max() < 0.02


@pytest.mark.slow
def test_a_source_that_others_stand_for_reads_0_and_its_neighbours_are_right():
    points = scan_lines(40)
    thin = representatives(points, 40)
    source = int(np.flatnonzero(~thin.is_kept & inside(points))[5000])
    distance = solver_of(points).distance(source)
    assert distance[source] == 0
    true = np.linalg.norm(points - points[source], axis=1)
    inner = inside(points)
    assert errors(distance[inner], true[inner], least=1).max() < 0.02


# -- what is left alone --------------------------------------------------------------------------


@pytest.mark.slow
def test_even_and_random_samples_of_surfaces_are_not_thinned():
    even, _ = sphere(3000)
    assert len(representatives(even, 40).kept) == 3000
    rng = np.random.default_rng(0)
    random = rng.normal(size=(8000, 3))
    random /= np.linalg.norm(random, axis=1, keepdims=True)
    for noise in (0.0, 0.01):
        thin = representatives(random * (1 + noise * rng.normal(size=(8000, 1))), 40)
        assert len(thin.kept) > 0.99 * 8000


def test_a_wire_keeps_its_length():
    turn = np.linspace(0, 1.8 * np.pi, 900)
    wire = np.column_stack([np.cos(turn), np.sin(turn), 0.3 * turn])
    steps = np.linalg.norm(np.diff(wire, axis=0), axis=1)
    along = np.concatenate([[0], np.cumsum(steps)])
    np.testing.assert_allclose(solver_of(wire).distance(0), along, rtol=1e-6, atol=1e-9)


def test_two_lines_alone_are_not_a_surface():
    line = np.column_stack([np.linspace(0, 10, 400), np.zeros(400), np.zeros(400)])
    distance = solver_of(np.concatenate([line, line + np.array([0.0, 3.0, 0.0])])).distance(0)
    np.testing.assert_allclose(distance[:400], line[:, 0], atol=1e-6)
    assert (distance[400:] == np.inf).all()


def length_along(points):
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0], np.cumsum(steps)])


def helix(turns, count, pitch, random=False):
    turn = np.linspace(0, 2 * np.pi * turns, count)
    if random:
        turn = np.sort(np.random.default_rng(0).uniform(0, 2 * np.pi * turns, count))
    return np.column_stack([np.cos(turn), np.sin(turn), pitch * turn / (2 * np.pi)])


def broken_line():
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 1], [0.5, 0, 1]])
    sides = itertools.pairwise(corners)
    return np.concatenate([np.linspace(a, b, 60)[:-1] for a, b in sides])


@pytest.mark.parametrize("refine", [True, False])
@pytest.mark.parametrize(
    "curve",
    [
        helix(3, 300, 1.0),
        helix(3, 300, 0.3),
        helix(3, 1000, 0.3),
        helix(10, 300, 6.0),
        helix(3, 300, 1.9, random=True),
        broken_line(),
    ],
    ids=["15 apart", "5 apart", "thinned", "ten turns", "random", "broken"],
)
def test_a_curve_in_space_is_as_long_as_it_is(curve, refine):
    distance = solver_of(curve, refine=refine).distance(0)
    np.testing.assert_allclose(distance, length_along(curve), rtol=2e-3, atol=1e-9)


def test_a_shaken_curve_is_only_slightly_longer():
    curve = helix(3, 300, 1.9)
    shaken = curve + 0.1 * 0.07 * np.random.default_rng(0).normal(size=curve.shape)
    distance = solver_of(shaken).distance(0)
    np.testing.assert_allclose(distance, length_along(curve), rtol=0.03, atol=0.05)


def test_wires_that_cross_are_connected_there():
    along = np.linspace(-1, 1, 201)
    none = np.zeros(201)
    one, other = np.column_stack([along, none, none]), np.column_stack([none, along + 0.003, none])
    distance = solver_of(np.concatenate([one, other])).distance(0)
    np.testing.assert_allclose(distance[:201], 1 + along, atol=0.01)
    np.testing.assert_allclose(distance[201:], 1 + np.abs(along + 0.003), atol=0.01)


def test_a_coil_that_passes_for_a_surface_is_reported():
    with pytest.warns(CurveWarning, match="of the points follow one line.*gt.Graph"):
        solver_of(helix(10, 1000, 0.3))


@pytest.mark.slow
def test_a_torn_ring_is_bridged_in_either_direction():
    # One gap is as wide as eleven points are apart, and stars see across it from one side only.
    turn = np.sort(np.random.default_rng(9).uniform(0, 2 * np.pi, 3000))
    turn = turn[(turn < 1.0) | (turn > 1.02)]
    height = np.random.default_rng(1).uniform(-0.003, 0.003, len(turn))
    points = np.column_stack([np.cos(turn), np.sin(turn), height])
    for source in (0, int(np.searchsorted(turn, 1.0)) - 1, int(np.searchsorted(turn, 1.02))):
        away = np.abs((turn - turn[source] + np.pi) % (2 * np.pi) - np.pi)
        true = np.hypot(away, height - height[source])
        assert errors(solver_of(points).distance(source), true, least=0.05).max() < 0.05


def test_a_slit_wider_than_near_points_is_not_bridged():
    side = np.arange(40) / 10
    grid = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    left = np.column_stack([grid, np.zeros(1600)])
    right = left + np.array([side[-1] + 0.8, 0, 0])  # eight spacings away
    distance = solver_of(np.concatenate([left, right])).distance(0)
    assert np.isinf(distance[1600:]).all()


# -- representatives -----------------------------------------------------------------------------


def test_the_first_of_a_heap_stands_for_it():
    points, _ = passes(20, 0.001, count=300)
    thin = representatives(points, 40)
    np.testing.assert_array_equal(thin.kept, np.arange(300))
    np.testing.assert_array_equal(thin.nearest, np.tile(np.arange(300), 20))
    assert (thin.neighbours < 300).all()
    np.testing.assert_array_equal(thin.own, thin.neighbours[:300])
    back = restored(points, thin, np.arange(len(points)) == 777)
    np.testing.assert_array_equal(back.kept, [*range(300), 777])
    assert back.reaches[777] == 0


@pytest.mark.slow
def test_heaps_of_more_points_than_neighbours_are_found():
    points, _ = passes(150, 0.001, count=60)
    assert len(representatives(points, 40).kept) < 100


@pytest.mark.slow
def test_results_are_the_same_every_time_and_on_any_number_of_threads():
    points = scan_lines(20, 0.5)
    first, second = (solver_of(points).distance(7) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    near = nearest_neighbours(points, 40)
    one, three = (_native.crowd_reaches(points, near, n_threads=n) for n in (1, 3))
    np.testing.assert_array_equal(one, three)


def test_kernels_of_crowds_refuse_what_does_not_fit():
    points = scan_lines(5)
    near = nearest_neighbours(points, 40)
    with pytest.raises(ValueError, match="do not fit together"):
        _native.crowd_reaches(points, near[:-1], n_threads=1)
    with pytest.raises(ValueError, match="do not fit together"):
        _native.thinned(points, near, np.zeros(3))
    near[3, 3] = len(points)
    with pytest.raises(ValueError, match="not a point of the cloud"):
        _native.crowd_reaches(points, near, n_threads=1)
    with pytest.raises(ValueError, match="not a point of the cloud"):
        _native.thinned(points, near, np.ones(len(points)))


@pytest.mark.slow
@pytest.mark.parametrize("spread", ["even", "random"])
def test_creases_and_thin_sheets_are_not_blades(spread):
    rng = np.random.default_rng(0)
    flat = rng.uniform(-1, 1, (20_000, 2))
    if spread == "even":
        flat = np.stack(np.meshgrid(*[np.linspace(-1, 1, 141)] * 2), axis=-1).reshape(-1, 2)
    roof = np.column_stack([flat, 0.5 * np.abs(flat[:, 0])])
    sheet = np.column_stack([flat + 5, rng.choice([0.0, 0.05], len(flat))])
    assert len(representatives(np.concatenate([roof, sheet]), 40).kept) > 0.99 * 2 * len(flat)


# -- what is said --------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(("highest", "unevenness"), [(-1, 3), (-3, 1.5)])
def test_plain_heat_on_a_sweep_says_that_it_is_not_to_be_trusted(highest, unevenness):
    points = sweep(16 if highest == -1 else 7, -15, highest, 3600)
    solver = solver_of(points, refine=False)
    with pytest.warns(UnevenCloudWarning, match="use refine=True"):
        solver.distance(0)
    refined = solver_of(points)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        refined.distance(0)
    assert refined.diagnosis.notes["unevenness"] > unevenness


def test_each_part_has_a_time_step_of_its_own():
    small, _ = sphere(400)
    cloud = np.concatenate([small, 100 * small + np.array([1000.0, 0, 0])])
    scales = solver_of(cloud).method.metric.scales
    np.testing.assert_allclose(scales[400:], 100 * scales[:400], rtol=1e-6)


def test_parts_that_lie_among_others_are_counted_and_reported():
    points = np.column_stack([np.arange(200.0), np.zeros((200, 2))])
    near = nearest_neighbours(points, 10)
    nothing = np.empty((0, 3))
    parts = np.where(np.arange(200) % 4 == 0, 1, 0)  # one between any three
    cloud = CloudParts(
        np.empty((0, 3), dtype=np.int64),
        nothing,
        np.empty(0),
        np.empty((0, 2), dtype=np.int64),
        np.empty(0),
        parts,
    )
    notes = {**cloud.notes(near, 1.0), "open_stars": 7}
    assert (notes["parts"], notes["torn_off"]) == (2, 50)
    with pytest.warns(FragmentedCloudWarning, match="2 components, and 50 of 200 points are not"):
        warn_of_fragments(notes, 200)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_of_fragments({**notes, "torn_off": 4}, 200)  # outliers


def test_separate_clouds_are_parts_and_nothing_is_said():
    points, _ = sphere(400)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        notes = solver_of(np.concatenate([points, points + 5.0])).diagnosis.notes
    assert (notes["parts"], notes["torn_off"]) == (2, 0)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("width", [0.002, 0.004, 0.006, 0.02, 0.1])  # 1 to 7 spacings
def test_a_narrow_band_is_not_a_line_of_a_scan(width, seed):
    rng = np.random.default_rng(seed)
    turn, height = rng.uniform(0, 2 * np.pi, 3000), rng.uniform(-width / 2, width / 2, 3000)
    points = np.column_stack([np.cos(turn), np.sin(turn), height])
    away = np.abs((turn - turn[0] + np.pi) % (2 * np.pi) - np.pi)
    true = np.hypot(away, height - height[0])
    off = errors(solver_of(points).distance(0), true, least=0.2)
    assert off.mean() < (0.01 if width > 0.002 else 0.03)
    assert off.max() < (0.03 if width > 0.002 else 0.1)


@pytest.mark.slow
@pytest.mark.parametrize("refine", [False, True])
@pytest.mark.filterwarnings("ignore::geodesic_toolkit.errors.UnevenCloudWarning")
def test_outliers_that_were_hit_twice_do_not_spoil_the_factors(refine):
    points = sweep(16, -15, -1, 360, noise=0.02)
    pair = np.array([[60.0, 40.0, 8.0], [60.0, 40.0, 8.0]])
    distance = solver_of(np.concatenate([points, pair]), refine=refine).distance(0)
    assert np.isfinite(distance[:-2]).all()
    twin = distance[-2] if refine else pytest.approx(distance[-2], rel=1e-9)  # it is solved for
    assert distance[-1] == twin


@pytest.mark.slow
@pytest.mark.parametrize("count", [20_000, 60_000])
def test_the_memory_of_stars_is_foreseen(count):
    points = np.random.default_rng(0).normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    expected = solver_of(points).method.expected_bytes
    assert 2900 * count < expected < 4500 * count
