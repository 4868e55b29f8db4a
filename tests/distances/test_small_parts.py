"""Parts of a mesh with few faces read exact distances by default."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sample_shapes import hull

import geodesic_toolkit as gt
from geodesic_toolkit.errors import SolverError
from geodesic_toolkit.refinement.polyhedra import MOST_FACES
from geodesic_toolkit.testing import shapes


def box(*sides):
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    return hull(corners * sides)


def corner(mesh, *place):
    return int(np.flatnonzero((mesh.vertices == place).all(axis=1))[0])


@pytest.mark.parametrize("sides", [(1, 1, 1), (1, 2, 3), (4, 1, 1), (0.1, 5, 5)])
def test_opposite_corners_of_a_box_are_as_far_as_two_faces_unfolded(sides):
    mesh = box(*sides)
    start, end = corner(mesh, 0, 0, 0), corner(mesh, *sides)
    a, b, c = sides
    shortest = min(np.hypot(a + b, c), np.hypot(a + c, b), np.hypot(b + c, a))
    assert gt.geodesic_distance(mesh, start)[end] == pytest.approx(shortest, rel=1e-12)


def test_a_point_within_a_face_of_a_cube_is_as_far_as_faces_unfolded():
    mesh = box(1, 1, 1)
    # The middle of the floor, and another point of it: straight on the floor and up the walls.
    for x, y in ((0.5, 0.5), (0.3, 0.6)):
        distance = gt.geodesic_distance(mesh, [x, y, 0.0])
        for px, py, pz in mesh.vertices:
            on_floor = np.hypot(px - x, py - y)
            walls = (np.hypot(abs(px - x) + 1, py - y), np.hypot(px - x, abs(py - y) + 1))
            expected = on_floor if pz == 0 else min(walls)
            assert distance[corner(mesh, px, py, pz)] == pytest.approx(expected, rel=1e-12)


def test_several_sources_and_offsets_are_exact_too():
    mesh = box(1, 2, 3)
    sources, offsets = [0, 7], [0.0, 0.4]
    expected = gt.exact_distance(mesh, gt.OffsetSources(sources, offsets))
    found = gt.geodesic_distance(mesh, gt.OffsetSources(sources, offsets))
    np.testing.assert_allclose(found, expected, rtol=1e-12)


@pytest.mark.slow
@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.integers(4, 60))
def test_the_default_is_exact_on_hulls_of_few_points(seed, count):
    rng = np.random.default_rng(seed)
    mesh = hull(rng.normal(size=(count, 3)) * rng.uniform(0.1, 1, 3))
    source = int(rng.integers(mesh.n_vertices))
    exact = gt.exact_distance(mesh, source)
    np.testing.assert_allclose(gt.geodesic_distance(mesh, source), exact, rtol=1e-9)
    # Symmetric, between the straight line and the path along edges.
    back = [gt.geodesic_distance(mesh, v)[source] for v in range(mesh.n_vertices)]
    np.testing.assert_allclose(back, exact, rtol=1e-9, atol=1e-12)
    assert (exact >= np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1) - 1e-12).all()


def test_a_small_part_beside_a_large_one_reads_what_it_reads_alone():
    small, large = box(1, 1, 1), shapes.icosphere(4)
    both = shapes.disjoint_union(large, small, large)
    solver = gt.GeodesicSolver(both)
    first = large.n_vertices
    found = solver.distances([first, 5, [5, first + 1]])
    np.testing.assert_allclose(found[0, first : first + 8], gt.exact_distance(small, 0))
    assert np.isinf(np.delete(found[0], np.arange(first, first + 8))).all()
    np.testing.assert_array_equal(found[1, :first], found[2, :first])
    np.testing.assert_allclose(found[2, first : first + 8], gt.exact_distance(small, 1))
    assert "exact on components of up to 500 faces" in solver.diagnosis.reason


def test_a_mask_may_leave_a_small_part():
    ball = shapes.icosphere(4)
    height = ball.vertices[:, 2]
    solver = gt.GeodesicSolver(ball, mask=height < 0.8)
    source = int(height.argmax())
    assert 0 < solver.passable.n_faces <= MOST_FACES
    expected = gt.exact_distance(solver.passable, source)
    np.testing.assert_allclose(solver.distance(source), expected, rtol=1e-12)


def test_faces_given_front_and_back_count_once():
    mesh = box(1, 2, 3)
    double = gt.TriangleMesh(mesh.vertices, np.vstack([mesh.faces, mesh.faces[:, ::-1]]))
    np.testing.assert_allclose(gt.geodesic_distance(double, 0), gt.exact_distance(mesh, 0))


def test_a_curve_is_left_to_fronts():
    square = shapes.grid(12)
    side = gt.Curve([[0, 0, 0], [0, 1, 0]])
    np.testing.assert_allclose(gt.geodesic_distance(square, side), square.vertices[:, 0], atol=0.02)


def test_plain_heat_stays_plain_and_large_parts_stay_swept():
    assert gt.GeodesicSolver(box(1, 1, 1), refine=False).method.small_parts is None
    assert gt.GeodesicSolver(shapes.icosphere(3)).method.small_parts is None


def test_a_solver_with_small_parts_travels():
    mesh = box(1, 2, 3)
    solver = pickle.loads(pickle.dumps(gt.GeodesicSolver(mesh)))
    np.testing.assert_array_equal(solver.distance(3), gt.geodesic_distance(mesh, 3))


def test_a_search_that_does_not_end_is_given_up(monkeypatch):
    monkeypatch.setattr("geodesic_toolkit.refinement.polyhedra.MOST_WINDOWS", 0)
    with pytest.raises(SolverError, match="not found with 0 windows"):
        gt.geodesic_distance(box(1, 1, 1), 0)
