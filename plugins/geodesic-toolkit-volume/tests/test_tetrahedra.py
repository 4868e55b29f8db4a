"""Distances inside tetrahedra against closed forms."""

import pickle
import re

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidDomainError, InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit_volume import TetLaplacian, TetMesh
from geodesic_toolkit_volume.samples import box

CORNER = np.eye(4)[:, 1:]


def cube(n=7, costs=None):
    """Return the unit cube of n vertices a side."""
    return TetMesh(*box((n, n, n), 1 / (n - 1)), costs)


def mean_error(found, exact):
    far = exact > 0
    return float(np.mean(np.abs(found[far] / exact[far] - 1)))


def test_in_a_cube_distances_from_a_vertex_are_straight():
    mesh = cube()
    for source in (0, 100, mesh.n_vertices - 1):
        straight = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)
        assert mean_error(gt.GeodesicSolver(mesh).distance(source), straight) < 0.002


def test_a_point_inside_a_cell_is_a_source():
    mesh, place = cube(), np.array([0.51, 0.37, 0.44])
    straight = np.linalg.norm(mesh.vertices - place, axis=1)
    assert mean_error(gt.GeodesicSolver(mesh).distance(place), straight) < 0.002


def test_a_front_is_plane_where_the_cost_jumps():
    apex = np.concatenate([CORNER, [[1.0, 1.0, 1.0]]])
    mesh = TetMesh(apex, [[0, 1, 2, 3], [1, 2, 3, 4]], [1e-6, 1e6])
    height = 2 / np.sqrt(3)
    assert gt.GeodesicSolver(mesh).distance(0)[4] == pytest.approx(1e6 * height)


@pytest.mark.parametrize("unit", [1e-60, 1e60])
def test_the_unit_of_length_does_not_matter(unit):
    mesh = cube(5)
    found = gt.GeodesicSolver(TetMesh(unit * mesh.vertices, mesh.cells)).distance(7)
    np.testing.assert_allclose(found / unit, gt.GeodesicSolver(mesh).distance(7), rtol=1e-9)


def test_every_point_is_in_the_cell_that_contains_it():
    thin = TetMesh(cube(5).vertices * [1.0, 1.0, 0.001], cube(5).cells)
    points = np.random.default_rng(0).uniform(0, 1, (50, 3)) * [1.0, 1.0, 0.001]
    at = thin.closest(points)
    np.testing.assert_allclose(at.positions(thin), points, atol=1e-9)


def test_points_beside_cells_without_a_surface_snap_to_vertices():
    double = TetMesh(CORNER, [[0, 1, 2, 3], [0, 1, 2, 3]])
    assert gt.GeodesicSolver(double).distance([1.1, 0.0, 0.0]).tolist()[1] == 0.0
    assert TetMesh(CORNER, []).closest(np.ones((1, 3))).weights.tolist() == [[1, 0, 0, 0]]


def test_a_query_reads_between_the_vertices():
    mesh = cube()
    found = gt.GeodesicSolver(mesh).query([[0.9, 0.55, 0.31]], [0.1, 0.2, 0.3])
    assert found[0] == pytest.approx(np.linalg.norm([0.8, 0.35, 0.01]), rel=0.01)


def test_sources_with_offsets_divide_the_cube():
    mesh = cube()
    sources = gt.OffsetSources([0, mesh.n_vertices - 1], [0.0, 0.5])
    ends = mesh.vertices[[0, -1]]
    both = np.linalg.norm(mesh.vertices[:, None] - ends, axis=2) + np.array([0.0, 0.5])
    found = gt.GeodesicSolver(mesh).distance(sources)
    assert mean_error(found, both.min(axis=1)) < 0.01


def test_errors_round_a_hole_fall_with_refinement():
    errors = []
    for n in (9, 17):
        mesh = cube(n)
        low, high = mesh.vertices[mesh.cells].min(axis=1), mesh.vertices[mesh.cells].max(axis=1)
        hole = (low[:, :2] >= 0.25 - 1e-9).all(axis=1) & (high[:, :2] <= 0.75 + 1e-9).all(axis=1)
        left = TetMesh(mesh.vertices, mesh.cells[~hole])
        x, y, z = mesh.vertices.T
        source = int(np.abs(mesh.vertices - [0, 0.5, 0.5]).sum(axis=1).argmin())
        found = gt.GeodesicSolver(left).distance(source)
        behind = np.flatnonzero((x > 0.76) & (np.abs(y - 0.5) < 0.2))
        first = np.hypot(0.25, 0.25)
        flat = first + 0.5 + np.hypot(x - 0.75, np.minimum(0.75 - y, y - 0.25))
        exact = np.hypot(flat, z - 0.5)
        errors.append(mean_error(found[behind], exact[behind]))
    assert errors[1] < 0.02
    assert errors[1] < 0.9 * errors[0]


def test_costs_scale_distances_and_bend_rays():
    mesh = cube(9)
    twice = TetMesh(mesh.vertices, mesh.cells, np.full(len(mesh.cells), 2.0))
    one, two = gt.GeodesicSolver(mesh), gt.GeodesicSolver(twice)
    np.testing.assert_allclose(two.distance(0), 2 * one.distance(0), rtol=1e-9)
    place = [0.51, 0.37, 0.44]
    np.testing.assert_allclose(two.distance(place), 2 * one.distance(place), rtol=1e-9)

    middle = mesh.vertices[mesh.cells].mean(axis=1)
    speed = 1 + 2 * middle[:, 0]
    bent = gt.GeodesicSolver(TetMesh(mesh.vertices, mesh.cells, 1 / speed)).distance(0)
    at = 1 + 2 * mesh.vertices[:, 0]
    squared = (mesh.vertices**2).sum(axis=1)
    exact = np.arccosh(1 + 4 * squared / (2 * at)) / 2
    assert mean_error(bent, exact) < 0.03


def test_a_plane_of_two_costs_refracts():
    mesh = cube(13)
    slow = mesh.vertices[mesh.cells].mean(axis=1)[:, 0] > 0.5
    found = gt.GeodesicSolver(TetMesh(mesh.vertices, mesh.cells, np.where(slow, 3.0, 1.0)))
    distance = found.distance(int(np.abs(mesh.vertices - [0, 0, 0]).sum(axis=1).argmin()))
    crossing = np.linspace(0, 1, 20001)
    exact = (np.hypot(0.5, crossing) + 3 * np.hypot(0.5, 1 - crossing)).min()
    corner = int(np.abs(mesh.vertices - [1, 1, 0]).sum(axis=1).argmin())
    assert distance[corner] == pytest.approx(exact, rel=0.03)


def test_parts_are_infinitely_far_and_masks_cut():
    mesh = cube()
    wall = np.isclose(mesh.vertices[:, 0], 0.5)
    distance = gt.GeodesicSolver(mesh, mask=wall).distance(0)
    assert np.isinf(distance[mesh.vertices[:, 0] > 0.6]).all()
    assert np.isfinite(distance[mesh.vertices[:, 0] < 0.4]).all()


def test_heat_is_left_to_refine_false():
    solver = gt.GeodesicSolver(cube(), refine=False)
    assert not solver.method.across
    assert gt.GeodesicSolver(cube(), refine=True).method.across
    assert gt.GeodesicSolver(cube(), time_factor=2.0).method.flows


def test_the_surface_looks_outward_and_is_closed():
    mesh = cube(4)
    assert mesh.triangles.shape == (6 * 9 * 2, 3)
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    assert np.einsum("fd,fd->", a, np.cross(b, c)) / 6 == pytest.approx(1.0)


def test_the_closest_place_to_a_point_outside_is_on_the_surface():
    mesh = cube()
    at = mesh.closest(np.array([[2.0, 0.3, 0.4]]))
    np.testing.assert_allclose(at.positions(mesh), [[1.0, 0.3, 0.4]], atol=1e-12)


def test_flat_cells_are_left_out():
    mesh = TetMesh(CORNER, [[0, 1, 2, 3], [0, 1, 2, 2]])
    assert TetLaplacian().assemble(mesh).notes["flat_cells"] == 1
    with pytest.raises(UnsupportedDomainError, match="none of the 1 cells has a volume"):
        TetLaplacian().assemble(TetMesh(np.ones((4, 3)), [[0, 1, 2, 3]]))


def test_a_solver_that_was_pickled_gives_the_same():
    solver = gt.GeodesicSolver(cube())
    again = pickle.loads(pickle.dumps(solver))
    np.testing.assert_array_equal(again.distance(0), solver.distance(0))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([[0, 0]], []), "vertices must have shape (n, 3)"),
        (([], []), "vertices must have shape (n, 3)"),
        ((np.zeros((0, 3)), []), "there are no vertices"),
        ((CORNER, [[0, 1, 2]]), "cells must have shape (n, 4)"),
        ((CORNER, [[0, 1, 2, 4]]), "cell 0 refers to vertex 4; there are 4, numbered from 0"),
        (
            (CORNER, [[0, 1, 2, 2.5]]),
            "cell 0 of cells holds (0.0, 1.0, 2.0, 2.5): not whole numbers",
        ),
        ((CORNER, [["a", "b", "c", "d"]]), "cells must"),
        ((CORNER, [[0], [1, 2]]), "cells cannot be read as an array"),
        ((np.full((4, 3), np.nan), [[0, 1, 2, 3]]), "vertex 0 is not finite"),
        ((CORNER, [[0, 1, 2, 3]], [0.0]), "cell 0 has the cost 0.0"),
        ((CORNER, [[0, 1, 2, 3]], [np.nan]), "cell 0 has the cost nan"),
        ((CORNER, [[0, 1, 2, -1]]), "cell 0 refers to vertex -1"),
        ((CORNER, [[0, 1, 2, np.inf]]), "not whole numbers"),
        ((CORNER, [[0, 1, 2, 3]], [1.0, 2.0]), "costs must have shape (1,)"),
    ],
)
def test_arrays_that_are_not_a_solid_are_refused(arguments, message):
    with pytest.raises(InvalidDomainError, match=re.escape(message)):
        TetMesh(*arguments)


def test_a_mask_of_everything_is_refused():
    with pytest.raises(InvalidOptionError, match="leaves no cell"):
        TetMesh(CORNER, [[0, 1, 2, 3]]).without(np.array([True, False, False, False]))


def test_a_click_on_the_page_is_a_place_on_the_surface_and_distances_cross_the_solid():
    from geodesic_toolkit.viz.live.session import Session

    session, toward = Session(cube()), np.array([1.0, 0.1, 0.2])
    assert session.refined
    session.click(session.pick(9 * toward, -toward))
    assert len(session.sources[0].vertices) == 3
    session.set_mode("measure")
    session.click(session.pick(-9 * toward, toward))
    through = np.linalg.norm(toward)  # from x = 1 to x = 0
    assert session.measured[1] == pytest.approx(through, rel=0.01)
    session.set_method(refine=False, time_factor=1.0)
    assert not session.refined
    assert session.measured[1] == pytest.approx(through, rel=0.2)
