"""Files of finite elements give back a surface: cells, their outsides, and node numbers."""

import re
import struct
import warnings

import numpy as np
import pytest
from sample_files import FACES, POINTS, WRITTEN, check_octahedron, place

import geodesic_toolkit as gt
from geodesic_toolkit.errors import ReadError, ReadWarning

# -- finite-element meshes ------------------------------------------------------------------------


def write_cells(path, cells, points=None):
    meshio = pytest.importorskip("meshio")
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    meshio.write(path, meshio.Mesh(corners if points is None else points, cells))
    return path


def directed_volume(mesh):
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    return np.einsum("fi,fi->", a, np.cross(b, c)) / 6


def test_the_surface_of_tetrahedra_is_what_only_one_of_them_has(tmp_path):
    cells = [("tetra", np.array([[0, 1, 2, 4], [1, 2, 4, 7]]))]
    mesh = gt.read(write_cells(tmp_path / "two.vtu", cells))
    assert (mesh.n_vertices, mesh.n_faces) == (8, 6)
    assert {frozenset(face) for face in mesh.faces.tolist()}.isdisjoint({frozenset({1, 2, 4})})


@pytest.mark.parametrize(
    ("kind", "cell", "volume", "quads"),
    [
        ("tetra", [0, 1, 2, 4], 1 / 6, 0),
        ("hexahedron", [0, 1, 3, 2, 4, 5, 7, 6], 1.0, 6),
        ("wedge", [0, 1, 2, 4, 5, 6], 1 / 2, 3),
        ("pyramid", [0, 1, 3, 2, 4], 1 / 3, 1),
    ],
)
def test_the_surface_of_a_solid_cell_is_closed_and_points_outwards(
    kind, cell, volume, quads, tmp_path
):
    path = write_cells(tmp_path / "one.vtu", [(kind, np.array([cell]))])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        mesh = gt.read(path)
    assert [w.category for w in caught] == [ReadWarning] * (quads > 0)
    assert directed_volume(mesh) == pytest.approx(volume)


def test_triangles_of_a_solid_mesh_are_its_surface_when_they_are_stored(tmp_path):
    cells = [("triangle", np.array([[0, 1, 2]])), ("tetra", np.array([[0, 1, 2, 4]]))]
    assert gt.read(write_cells(tmp_path / "t.mesh", cells)).n_faces == 1


def test_triangles_of_second_order_are_split_at_the_nodes_of_their_edges(tmp_path):
    mesh = gt.read(write_cells(tmp_path / "t.vtu", [("triangle6", np.array([[0, 1, 2, 3, 4, 5]]))]))
    np.testing.assert_array_equal(mesh.faces, [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])


def test_polygons_of_a_finite_element_file_are_split(tmp_path):
    path = write_cells(tmp_path / "t.vtu", [("polygon", np.array([[0, 1, 3, 7, 5]]))])
    with pytest.warns(ReadWarning, match="1 polygon was split into 3"):
        assert gt.read(path).n_faces == 3


def test_what_meshio_remarks_is_a_warning_and_not_printed(tmp_path, capsys):
    text = meshio_text(tmp_path).replace("$EndElements", "$EndOfIt")
    with pytest.warns(ReadWarning, match=r"o\.msh: meshio says: .*not closed"):
        check_octahedron(gt.read(place(tmp_path, "o.msh", text)), exact=False)
    assert capsys.readouterr() == ("", "")


def meshio_text(folder):
    pytest.importorskip("meshio")
    return WRITTEN["msh"][1](folder).decode()


def test_flat_finite_element_meshes_lie_in_the_plane(tmp_path):
    points = np.array([[0.0, 0], [1, 0], [0, 1]])
    path = tmp_path / "flat.mesh"
    mesh = gt.read(write_cells(path, [("triangle", np.array([[0, 1, 2]]))], points))
    np.testing.assert_array_equal(mesh.vertices, np.column_stack([points, np.zeros(3)]))


def test_single_points_of_a_finite_element_file_are_a_cloud(tmp_path):
    path = write_cells(tmp_path / "p.vtu", [("vertex", np.arange(8)[:, None])])
    assert isinstance(gt.read(path), gt.PointCloud)


def test_cells_that_are_neither_surface_nor_solid_are_named(tmp_path):
    path = write_cells(tmp_path / "lines.vtu", [("line", np.array([[0, 1], [1, 2]]))])
    with pytest.raises(ReadError, match="no surface and no solid cells: the cells are line"):
        gt.read(path)


@pytest.mark.parametrize("version", ["2.2", "4.0", "4.1"])
@pytest.mark.parametrize("binary", [True, False])
def test_node_numbers_of_gmsh_that_would_take_all_memory_are_refused(version, binary, tmp_path):
    gmsh = pytest.importorskip("meshio.gmsh.main")
    meshio = pytest.importorskip("meshio")
    path = tmp_path / "o.msh"
    gmsh.write(path, meshio.Mesh(POINTS, [("triangle", FACES)]), version, binary=binary)
    assert gt.read(path).n_faces == 8
    place, width = POINTS[5].tobytes(), {"4.1": "<Q"}.get(version, "<i")
    if version == "4.1" and binary:
        place = POINTS[0].tobytes()  # behind the last number
    head, nodes, rest = path.read_bytes().partition(b"$Nodes")
    if binary:
        damaged = rest.replace(struct.pack(width, 6) + place, struct.pack(width, 2**31 - 2) + place)
    else:
        line = rb"(?m)^6$" if version == "4.1" else rb"(?m)^6(?= .*\..*\.)"
        damaged = re.sub(line, b"2147483646", rest, count=1)
    assert damaged != rest
    path.write_bytes(head + nodes + damaged)
    with pytest.raises(ReadError, match="node 2147483646 among 6 nodes"):
        gt.read(path)


@pytest.mark.parametrize("version", ["4.0", "4.1"])
@pytest.mark.parametrize("binary", [True, False])
def test_nodes_of_gmsh_that_are_announced_and_do_not_come_are_refused(version, binary, tmp_path):
    gmsh = pytest.importorskip("meshio.gmsh.main")
    meshio = pytest.importorskip("meshio")
    path = tmp_path / "o.msh"
    gmsh.write(path, meshio.Mesh(POINTS, [("triangle", FACES)]), version, binary=binary)
    head, nodes, rest = path.read_bytes().partition(b"$Nodes\n")
    six, nine = (struct.pack("<Q", 6), struct.pack("<Q", 9)) if binary else (b" 6", b" 9")
    path.write_bytes(head + nodes + rest.replace(six, nine, 1))
    with pytest.raises(ReadError, match="9 nodes are announced, but 6 follow"):
        gt.read(path)


def test_sparse_node_numbers_of_gmsh_are_read(tmp_path):
    gmsh = pytest.importorskip("meshio.gmsh.main")
    meshio = pytest.importorskip("meshio")
    path = tmp_path / "o.msh"
    gmsh.write(path, meshio.Mesh(POINTS, [("triangle", FACES)]), "2.2", binary=False)
    text = path.read_text()
    sparse = re.sub(r"(?m)^6 (?=.*\..*\.)", "60000 ", text, count=1)
    sparse = re.sub(r"(?m)(^\d+ 2 2 .*)\b6\b", r"\g<1>60000", sparse)
    path.write_text(sparse)
    assert sparse != text
    np.testing.assert_array_equal(gt.read(path).faces, FACES)


def test_grids_are_read_whatever_data_they_carry(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    grid = pyvista.PolyData.from_regular_faces(POINTS, FACES).cast_to_unstructured_grid()
    grid.point_data.active_normals = POINTS
    for binary in (True, False):
        grid.save(tmp_path / "n.vtk", binary=binary)
        check_octahedron(gt.read(tmp_path / "n.vtk"), exact=False)
