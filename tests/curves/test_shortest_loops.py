"""The shortest loops that do not shrink: lengths in closed form, classes, surfaces without any."""

from itertools import combinations, permutations

import numpy as np
import pytest
from curved_shapes import moebius
from loop_shapes import (
    Homology,
    along_edges,
    polygon,
    pretzel,
    subdivided,
    surface_of,
    tilted_cylinder,
)
from sample_shapes import scrambled

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    ContractibleLoopError,
    GeodesicError,
    InvalidOptionError,
    InvalidSourceError,
    UnreachableError,
    UnsupportedDomainError,
)
from geodesic_toolkit.testing import shapes

NARROWER = 2e-3
"""Share by which a tube of straight edges is narrower between its rings than at them."""
SAME = 1e-9
"""Difference of lengths that rounding explains."""


def girth(mesh, at=None, **options):
    return gt.shortest_loop(gt.GeodesicSolver(mesh), at, **options)


def plate_with_hole(side=12, low=4, high=7):
    """A plate of squares of side 1, and a square hole in it."""
    plate = shapes.grid(side + 1)
    places = np.round(plate.vertices * side)
    inside = ((places[:, :2] > low - 0.5) & (places[:, :2] < high + 0.5)).all(axis=1)
    return gt.TriangleMesh(places, plate.faces[~inside[plate.faces].all(axis=1)])


def around_hull(points):
    """Perimeter of the convex hull of points in the plane."""
    from scipy.spatial import ConvexHull

    return ConvexHull(points).area  # in the plane that is the perimeter


def seven_vertex_torus():
    """Császár's: every two of its vertices have an edge."""
    step = np.arange(7)
    faces = [
        np.column_stack([step, step + 1, step + 3]),
        np.column_stack([step, step + 3, step + 2]),
    ]
    places = np.random.default_rng(0).normal(size=(7, 3))
    return gt.TriangleMesh(places, np.concatenate(faces) % 7)


def projective_plane():
    faces = "012 023 034 045 051 124 235 341 452 513"
    places = np.random.default_rng(1).normal(size=(6, 3))
    return gt.TriangleMesh(places, [[int(v) for v in face] for face in faces.split()])


def holed(mesh, share, rng):
    """A mesh without some of its faces."""
    return gt.TriangleMesh(mesh.vertices, mesh.faces[rng.random(mesh.n_faces) >= share])


# -- closed forms --------------------------------------------------------------------------------


def test_the_girth_of_a_thin_torus_is_around_its_tube():
    loop = girth(shapes.torus(60, 30, major=2.0, minor=0.5))
    assert loop.closed
    assert loop.length == pytest.approx(polygon(30, 0.5), rel=NARROWER)


def test_the_girth_of_a_fat_torus_is_its_inner_equator():
    mesh = shapes.torus(60, 30, major=1.2, minor=1.0)
    loop = girth(mesh)
    assert loop.length == pytest.approx(polygon(60, 0.2), rel=SAME)
    assert np.hypot(*loop.points.T[:2]) == pytest.approx(0.2, rel=2e-3)


def test_through_the_outer_side_of_a_fat_torus_the_loop_is_around_the_tube():
    mesh = shapes.torus(60, 30, major=1.2, minor=1.0)
    outer = int(np.argmax(mesh.vertices[:, 0]))
    loop = girth(mesh, outer)
    assert loop.points[0] == pytest.approx(mesh.vertices[outer])
    assert loop.length == pytest.approx(polygon(30, 1.0), rel=NARROWER)


def test_lengths_converge_to_the_small_circle():
    errors = [abs(girth(shapes.torus(n, n // 2)).length / np.pi - 1) for n in (30, 60, 120)]
    assert errors[1] < errors[0] / 2
    assert errors[2] < errors[1] / 2


def test_a_tube_that_is_open_at_both_ends_has_its_circumference():
    mesh, cell = tilted_cylinder()
    around = cell.shape[1]
    for at in (None, int(cell[12, 3])):
        length = girth(mesh, at).length
        assert polygon(around, 1.0) * np.cos(np.pi / around) <= length * (1 + SAME)
        assert length <= polygon(around, 1.0) * (1 + SAME)
    assert girth(shapes.tube(20, 12)).length == pytest.approx(12.0, rel=SAME)


def test_around_the_hole_of_a_plate_the_loop_is_its_outline():
    assert girth(plate_with_hole()).length == pytest.approx(12.0, rel=SAME)


@pytest.mark.parametrize("place", [(0, 0), (11, 3), (5, 12), (4, 9)])
def test_through_a_place_beside_a_hole_the_loop_is_a_convex_hull(place):
    mesh = plate_with_hole()
    at = int(np.flatnonzero((mesh.vertices[:, :2] == place).all(axis=1))[0])
    hull = around_hull([place, (4, 4), (7, 4), (4, 7), (7, 7)])
    assert girth(mesh, at).length == pytest.approx(hull, rel=SAME)


def test_a_place_inside_a_face_is_on_the_loop():
    mesh = plate_with_hole()
    place = np.array([1.25, 9.5, 0.0])
    hull = around_hull([place[:2], (4, 4), (7, 4), (4, 7), (7, 7)])
    loop = girth(mesh, [place])
    assert loop.length == pytest.approx(hull, rel=SAME)
    assert loop.points[0] == pytest.approx(place)


def test_the_shorter_outline_of_an_annulus_is_its_girth():
    n = 40
    turn = 2 * np.pi * np.arange(n) / n
    rings = [radius * np.column_stack([np.cos(turn), np.sin(turn)]) for radius in (1, 1.4, 2)]
    mesh, _ = tilted_cylinder(rings=3, around=n)
    flat = gt.TriangleMesh(np.column_stack([np.vstack(rings), np.zeros(3 * n)]), mesh.faces)
    assert girth(flat).length == pytest.approx(polygon(n, 1.0), rel=SAME)


def test_the_girth_of_a_block_with_holes_is_around_the_thinnest_wall():
    mesh, _ = pretzel(holes=2)
    # The wall beyond the hole is 2 by 3; between the holes it is 3 by 3, and a hole is 4 by 3.
    assert girth(mesh).length == pytest.approx(10.0, rel=SAME)


def test_a_neck_that_separates_two_handles_is_found():
    solid = np.zeros((17, 7, 3), dtype=bool)
    for begin in (0, 10):
        solid[begin : begin + 7] = True
        solid[begin + 2 : begin + 5, 2:5] = False
    solid[7:10, 3, 1] = True
    mesh, corners = surface_of(solid)
    loop = girth(mesh)
    assert loop.length == pytest.approx(4.0, rel=SAME)
    assert Homology(mesh.faces).bounds(along_edges(loop))
    assert girth(mesh, corners[9, 4, 3]).length == pytest.approx(4.0, rel=SAME)


def test_a_masked_limb_has_the_girth_of_its_waist():
    sphere = shapes.icosphere(4)
    up = sphere.vertices[:, 2]
    width = 1 - 0.5 * np.exp(-((up / 0.5) ** 2))
    mesh = gt.TriangleMesh(
        sphere.vertices * np.column_stack([width, width, np.ones(len(up))]), sphere.faces
    )
    with pytest.raises(ContractibleLoopError, match="mask the vertices at both of its ends"):
        girth(mesh)
    loop = gt.shortest_loop(gt.GeodesicSolver(mesh, mask=np.abs(up) > 0.7))
    assert loop.length == pytest.approx(2 * np.pi * 0.5, rel=0.03)
    assert abs(loop.points[:, 2]).max() < 0.1


def test_a_loop_goes_around_a_band_of_one_side():
    mesh, *_ = np.atleast_1d(moebius())
    loop = girth(mesh)
    assert not Homology(mesh.faces).bounds(along_edges(loop))


# -- classes, against all cycles of edges ----------------------------------------------------------


@pytest.mark.parametrize("mesh", [seven_vertex_torus(), projective_plane(), shapes.torus(4, 3)])
def test_on_a_tiny_surface_no_cycle_is_pulled_to_a_shorter_loop(mesh):
    solver, classes = gt.GeodesicSolver(mesh), Homology(mesh.faces)
    loop = gt.shortest_loop(solver)
    assert not classes.bounds(along_edges(loop))
    edges = {frozenset(pair) for face in mesh.faces.tolist() for pair in combinations(face, 2)}
    shortest = np.inf
    for size in (3, 4):
        for first, *rest in permutations(range(mesh.n_vertices), size):
            cycle = [first, *rest]
            if first != min(cycle) or rest[0] > rest[-1]:
                continue
            sides = {frozenset(pair) for pair in zip(cycle, [*rest, first], strict=True)}
            if sides <= edges and not classes.bounds(cycle):
                shortest = min(shortest, gt.geodesic_loop(solver, cycle).length)
    assert loop.length <= shortest * (1 + SAME)


@pytest.mark.parametrize("seed", range(8))
def test_a_loop_is_found_where_the_surface_has_one_and_does_not_bound(seed):
    """Faces and vertices are left out at random: sheets meet at vertices, holes at corners."""
    rng = np.random.default_rng(seed)
    for whole in (shapes.torus(10, 6), shapes.icosphere(1), shapes.tube(6, 5), shapes.grid(6)):
        mesh = holed(whole, rng.choice([0.0, 0.1, 0.3]), rng)
        mask = rng.random(mesh.n_vertices) < rng.choice([0.0, 0.05, 0.2])
        mask[mesh.faces[0]] = False
        solver = gt.GeodesicSolver(mesh, mask=mask)
        classes = Homology(mesh.faces[~mask[mesh.faces].any(axis=1)])
        if not classes.rank:
            with pytest.raises(ContractibleLoopError):
                gt.shortest_loop(solver)
            continue
        loop = gt.shortest_loop(solver)
        assert not classes.bounds(along_edges(loop))
        for at in mesh.faces[:3, 0].tolist():
            if mask[at]:
                continue
            try:
                held = gt.shortest_loop(solver, at)
            except (ContractibleLoopError, UnreachableError):
                continue
            assert not classes.bounds(along_edges(held))
            assert held.points[0] == pytest.approx(mesh.vertices[at])
            assert held.length >= loop.length * (1 - SAME)


def test_a_loop_runs_through_two_vertices_in_which_sheets_meet():
    sphere = shapes.icosphere(2)
    north, east = int(sphere.vertices[:, 2].argmax()), int(sphere.vertices[:, 0].argmax())
    number = np.arange(sphere.n_vertices) + sphere.n_vertices
    number[[north, east]] = north, east
    other = 1.1 * sphere.vertices
    other[[north, east]] = sphere.vertices[[north, east]]
    mesh = gt.TriangleMesh(
        np.vstack([sphere.vertices, other]), np.concatenate([sphere.faces, number[sphere.faces]])
    )
    pieces = [
        gt.geodesic_path(gt.GeodesicSolver(gt.TriangleMesh(places, sphere.faces)), north, east)
        for places in (sphere.vertices, other)
    ]
    length = sum(piece.length for piece in pieces)
    for at in (None, north, east):
        assert girth(mesh, at).length == pytest.approx(length, rel=1e-6)
    once = number.copy()
    once[east] += sphere.n_vertices
    joined = gt.TriangleMesh(
        np.vstack([sphere.vertices, other, other[[east]]]),
        np.concatenate(
            [sphere.faces, np.where(number == east, 2 * sphere.n_vertices, number)[sphere.faces]]
        ),
    )
    with pytest.raises(ContractibleLoopError):
        girth(joined)


def test_the_shortest_of_several_components_is_found():
    two = shapes.disjoint_union(
        shapes.torus(40, 20), shapes.icosphere(2), shapes.torus(30, 20, minor=0.3)
    )
    assert girth(two).length == pytest.approx(polygon(20, 0.3), rel=2 * NARROWER)
    assert girth(two, 0).length == pytest.approx(polygon(20, 0.5), rel=2 * NARROWER)
    with pytest.raises(ContractibleLoopError, match="its component has no handle"):
        girth(two, 800)


# -- laws ------------------------------------------------------------------------------------------


def test_length_scales_and_does_not_depend_on_the_numbering_or_on_flat_cuts():
    mesh = shapes.bumpy_torus(48, 24, rng=np.random.default_rng(0))
    length = girth(mesh).length
    assert girth(gt.TriangleMesh(1e3 * mesh.vertices, mesh.faces)).length == pytest.approx(
        1e3 * length
    )
    assert girth(scrambled(mesh)).length == pytest.approx(length, rel=1e-6)
    assert girth(subdivided(mesh)).length == pytest.approx(length, rel=1e-6)


@pytest.mark.parametrize("seed", [0, 2])
def test_no_loop_through_way_points_is_shorter(seed):
    rng = np.random.default_rng(seed)
    torus = shapes.torus(40, 40, major=1.5, minor=1.0)
    bumps = 1 + 0.02 * rng.normal(size=(torus.n_vertices, 1))
    solver = gt.GeodesicSolver(gt.TriangleMesh(torus.vertices * bumps, torus.faces))
    length = gt.shortest_loop(solver).length
    for _ in range(40):
        try:
            other = gt.geodesic_loop(solver, rng.integers(0, torus.n_vertices, 4))
        except GeodesicError:
            continue
        assert length <= other.length * (1 + SAME)


def test_loops_through_neighbours_differ_by_twice_their_edge_at_most():
    mesh = shapes.bumpy_torus(48, 24, rng=np.random.default_rng(1))
    solver = gt.GeodesicSolver(mesh)
    lengths = np.array([gt.shortest_loop(solver, v).length for v in range(120)])
    edges = np.vstack([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]]])
    edges = edges[(edges < len(lengths)).all(axis=1)]
    apart = np.linalg.norm(np.diff(mesh.vertices[edges], axis=1)[:, 0], axis=1)
    assert (np.abs(np.diff(lengths[edges], axis=1)[:, 0]) <= 2 * apart + SAME).all()
    assert lengths.min() >= gt.shortest_loop(solver).length * (1 - SAME)


# -- short holes -----------------------------------------------------------------------------------


def without(mesh, *faces):
    return gt.TriangleMesh(mesh.vertices, np.delete(mesh.faces, faces, axis=0))


def test_short_holes_count_as_filled():
    torus = shapes.torus(24, 12)
    length = girth(torus).length
    pierced = without(torus, *range(0, torus.n_faces, 37))
    assert girth(pierced).length < 2
    assert length * (1 - SAME) <= girth(pierced, min_hole=2.0).length < 1.05 * length
    sphere = without(shapes.icosphere(2), 3, 60, 200)
    with pytest.raises(ContractibleLoopError, match="one hole of 10 or more"):
        girth(sphere, min_hole=10.0)


def test_short_holes_that_meet_at_a_vertex_count_as_filled():
    sphere = shapes.icosphere(2)
    around = np.flatnonzero((sphere.faces == 20).any(axis=1))
    shared = (sphere.faces[around][:, :, None] == sphere.faces[around[0]]).any(axis=2).sum(axis=1)
    opposite = around[shared == 1][0]
    touching = without(sphere, around[0], opposite)
    assert girth(touching).length < 2
    for at in (None, 20, 100):
        with pytest.raises(ContractibleLoopError):
            girth(touching, at, min_hole=10.0)


def test_an_island_in_a_hole_is_refused():
    """A face in a hole that touches its outline at two corners."""
    plate = shapes.grid(7)
    places = np.round(plate.vertices * 6)
    centre = places[plate.faces].mean(axis=1)
    inside = (np.abs(centre[:, :2] - 3) < 1).all(axis=1)
    faces = plate.faces[~inside]
    corners = [int(np.flatnonzero((places[:, :2] == at).all(axis=1))[0]) for at in ((2, 2), (4, 4))]
    mesh = gt.TriangleMesh(
        np.vstack([places, [[2.6, 3.4, 0]]]), np.vstack([faces, [[*corners, len(places)]]])
    )
    with pytest.raises(UnsupportedDomainError, match="holes shorter than min_hole meet at vertex"):
        girth(mesh, min_hole=12.0)


def test_a_long_hole_remains_one_beside_short_ones():
    mesh = plate_with_hole(side=16, low=5, high=9)
    near = np.abs(mesh.vertices[mesh.faces].mean(axis=1)[:, :2] - 7).max(axis=1)
    mesh = without(mesh, *np.flatnonzero(near > 4)[::40])
    assert girth(mesh).length < 4
    assert girth(mesh, min_hole=15.5).length == pytest.approx(16.0, rel=SAME)
    with pytest.raises(ContractibleLoopError):
        girth(mesh, min_hole=16.5)


# -- errors ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "mesh", [shapes.icosphere(2), shapes.grid(5), gt.TriangleMesh(np.eye(3), [[0, 1, 2]])]
)
@pytest.mark.parametrize("at", [None, 0, 2])
def test_spheres_and_discs_have_none(mesh, at):
    with pytest.raises(ContractibleLoopError, match=r"shrinks to a point.*isolines"):
        girth(mesh, at)


def test_loops_need_a_triangle_mesh():
    torus = shapes.torus(8, 6)
    lengths = np.linalg.norm(np.diff(torus.vertices[torus.faces[:, [1, 2, 0, 1]]], axis=1), axis=2)
    for domain in (gt.PointCloud(torus.vertices), gt.IntrinsicMesh(torus.faces, lengths)):
        with pytest.raises(UnsupportedDomainError, match="need a triangle mesh"):
            girth(domain)
    with pytest.raises(InvalidOptionError, match="GeodesicSolver"):
        gt.shortest_loop(torus)


@pytest.mark.parametrize("at", [None, 0])
def test_an_edge_of_three_faces_is_named_by_its_faces(at):
    torus = shapes.torus(8, 6)
    fin = gt.TriangleMesh(
        np.vstack([torus.vertices, [[4.0, 0, 0]]]),
        np.concatenate([torus.faces, [[*torus.faces[5, :2], torus.n_vertices]]]),
    )
    with pytest.raises(UnsupportedDomainError, match=r"faces .*96 share an edge"):
        girth(fin, at)
    both = shapes.disjoint_union(fin, torus)
    assert girth(both, fin.n_vertices).length == pytest.approx(girth(torus, 0).length)


@pytest.mark.parametrize(
    ("at", "words"),
    [
        ([0, 1], "held at one place, not at 2"),
        (10**6, "vertex 1000000 does not exist"),
        (gt.Curve([[0, 0, 0], [1, 0, 0], [1, 1, 0]]), "not through a Curve"),
        ([[0, 0, np.nan]], "not finite"),
    ],
)
def test_what_is_not_one_place_is_refused(at, words):
    with pytest.raises(InvalidSourceError, match=words):
        girth(shapes.torus(8, 6), at)


def test_a_place_in_no_face_is_unreachable():
    torus = shapes.torus(8, 6)
    mask = np.zeros(torus.n_vertices, dtype=bool)
    mask[torus.faces[(torus.faces == 0).any(axis=1)]] = True
    mask[0] = False
    with pytest.raises(UnreachableError, match="the place of the loop"):
        gt.shortest_loop(gt.GeodesicSolver(torus, mask=mask), 0)


@pytest.mark.parametrize("length", [-1.0, np.nan, np.inf, "long", True])
def test_the_least_length_of_a_hole_is_a_length(length):
    with pytest.raises(InvalidOptionError, match="min_hole"):
        girth(shapes.torus(8, 6), min_hole=length)


def test_faces_turned_any_way_and_degenerate_faces_do_no_harm():
    torus = shapes.torus(24, 12)
    faces = torus.faces.copy()
    faces[::3] = faces[::3, ::-1]
    mesh = gt.TriangleMesh(
        torus.vertices, np.concatenate([faces, faces[:5], [[0, 0, 1], [3, 4, 3]]])
    )
    assert girth(mesh).length == pytest.approx(girth(torus).length, rel=SAME)
    flat = torus.vertices.copy()
    flat[0] = flat[12]  # an edge without length
    assert girth(gt.TriangleMesh(flat, torus.faces)).length <= girth(torus).length * 1.01


# -- real meshes -----------------------------------------------------------------------------------


def test_no_loop_through_way_points_of_a_mesh_with_three_handles_is_shorter(shared_data):
    mesh = gt.read(shared_data("igltut__3holes.off"))
    solver, rng = gt.GeodesicSolver(mesh), np.random.default_rng(0)
    loop = gt.shortest_loop(solver)
    for _ in range(20):
        try:
            other = gt.geodesic_loop(solver, rng.integers(0, mesh.n_vertices, 4))
        except ContractibleLoopError:
            continue
        assert loop.length <= other.length * (1 + SAME)


def test_a_scan_with_missing_faces_goes_around_longer_holes(shared_data):
    scan = gt.read(shared_data("meshlab__Laurana50k.ply"))
    solver = gt.GeodesicSolver(scan)
    lengths = [gt.shortest_loop(solver, min_hole=least).length for least in (0.0, 2.0, 5.0)]
    assert lengths[0] < 2 <= lengths[1] < 5 <= lengths[2]
