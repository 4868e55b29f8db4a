"""The boundary of a surface: slivers there, sources there, and fronts that do not enter there."""

import dataclasses
import re
import warnings

import numpy as np
import pytest
from closed_forms import mean_relative_error, on_plane
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import Delaunay

import geodesic_toolkit as gt
from geodesic_toolkit import _native
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.errors import (
    CoarseMeshWarning,
    InvalidDiscretizationError,
    NonPositiveHeatWarning,
)
from geodesic_toolkit.geometry.rims import mirrored_at_rims, rim_cotangents, rim_edges
from geodesic_toolkit.geometry.triangles import face_edge_lengths, measured_by_lengths
from geodesic_toolkit.testing import shapes

DELAUNAY = gt.CotanLaplacian(intrinsic_delaunay=True)


def scattered(n, seed=0):
    """Return random points of a square, triangulated: along the hull lie slivers."""
    points = np.random.default_rng(seed).uniform(size=(n, 2))
    plan = Delaunay(points)
    return in_space(points, plan.simplices), np.unique(plan.convex_hull)


def in_space(points, faces):
    return gt.TriangleMesh(np.column_stack([points, np.zeros(len(points))]), faces)


def without(points, faces, gone):
    """Return the plane mesh without the faces for whose middles `gone` is true."""
    kept = faces[~gone(*points[faces].mean(axis=1).T)]
    used, kept = np.unique(kept, return_inverse=True)
    return in_space(points[used], kept.reshape(-1, 3))


def jittered(n, seed=0):
    """Return points near those of a grid over the unit square, and their triangles."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n))
    points = np.column_stack([x.ravel(), y.ravel()])
    inside = ((points > 0) & (points < 1)).all(axis=1)
    points[inside] += rng.uniform(-0.3, 0.3, size=(inside.sum(), 2)) / n
    faces = Delaunay(points).simplices
    u, v = (points[faces[:, k]] - points[faces[:, 0]] for k in (1, 2))
    return points, faces[np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) > 1e-9]


def off_diagonal(discretization):
    entries = discretization.stiffness.tocoo()
    return entries.data[entries.row != entries.col]


# -- the stiffness ---------------------------------------------------------------------------------


def test_an_obtuse_triangle_becomes_two_right_ones():
    # Its corner at (1, h): half the kite with its image is two triangles with legs (1, h) and (3,
    # h) that change along the rim alone.
    h = 0.5
    mesh = gt.TriangleMesh([[0, 0, 0], [4, 0, 0], [1, h, 0]], [[0, 1, 2]])
    found = DELAUNAY.assemble(mesh)
    expected = np.array([[h, 0, -h], [0, h / 3, -h / 3], [-h, -h / 3, h + h / 3]]) / 2
    np.testing.assert_allclose(found.stiffness.toarray(), expected, atol=1e-14)
    np.testing.assert_allclose(found.mass, [h / 6, h / 2, 4 * h / 3])
    assert found.boundary.all()
    given = gt.CotanLaplacian().assemble(mesh)
    assert off_diagonal(given).max() > 0
    assert given.surface is None


def doubled(mesh):
    """Return the stiffness and mass of a mesh glued to its image at its rims: half of both."""
    faces, n = mesh.faces, mesh.n_vertices
    lengths = face_edge_lengths(mesh.vertices, faces)
    twin, coherent = _native.sorted_half_edges(faces, n).twins()
    assert coherent
    halves = np.arange(faces.size)
    image = faces.size + halves - halves % 3 + 2 - halves % 3  # corners in the other order
    glued = np.empty(2 * faces.size, dtype=np.int64)
    glued[halves] = np.where(twin < 0, image, twin)
    glued[image] = np.where(twin < 0, halves, image[twin])
    both, long = np.vstack([faces, faces[:, ::-1]]), np.vstack([lengths, lengths[:, ::-1]])
    both, long = np.ascontiguousarray(both), np.ascontiguousarray(long)
    _native.flip_edges(both, long, glued, np.zeros(n, dtype=bool))
    frames, areas = measured_by_lengths(long)
    return ElementGradient.of_triangles(both, frames, areas / 2, n).sums()


@given(st.integers(0, 2**32 - 1), st.integers(4, 60))
def test_it_is_that_of_the_surface_and_its_mirror_image(seed, n):
    points = np.random.default_rng(seed).uniform(size=(n, 2))
    mesh = in_space(points, Delaunay(points).simplices.astype(np.int64))
    found, expected = DELAUNAY.assemble(mesh), doubled(mesh)
    assert off_diagonal(found).max() <= 1e-9 * np.abs(found.stiffness.data).max()
    if found.notes["mollified_by"] == 0:  # thinner ones are made thicker before
        matrix = expected.stiffness().scipy.toarray()
        scale = np.abs(matrix).max()
        np.testing.assert_allclose(found.stiffness.toarray(), matrix, atol=1e-7 * scale)
        assert found.mass.sum() == pytest.approx(expected.lumped_mass.sum(), rel=1e-9)


def messy(seed):
    """Return scattered points with third faces on edges, repeated and reversed faces."""
    rng = np.random.default_rng(seed)
    mesh, _ = scattered(120, seed)
    fins = np.column_stack([mesh.faces[:8, :2], 120 + np.arange(8)])
    tips = mesh.vertices[mesh.faces[:8, 0]] + [0, 0, 0.1]
    faces = np.vstack([mesh.faces, fins, mesh.faces[20:30], mesh.faces[30:35, ::-1]])
    return gt.TriangleMesh(np.vstack([mesh.vertices, tips]), faces[rng.permutation(len(faces))])


@pytest.mark.parametrize("seed", range(5))
def test_no_weight_has_the_wrong_sign_even_where_many_faces_meet(seed):
    found = DELAUNAY.assemble(messy(seed))
    assert off_diagonal(found).max() <= 1e-12 * np.abs(found.stiffness.data).max()
    assert found.mass.sum() == pytest.approx(gt.CotanLaplacian().assemble(messy(seed)).mass.sum())


def test_parts_that_are_left_alone_keep_their_rims():
    slivers, _ = scattered(300)
    together = gt.CotanLaplacian(intrinsic_delaunay="auto").assemble(
        shapes.disjoint_union(shapes.grid(25), slivers)
    )
    assert together.notes["triangulation"] == "partly intrinsic Delaunay"
    apart = gt.CotanLaplacian(intrinsic_delaunay="auto").assemble(slivers)
    alone = shapes.grid(25).n_vertices
    np.testing.assert_allclose(
        together.stiffness.toarray()[alone:, alone:], apart.stiffness.toarray(), atol=1e-9
    )
    given = gt.CotanLaplacian().assemble(shapes.grid(25))
    np.testing.assert_allclose(
        together.stiffness.toarray()[:alone, :alone], given.stiffness.toarray(), atol=1e-12
    )


def test_a_rim_without_slivers_is_not_flipped():
    points, faces = jittered(30)
    found = gt.CotanLaplacian(intrinsic_delaunay="auto").assemble(in_space(points, faces))
    assert found.notes["triangulation"] == "given"
    assert found.surface is None


def test_rims_are_found_and_their_angles_measured():
    mesh = gt.TriangleMesh([[0, 0, 0], [2, 0, 0], [1, 1, 0], [1, -0.5, 0]], [[0, 1, 2], [1, 0, 3]])
    rims = rim_edges(mesh.faces, np.ones(4, dtype=bool))
    assert rims.tolist() == [0, 1, 3, 4]  # all but the edge of both
    cotangents = rim_cotangents(face_edge_lengths(mesh.vertices, mesh.faces), rims)
    np.testing.assert_allclose(cotangents, [1, 1, 2, 2])
    assert rim_edges(shapes.icosphere(1).faces, np.zeros(42, dtype=bool)).size == 0


def test_a_closed_surface_has_nothing_to_be_mirrored_at():
    mesh = shapes.icosphere(1)
    twin, _ = _native.sorted_half_edges(mesh.faces, 42).twins()
    kept, beside = mirrored_at_rims(mesh.faces, face_edge_lengths(mesh.vertices, mesh.faces), twin)
    assert kept.all()
    assert beside.tails.size == 0


def test_the_surface_that_fronts_cross_is_made_of_triangles():
    mesh, _ = scattered(300)
    metric = DELAUNAY.assemble(mesh)
    assert metric.surface.elements.shape == mesh.faces.shape
    assert metric.on_surface is metric.surface
    refined = gt.GeodesicSolver(mesh, operator=DELAUNAY, refine=True)
    np.testing.assert_allclose(refined.distance(0), on_plane(mesh, 0), rtol=1e-3)
    for wrong in (
        gt.CotanLaplacian().assemble(shapes.grid(3)).gradient,
        gt.ElementGradient(np.array([[0, 1]]), np.array([[[-1.0, 1.0]]]), np.ones(1), 300),
    ):
        with pytest.raises(InvalidDiscretizationError, match="triangles with the same 300"):
            dataclasses.replace(metric, surface=wrong)


# -- distances from heat ---------------------------------------------------------------------------


@pytest.mark.parametrize("boundary", ["neumann", "dirichlet", "average"])
@pytest.mark.parametrize("n", [500, 2000])
def test_slivers_on_the_hull_cost_nothing(n, boundary):
    # Heat that runs along the hull was 11 to 49 % off.
    mesh, hull = scattered(n)
    inside = np.setdiff1d(np.arange(n), hull)
    solver = gt.GeodesicSolver(mesh, boundary=boundary, refine=False)
    for sources in (hull, inside[:: n // 40]):
        errors = []
        for source in sources.tolist():
            exact = on_plane(mesh, source)
            far = exact > 0.1
            errors.append(mean_relative_error(solver.distance(source)[far], exact[far]))
        assert np.mean(errors) < 0.03


def test_holes_in_scattered_points_cost_little():
    points = np.random.default_rng(3).uniform(size=(2000, 2))
    mesh = without(
        points, Delaunay(points).simplices, lambda x, y: np.hypot(x - 0.5, y - 0.5) < 0.2
    )
    refined = gt.geodesic_distance(mesh, 0, refine=True)
    assert mean_relative_error(gt.geodesic_distance(mesh, 0, refine=False), refined) < 0.03


def test_a_source_on_a_boundary_held_at_zero_is_as_if_that_were_free():
    points, faces = jittered(22)
    mesh = in_space(points, faces)
    free = gt.GeodesicSolver(mesh, refine=False)
    held = gt.GeodesicSolver(mesh, boundary="dirichlet", refine=False)
    rim, inside = 5, 22 * 11 + 11
    np.testing.assert_array_equal(held.distance(rim), free.distance(rim))
    np.testing.assert_array_equal(held.heat(rim), free.heat(rim))
    both = held.distances([rim, inside])
    np.testing.assert_allclose(both[0], free.distance(rim), atol=1e-12)
    np.testing.assert_allclose(both[1], held.distance(inside), atol=1e-12)
    assert (held.heat(inside)[held.method.metric.boundary] == 0).all()
    assert held.method.nbytes > free.method.nbytes


# -- warnings --------------------------------------------------------------------------------------


def error_and_advice(mesh, source, **options):
    """Return the mean relative error on a plane, and what a warning says."""
    exact = on_plane(mesh, source)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        distance = gt.geodesic_distance(mesh, source, **options)
    assert all(issubclass(warning.category, NonPositiveHeatWarning) for warning in caught)
    return mean_relative_error(distance, exact), " ".join(str(w.message) for w in caught)


def test_flips_are_advised_where_there_are_none_and_help():
    mesh, hull = scattered(500)
    source = int(hull[0])
    wrong, advice = error_and_advice(mesh, source, operator="cotan", refine=False)
    assert "CotanLaplacian(intrinsic_delaunay=True) is better" in advice
    right, advice = error_and_advice(mesh, source, operator=DELAUNAY, refine=False)
    assert advice == ""
    assert right < 0.03 < 0.1 < wrong


def sheared_without_notes():
    """Return a mesh and a method of heat that turns negative on it, of an operator of others."""
    mesh = shapes.grid(31, shear=3.0)
    metric = dataclasses.replace(gt.CotanLaplacian().assemble(mesh), triangulation="")
    return mesh, metric


def test_refinement_is_advised_where_the_operator_is_another_and_helps():
    mesh, metric = sheared_without_notes()
    direct, exact = gt.Supernodal(), on_plane(mesh, 480)
    plain = gt.HeatMethod(metric, heat_solver=direct, poisson_solver=direct)
    with pytest.warns(NonPositiveHeatWarning, match="refine=True is better"):
        wrong = mean_relative_error(plain.distance(480), exact)
    refined = gt.HeatMethod(metric, heat_solver=direct, poisson_solver=direct, refine=True)
    assert mean_relative_error(refined.distance(480), exact) < 0.001 < 0.1 < wrong


def test_better_elements_are_advised_where_there_are_no_triangles_and_help():
    def error(shear):
        mesh = shapes.grid(31, shear=shear)
        metric = gt.CotanLaplacian().assemble(mesh)
        given = metric.gradient  # the same in three dimensions
        flat = np.concatenate([given.coefficients, np.zeros((mesh.n_faces, 1, 3))], axis=1)
        gradient = gt.ElementGradient(given.elements, flat, given.measure, mesh.n_vertices)
        solid = dataclasses.replace(metric, gradient=gradient, triangulation="")
        method = gt.HeatMethod(solid, heat_solver=gt.Supernodal(), poisson_solver=gt.Supernodal())
        return mean_relative_error(method.distance(480), on_plane(mesh, 480))

    with pytest.warns(NonPositiveHeatWarning, match="elements with fewer obtuse angles are better"):
        wrong = error(shear=3.0)
    assert error(shear=0.0) < 0.03 < 0.1 < wrong


def test_the_averaged_condition_is_advised_where_none_gets_through_and_helps():
    grid = shapes.grid(41)
    middle = grid.vertices[grid.faces].mean(axis=1)
    neck = (np.abs(middle[:, 0] - 0.5) < 0.1) & (np.abs(middle[:, 1] - 0.5125) > 0.013)
    used, faces = np.unique(grid.faces[~neck], return_inverse=True)
    mesh = gt.TriangleMesh(grid.vertices[used], faces.reshape(-1, 3))
    source = int(np.argmin(np.linalg.norm(mesh.vertices - [0.25, 0.5, 0], axis=1)))
    with pytest.warns(NonPositiveHeatWarning, match='use boundary="average"'):
        held = gt.geodesic_distance(mesh, source, boundary="dirichlet", refine=False)
    average = gt.geodesic_distance(mesh, source, boundary="average", refine=False)
    refined = gt.geodesic_distance(mesh, source, refine=True)
    assert mean_relative_error(average, refined) < 0.04
    assert not mean_relative_error(held, refined) < 0.08


def test_what_takes_the_order_of_the_heat_alone_is_not_warned_of():
    mesh = shapes.grid(40, shear=3.0)
    solver = gt.GeodesicSolver(mesh, operator="cotan", refine=True)
    assert solver.method.heat_report(820).non_positive > 400
    assert mean_relative_error(solver.distance(820), on_plane(mesh, 820)) < 0.001
    plain = gt.GeodesicSolver(mesh, operator="cotan", refine=False)
    path = gt.geodesic_path(plain, 820, 0)
    assert path.length == pytest.approx(on_plane(mesh, 820)[0])
    with pytest.warns(NonPositiveHeatWarning):
        plain.log_heat(820)


# -- fronts ----------------------------------------------------------------------------------------


def window(h):
    """Return a plate with a D-shaped hole, fine before its round side, coarse behind the straight.

    And the vertices behind the hole, the way to which leads past the ends of the straight side.
    """
    turn = np.linspace(np.pi / 2, 3 * np.pi / 2, int(np.pi * 0.4 / h) + 1)
    rim = np.column_stack([1 + 0.4 * np.cos(turn), 0.5 + 0.4 * np.sin(turn)])
    x, y = np.meshgrid(np.arange(0, 1 - 1e-9, h), np.linspace(0, 1, int(1 / h) + 1))
    front = np.column_stack([x.ravel(), y.ravel()])
    front = front[np.hypot(front[:, 0] - 1, front[:, 1] - 0.5) > 0.4 + 0.4 * h]
    behind = np.array([[1, 0], [1, 1], [1.5, 0], [1.5, 0.5], [1.5, 1], [2, 0], [2, 0.5], [2, 1]])
    points = np.unique(np.concatenate([front, rim, behind]).round(9), axis=0)
    faces = Delaunay(points).simplices
    u, v = (points[faces[:, k]] - points[faces[:, 0]] for k in (1, 2))
    faces = faces[np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) > 1e-9]
    return without(points, faces, lambda x, y: (x < 1) & (np.hypot(x - 1, y - 0.5) < 0.4))


def plates():
    """Return plates with holes, slits and corners, by name."""
    fine, coarse = jittered(25), jittered(12)
    few = np.random.default_rng(0).choice(len(coarse[1]), 6, replace=False)
    return {
        "a window": window(0.05),
        "a slit": without(*fine, lambda x, y: (np.abs(x - 0.5) < 0.03) & (np.abs(y - 0.5) < 0.3)),
        "holes": without(*fine, lambda x, y: np.hypot((2 * x) % 1 - 0.5, (2 * y) % 1 - 0.5) < 0.3),
        "holes of one triangle": in_space(coarse[0], np.delete(coarse[1], few, axis=0)),
        "a concave corner": without(*coarse, lambda x, y: (x > 0.5) & (y > 0.5)),
    }


@pytest.mark.parametrize("name", plates())
def test_nothing_comes_across_an_edge_with_nothing_behind_it(name):
    mesh = plates()[name]
    solver = gt.GeodesicSolver(mesh, refine=True)
    rng = np.random.default_rng(0)
    for source in rng.choice(mesh.n_vertices, 3, replace=False).tolist():
        distance = solver.distance(source)
        assert (distance >= on_plane(mesh, source) * (1 - 0.03)).all()
        for target in rng.choice(mesh.n_vertices, 6, replace=False).tolist():
            if target != source:
                path = gt.geodesic_path(solver, source, target)
                assert distance[target] == pytest.approx(path.length, rel=0.03)


def test_behind_a_window_distance_is_that_around_it():
    # A front that took the straight side for one to be crossed was 17 % too short.
    mesh = window(0.05)
    source = int(np.argmin(np.linalg.norm(mesh.vertices - [0.3, 0.5, 0], axis=1)))
    target = int(np.argmin(np.linalg.norm(mesh.vertices - [1.5, 0.5, 0], axis=1)))
    distance = gt.geodesic_distance(mesh, source, refine=True)[target]
    assert distance == pytest.approx(1.458, abs=0.002)


def test_the_edge_of_a_mask_is_a_rim():
    mesh = window(0.05)
    x, y = mesh.vertices[:, :2].T
    filled = in_space(mesh.vertices[:, :2], Delaunay(mesh.vertices[:, :2]).simplices)
    inside = (x < 0.999) & (np.hypot(x - 1, y - 0.5) < 0.41)
    solver = gt.GeodesicSolver(filled, mask=inside, refine=True)
    source = int(np.argmin(np.linalg.norm(mesh.vertices - [0.2, 0.5, 0], axis=1)))
    distance = solver.distance(source)
    for target in np.flatnonzero(x > 1.2).tolist():
        assert distance[target] == pytest.approx(
            gt.geodesic_path(solver, source, target).length, rel=0.02
        )


@pytest.mark.parametrize("source", [[0.53, 0.0, 0.0], [0.5, 0.02, 0.0]])
def test_a_front_begins_on_the_rim_itself(source):
    mesh = in_space(*jittered(12))
    distance = gt.geodesic_distance(mesh, np.array([source]), refine=True)
    exact = np.linalg.norm(mesh.vertices - source, axis=1)
    np.testing.assert_allclose(distance, exact, atol=1e-6)


def test_a_curve_along_the_rim_is_a_source():
    mesh = in_space(*jittered(12))
    distance = gt.geodesic_distance(mesh, gt.Curve([[0, 0, 0], [1, 0, 0]]), refine=True)
    inner = np.abs(mesh.vertices[:, 0] - 0.5) + mesh.vertices[:, 1] < 0.4  # of the ends' circles
    np.testing.assert_allclose(distance[inner], mesh.vertices[inner, 1], atol=1e-4)


# -- the warning of answers that are off -----------------------------------------------------------


def coarse_warnings(solver, sources):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", CoarseMeshWarning)
        found = solver.distance(sources)
    return found, [str(each.message) for each in caught]


@pytest.mark.parametrize("stretch", [1, 5, 100])
@pytest.mark.parametrize("boundary", ["dirichlet", "average"])
def test_a_boundary_condition_is_named_where_it_harms_and_what_is_advised_helps(stretch, boundary):
    square = shapes.grid(22)
    mesh = gt.TriangleMesh(square.vertices * [stretch, 1, 1], square.faces)
    exact = on_plane(mesh, 253)
    solver = gt.GeodesicSolver(mesh, boundary=boundary, refine=False)
    found, said = coarse_warnings(solver, 253)
    error = mean_relative_error(found, exact)
    assert bool(said) == (error > 0.04)
    if said:
        text = f'plain heat with boundary="{boundary}" is {100 * error:.0f} % off.*refine=True'
        assert re.match(text, said[0])
        refined = gt.GeodesicSolver(mesh, boundary=boundary, refine=True)
        assert mean_relative_error(refined.distance(253), exact) < 0.001


@pytest.mark.parametrize("n", [8, 22])
def test_many_sources_are_named_where_plain_heat_from_them_is_off_and_one_is_not(n):
    square = shapes.grid(n)
    x, y = square.vertices[:, :2].T
    hull = np.flatnonzero((x * (1 - x) < 1e-9) | (y * (1 - y) < 1e-9))
    exact = np.minimum(np.minimum(x, 1 - x), np.minimum(y, 1 - y))
    solver = gt.GeodesicSolver(square, refine=False)
    found, said = coarse_warnings(solver, hull)
    assert mean_relative_error(found, exact) > 0.05
    assert f"from {len(hull)} sources is" in said[0]
    side, said = coarse_warnings(solver, np.flatnonzero(x < 1e-9))
    assert mean_relative_error(side, x) < 0.04
    assert not said
    rows = gt.GeodesicSolver(square, refine=True).distances([hull])
    assert mean_relative_error(rows[0], exact) < 1e-6
    with pytest.warns(CoarseMeshWarning, match=f"from {len(hull)} sources"):
        solver.distances([[0], hull])
    with pytest.warns(CoarseMeshWarning, match=f"from {len(hull)} sources"):
        gt.geodesic_voronoi(solver, [hull])
    with pytest.warns(CoarseMeshWarning, match=f"from {len(hull)} sources"):
        solver.query([0.5, 0.5, 0.0], hull)


def test_a_time_step_that_is_too_long_is_warned_of():
    square = shapes.grid(50)
    exact = on_plane(square, 1010)
    found, said = coarse_warnings(gt.GeodesicSolver(square, time_factor=1e4, refine=False), 1010)
    assert mean_relative_error(found, exact) > 0.04
    assert "with this time step" in said[0]
    found, said = coarse_warnings(gt.GeodesicSolver(square, refine=False), 1010)
    assert mean_relative_error(found, exact) < 0.04
    assert not said
