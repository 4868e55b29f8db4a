"""Do the kernels of refinement read triangles as the plain formulas do, and finish their sweeps?"""

import dataclasses
from collections import Counter
from itertools import pairwise, permutations

import numpy as np
import pytest
from closed_forms import mean_relative_error, on_sphere
from hypothesis import given
from hypothesis import strategies as st
from sample_shapes import many_sheets, scrambled
from scipy.sparse import coo_array, csr_array

import geodesic_toolkit as gt
from geodesic_toolkit import _native
from geodesic_toolkit.discretization.heat import Heat
from geodesic_toolkit.refinement import wavefronts as refine
from geodesic_toolkit.refinement.wavefronts import WavefrontSweeper
from geodesic_toolkit.sources.points import SourcePoints
from geodesic_toolkit.testing import shapes


def disk(count):
    """Return so many triangles about vertex 0."""
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)
    rim = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(count)])
    at = np.arange(count)
    faces = np.column_stack([np.zeros_like(at), at + 1, (at + 1) % count + 1])
    return gt.TriangleMesh(np.vstack([[0.0, 0, 0], rim]), faces)


def curve_beside_a_sheet():
    """Return points of a sheet, of a line that has no triangles, and one of them twice."""
    sheet = shapes.grid(7, spacing=1.0).vertices
    line = np.column_stack([np.arange(8.0), np.zeros(8), np.full(8, 40.0)])
    return gt.PointCloud(np.vstack([sheet, line, sheet[:1], line[3:4]]))


DOMAINS = {
    "one triangle": gt.TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
    "sphere": shapes.icosphere(2),
    "right angles": shapes.grid(6),
    "obtuse": shapes.grid(9, shear=2.0),
    "scrambled": scrambled(shapes.torus(12, 7)),
    "two parts": shapes.disjoint_union(shapes.grid(4), shapes.icosphere(1)),
    "many sheets": many_sheets(alone=[9, 9, 9]),
    "cloud": gt.PointCloud(shapes.icosphere(2).vertices),
    "cloud with links and ties": curve_beside_a_sheet(),
}


MANY = 32
"""Triangles of a vertex up to which they are sorted round it."""

FIELDS = ("a", "b", "to_a", "to_b", "edge")


def assembled(domain):
    cloud = isinstance(domain, gt.PointCloud)
    recipe = gt.PointCloudLaplacian(normals="pca") if cloud else gt.CotanLaplacian()
    return recipe.assemble(domain)


@pytest.fixture(params=DOMAINS)
def sweeper(request):
    metric = assembled(DOMAINS[request.param])
    return WavefrontSweeper(dataclasses.replace(metric, surface_frames=np.zeros((0, 3))))


def plain_areas(gradient):
    p, q = gradient.coefficients[:, :, 1], gradient.coefficients[:, :, 2]
    with np.errstate(divide="ignore"):
        return 0.5 / np.abs(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])


def plain_lengths(gradient):
    """Return the (E, 3) edges opposite the corners, from how steep hat functions are."""
    steepness = np.linalg.norm(gradient.coefficients, axis=1)
    areas = plain_areas(gradient)
    segment = np.isinf(areas)
    lengths = 2 * np.where(segment, 0.0, areas)[:, None] * steepness
    ends = gradient.elements[segment]
    apart = ends[:, [1, 2, 0]] != ends[:, [2, 0, 1]]
    lengths[segment] = apart / steepness[segment].max(axis=1, keepdims=True)
    return lengths


def as_swept(sweeper):
    """Return the gradient on the triangles that fronts cross."""
    own = sweeper.metric.gradient
    return (
        own if own.stars else gt.ElementGradient.of_triangles(*sweeper._triangles, own.n_vertices)
    )


def edges_of(faces):
    return {tuple(sorted(edge)) for face in faces.tolist() for edge in pairwise([*face, face[0]])}


def plate_with_a_notch(n):
    """Return a square plate of n x n squares without its upper right quarter."""
    plate = shapes.grid(n + 1, spacing=1.0)
    middle = plate.vertices[plate.faces].mean(axis=1)
    kept = plate.faces[~(middle[:, :2] > n / 2).all(axis=1)]
    used, faces = np.unique(kept, return_inverse=True)
    return gt.TriangleMesh(plate.vertices[used], faces.reshape(-1, 3))


def test_every_vertex_has_its_corners_and_those_of_its_own_star_first(sweeper):
    gradient = as_swept(sweeper)
    faces, count = gradient.elements, gradient.n_vertices
    foreign = np.zeros(faces.shape, dtype=bool)
    if gradient.stars:
        foreign[np.isfinite(plain_areas(gradient)), 1:] = True
    total = np.bincount(faces.ravel(), minlength=count)
    own = np.bincount(faces[~foreign], minlength=count)
    corners = sweeper._corners
    np.testing.assert_array_equal(corners.starts, np.concatenate([[0], np.cumsum(total)]))
    np.testing.assert_array_equal(corners.ends, corners.starts[:-1] + np.where(own > 0, own, total))

    vertex = np.repeat(np.arange(count), total)
    later = np.arange(faces.size) >= (corners.starts[:-1] + own)[vertex]
    found = np.column_stack([vertex, later, *(getattr(corners, name) for name in FIELDS)])
    edges = [tuple(sorted(pair)) for pair in zip(corners.a, corners.b, strict=True)]
    rims = Counter(tuple(sorted(side)) for face in faces.tolist() for side in permutations(face, 2))
    alone = [not gradient.stars and rims[edge] == 2 for edge in edges]  # there and back
    np.testing.assert_array_equal(np.signbit(corners.edge), alone)
    found[:, -1] = np.abs(found[:, -1])
    lengths, (c, a, b) = plain_lengths(gradient), ([0, 1, 2], [1, 2, 0], [2, 0, 1])
    table = [faces, foreign, faces[:, a], faces[:, b], lengths[:, b], lengths[:, a], lengths[:, c]]
    expected = np.column_stack([column.ravel() for column in table])
    for one in (found, expected):
        one[:] = one[np.lexsort(one.T[::-1].round(9))]
    np.testing.assert_allclose(found, expected, rtol=1e-12)


@pytest.mark.parametrize("name", ["sphere", "right angles", "obtuse", "scrambled"])
def test_corners_surround_every_interior_vertex(name):
    metric = assembled(DOMAINS[name])
    corners = WavefrontSweeper(metric)._corners
    for v in np.flatnonzero(~metric.boundary):
        own = slice(corners.starts[v], corners.starts[v + 1])
        np.testing.assert_array_equal(corners.a[own], np.roll(corners.b[own], 1))


@pytest.mark.parametrize("count", [MANY, MANY + 1])
def test_a_vertex_of_many_triangles_has_them_in_their_order(count):
    rng = np.random.default_rng(0)
    wheel = disk(count)
    wheel = gt.TriangleMesh(wheel.vertices, wheel.faces[rng.permutation(count)])
    corners = WavefrontSweeper(assembled(wheel))._corners
    around = corners.a[: corners.starts[1]]
    as_given = np.array_equal(around, wheel.faces[:, 1])
    assert as_given == (count > MANY)
    assert np.array_equal(np.sort(around), np.arange(1, count + 1))


def test_curvature_is_the_mean_angle_defect_over_the_mean_area(sweeper):
    gradient, count = sweeper.metric.gradient, sweeper.metric.n_vertices
    if gradient.stars:
        np.testing.assert_array_equal(sweeper._curvature, np.zeros(count))
        return
    faces, hats = gradient.elements, gradient.coefficients
    angles, area = np.zeros(count), np.zeros(count)
    for corner in range(3):
        p, q = hats[:, :, (corner + 1) % 3], hats[:, :, (corner + 2) % 3]
        across, along = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0], (p * q).sum(axis=1)
        np.add.at(angles, faces[:, corner], np.arctan2(np.abs(across), -along))
        np.add.at(area, faces[:, corner], gradient.measure / 3)
    pairs = (np.repeat(faces, 3, axis=1).ravel(), np.tile(faces, (1, 3)).ravel())
    ring = csr_array(coo_array((np.ones(len(pairs[0])), pairs), shape=(count, count)))
    sheets = np.bincount(faces.ravel(), minlength=count) > np.diff(ring.indptr) - 1
    defect = np.where(sweeper.metric.boundary | sheets | (area == 0), 0.0, 2 * np.pi - angles)
    total = ring @ area
    expected = np.divide(ring @ defect, total, out=np.zeros(count), where=total > 0)
    expected /= 1 + np.abs(expected) * area * 2 / np.sqrt(3) / refine.CURVATURE_OF_HALF_WEIGHT
    atol = 1e-13 / sweeper.metric.spacing**2
    np.testing.assert_allclose(sweeper._curvature, expected, rtol=1e-12, atol=atol)


def test_fronts_cross_a_delaunay_triangulation_of_the_same_surface():
    sheared = shapes.grid(9, shear=2.0)
    given, delaunay = (
        WavefrontSweeper(gt.CotanLaplacian(intrinsic_delaunay=flip).assemble(sheared))._triangles
        for flip in (False, True)
    )
    edges, flipped = edges_of(given[0]), edges_of(delaunay[0])
    assert edges == flipped != edges_of(sheared.faces)
    assert given[2].sum() == pytest.approx(delaunay[2].sum())


def test_edges_at_sharp_vertices_are_not_flipped():
    sphere, rng = shapes.icosphere(3), np.random.default_rng(0)
    bumps = rng.uniform(0.93, 1.07, (sphere.n_vertices, 1))
    mesh = gt.TriangleMesh(sphere.vertices * bumps * [1, 1, 3], sphere.faces)
    sweeper = WavefrontSweeper(assembled(mesh))
    sharp = np.abs(sweeper._defects) > refine.MIN_DEFECT_OF_CORNERS
    before, after = edges_of(mesh.faces), edges_of(sweeper._triangles[0])
    assert before != after
    assert 0.1 < sharp.mean() < 0.9
    assert {edge for edge in before if sharp[list(edge)].any()} <= after


def test_the_defects_of_a_closed_surface_are_its_whole_curvature():
    for mesh, whole in ((shapes.icosphere(2), 4 * np.pi), (shapes.torus(12, 7), 0.0)):
        sweeper = WavefrontSweeper(assembled(mesh))
        assert sweeper._defects.sum() == pytest.approx(whole, abs=1e-9)
        assert not sweeper._reflex.any()


def test_a_front_turns_about_a_reflex_corner_of_the_boundary(monkeypatch):
    mesh = plate_with_a_notch(20)
    corner = int(np.flatnonzero((mesh.vertices == [10, 10, 0]).all(axis=1))[0])
    source = int(np.flatnonzero((mesh.vertices == [20, 4, 0]).all(axis=1))[0])
    metric = assembled(mesh)
    assert np.flatnonzero(WavefrontSweeper(metric)._reflex).tolist() == [corner]
    to_corner, x = mesh.vertices[corner] - mesh.vertices[source], mesh.vertices
    beyond = x - mesh.vertices[corner]
    shadow = np.flatnonzero(to_corner[0] * beyond[:, 1] - to_corner[1] * beyond[:, 0] < -1e-9)
    shadow = shadow[x[shadow, 1] > 10]
    exact = np.linalg.norm(to_corner) + np.linalg.norm(beyond[shadow], axis=1)

    def error():
        found = gt.HeatMethod(
            metric, heat_solver=gt.SuperLU(), poisson_solver=gt.SuperLU(), refine=True
        ).distance(source)[shadow]
        return np.abs(found / exact - 1).mean()

    turning = error()
    monkeypatch.setattr(refine, "MIN_ANGLE_OF_REFLEX_CORNERS", np.inf)
    assert turning < 0.8 * error()
    assert turning < 0.005


@pytest.mark.parametrize("name", ["sphere", "obtuse", "scrambled", "many sheets", "cloud"])
def test_after_the_sweeps_no_vertex_has_anything_to_gain(name):
    solver = gt.GeodesicSolver(DOMAINS[name], refine=True)
    method = solver.method
    fronts, log_heat = method._refined.sweeper._fronts, method.log_heat(2)
    tolerance = np.array([refine.SWEEP_TOLERANCE * method.metric.spacing])

    def swept(vertices, distances, kappas):
        """Return what sweeps make of fronts at vertices, of which all neighbours are asked."""
        found = np.empty((1, len(log_heat))), np.empty((1, len(log_heat)))
        begins = np.array([0, len(vertices)])
        sources = (begins, vertices, distances, kappas, tolerance)
        fronts.sweep(log_heat, True, *sources, 0, 0, refine.MAX_SWEEPS, *found)
        return found[0][0], found[1][0]

    distance, kappa = swept(np.array([2]), np.array([0.0]), np.array([np.inf]))
    reached = np.flatnonzero(np.isfinite(distance))
    assert len(reached) > 6
    again, _ = swept(reached, distance[reached], kappa[reached])
    np.testing.assert_array_equal(again, distance)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("heat", np.zeros(7), "a number for each vertex"),
        ("heat", np.zeros((162, 2)), "a number for each vertex"),
        ("distances", np.zeros((2, 162)), "a number for each vertex"),
        ("begins", np.array([0, 2]), "a beginning and a tolerance"),
        ("begins", np.array([0]), "a beginning and a tolerance"),
        ("tolerances", np.zeros(2), "a beginning and a tolerance"),
        ("known", np.zeros(2), "a distance and a curvature"),
        ("vertices", np.array([162]), "vertices of the sources"),
        ("vertices", np.array([-1]), "vertices of the sources"),
        ("n_threads", 0, "at least one thread"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(name, value, message):
    fronts, count = WavefrontSweeper(assembled(DOMAINS["sphere"]))._fronts, 162
    arguments = {
        "heat": np.zeros(count),
        "logarithmic": True,
        "begins": np.array([0, 1]),
        "vertices": np.array([0]),
        "known": np.array([0.0]),
        "curvatures": np.array([np.inf]),
        "tolerances": np.zeros(1),
        "returns": 0,
        "steady": 0,
        "most_sweeps": 1,
        "distances": np.empty((1, count)),
    }
    fronts.sweep(**arguments)
    with pytest.raises(ValueError, match=message):
        fronts.sweep(**(arguments | {name: value}))


def test_limited_fronts_reach_what_is_near_and_do_not_take_ways_around():
    mesh = gt.testing.shapes.grid(21)
    method = gt.GeodesicSolver(mesh, refine=True).method
    source, (x, y) = SourcePoints.at_vertices(np.array([0]), mesh.n_vertices), mesh.vertices.T[:2]
    whole = method.distance(0)
    near = method.sweeper.distance_within(source, np.full(mesh.n_vertices, 0.52))
    np.testing.assert_allclose(near[whole < 0.52], whole[whole < 0.52], rtol=1e-9)
    assert np.isinf(near[whole > 0.53]).all()
    wall = (x > 0.48) & (x < 0.52) & (y < 0.9)
    beyond = method.sweeper.distance_within(source, np.where(wall, -1.0, 1.0))
    assert np.isinf(beyond[(x > 0.52) & (y < 0.2)]).all()  # a way around is longer than 1
    everything = method.sweeper.distance_within(source, np.full(mesh.n_vertices, np.inf))
    np.testing.assert_allclose(everything, whole, rtol=1e-9)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("latest", np.zeros(161), "a limit and a distance for each vertex"),
        ("distances", np.zeros(161), "a limit and a distance for each vertex"),
        ("vertices", np.array([162]), "vertices of the sources"),
        ("known", np.zeros(2), "a distance and a curvature"),
    ],
)
def test_arrays_that_do_not_fit_limited_fronts_are_refused(name, value, message):
    fronts, count = WavefrontSweeper(assembled(DOMAINS["sphere"]))._fronts, 162
    arguments = {
        "vertices": np.array([0]),
        "known": np.array([0.0]),
        "curvatures": np.array([np.inf]),
        "tolerance": 0.0,
        "latest": np.full(count, np.inf),
        "most_visits": 1,
        "distances": np.empty(count),
    }
    fronts.sweep_limited(**arguments)
    with pytest.raises(ValueError, match=message):
        fronts.sweep_limited(**(arguments | {name: value}))


@given(st.lists(st.integers(-50, 50).map(lambda k: k / 7 if k > -50 else -np.inf), min_size=1))
def test_the_order_falls_and_keeps_that_of_equals(values):
    values = np.array(values)
    expected = np.argsort(-values, kind="stable")
    np.testing.assert_array_equal(_native.falling(values, True), expected)
    np.testing.assert_array_equal(_native.falling(np.exp(values), False), expected)


@pytest.mark.parametrize("count", [1, 2, 3000, 70_000])
def test_heat_of_any_range_is_ordered_to_six_digits(count):
    rng = np.random.default_rng(0)
    log_heat = rng.uniform(-700, 0, (count, 3))
    log_heat[rng.random((count, 3)) < 0.1] = -np.inf
    orders = [
        _native.falling(log_heat, True).reshape(3, count),
        _native.falling(np.exp(log_heat), False).reshape(3, count),
    ]
    for order in orders:
        for own, values in zip(order, log_heat.T, strict=True):
            assert (np.sort(own) == np.arange(count)).all()
            found, best = values[own], np.sort(values)[::-1]
            warm = np.isfinite(best)
            np.testing.assert_allclose(found[warm], best[warm], rtol=0, atol=1e-6)
            assert (own[~warm] == np.flatnonzero(~np.isfinite(values))).all()


@pytest.mark.parametrize("returns", [0, 1, 8])
def test_an_order_that_says_nothing_costs_sweeps_and_not_the_distance(returns, monkeypatch):
    monkeypatch.setattr(refine, "MAX_RETURNS_PER_VERTEX", returns)
    sphere = shapes.icosphere(3)
    sweeper = WavefrontSweeper(assembled(sphere))
    noise = np.random.default_rng(0).normal(size=sphere.n_vertices)
    source = SourcePoints.at_vertices(np.array([0]), sphere.n_vertices)
    (distance,) = distances = np.empty((1, sphere.n_vertices))
    sweeper.fill(distances, Heat.of_log(noise), [source])
    assert mean_relative_error(distance, on_sphere(sphere, 0)) < 5e-3


@pytest.mark.parametrize("count", [7, 8, 9, 16])
def test_any_number_of_vertices_fits_the_flags(count):
    distance = gt.geodesic_distance(disk(count - 1), 0, refine=True)
    np.testing.assert_allclose(distance[1:], 1)
