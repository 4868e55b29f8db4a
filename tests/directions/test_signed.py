"""Signed distance from curves: open, closed, broken, several, on meshes and clouds."""

import numpy as np
import pytest
from curved_shapes import irregular_plate, irregular_sphere, moebius

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidCurveError,
    InvalidOptionError,
    InvalidSourceError,
    UnsupportedDomainError,
)
from geodesic_toolkit.geometry.isolines import level_set

SPHERE = irregular_sphere(1500, seed=1)
SPACING = gt.CotanLaplacian().assemble(SPHERE).spacing


def latitude(angle, degrees=(0, 360)):
    """Part of a circle of latitude so far from the pole, along which the south is on the left."""
    closed = degrees == (0, 360)
    turn = np.radians(np.linspace(*degrees, 200, endpoint=not closed))[::-1]
    points = [np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), 0 * turn + np.cos(angle)]
    return gt.Curve(np.column_stack(points), closed=closed)


def beyond(points, angle):
    """The signed distance from a circle of latitude on the unit sphere."""
    return np.arccos(np.clip(points[:, 2], -1, 1)) - angle


def relative_error(distance, exact, spacing=SPACING):
    away = np.abs(exact) > spacing
    return float((np.abs(distance - exact)[away] / np.abs(exact)[away]).mean())


def wrong_signs(distance, exact, spacing=SPACING):
    return int(((distance * exact < 0) & (np.abs(exact) > 0.2 * spacing)).sum())


@pytest.fixture(scope="module")
def solver():
    return gt.GeodesicSolver(SPHERE)


@pytest.mark.parametrize("angle", [0.6, 1.2])
@pytest.mark.parametrize(("refine", "bound"), [(None, 0.002), (False, 0.006)])
def test_from_a_circle_of_latitude(solver, angle, refine, bound):
    exact = beyond(SPHERE.vertices, angle)
    distance = gt.signed_distance(solver, latitude(angle), refine=refine)
    assert relative_error(distance, exact) < bound  # 0.0012 and 0.0039
    assert wrong_signs(distance, exact) == 0


def test_refined_it_is_the_distance_with_a_sign(solver):
    curve = latitude(1.2)
    distance = gt.signed_distance(solver, curve)
    np.testing.assert_allclose(np.abs(distance), solver.distance(curve), atol=0.05 * SPACING)


def test_along_the_reversed_curve_it_has_the_opposite_sign(solver):
    curve = latitude(1.2)
    back = gt.Curve(curve.points[::-1], closed=True)
    for refine in (False, True):
        one, other = (gt.signed_distance(solver, c, refine=refine) for c in (curve, back))
        np.testing.assert_allclose(one, -other, atol=0.02 * SPACING)


def test_a_plain_one_is_level_on_the_curve_or_in_its_mean(solver):
    curve = latitude(0.6)
    exact = beyond(SPHERE.vertices, 0.6)
    beside = np.abs(exact) < SPACING
    level, mean = (
        gt.signed_distance(solver, curve, refine=False, level=level) for level in (True, False)
    )
    assert np.abs(level - exact)[beside].mean() < np.abs(mean - exact)[beside].mean()


@pytest.mark.parametrize("refine", [False, True])
def test_gaps_are_bridged(solver, refine):
    exact = beyond(SPHERE.vertices, 1.2)
    half = [latitude(1.2, (begin, begin + 60)) for begin in (0, 120, 240)]
    distance = gt.signed_distance(solver, half, refine=refine)
    assert relative_error(distance, exact) < 0.033
    most = [latitude(1.2, (150, 360))]
    distance = gt.signed_distance(solver, most, refine=refine)
    assert relative_error(distance, exact) < 0.11


def test_segments_may_cross_any_number_of_faces():
    mesh = irregular_plate(20)
    distance = gt.signed_distance(gt.GeodesicSolver(mesh), gt.Curve([[0.3, 0, 0], [0.3, 1, 0]]))
    np.testing.assert_allclose(distance, 0.3 - mesh.vertices[:, 0], atol=1e-6)


def test_corners_may_be_points_of_faces():
    mesh = irregular_plate(20)
    chain = level_set(mesh.faces, 0.3 - mesh.vertices[:, 0])[0]
    points = [
        gt.SurfacePoint(f, tuple(w))
        for f, w in zip(chain.faces.tolist(), chain.weights.tolist(), strict=True)
    ]
    distance = gt.signed_distance(gt.GeodesicSolver(mesh), gt.Curve(points))
    np.testing.assert_allclose(distance, 0.3 - mesh.vertices[:, 0], atol=1e-6)


def test_several_curves_have_each_their_sides():
    mesh = irregular_plate(24)
    solver = gt.GeodesicSolver(mesh)
    curves = [gt.Curve([[0.2, 1, 0], [0.2, 0, 0]]), gt.Curve([[0.8, 0, 0], [0.8, 1, 0]])]
    exact = np.minimum(mesh.vertices[:, 0] - 0.2, 0.8 - mesh.vertices[:, 0])
    for refine, bound in ((True, 1e-6), (False, 0.05)):
        distance = gt.signed_distance(solver, curves, refine=refine)
        assert np.abs(distance - exact).max() < bound
        assert wrong_signs(distance, exact, solver.method.metric.spacing) == 0


@pytest.mark.parametrize("refine", [False, True])
def test_curves_without_sides_shorten_the_distance_and_change_no_sign(refine):
    mesh = irregular_plate(20)
    solver = gt.GeodesicSolver(mesh)
    curve = gt.Curve([[0.3, 0, 0], [0.3, 1, 0]])
    wall = gt.Curve([[0.7, 0, 0], [0.7, 1, 0]])
    distance = gt.signed_distance(solver, curve, unsigned=wall, refine=refine)
    x = mesh.vertices[:, 0]
    exact = np.sign(0.3 - x) * np.minimum(np.abs(x - 0.3), np.abs(x - 0.7))
    np.testing.assert_allclose(distance, exact, atol=0.06)


def test_about_a_corner_the_sides_are_those_of_the_region():
    mesh = irregular_plate(30)
    solver = gt.GeodesicSolver(mesh)
    box = gt.Curve([[0.3, 0.3, 0], [0.7, 0.3, 0], [0.7, 0.7, 0], [0.3, 0.7, 0]], closed=True)
    distance = gt.signed_distance(solver, box)
    out = np.maximum(np.abs(mesh.vertices[:, :2] - 0.5) - 0.2, 0)
    inside = 0.2 - np.abs(mesh.vertices[:, :2] - 0.5).max(axis=1)
    exact = np.where(inside > 0, inside, -np.hypot(*out.T))
    assert wrong_signs(distance, exact, solver.method.metric.spacing) == 0
    assert np.abs(distance - exact).max() < 0.6 * solver.method.metric.spacing


@pytest.mark.parametrize("refine", [False, True])
def test_nothing_comes_to_what_no_curve_connects(refine):
    ball = irregular_sphere(300)
    vertices = np.concatenate([ball.vertices, ball.vertices + np.array([5.0, 0, 0])])
    solver = gt.GeodesicSolver(
        gt.TriangleMesh(vertices, np.concatenate([ball.faces, ball.faces + 300]))
    )
    for level in (False, True):
        distance = gt.signed_distance(solver, latitude(1.2), refine=refine, level=level)
        assert np.isposinf(distance[300:]).all()
        assert relative_error(distance[:300], beyond(ball.vertices, 1.2), 0.2) < 0.03


def test_far_from_the_curve_it_is_still_there():
    tube = gt.testing.shapes.tube(900, 8)
    solver = gt.GeodesicSolver(tube)
    axis = tube.vertices[:, 2]
    ring = np.flatnonzero(axis == axis.min())
    turn = np.argsort(np.arctan2(*tube.vertices[ring, 1::-1].T))
    start = gt.Curve(tube.vertices[ring[turn]], closed=True)
    for refine in (False, True):
        distance = np.abs(gt.signed_distance(solver, start, refine=refine))
        np.testing.assert_allclose(distance, axis - axis.min(), rtol=0.01, atol=0.5)


@pytest.mark.parametrize("refine", [None, True])
@pytest.mark.parametrize("noise", [0.0, 0.004])
def test_on_a_cloud_it_is_as_good(refine, noise):
    shaken = SPHERE.vertices * (1 + noise * np.random.default_rng(0).normal(size=(1500, 1)))
    solver = gt.GeodesicSolver(gt.PointCloud(shaken))
    exact = beyond(SPHERE.vertices, 1.2)
    distance = gt.signed_distance(solver, latitude(1.2), refine=refine)
    assert relative_error(distance, exact) < 0.004
    assert wrong_signs(distance, exact) == 0


@pytest.mark.parametrize("refine", [False, True])
def test_on_sheared_plates_and_on_faces_turned_over(refine):
    sheared = gt.testing.shapes.grid(20, shear=4.0)
    faces = sheared.faces.copy()
    faces[::3] = faces[::3, ::-1]
    for mesh in (sheared, gt.TriangleMesh(sheared.vertices, faces)):
        solver = gt.GeodesicSolver(mesh)
        line = gt.Curve([[0, 0.5, 0], [5.0, 0.5, 0]][::-1])
        if mesh is sheared:
            line = gt.Curve(
                np.column_stack([np.linspace(2.0, 3.0, 9), np.full(9, 0.5), np.zeros(9)])
            )
            distance = gt.signed_distance(solver, line, refine=refine)
            exact = mesh.vertices[:, 1] - 0.5
            assert (distance * exact >= -1e-9).all()
        else:
            distance = gt.signed_distance(
                solver,
                gt.Curve(np.column_stack([np.linspace(2.0, 3.0, 9), np.full(9, 0.5), np.zeros(9)])),
                refine=refine,
            )
            assert (distance * (mesh.vertices[:, 1] - 0.5) >= -1e-9).all()


def test_through_a_mask_there_is_no_way():
    mesh = irregular_plate(20)
    wall = np.abs(mesh.vertices[:, 0] - 0.6) < 0.06
    solver = gt.GeodesicSolver(mesh, mask=wall)
    distance = gt.signed_distance(solver, gt.Curve([[0.3, 0, 0], [0.3, 1, 0]]))
    assert np.isposinf(distance[mesh.vertices[:, 0] > 0.6]).all()
    left = mesh.vertices[:, 0] < 0.5
    np.testing.assert_allclose(distance[left], 0.3 - mesh.vertices[left, 0], atol=1e-6)
    open_curve = gt.Curve([[0.3, 0.2, 0], [0.3, 0.8, 0]])
    assert np.isfinite(gt.signed_distance(solver, open_curve)[left]).all()


# -- what is refused -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("curves", "message"),
    [
        ([], "there are no curves"),
        ("circle", "curves must be a Curve or a sequence"),
        (np.zeros((3, 3)), "curves must be a Curve or a sequence"),
        ([latitude(1.0), [[0, 0, 1.0]]], "curve 1 must be a Curve"),
        (gt.Curve([[0, 0, 1.0], [0, 0, 1.0]]), "curve 0 is a single place"),
        (
            [latitude(1.0), gt.Curve([[0, 0.2, 1.0], [0, 0.1, -1.0]])],
            "curve 1 leaves the surface between its points 0 and 1",
        ),
    ],
)
def test_what_is_not_a_curve_on_the_surface_is_refused(solver, curves, message):
    with pytest.raises(InvalidCurveError, match=message):
        gt.signed_distance(solver, curves)


def test_a_bad_curve_without_sides_is_refused_too(solver):
    with pytest.raises(InvalidCurveError, match="unsigned curve 0 must be a Curve"):
        gt.signed_distance(solver, latitude(1.0), unsigned=[3])


def test_a_curve_in_another_unit_or_over_a_mask_is_refused():
    mesh = irregular_plate(10)
    with pytest.raises(InvalidSourceError, match="in the unit of the shape"):
        gt.signed_distance(gt.GeodesicSolver(mesh), gt.Curve([[0, 0, 0], [1e9, 0, 0]]))
    cloud = gt.PointCloud(SPHERE.vertices)
    solver = gt.GeodesicSolver(cloud, mask=np.abs(cloud.points[:, 2] - np.cos(1.2)) < 0.1)
    with pytest.raises(InvalidSourceError, match=r"curve 0: vertex \d+ is masked"):
        gt.signed_distance(solver, latitude(1.2))


@pytest.mark.parametrize("options", [{"refine": "yes"}, {"level": 1}, {"level": None}])
def test_options_are_true_or_false(solver, options):
    with pytest.raises(InvalidOptionError, match="must be True or False"):
        gt.signed_distance(solver, latitude(1.0), **options)


def test_what_has_no_sides_is_refused():
    curve = gt.Curve([[0.3, 0, 0], [0.3, 1, 0]])
    graph = gt.GeodesicSolver(gt.Graph(3, [[0, 1], [1, 2]]))
    with pytest.raises(UnsupportedDomainError, match="an edge has no angle"):
        gt.signed_distance(graph, curve)
    edges = gt.GeodesicSolver(irregular_plate(6), operator="uniform")
    with pytest.raises(UnsupportedDomainError, match="needs triangles"):
        gt.signed_distance(edges, curve)
    with pytest.raises(UnsupportedDomainError, match="one-sided"):
        gt.signed_distance(gt.GeodesicSolver(moebius()), gt.Curve([[1.3, 0, 0], [0.7, 0, 0]]))
    with pytest.raises(InvalidOptionError, match="signed_distance needs a GeodesicSolver"):
        gt.signed_distance(irregular_plate(5), curve)


# -- real meshes -----------------------------------------------------------------------------------

REAL = ["igltut__bunny.off", "jacobson__spot.obj", "igltut__3holes.off"]


@pytest.mark.parametrize("name", REAL)
def test_from_geodesic_circles_on_real_meshes(name, shared_data):
    mesh = gt.read(shared_data(name))
    solver = gt.GeodesicSolver(mesh)
    spacing = solver.method.metric.spacing
    reach = gt.exact_distance(mesh, mesh.n_vertices // 5)
    exact = reach - 0.3 * reach.max()
    circles = [
        gt.Curve(
            [
                gt.SurfacePoint(f, tuple(w))
                for f, w in zip(chain.faces.tolist(), chain.weights.tolist(), strict=True)
            ],
            closed=chain.closed,
        )
        for chain in level_set(mesh.faces, exact)
    ]
    distance = gt.signed_distance(solver, circles)
    outside = exact > spacing
    assert (np.abs(distance - exact) / np.abs(exact))[outside].mean() < 0.007
    assert wrong_signs(distance, exact, spacing) == 0


# -- level sets ------------------------------------------------------------------------------------


def test_a_level_set_is_one_closed_chain_with_larger_values_on_its_left():
    (chain,) = level_set(SPHERE.faces, SPHERE.vertices[:, 2], 0.3)
    assert chain.closed
    points = np.einsum("pc,pcd->pd", chain.weights, SPHERE.vertices[SPHERE.faces[chain.faces]])
    np.testing.assert_allclose(points[:, 2], 0.3, atol=1e-12)
    turn = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
    assert turn[-1] > turn[0] + 6  # counterclockwise, seen from the north


def test_a_level_set_ends_at_the_boundary_and_beside_what_is_not_finite():
    mesh = irregular_plate(12)
    (chain,) = level_set(mesh.faces, mesh.vertices[:, 0], 0.52)
    assert not chain.closed
    ends = np.einsum("pc,pcd->pd", chain.weights, mesh.vertices[mesh.faces[chain.faces]])[[0, -1]]
    np.testing.assert_allclose(ends[:, 1], [1, 0], atol=1e-12)
    values = np.where(mesh.vertices[:, 1] > 0.5, np.inf, mesh.vertices[:, 0])
    (chain,) = level_set(mesh.faces, values, 0.52)
    assert len(chain.faces) < 15
    assert level_set(mesh.faces, mesh.vertices[:, 0], 2.0) == []


def test_a_level_set_goes_by_vertices_that_have_just_the_level():
    mesh = gt.testing.shapes.grid(5)
    (chain,) = level_set(mesh.faces, mesh.vertices[:, 0], 0.5)
    points = np.einsum("pc,pcd->pd", chain.weights, mesh.vertices[mesh.faces[chain.faces]])
    np.testing.assert_allclose(points[:, 0], 0.5, atol=1e-9)
    assert np.ptp(points[:, 1]) == pytest.approx(1)
