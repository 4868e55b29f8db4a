"""Costs, metric tensors and edge lengths alone: distances by closed forms."""

from itertools import pairwise

import numpy as np
import pytest
from closed_forms import by_snell, mean_relative_error, on_tube

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidSourceError, UnsupportedDomainError
from geodesic_toolkit.geometry.triangles import face_edge_lengths
from geodesic_toolkit.testing import shapes

pytestmark = pytest.mark.filterwarnings("ignore::geodesic_toolkit.errors.CoarseMeshWarning")

SIDES = (11, 21, 41)
"""Vertices along the side of a square, from coarse to fine."""

# Mean relative errors allowed on the finest square, and the factor by which they must fall per
# halving, for refined distances and for plain heat. Measured at a jump of the cost: 0.1 to 0.5 %
# and 1.6 to 2.6 %, falling by 0.35 to 0.5 and 0.5 to 0.75; where the cost is smooth 0.03 and 1.9 %,
# by 0.2 to 0.3 and 0.5 to 0.6; with a constant tensor 2.6 % for plain heat.
TOLERANCES_AT_JUMP = {True: 0.008, False: 0.035}
TOLERANCES_OF_SMOOTH = {True: 0.0006, False: 0.025}
TOLERANCE_OF_TENSOR = 0.035
HALVINGS_AT_JUMP = {True: 0.6, False: 0.85}
HALVINGS_OF_SMOOTH = {True: 0.35, False: 0.75}

both = pytest.mark.parametrize("refine", [True, False], ids=["refined", "plain"])


def nearest(mesh, *place):
    return int(np.linalg.norm(mesh.vertices[:, : len(place)] - place, axis=1).argmin())


def middles(mesh):
    return mesh.vertices[mesh.faces].mean(axis=1)


def distance_from(domain, source, refine=True):
    return gt.GeodesicSolver(domain, refine=refine).distance(source)


@both
@pytest.mark.parametrize("costs", [(1.0, 2.0), (2.0, 1.0), (5.0, 1.0)], ids=str)
def test_paths_bend_by_snells_law_where_the_cost_jumps(costs, refine):
    errors = []
    for n in SIDES:
        mesh = shapes.grid(n)
        source = nearest(mesh, 0.2, 0.3)
        cost = np.where(middles(mesh)[:, 0] < 0.5, *costs)
        times = distance_from(gt.MetricMesh(mesh, cost=cost), source, refine)
        errors.append(mean_relative_error(times, by_snell(mesh, source, *costs)))
    assert errors[-1] < TOLERANCES_AT_JUMP[refine]
    assert all(after < HALVINGS_AT_JUMP[refine] * before for before, after in pairwise(errors))


@both
def test_travel_times_in_a_linear_velocity_are_second_order(refine):
    errors = []
    for n in SIDES:
        mesh = shapes.grid(n)
        source = nearest(mesh, 0.2, 0.5)
        velocity = 1.0 + 3.0 * mesh.vertices[:, 0]
        squares = ((mesh.vertices - mesh.vertices[source]) ** 2).sum(axis=1)
        exact = np.arccosh(1 + 9.0 * squares / (2 * velocity * velocity[source])) / 3.0
        times = distance_from(gt.MetricMesh(mesh, cost=1 / velocity), source, refine)
        errors.append(mean_relative_error(times, exact))
    assert errors[-1] < TOLERANCES_OF_SMOOTH[refine]
    assert all(after < HALVINGS_OF_SMOOTH[refine] * before for before, after in pairwise(errors))


TENSOR = np.array([[4.0, 1.5, 0.0], [1.5, 1.0, 0.0], [0.0, 0.0, 7.0]])


def in_frames_of_faces(mesh, tensor):
    """Return the same tensor in the frame of each face of a mesh in the xy plane."""
    corners = mesh.vertices[mesh.faces]
    first = corners[:, 1] - corners[:, 0]
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    axes = np.stack([first, np.cross([0.0, 0.0, 1.0], first)], axis=1)
    return np.einsum("fkd,de,fle->fkl", axes, tensor, axes)


@pytest.mark.parametrize("form", ["faces in space", "vertices in space", "frames of faces"])
def test_circles_of_a_constant_tensor_are_ellipses(form):
    mesh = shapes.grid(SIDES[-1])
    source = nearest(mesh, 0.5, 0.5)
    tensor = {
        "faces in space": np.tile(TENSOR, (mesh.n_faces, 1, 1)),
        "vertices in space": np.tile(TENSOR, (mesh.n_vertices, 1, 1)),
        "frames of faces": in_frames_of_faces(mesh, TENSOR),
    }[form]
    steps = mesh.vertices - mesh.vertices[source]
    exact = np.sqrt(np.einsum("nd,de,ne->n", steps, TENSOR, steps))
    domain = gt.MetricMesh(mesh, tensor=tensor)
    np.testing.assert_allclose(distance_from(domain, source), exact, atol=1e-12)
    assert mean_relative_error(distance_from(domain, source, False), exact) < TOLERANCE_OF_TENSOR


def test_a_tensor_that_jumps_keeps_the_distances_of_its_parts():
    mesh = shapes.grid(21)
    source = nearest(mesh, 0.2, 0.5)
    left = middles(mesh)[:, 0] < 0.5
    tensor = np.where(left[:, None, None], np.eye(3), np.diag([9.0, 1.0, 1.0]))
    distance = distance_from(gt.MetricMesh(mesh, tensor=tensor), source)
    here = mesh.vertices[:, 0] < 0.5 + 1e-9
    straight = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)
    np.testing.assert_allclose(distance[here], straight[here], rtol=1e-9)
    ahead = nearest(mesh, 1.0, 0.5)  # a straight path, at a right angle to the line
    assert distance[ahead] == pytest.approx(0.3 + 3 * 0.5, rel=0.01)


@both
@pytest.mark.parametrize("factor", [1e-3, 3.7])
def test_a_constant_cost_multiplies_all_distances(factor, refine):
    ball = shapes.icosphere(3)
    plain = distance_from(ball, 0, refine)
    for cost in (factor, np.full(ball.n_faces, factor), np.full(ball.n_vertices, factor)):
        times = distance_from(gt.MetricMesh(ball, cost=cost), 0, refine)
        np.testing.assert_allclose(times, factor * plain, rtol=1e-11)


def test_a_path_along_an_edge_has_the_lesser_cost():
    # A road of one row of faces through mud.
    mesh = shapes.grid(11)
    height = middles(mesh)[:, 1]
    cost = np.where((height > 0.5) & (height < 0.6), 1.0, 10.0)
    times = distance_from(gt.MetricMesh(mesh, cost=cost), nearest(mesh, 0.0, 0.5))
    assert times[nearest(mesh, 1.0, 0.5)] == pytest.approx(1.0, rel=1e-9)


def test_corner_faces_of_another_cost_are_crossed():
    # The diagonal of a corner joins two vertices of the boundary, and is inside the surface.
    mesh = shapes.grid(2)
    times = distance_from(gt.MetricMesh(mesh, cost=[1.0, 3.0]), 0)
    assert np.isfinite(times).all()
    fine = shapes.grid(9)
    cost = np.random.default_rng(0).uniform(1, 3, fine.n_faces)
    times = distance_from(gt.MetricMesh(fine, cost=cost), nearest(fine, 0.5, 0.5))
    straight = np.linalg.norm(fine.vertices - [0.5, 0.5, 0.0], axis=1)
    assert (times >= straight - 1e-12).all()
    assert (times <= 3 * straight * 1.1 + 1e-12).all()


@both
def test_a_cost_that_changes_within_a_face_still_makes_triangles(refine):
    mesh = shapes.grid(15)
    cost = 10.0 ** np.random.default_rng(1).uniform(-1, 1, mesh.n_vertices)
    domain = gt.MetricMesh(mesh, cost=cost)
    longest = domain.lengths.max(axis=1)
    assert (domain.lengths.sum(axis=1) > 2 * longest).all()
    times = distance_from(domain, 0, refine)
    assert np.isfinite(times).all()


# -- edge lengths alone ----------------------------------------------------------------------------


@both
def test_a_tube_by_its_edge_lengths_is_the_tube_in_space(refine):
    rings, around = 24, 12
    tube = shapes.tube(rings, around)
    intrinsic = gt.IntrinsicMesh(tube.faces, face_edge_lengths(tube.vertices, tube.faces))
    assert not intrinsic.has("positions")
    ours, theirs = (distance_from(domain, 0, refine) for domain in (intrinsic, tube))
    np.testing.assert_allclose(ours, theirs, rtol=0.01 if refine else 1e-9, atol=1e-9)
    assert mean_relative_error(ours, on_tube(rings, around)) < (0.01 if refine else 0.05)


def test_a_matrix_of_an_intrinsic_surface_is_that_of_the_embedded_one():
    ball = shapes.icosphere(3)
    intrinsic = gt.IntrinsicMesh(ball.faces, face_edge_lengths(ball.vertices, ball.faces))
    ours, theirs = (
        gt.distance_matrix(gt.GeodesicSolver(one), [0, 7, 99]) for one in (intrinsic, ball)
    )
    np.testing.assert_allclose(ours, theirs, rtol=1e-9)


@pytest.mark.parametrize("kind", ["cost", "intrinsic"])
def test_masked_vertices_are_not_crossed(kind):
    mesh = shapes.grid(11)
    domain = (
        gt.MetricMesh(mesh, cost=2.0)
        if kind == "cost"
        else gt.IntrinsicMesh(mesh.faces, 2 * face_edge_lengths(mesh.vertices, mesh.faces))
    )
    wall = np.isclose(mesh.vertices[:, 0], 0.5) & (mesh.vertices[:, 1] < 0.85)
    source = nearest(mesh, 0.3, 0.2)
    ours = gt.GeodesicSolver(domain, mask=wall).distance(source)
    theirs = gt.GeodesicSolver(mesh, mask=wall, refine=True).distance(source)
    np.testing.assert_array_equal(np.isinf(ours), wall)
    np.testing.assert_allclose(ours[~wall], 2 * theirs[~wall], rtol=0.02)


@pytest.mark.parametrize("kind", ["cost", "intrinsic"])
def test_a_source_inside_a_face_is_measured_by_the_metric(kind):
    mesh = shapes.grid(6)
    lengths = 3 * face_edge_lengths(mesh.vertices, mesh.faces)
    domain = (
        gt.MetricMesh(mesh, cost=3.0) if kind == "cost" else gt.IntrinsicMesh(mesh.faces, lengths)
    )
    point = gt.SurfacePoint(12, (0.2, 0.5, 0.3))
    place = np.array([0.2, 0.5, 0.3]) @ mesh.vertices[mesh.faces[12]]
    exact = 3 * np.linalg.norm(mesh.vertices - place, axis=1)
    np.testing.assert_allclose(distance_from(domain, point), exact, rtol=0.02)
    located = gt.GeodesicSolver(domain).locate(point)
    np.testing.assert_allclose(located.distances, exact[located.vertices], rtol=1e-12)


def test_points_in_space_are_sources_and_queries_of_a_mesh_with_a_cost():
    mesh = shapes.grid(11)
    solver = gt.GeodesicSolver(gt.MetricMesh(mesh, cost=2.0))
    distance = solver.distance([[0.0, 0.0, 0.1]])
    found = solver.interpolate(distance, [[0.75, 0.0, 0.05], [0.5, 0.5, 9.0]])
    np.testing.assert_allclose(found, [1.5, np.inf], rtol=1e-9)


def test_edges_of_a_mesh_with_a_cost_are_a_graph():
    mesh = shapes.grid(2)
    graph = gt.MetricMesh(mesh, cost=[1.0, 3.0]).as_graph()
    assert sorted(graph.lengths) == pytest.approx([1.0, 1.0, np.sqrt(2), 3.0, 3.0])


def test_what_needs_a_surface_in_space_is_refused():
    mesh = shapes.grid(5)
    lengths = face_edge_lengths(mesh.vertices, mesh.faces)
    weighted, intrinsic = gt.MetricMesh(mesh, cost=2.0), gt.IntrinsicMesh(mesh.faces, lengths)
    with pytest.raises(InvalidSourceError, match="a curve is measured in space"):
        gt.geodesic_distance(weighted, gt.Curve([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]))
    with pytest.raises(InvalidSourceError, match="has no positions"):
        gt.geodesic_distance(intrinsic, [[0.0, 0.0, 0.0]])
    with pytest.raises(UnsupportedDomainError, match="no positions"):
        gt.GeodesicSolver(intrinsic).interpolate(np.zeros(25), [[0.0, 0.0, 0.0]])
    with pytest.raises(InvalidSourceError, match="are not the corners of a face"):
        gt.geodesic_distance(intrinsic, gt.Located([[0, 1, 24]], [[0.2, 0.3, 0.5]]))
    for domain in (weighted, intrinsic):
        with pytest.raises(UnsupportedDomainError, match="surface in space"):
            _ = gt.GeodesicSolver(domain).frames
        with pytest.raises(UnsupportedDomainError):
            gt.exact_distance(domain, 0)
        with pytest.raises(UnsupportedDomainError):
            gt.geodesic_disc(gt.GeodesicSolver(domain), 0, 0.5)
        with pytest.raises(UnsupportedDomainError):
            gt.log_map(gt.GeodesicSolver(domain), 0)


# -- isochrones ------------------------------------------------------------------------------------


def test_an_isochrone_of_a_uniform_cost_is_an_isoline_at_another_level():
    plane = shapes.grid(41)
    middle = nearest(plane, 0.5, 0.5)
    slow = gt.MetricMesh(plane, cost=2.0)
    (isochrone,) = gt.isolines(slow, distance_from(slow, middle), 0.6)
    points = np.array(
        [p.barycentric @ plane.vertices[plane.faces[p.face]] for p in isochrone.points]
    )
    assert isochrone.closed
    np.testing.assert_allclose(np.linalg.norm(points - plane.vertices[middle], axis=1), 0.3, 5e-3)
    alone = gt.IntrinsicMesh(slow.faces, slow.lengths)
    (same,) = gt.isolines(alone, distance_from(alone, middle), 0.6)
    assert [place.face for place in same.points] == [place.face for place in isochrone.points]


def test_lengths_and_discs_need_faces_in_space():
    slow = gt.MetricMesh(shapes.grid(5), cost=2.0)
    with pytest.raises(UnsupportedDomainError, match="whose faces lie in space"):
        gt.area_above(slow, np.zeros(25), 0.0)
    with pytest.raises(UnsupportedDomainError, match="whose faces lie in space"):
        gt.geodesic_disc(gt.GeodesicSolver(slow), 0, 0.5)
