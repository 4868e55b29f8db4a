"""Closed geodesics: their length on shapes with closed forms, their class, where there is none."""

import numpy as np
import pytest
from loop_shapes import polygon, pretzel, tilted_cylinder

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    ContractibleLoopError,
    InvalidOptionError,
    InvalidSourceError,
    UnreachableError,
    UnsupportedDomainError,
)
from geodesic_toolkit.testing import shapes

RINGS, AROUND, MAJOR, MINOR = 60, 30, 2.0, 0.5
TORUS = gt.GeodesicSolver(shapes.torus(RINGS, AROUND, major=MAJOR, minor=MINOR))
NARROWER = 2e-3
"""Share by which a tube of straight edges is narrower between its rings than at them."""

SPHERE = gt.GeodesicSolver(shapes.icosphere(3))


def around_tube(start=0):
    return [start, start + AROUND // 3, start + 2 * AROUND // 3]


def along_tube(angle=0):
    return [angle + step * AROUND for step in (0, RINGS // 3, 2 * RINGS // 3)]


def winding(points, centre):
    """Times that a closed polyline goes around a vertical line."""
    flat = (points[:, :2] - centre) @ np.array([1, 1j])
    return round(float(np.angle(np.roll(flat, -1) / flat).sum() / (2 * np.pi)))


# -- closed forms --------------------------------------------------------------------------------


@pytest.mark.parametrize("ring", [0, 7])
def test_a_loop_around_the_tube_of_a_torus_is_the_small_circle(ring):
    loop = gt.geodesic_loop(TORUS, around_tube(ring * AROUND))
    assert loop.closed
    assert loop.length == pytest.approx(polygon(AROUND, MINOR), rel=NARROWER)
    assert loop.length <= polygon(AROUND, MINOR) * (1 + 1e-12)


def test_loops_converge_to_the_small_circle():
    errors = []
    for n in (30, 60, 120):
        solver = gt.GeodesicSolver(shapes.torus(n, n // 2, major=MAJOR, minor=MINOR))
        loop = gt.geodesic_loop(solver, [0, n // 6, n // 3])
        errors.append(abs(loop.length / (2 * np.pi * MINOR) - 1))
    assert errors[1] < errors[0] / 2
    assert errors[2] < errors[1] / 2


@pytest.mark.parametrize("angle", [0, 4, AROUND // 2])
def test_a_loop_along_the_tube_slips_to_the_inner_equator(angle):
    loop = gt.geodesic_loop(TORUS, along_tube(angle))
    assert loop.length == pytest.approx(polygon(RINGS, MAJOR - MINOR), rel=1e-9)


def test_a_loop_that_keeps_its_way_points_passes_them():
    stops = along_tube(0)
    loop = gt.geodesic_loop(TORUS, stops, through=True)
    gaps = np.linalg.norm(loop.points[:, None] - TORUS.domain.vertices[stops], axis=2)
    assert gaps.min(axis=0) == pytest.approx(0, abs=1e-12)
    assert loop.length > gt.geodesic_loop(TORUS, stops).length


def test_a_loop_around_a_cylinder_has_its_circumference_wherever_it_was_begun():
    mesh, cell = tilted_cylinder()
    solver = gt.GeodesicSolver(mesh)
    around = cell.shape[1]
    least = polygon(around, 1.0)
    for stops in ([(3, 0), (20, 13), (12, 26)], [(10, 0), (10, 13), (10, 26)]):
        loop = gt.geodesic_loop(solver, [cell[place] for place in stops])
        # The polyhedral cylinder is narrower between its rings, by the cosine of half an edge.
        assert least * np.cos(np.pi / around) <= loop.length <= least * (1 + 1e-9)


def test_a_loop_at_a_boundary_stays_on_the_surface():
    mesh, cell = tilted_cylinder(height=0.4, rings=3)
    mesh = gt.TriangleMesh(
        mesh.vertices * [1, 1, 1] * (1 + 0.5 * mesh.vertices[:, [2]]) ** [1, 1, 0], mesh.faces
    )
    solver = gt.GeodesicSolver(mesh)
    loop = gt.geodesic_loop(solver, cell[2, [0, 13, 26]])
    assert loop.points[:, 2] == pytest.approx(0, abs=1e-9)
    assert loop.length == pytest.approx(polygon(cell.shape[1], 1.0), rel=1e-9)


def test_points_in_faces_and_in_space_are_way_points():
    torus = TORUS.domain
    faces = [int(np.flatnonzero((torus.faces == v).any(axis=1))[0]) for v in around_tube()]
    inside = [gt.SurfacePoint(face, (0.2, 0.3, 0.5)) for face in faces]
    length = gt.geodesic_loop(TORUS, around_tube()).length
    assert gt.geodesic_loop(TORUS, inside).length == pytest.approx(length, rel=1e-3)
    space = torus.vertices[around_tube()]
    assert gt.geodesic_loop(TORUS, space).length == pytest.approx(length, rel=1e-9)


# -- classes -------------------------------------------------------------------------------------


def test_a_loop_stays_around_the_hole_that_it_was_laid_around():
    mesh, corners = pretzel()
    solver = gt.GeodesicSolver(mesh)
    size, last = 7, 4
    for hole in range(3):
        west, east = hole * size + 2, hole * size + 2 + size - 3
        places = [(west, 2, last), (east + 2, 2, last), (east + 2, 8, last), (west, 8, last)]
        loop = gt.geodesic_loop(solver, [corners[place] for place in places])
        centres = [np.array([k * size + 5.0, 5.5]) for k in range(3)]
        assert [abs(winding(loop.points, centre)) for centre in centres] == [
            int(k == hole) for k in range(3)
        ]
        # The hole is a square of 4 by 3; within it the loop is the shortest one: its border.
        assert loop.length == pytest.approx(14.0)


def test_a_loop_may_cross_itself_and_go_around_twice():
    stops = around_tube()
    twice = [*stops, *(vertex + AROUND for vertex in stops)]
    loop = gt.geodesic_loop(TORUS, twice)
    assert loop.length == pytest.approx(2 * polygon(AROUND, MINOR), rel=NARROWER)


def test_no_side_of_a_loop_has_a_shorter_path():
    """Around every corner of a closed geodesic there are at least π on either side."""
    mesh, corners = pretzel()
    solver = gt.GeodesicSolver(mesh)
    places = [(1, 3, 4), (12, 3, 4), (12, 9, 4), (1, 9, 4)]
    loop = gt.geodesic_loop(solver, [corners[place] for place in places])
    for first in range(0, len(loop.surface_points), 5):
        second = (first + 7) % len(loop.surface_points)
        ends = [loop.surface_points[first], loop.surface_points[second]]
        along = np.roll(loop.points, -first, axis=0)[:8]
        straight = gt.geodesic_path(solver, *ends).length
        assert straight <= np.linalg.norm(np.diff(along, axis=0), axis=1).sum() * (1 + 1e-9)


# -- nothing to go around ------------------------------------------------------------------------


@pytest.mark.parametrize("stops", [[0, 1, 2], [5, 100, 300, 600], [10, 20, 30, 40, 50]])
def test_a_loop_on_a_sphere_contracts(stops):
    with pytest.raises(ContractibleLoopError, match="shrinks to a point"):
        gt.geodesic_loop(SPHERE, stops)


def test_a_loop_about_one_place_of_a_torus_contracts():
    near = [2 * AROUND + 3, 3 * AROUND + 5, 5 * AROUND + 4]
    with pytest.raises(ContractibleLoopError):
        gt.geodesic_loop(TORUS, near)


def test_a_loop_there_and_back_contracts():
    with pytest.raises(ContractibleLoopError):
        gt.geodesic_loop(TORUS, [0, 4, 8])


def test_a_loop_shorter_than_the_least_length_counts_as_contracted():
    assert gt.geodesic_loop(TORUS, around_tube(), min_length=3.0).length > 3.0
    with pytest.raises(ContractibleLoopError, match=r"less than 3\.2"):
        gt.geodesic_loop(TORUS, around_tube(), min_length=3.2)


def test_a_contractible_loop_that_keeps_its_way_points_is_one():
    stops = [5, 100, 300]
    loop = gt.geodesic_loop(SPHERE, stops, through=True)
    pieces = [gt.geodesic_path(SPHERE, a, b).length for a, b in ((5, 100), (100, 300), (300, 5))]
    assert loop.length == pytest.approx(sum(pieces), rel=1e-3)


# -- surfaces that are not tidy ------------------------------------------------------------------


def test_a_loop_lies_on_one_sheet_of_a_mesh_with_a_fin():
    torus = TORUS.domain
    fin = np.array([[0, AROUND, torus.n_vertices]])  # a third face at an edge
    mesh = gt.TriangleMesh(
        np.vstack([torus.vertices, [[4.0, 0, 0]]]), np.concatenate([torus.faces, fin])
    )
    loop = gt.geodesic_loop(gt.GeodesicSolver(mesh), around_tube(20 * AROUND))
    assert loop.length == pytest.approx(polygon(AROUND, MINOR), rel=NARROWER)
    held = gt.geodesic_loop(gt.GeodesicSolver(mesh), along_tube())
    assert polygon(RINGS, MAJOR - MINOR) < held.length < polygon(RINGS, MAJOR + MINOR)


def test_faces_turned_any_way_make_the_same_loop():
    torus = TORUS.domain
    faces = torus.faces.copy()
    faces[::3] = faces[::3, ::-1]
    mesh = gt.TriangleMesh(torus.vertices, np.concatenate([faces, faces[:5]]))
    loop = gt.geodesic_loop(gt.GeodesicSolver(mesh), along_tube())
    assert loop.length == pytest.approx(polygon(RINGS, MAJOR - MINOR), rel=1e-9)


def test_a_loop_goes_around_a_surface_with_one_side():
    n, width = 60, 4
    turn = 2 * np.pi * np.arange(n) / n
    across = np.linspace(-0.4, 0.4, width + 1)
    out = 1 + across * np.cos(turn[:, None] / 2)
    places = np.stack(
        [
            out * np.cos(turn[:, None]),
            out * np.sin(turn[:, None]),
            across * np.sin(turn[:, None] / 2),
        ],
        axis=2,
    ).reshape(-1, 3)
    cell = np.arange(n * (width + 1)).reshape(n, width + 1)
    cell = np.vstack([cell, cell[:1, ::-1]])
    low, high = cell[:-1], cell[1:]
    faces = np.concatenate(
        [
            np.stack([low[:, :-1], low[:, 1:], high[:, 1:]], -1).reshape(-1, 3),
            np.stack([low[:, :-1], high[:, 1:], high[:, :-1]], -1).reshape(-1, 3),
        ]
    )
    solver = gt.GeodesicSolver(gt.TriangleMesh(places, faces))
    loop = gt.geodesic_loop(solver, [cell[0, 2], cell[20, 2], cell[40, 2]])
    assert abs(winding(loop.points, np.zeros(2))) == 1
    assert loop.length <= polygon(n, 1.0) * (1 + 1e-9)


def test_a_loop_through_a_non_manifold_vertex_is_held_there():
    near = shapes.torus(24, 12)
    far = gt.TriangleMesh(near.vertices + np.array([5.0, 0, 0]), near.faces)
    west = near.vertices[:, 0].argmax()
    east = far.vertices[:, 0].argmin()
    faces = far.faces + near.n_vertices
    faces[faces == east + near.n_vertices] = west
    mesh = gt.TriangleMesh(
        np.vstack([near.vertices, far.vertices]), np.concatenate([near.faces, faces])
    )
    solver = gt.GeodesicSolver(mesh)
    stops = [100, 200, near.n_vertices + 60, near.n_vertices + 200]
    path = gt.geodesic_path(solver, 100, near.n_vertices + 60)
    assert np.linalg.norm(path.points - mesh.vertices[west], axis=1).min() < 1e-9
    loop = gt.geodesic_loop(solver, stops)
    assert np.linalg.norm(loop.points - mesh.vertices[west], axis=1).min() < 1e-9


def test_a_mask_is_not_crossed():
    mask = np.zeros(TORUS.domain.n_vertices, dtype=bool)
    inner = np.arange(RINGS) * AROUND + AROUND // 2
    mask[inner] = True
    solver = gt.GeodesicSolver(TORUS.domain, mask=mask)
    loop = gt.geodesic_loop(solver, along_tube())
    assert loop.length > 1.005 * polygon(RINGS, MAJOR - MINOR)
    with pytest.raises(ContractibleLoopError):  # every way around the tube is cut
        gt.geodesic_loop(solver, [0, AROUND // 3, 2 * AROUND // 3])


def test_degenerate_faces_do_no_harm():
    torus = TORUS.domain
    extra = np.array([[0, 0, 1], [3, 4, 3], [0, AROUND, 2 * AROUND]])
    vertices = torus.vertices.copy()
    vertices[AROUND] = (vertices[0] + vertices[2 * AROUND]) / 2
    mesh = gt.TriangleMesh(vertices, np.concatenate([torus.faces, extra]))
    loop = gt.geodesic_loop(gt.GeodesicSolver(mesh), around_tube(20 * AROUND))
    assert np.isfinite(loop.length)


# -- errors --------------------------------------------------------------------------------------


def test_loops_need_a_triangle_mesh():
    cloud = gt.GeodesicSolver(gt.PointCloud(shapes.icosphere(2).vertices))
    with pytest.raises(UnsupportedDomainError, match="need a triangle mesh"):
        gt.geodesic_loop(cloud, [0, 1, 2])
    with pytest.raises(InvalidOptionError, match="GeodesicSolver"):
        gt.geodesic_loop(TORUS.domain, [0, 1, 2])


@pytest.mark.parametrize(
    ("stops", "words"),
    [
        ([0, 1, 10**6], "vertex 1000000 does not exist"),
        ([0, 1, -1], "does not exist"),
        ([0, 1], "three places or more"),
        (5, "three places or more"),
        ([], "there are none"),
        ([0, 1, 1, 2], "place 2 is place 1 again"),
        ([0, 1, 2, 0], "place 0 is place 3 again"),
        (gt.Curve([[0, 0, 0], [1, 0, 0], [1, 1, 0]]), "not through a Curve"),
        (gt.OffsetSources([0, 1, 2], [0, 1, 2]), "not through an OffsetSources"),
        ([0.5, 1.5], "points in space"),
        ([[0, 0, np.nan]], "not finite"),
        ("abc", "must be vertex indices"),
    ],
)
def test_way_points_that_are_none_are_refused(stops, words):
    with pytest.raises(InvalidSourceError, match=words):
        gt.geodesic_loop(TORUS, stops)


@pytest.mark.parametrize("length", [-1.0, np.nan, np.inf, "long", True])
def test_a_least_length_is_a_length(length):
    with pytest.raises(InvalidOptionError, match="min_length"):
        gt.geodesic_loop(TORUS, around_tube(), min_length=length)


def test_way_points_in_different_components_are_named():
    two = shapes.disjoint_union(shapes.icosphere(1), shapes.icosphere(1))
    solver = gt.GeodesicSolver(two)
    for through in (False, True):
        with pytest.raises(UnreachableError, match="place 2 with place 1"):
            gt.geodesic_loop(solver, [0, 5, 50], through=through)
