"""Polygons become triangles inside them, whatever their form."""

import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import geodesic_toolkit as gt
from geodesic_toolkit.errors import MissingDependencyError, ReadWarning
from geodesic_toolkit.geometry.polygons import split_polygons

U = np.array([[0, 0], [3, 0], [3, 3], [2, 3], [2, 0.5], [1, 0.5], [1, 3], [0, 3]], dtype=float)
ARROW = np.array([[0, 0], [2, 1], [0, 2], [0.5, 1]], dtype=float)
KEYHOLE = np.array(
    [[0, 0], [3, 0], [3, 3], [0, 3], [0, 0], [1, 1], [1, 2], [2, 2], [2, 1], [1, 1]], dtype=float
)
SLIT = np.array([[0, 0], [4, 0], [4, 4], [2 + 1e-6, 4], [2, 1], [2 - 1e-6, 4], [0, 4]])
TILT = np.linalg.qr(np.array([[1.0, 2, 3], [0, 1, 4], [5, 6, 0]]))[0]


def in_space(ring):
    return np.column_stack([ring, np.zeros(len(ring))]) @ TILT.T


def shoelace(ring):
    x, y = ring.T
    return abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2


def split(points):
    n = len(points)
    return split_polygons(np.asarray(points, dtype=float), np.array([n]), np.arange(n))


def areas(points, faces):
    a, b, c = (np.asarray(points)[faces[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def rim(faces):
    """The directed edges that have no opposite."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    directed = set(map(tuple, edges.tolist()))
    return {(a, b) for a, b in directed if (b, a) not in directed}


def fan(n):
    return np.column_stack([np.zeros(n - 2), np.arange(1, n - 1), np.arange(2, n)]).astype(int)


def check_inside(ring):
    points = in_space(ring)
    faces, remarks = split(points)
    assert len(faces) == len(ring) - 2
    assert areas(points, faces).sum() == pytest.approx(shoelace(ring))
    n = len(ring)
    assert rim(faces) == {(k, (k + 1) % n) for k in range(n)}
    assert not any("cross" in remark for remark in remarks)


# -- what is not convex ---------------------------------------------------------------------------


@pytest.mark.parametrize("start", range(8))
@pytest.mark.parametrize("turn", [1, -1])
def test_a_notch_is_left_open_from_whichever_corner_the_polygon_begins(start, turn):
    check_inside(np.roll(U, start, axis=0)[::turn])


@pytest.mark.parametrize("start", range(7))
def test_a_slit_that_is_almost_closed_is_left_open(start):
    check_inside(np.roll(SLIT, start, axis=0))


@pytest.mark.parametrize("start", range(10))
def test_a_hole_that_a_bridge_joins_to_the_rim_is_left_open(start):
    ring = np.roll(KEYHOLE, start, axis=0)
    points = in_space(ring)
    faces, remarks = split(points)
    assert areas(points, faces).sum() == pytest.approx(8)
    assert len(remarks) == 1


@pytest.mark.parametrize("start", range(4))
def test_a_quadrangle_is_cut_along_the_diagonal_inside_it(start, monkeypatch):
    monkeypatch.setitem(sys.modules, "manifold3d", None)  # which is not needed for it
    check_inside(np.roll(ARROW, start, axis=0))


def test_corners_on_a_straight_side_stay_corners():
    """Or there would be a crack towards the neighbour on that side."""
    halved = np.stack([U, (U + np.roll(U, -1, axis=0)) / 2], axis=1).reshape(-1, 2)
    for start in range(len(halved)):
        check_inside(np.roll(halved, start, axis=0))


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(0.05, 1), min_size=5, max_size=40), st.integers(0, 39), st.booleans())
def test_a_star_is_covered_and_nothing_else(radii, start, halved):
    angle = np.linspace(0, 2 * np.pi, len(radii), endpoint=False)
    ring = np.roll(np.array(radii) * [np.cos(angle), np.sin(angle)], start, axis=1).T
    if halved:
        ring = np.stack([ring, (ring + np.roll(ring, -1, axis=0)) / 2], axis=1).reshape(-1, 2)
    check_inside(ring)


def test_a_polygon_that_is_not_plane_is_split_as_it_is_seen_along_its_normal():
    points = np.column_stack([U, 0.1 * np.sin(3 * U[:, 0])])
    faces, _ = split(points)
    assert areas(points * [1, 1, 0], faces).sum() == pytest.approx(6.5)


@pytest.mark.slow
def test_a_large_polygon_takes_no_time():
    angle = np.linspace(0, 2 * np.pi, 20_000, endpoint=False)
    ring = ((1 + 0.3 * np.sin(50 * angle)) * [np.cos(angle), np.sin(angle)]).T
    points = in_space(ring)
    faces, _ = split(points)
    assert areas(points, faces).sum() == pytest.approx(shoelace(ring))


def test_only_what_is_not_convex_is_split_another_way():
    hexagon = np.array([[np.cos(a), np.sin(a)] for a in np.arange(6) * np.pi / 3])
    points = np.vstack([in_space(hexagon), in_space(U), in_space(ARROW)])
    sizes = np.array([6, 2, 3, 8, 4])
    corners = np.concatenate([range(6), [0, 1], [0, 1, 2], range(6, 14), range(14, 18)])
    faces, remarks = split_polygons(points, sizes, corners)
    np.testing.assert_array_equal(faces[:4], fan(6))
    np.testing.assert_array_equal(faces[4], [0, 1, 2])
    assert areas(points, faces[5:11]).sum() == pytest.approx(6.5)
    assert areas(points, faces[11:]).sum() == pytest.approx(shoelace(ARROW))
    assert remarks[0].startswith("3 polygons were split into 12 triangles")


# -- what is convex -------------------------------------------------------------------------------


@pytest.mark.parametrize("offset", [0, 5.4e6])
@pytest.mark.parametrize("n", [4, 5, 12])
def test_a_convex_polygon_becomes_the_fan_of_its_first_corner(n, offset, monkeypatch):
    monkeypatch.setitem(sys.modules, "manifold3d", None)
    angle = np.linspace(0, 2 * np.pi, n, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    halved = np.stack([ring, (ring + np.roll(ring, -1, axis=0)) / 2], axis=1).reshape(-1, 2)
    for points in (ring, halved, np.repeat(ring, 2, axis=0)):
        faces, _ = split(in_space(points) + offset)
        np.testing.assert_array_equal(faces, fan(len(points)))


@pytest.mark.parametrize(
    "points", [np.zeros((5, 3)), np.arange(15.0).reshape(5, 3), np.full((5, 3), np.nan)]
)
def test_a_polygon_without_area_keeps_its_fan(points):
    faces, remarks = split(points)
    np.testing.assert_array_equal(faces, fan(5))
    assert len(remarks) == 1


def test_a_polygon_that_refers_to_no_vertex_is_for_the_mesh_to_name():
    faces, _ = split_polygons(np.zeros((3, 3)), np.array([4]), np.array([0, 1, 2, 9]))
    np.testing.assert_array_equal(faces, [[0, 1, 2], [0, 2, 9]])


# -- what crosses itself --------------------------------------------------------------------------

PENTAGON = np.array([[np.cos(a), np.sin(a)] for a in np.arange(5) * 2 * np.pi / 5])
CROSSED = {
    "bow tie": U[[0, 2, 1, 7]],
    "star": PENTAGON[[0, 2, 4, 1, 3]],
    "eight": np.array([[0, 0], [2, 2], [4, 4], [4, 0], [2, 2], [0, 4]], dtype=float),
    "two loops": np.array([[0, 0], [4, 4], [4, 2], [0, 2], [0, 4], [4, 0]], dtype=float),
    "twice round": np.vstack([PENTAGON, PENTAGON * 0.9]),
}


@pytest.mark.parametrize("name", CROSSED)
def test_a_polygon_that_crosses_itself_is_named(name):
    ring = CROSSED[name]
    for start in range(len(ring)):
        points = np.vstack([in_space(PENTAGON), in_space(np.roll(ring, start, axis=0))])
        sizes = np.array([5, len(ring)])
        _, remarks = split_polygons(points, sizes, np.arange(len(points)))
        assert any("polygon 1 crosses itself" in remark for remark in remarks), start


@pytest.mark.parametrize("name", CROSSED)
def test_edges_that_pass_each_other_in_space_are_not_a_crossing(name):
    ring = CROSSED[name]
    heights = np.random.default_rng(0).uniform(0, np.ptp(ring), len(ring))
    faces, remarks = split(np.column_stack([ring, heights]))
    assert len(faces) == len(ring) - 2
    assert len(remarks) == 1


def test_many_polygons_that_cross_themselves_are_counted():
    points = in_space(CROSSED["bow tie"])
    _, remarks = split_polygons(points, np.full(8, 4), np.tile(np.arange(4), 8))
    assert "polygons 0, 1, 2, 3, 4 and 3 more cross themselves" in remarks[1]


# -- every input ----------------------------------------------------------------------------------


def files():
    points = "".join(f"{x} {y} 0\n" for x, y in U)
    corners = " ".join(map(str, range(8)))
    return {
        "floor.obj": "".join(f"v {line}\n" for line in points.splitlines()) + "f 1 2 3 4 5 6 7 8\n",
        "floor.off": f"OFF\n8 1 0\n{points}8 {corners}\n",
        "floor.ply": "ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\n"
        "property double y\nproperty double z\nelement face 1\n"
        f"property list uchar int vertex_indices\nend_header\n{points}8 {corners}\n",
        "floor.vtk": "# vtk DataFile Version 3.0\nU\nASCII\nDATASET POLYDATA\n"
        f"POINTS 8 double\n{points}POLYGONS 1 9\n8 {corners}\n",
    }


@pytest.mark.parametrize("name", files())
def test_every_reader_leaves_a_notch_open(name, tmp_path):
    (tmp_path / name).write_text(files()[name])
    with pytest.warns(ReadWarning, match="1 polygon was split into 6 triangles"):
        mesh = gt.read(tmp_path / name)
    assert gt.geodesic_distance(mesh, 6, refine=True)[3] == pytest.approx(6.0)


def test_shapes_of_other_libraries_leave_a_notch_open():
    pyvista, meshio = pytest.importorskip("pyvista"), pytest.importorskip("meshio")
    points = in_space(U)
    surface = pyvista.PolyData(points, [8, *range(8)])
    for shape in (
        surface,
        surface.cast_to_unstructured_grid(),
        meshio.Mesh(points, [("polygon", [range(8)])]),
    ):
        with pytest.warns(ReadWarning, match="1 polygon was split into 6 triangles"):
            mesh = gt.as_domain(shape)
        assert gt.geodesic_distance(mesh, 6, refine=True)[3] == pytest.approx(6.0)


def test_a_crossing_of_a_file_is_a_warning_that_names_the_file_and_the_polygon(tmp_path):
    path = tmp_path / "roof.obj"
    path.write_text("v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 3 2\nf 1 2 3 4\n")
    with pytest.warns(ReadWarning) as caught:
        gt.read(path)
    assert any(str(w.message).startswith("roof.obj: polygon 1 crosses itself") for w in caught.list)


def test_what_is_missing_to_split_a_polygon_is_named_with_its_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "manifold3d", None)
    (tmp_path / "floor.obj").write_text(files()["floor.obj"])
    with pytest.raises(MissingDependencyError, match=r'manifold3d: pip install ".*\[io\]"'):
        gt.read(tmp_path / "floor.obj")
