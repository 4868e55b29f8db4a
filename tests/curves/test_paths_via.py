"""Paths that take a side, and paths through way points."""

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    UnreachableError,
    UnsupportedDomainError,
)
from geodesic_toolkit.testing import shapes

TORUS = gt.GeodesicSolver(shapes.torus(60, 30))
SQUARE = gt.GeodesicSolver(shapes.grid(21))


def plate_with_a_hole(n=41):
    """The unit square without the middle square of side 0.5."""
    square = shapes.grid(n)
    middles = square.vertices[square.faces].mean(axis=1)
    hole = (np.abs(middles[:, :2] - 0.5) < 0.25).all(axis=1)
    return gt.TriangleMesh(square.vertices, square.faces[~hole])


def vertex_at(mesh, x, y):
    return int(np.linalg.norm(mesh.vertices[:, :2] - [x, y], axis=1).argmin())


def test_a_path_via_a_place_takes_its_side_of_a_hole_and_leaves_it():
    mesh = plate_with_a_hole()
    solver = gt.GeodesicSolver(mesh)
    start, end = vertex_at(mesh, 0.5, 0.1), vertex_at(mesh, 0.5, 0.9)
    around = 0.5 + 2 * np.hypot(0.25, 0.15)
    for x in (0.05, 0.95):
        path = gt.geodesic_path(solver, start, end, via=[vertex_at(mesh, x, 0.5)])
        assert path.length == pytest.approx(around, rel=1e-9)
        middle = path.points[np.abs(path.points[:, 1] - 0.5).argmin()]
        assert middle[0] == pytest.approx(0.25 if x < 0.5 else 0.75)


def test_a_path_through_a_place_passes_it():
    mesh = plate_with_a_hole()
    solver = gt.GeodesicSolver(mesh)
    start, end = vertex_at(mesh, 0.5, 0.1), vertex_at(mesh, 0.5, 0.9)
    stop = vertex_at(mesh, 0.05, 0.5)
    path = gt.geodesic_path(solver, start, end, via=stop, through=True)
    corner = np.hypot(0.25, 0.15) + np.hypot(0.2, 0.25)
    assert path.length == pytest.approx(2 * corner, rel=1e-9)
    assert np.linalg.norm(path.points - mesh.vertices[stop], axis=1).min() < 1e-12


def test_a_path_via_places_between_which_there_is_nothing_is_straight():
    path = gt.geodesic_path(SQUARE, [[0.1, 0.1, 0.0]], [[0.9, 0.5, 0.0]], via=[20, 440])
    assert path.length == pytest.approx(np.hypot(0.8, 0.4), rel=1e-6)


def test_a_path_via_a_spur_comes_back_from_it():
    path = gt.geodesic_path(SQUARE, 0, 5, via=[20])
    assert path.length == pytest.approx(0.25)


def test_a_path_takes_the_other_side_of_a_torus():
    near = gt.geodesic_path(TORUS, 15, 15 + 20 * 30)
    far = gt.geodesic_path(TORUS, 15, 15 + 20 * 30, via=[15 + 40 * 30])
    edge = 2 * 1.5 * np.sin(np.pi / 60)
    assert near.length == pytest.approx(20 * edge, rel=1e-9)
    assert far.length == pytest.approx(40 * edge, rel=1e-9)


def test_pieces_between_way_points_are_shortest_paths():
    stops = [3, 200, 417]
    whole = gt.geodesic_path(SQUARE, stops)
    places = SQUARE.domain.vertices[stops]
    sides = np.linalg.norm(places - np.roll(places, -1, axis=0), axis=1)
    assert not whole.closed
    assert whole.length == pytest.approx(sides[:2].sum(), rel=1e-9)
    closed = gt.geodesic_path(SQUARE, stops, closed=True)
    assert closed.closed
    assert closed.length == pytest.approx(sides.sum(), rel=1e-9)
    assert repr(closed).startswith("GeodesicPath(closed, ")
    assert SQUARE.distance(closed.curve)[stops] == pytest.approx(0, abs=1e-9)


def test_a_path_on_a_mesh_with_three_sheets_at_an_edge_is_taut():
    square = shapes.grid(11)
    fin = square.vertices[square.vertices[:, 0] == 0.5] + [0, 0, 0.4]
    middle = np.flatnonzero(square.vertices[:, 0] == 0.5)
    up = square.n_vertices + np.arange(len(middle))
    faces = [[a, b, c] for a, b, c in zip(middle, middle[1:], up, strict=False)]
    faces += [[b, d, c] for b, c, d in zip(middle[1:], up, up[1:], strict=False)]
    mesh = gt.TriangleMesh(np.vstack([square.vertices, fin]), np.concatenate([square.faces, faces]))
    solver = gt.GeodesicSolver(mesh)
    corner = int(up[0])
    path = gt.geodesic_path(solver, 0, 120, via=[corner])
    assert path.length >= np.sqrt(2) * (1 - 1e-9)
    assert np.isfinite(path.points).all()


@pytest.mark.parametrize(
    ("arguments", "options", "words"),
    [
        ((0, 5), {"closed": True}, "for way points alone"),
        ((0, 5), {"through": True}, "give some"),
        (([0, 5, 9],), {"via": [3]}, "there is none"),
        (([0, 5, 9],), {"through": True}, "there is none"),
    ],
)
def test_options_that_do_not_go_together_are_refused(arguments, options, words):
    with pytest.raises(InvalidOptionError, match=words):
        gt.geodesic_path(SQUARE, *arguments, **options)


@pytest.mark.parametrize(
    ("arguments", "options", "words"),
    [
        (([0],), {}, "two places or more"),
        (([0, 5],), {"closed": True}, "three places or more"),
        (([0, 5, 5],), {}, "place 2 is place 1 again"),
        (([0, 1], 5), {"via": [3]}, "one source, not 2"),
        ((0, [5, 6]), {"via": [3]}, "one target, not 2"),
        ((0, 5), {"via": [0]}, "place 1 is place 0 again"),
        ((0, 5), {"via": [10**9]}, "via: vertex 1000000000"),
    ],
)
def test_places_that_are_none_are_refused(arguments, options, words):
    with pytest.raises(InvalidSourceError, match=words):
        gt.geodesic_path(SQUARE, *arguments, **options)


def test_way_points_need_a_mesh_that_connects_them():
    cloud = gt.GeodesicSolver(gt.PointCloud(shapes.grid(9).vertices))
    with pytest.raises(UnsupportedDomainError, match="need a triangle mesh"):
        gt.geodesic_path(cloud, [0, 5, 9])
    two = gt.GeodesicSolver(shapes.disjoint_union(shapes.grid(4), shapes.grid(4)))
    with pytest.raises(UnreachableError, match="way point 1 with way point 0"):
        gt.geodesic_path(two, [0, 20])
    with pytest.raises(UnreachableError, match="place 2 with place 1"):
        gt.geodesic_path(two, 0, 20, via=[5])


@pytest.mark.parametrize(
    ("stops", "length"),
    [
        ((1343, 2162, 142), 0.172473494325),
        ((409, 1865, 2850), 0.190978459083),
        ((3444, 3019, 3357), 0.202791330419),
        ((3370, 153, 2817), 0.208842932321),
    ],
)
def test_paths_via_a_place_are_not_longer_than_by_edge_flips(shared_data, stops, length):
    """Lengths by the edge flips of potpourri3d; by turns at bends alone these paths are longer."""
    source, via, target = stops
    solver = gt.GeodesicSolver(gt.read(shared_data("igltut__bunny.off")))
    path = gt.geodesic_path(solver, source, target, via=[via])
    assert path.length < length * (1 + 1e-9)
