"""Files to domains: counts of real files, every format, and files that are not what they say."""

import gzip
import random
import re
import struct
import sys
import warnings
from functools import partial

import numpy as np
import pytest
from conftest import shared_file
from sample_files import (
    EDGES,
    FACES,
    LENGTHS,
    LISTS,
    POINTS,
    SAMPLES,
    WRITTEN,
    XYZ,
    npz_of,
    off,
    pcd_header,
    ply_header,
    stl,
)
from scipy import sparse

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    GeodesicError,
    MissingDependencyError,
    NotEnoughMemoryError,
    PluginLoadError,
    ReadError,
    ReadWarning,
)
from geodesic_toolkit.io import read_mask, read_points, read_vertices

# -- the shared data set, whose table of counts is the measure ------------------------------------

MESHES = {  # vertices, faces, polygons of more than three corners
    "igltut__bunny.off": (3485, 6966, 0),
    "jacobson__stanford-bunny.obj": (35947, 69451, 0),
    "igltut__armadillo.obj": (43243, 86482, 0),
    "jacobson__spot.obj": (2930, 5856, 0),
    "jacobson__cow.obj": (2903, 5804, 0),
    "jacobson__igea.ply": (134345, 268686, 0),
    "igltut__camelhead.off": (11381, 22704, 0),
    "igltut__3holes.off": (3596, 7200, 0),
    "igltut__face.obj": (25905, 51712, 0),
    "igltut__truck.obj": (2956, 4770, 0),
    "igltut__inspired_mesh_quads_Smooth.off": (1963, 3676, 1838),
    "igltut__horse_quad.obj": (2400, 4796, 2398),
    "igltut__octopus-low.mesh": (452, 898, 0),
    "odedstein__spot_control_mesh.obj": (188, 372, 176),
    "potpourri3d__bunny_poly.ply": (1241, 2478, 996),
    "meshlab__non_manif_hole.ply": (432, 755, 0),
    "meshlab__Laurana50k.ply": (27861, 49954, 0),
    "odedstein__sphere.obj": (642, 1280, 0),
    "odedstein__koala_low_resolution.obj": (3560, 7116, 0),
    "geomcentral__fox.ply": (313, 622, 0),
    "trimesh__counter.unitsmm.STL": (41837, 83750, 0),
    "trimesh__cube_compressed.obj": (8, 12, 0),
    "manifold__99865.stl": (35987, 71974, 0),
}

CLOUDS = {  # points, missing ones, whether normals come with them
    "pcldata__samp11-utm.pcd": (38010, 0, False),
    "pcldata__learn0.pcd": (307200, 124908, False),
    "pcldata__room_scan1.pcd": (112586, 0, False),
    "pcldata__milk.pcd": (12575, 0, False),
    "open3d__fragment_002.ply": (112698, 0, False),
    "open3d__bunnyData.pts": (30571, 0, False),
    "pcl__bun0.pcd": (397, 0, True),
}


@pytest.mark.parametrize("name", MESHES)
def test_a_real_mesh_has_the_vertices_and_faces_of_its_file(name):
    n_vertices, n_faces, n_polygons = MESHES[name]
    if name.endswith(".mesh"):
        pytest.importorskip("meshio")
    path = shared_file(name)
    if n_polygons:
        with pytest.warns(ReadWarning, match=f"^{name}: {n_polygons} polygons were split"):
            mesh = gt.read(path)
    else:
        mesh = gt.read(path)
    assert isinstance(mesh, gt.TriangleMesh)
    assert (mesh.n_vertices, mesh.n_faces) == (n_vertices, n_faces)


@pytest.mark.parametrize("name", CLOUDS)
def test_a_real_cloud_has_the_points_of_its_file(name):
    n_points, n_missing, has_normals = CLOUDS[name]
    cloud = gt.read(shared_file(name))
    assert isinstance(cloud, gt.PointCloud)
    assert cloud.n_vertices == n_points
    assert (~cloud.present).sum() == n_missing
    assert (cloud.normals is not None) == has_normals


def test_the_triangle_strips_of_igea_close_the_surface():
    faces = gt.read(shared_file("jacobson__igea.ply")).faces
    half_edges = set(
        zip(faces.ravel().tolist(), np.roll(faces, -1, axis=1).ravel().tolist(), strict=True)
    )
    assert len(half_edges) == faces.size
    assert half_edges == {(head, tail) for tail, head in half_edges}


# -- every format ---------------------------------------------------------------------------------


def place(folder, name, contents):
    path = folder / name
    path.write_bytes(contents if isinstance(contents, bytes) else contents.encode())
    return path


def check_octahedron(domain, *, exact=True):
    tolerance = 0 if exact else 1e-6
    if isinstance(domain, gt.Graph):
        assert domain.n_vertices == 6
        order = np.lexsort(np.sort(EDGES).T[::-1])
        found = np.lexsort(domain.edges.T[::-1])
        np.testing.assert_array_equal(domain.edges[found], EDGES[order])
        np.testing.assert_array_equal(domain.lengths[found], LENGTHS[order])
    elif isinstance(domain, gt.PointCloud):
        np.testing.assert_allclose(domain.points, POINTS, rtol=tolerance)
    else:
        np.testing.assert_allclose(domain.vertices, POINTS, rtol=tolerance)
        np.testing.assert_array_equal(domain.faces, FACES)


OWN = [(suffix, make) for suffix, makes in SAMPLES.items() for make in makes]


@pytest.mark.parametrize(("suffix", "make"), OWN, ids=[make.__name__ for _, make in OWN])
def test_every_format_gives_back_the_octahedron(suffix, make, tmp_path):
    domain = gt.read(place(tmp_path, f"octahedron.{suffix}", make()))
    if suffix == "stl":  # vertices are numbered by their first use in a face
        np.testing.assert_array_equal(domain.vertices[domain.faces], POINTS[FACES])
        assert domain.n_vertices == 6
    else:
        check_octahedron(domain)


@pytest.mark.parametrize("name", WRITTEN)
def test_every_format_of_another_package_gives_back_the_octahedron(name, tmp_path):
    package, make = WRITTEN[name]
    pytest.importorskip(package)
    domain = gt.read(place(tmp_path, f"octahedron.{name.split()[0]}", make(tmp_path)))
    check_octahedron(domain, exact=False)


def test_the_suffix_may_be_in_capitals_and_the_path_a_string(tmp_path):
    check_octahedron(gt.read(str(place(tmp_path, "OCTAHEDRON.OFF", off()))))


FREESURFER = {"white", "inflated", "sphere", "orig", "smoothwm"}
"""Other names of what is read from .pial."""


def test_every_registered_reader_of_the_core_has_a_sample():
    own = {name for name in gt.readers if ":" not in name} - FREESURFER
    assert own <= {*SAMPLES, *(name.split()[0] for name in WRITTEN), "edgelist"}


# -- OFF ------------------------------------------------------------------------------------------

TRIANGLE = "0 0 0\n1 0 0\n0 1 0\n"


@pytest.mark.parametrize(
    "text",
    [
        "OFF 3 1 0\n" + TRIANGLE + "3 0 1 2\n",
        "OFF3 1 0\n" + TRIANGLE + "3 0 1 2\n",
        "3 1 0\n" + TRIANGLE + "3 0 1 2\n",
        "OFF\n3 1\n" + TRIANGLE + "3 0 1 2\n",
        "# made by hand\n\nOFF # a triangle\r\n3 1 0\r\n" + TRIANGLE + "3 0 1 2 # face\n",
        "OFF\n3 1 0\n" + TRIANGLE + "3 0 1 2 255 0 0\n",
        "OFF\n3 1 0\n" + TRIANGLE + "3\n0 1\n2\n",
        "OFF 3 1 0 0 0 0 1 0 0 0 1 0 3 0 1 2",
        "OFF\n3\n1 0\n" + TRIANGLE + "3 0 1 2\n",
        "COFF\n3 1 0\n0 0 0 9 9 9 9\n1 0 0 9 9 9 9\n0 1 0 9 9 9 9\n3 0 1 2\n",
        "COFF\n3 1 0\n0 0 0 9 9 9\n1 0 0 9 9 9\n0 1 0 9 9 9\n3 0 1 2 1 0 0 1\n",
        "NOFF\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n",
        "STOFF\n3 1 0\n0 0 0 0 1\n1 0 0 0 1\n0 1 0 0 1\n3 0 1 2\n",
        "\ufeffOFF\n3 1 0\n" + TRIANGLE + "3 0 1 2\n",
    ],
)
def test_an_off_file_may_be_written_in_many_ways(text, tmp_path):
    mesh = gt.read(place(tmp_path, "t.off", text))
    np.testing.assert_array_equal(mesh.vertices, [[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2]])


def test_faces_of_an_off_file_may_have_colours_of_different_lengths(tmp_path):
    text = f"OFF\n4 2 0\n{TRIANGLE}1 1 0\n3 0 1 2 255 0 0\n3 1 3 2\n"
    np.testing.assert_array_equal(
        gt.read(place(tmp_path, "t.off", text)).faces, [[0, 1, 2], [1, 3, 2]]
    )


def test_an_off_file_without_faces_is_a_cloud(tmp_path):
    assert isinstance(gt.read(place(tmp_path, "t.off", "OFF\n3 0 0\n" + TRIANGLE)), gt.PointCloud)


# -- polygons -------------------------------------------------------------------------------------

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def test_polygons_are_split_into_fans_with_a_warning_that_points_at_the_caller(tmp_path):
    path = place(tmp_path, "square.obj", SQUARE + "v 0 0 1\nf 1 2 3 4\nf 5 1 2\nf 1 2 3 4 5\n")
    with pytest.warns(
        ReadWarning, match=r"square\.obj: 2 polygons were split into 5 tri"
    ) as caught:
        mesh = gt.read(path)
    np.testing.assert_array_equal(
        mesh.faces, [[0, 1, 2], [0, 2, 3], [4, 0, 1], [0, 1, 2], [0, 2, 3], [0, 3, 4]]
    )
    assert caught[0].filename == __file__


def test_faces_of_fewer_than_three_corners_are_left_out_with_a_warning(tmp_path):
    path = place(tmp_path, "square.obj", SQUARE + "f 1 2\nf 1 2 3\n")
    with pytest.warns(ReadWarning, match="1 faces have fewer than three corners"):
        assert gt.read(path).n_faces == 1


def test_binary_polygons_of_mixed_sizes_are_read(tmp_path):
    header = ply_header(
        "binary_little_endian", ("vertex 6", XYZ), ("face 3", ["uchar flag", *LISTS])
    )
    faces = [[0, 1, 2], [0, 1, 2, 3], [3, 4, 5]]
    data = b"".join(bytes([7, len(face)]) + np.array(face, dtype="<i4").tobytes() for face in faces)
    with pytest.warns(ReadWarning, match="1 polygon was split into 2"):
        mesh = gt.read(place(tmp_path, "p.ply", header + POINTS.tobytes() + data))
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 1, 2], [0, 2, 3], [3, 4, 5]])


def test_text_polygons_of_mixed_sizes_are_read(tmp_path):
    header = ply_header("ascii", ("vertex 4", XYZ), ("face 2", LISTS))
    text = header.decode() + TRIANGLE + "1 1 0\n4 0 1 3 2\n3 0 1 2\n"
    with pytest.warns(ReadWarning, match="1 polygon was split into 2"):
        mesh = gt.read(place(tmp_path, "p.ply", text))
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 3], [0, 3, 2], [0, 1, 2]])


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian"])
def test_a_ply_that_announces_no_faces_is_a_cloud(form, tmp_path):
    header = ply_header(form, ("vertex 6", XYZ), ("face 0", LISTS), ("camera 1", []))
    body = POINTS.tobytes() if form != "ascii" else b"0 0 1\n" * 6
    assert isinstance(gt.read(place(tmp_path, "p.ply", header + body)), gt.PointCloud)


def test_elements_of_a_ply_that_are_no_surface_are_passed_over(tmp_path):
    header = ply_header(
        "ascii", ("edge 1", ["int vertex1", "list uchar int tags"]), ("vertex 3", XYZ)
    )
    header = header.replace(
        b"end_header", b"element face 1\nproperty list uchar int vertex_index\nend_header"
    )
    path = place(tmp_path, "p.ply", header.decode() + "7 2 5 5\n" + TRIANGLE + "3 0 1 2\n")
    assert gt.read(path).n_faces == 1


def test_triangle_strips_turn_every_second_triangle_and_leave_out_joints(tmp_path):
    header = ply_header("ascii", ("vertex 6", XYZ), ("tristrips 2", LISTS)).decode()
    points = "\n".join("0 0 1" for _ in range(6))
    text = f"{header}{points}\n9 0 1 2 3 -1 2 3 4 5\n5 0 1 1 2 3\n"
    mesh = gt.read(place(tmp_path, "strips.ply", text))
    np.testing.assert_array_equal(
        mesh.faces, [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5], [1, 2, 3]]
    )


# -- nothing merged, nothing dropped --------------------------------------------------------------


def test_texture_seams_of_an_obj_do_not_split_the_surface(tmp_path):
    text = SQUARE + "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/4 3/2 4/1\n"
    mesh = gt.read(place(tmp_path, "seam.obj", text))
    assert mesh.n_vertices == 4
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3]])


def test_negative_indices_of_an_obj_count_back_from_the_face(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 1 1 0\nf -3//-1 \\\n -1//-1 -2//-1\n"
    np.testing.assert_array_equal(
        gt.read(place(tmp_path, "t.obj", text)).faces, [[0, 1, 2], [1, 3, 2]]
    )


def test_unused_and_repeated_vertices_and_flat_faces_stay(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nv 9 9 9\nf 1 2 3\nf 4 4 2\n"
    mesh = gt.read(place(tmp_path, "t.obj", text))
    assert (mesh.n_vertices, mesh.n_faces) == (5, 2)


def test_colours_of_obj_vertices_are_no_coordinates(tmp_path):
    text = "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nf 1 2 3\n"
    np.testing.assert_array_equal(gt.read(place(tmp_path, "t.obj", text)).vertices[1], [1, 0, 0])


def test_an_obj_without_faces_is_a_cloud_with_its_normals(tmp_path):
    cloud = gt.read(place(tmp_path, "t.obj", "v 0 0 0\nvn 0 0 1\nv 1 0 0\nvn 0 1 0\n"))
    np.testing.assert_array_equal(cloud.normals, [[0, 0, 1], [0, 1, 0]])


def test_corners_of_an_stl_are_one_vertex_where_they_agree_in_sign_of_zero_or_not(tmp_path):
    data = bytearray(stl())
    at = 84 + 12 + 4  # y of the first corner: 0.0
    data[at : at + 4] = np.array(-0.0, dtype="<f4").tobytes()
    assert gt.read(place(tmp_path, "o.stl", bytes(data))).n_vertices == 6


def test_repeated_positions_of_a_gltf_are_kept_with_a_warning(tmp_path):
    import trimesh

    soup = trimesh.Trimesh(POINTS[FACES].reshape(-1, 3), np.arange(24).reshape(8, 3), process=False)
    path = place(tmp_path, "soup.glb", soup.export(file_type="glb"))
    with pytest.warns(ReadWarning, match="18 of 24 vertices repeat another's position"):
        assert gt.read(path).n_vertices == 24


def test_the_meshes_of_a_gltf_scene_stand_where_the_scene_puts_them(tmp_path):
    import trimesh

    scene = trimesh.Scene()
    for shift in (0.0, 5.0):
        moved = trimesh.transformations.translation_matrix([shift, 0, 0])
        scene.add_geometry(trimesh.Trimesh(POINTS, FACES, process=False), transform=moved)
    mesh = gt.read(place(tmp_path, "two.glb", scene.export(file_type="glb")))
    assert (mesh.n_vertices, mesh.n_faces) == (12, 16)
    np.testing.assert_allclose(mesh.vertices[6:] - mesh.vertices[:6], [[5, 0, 0]] * 6, atol=1e-6)


def test_a_gltf_of_points_is_a_cloud(tmp_path):
    import trimesh

    scene = trimesh.Scene([trimesh.PointCloud(POINTS)])
    cloud = gt.read(place(tmp_path, "points.glb", scene.export(file_type="glb")))
    assert isinstance(cloud, gt.PointCloud)
    assert cloud.n_vertices == 6


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


def test_cells_that_are_no_surface_and_no_solid_are_named(tmp_path):
    path = write_cells(tmp_path / "lines.vtu", [("line", np.array([[0, 1], [1, 2]]))])
    with pytest.raises(ReadError, match="no surface and no solid: the cells are line"):
        gt.read(path)


VTK = (
    "# vtk DataFile Version 5.1\nt\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n"
    + TRIANGLE
    + "1 1 0\n"
)


def test_a_vtk_surface_may_have_offsets_and_strips(tmp_path):
    text = VTK + (
        "METADATA\nINFORMATION 0\n\nPOLYGONS 2 3\nOFFSETS vtktypeint64\n0 3\n"
        "CONNECTIVITY vtktypeint64\n0 1 2\nTRIANGLE_STRIPS 1 5\n4 0 1 2 3\n"
    )
    mesh = gt.read(place(tmp_path, "t.vtk", text))
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 1, 2], [2, 1, 3]])


def test_a_binary_vtk_surface_is_read(tmp_path):
    faces = np.column_stack([np.full(8, 3), FACES])
    data = (
        b"# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\nPOINTS 6 double\n"
        + POINTS.astype(">f8").tobytes()
        + b"\nPOLYGONS 8 32\n"
        + faces.astype(">i4").tobytes()
        + b"\n"
    )
    check_octahedron(gt.read(place(tmp_path, "o.vtk", data)))


def test_a_vtk_surface_of_points_alone_is_a_cloud(tmp_path):
    assert isinstance(gt.read(place(tmp_path, "p.vtk", VTK)), gt.PointCloud)


@pytest.mark.parametrize(
    ("tail", "says"),
    [
        ("POLYGONS 2 3\nOFFSETS int\n0 4\nCONNECTIVITY int\n0 1 2\n", "do not go together"),
        ("POLYGONS 2 3\nOFFSETS int\n0 3\n", "without their corners"),
        ("POLYGONS 2 4\n3 0 1 2\n", "sizes of cells"),
        ("POLYGONS 1 40\n3 0 1 2\n", "the file ends before"),
        ("POLYGONS -1 4\n3 0 1 2\n", "a number of entries is '-1'"),
        ("POINTS 1 float128\n", "numbers of type 'float128'"),
    ],
)
def test_a_damaged_vtk_surface_is_refused(tail, says, tmp_path):
    with pytest.raises(ReadError, match=says):
        gt.read(place(tmp_path, "t.vtk", VTK + tail))


def test_a_vtk_surface_without_points_is_refused(tmp_path):
    text = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\n"
    with pytest.raises(ReadError, match="has no points"):
        gt.read(place(tmp_path, "t.vtk", text))


# -- clouds ---------------------------------------------------------------------------------------


def test_large_coordinates_keep_their_digits(tmp_path):
    point = [5403849.123456789, 512345.987654321, 301.25]
    text = " ".join(map(repr, point)) + "\n"
    for name in ("utm.xyz", "utm.pts"):
        np.testing.assert_array_equal(gt.read(place(tmp_path, name, text)).points, [point])
    header = pcd_header("binary").replace(b"WIDTH 6", b"WIDTH 1").replace(b"POINTS 6", b"POINTS 1")
    path = place(tmp_path, "utm.pcd", header + np.array(point).tobytes())
    np.testing.assert_array_equal(gt.read(path).points, [point])


@pytest.mark.parametrize("suffix", ["xyz", "pcd", "ply"])
def test_missing_points_stay(suffix, tmp_path):
    body = "0 0 0\nnan nan nan\n1 0 0\n" + "0 1 0\n" * 3
    header = {"xyz": b"", "pcd": pcd_header("ascii"), "ply": ply_header("ascii", ("vertex 6", XYZ))}
    cloud = gt.read(place(tmp_path, f"p.{suffix}", header[suffix].decode() + body))
    np.testing.assert_array_equal(cloud.present, [True, False, True, True, True, True])


@pytest.mark.parametrize(
    "text",
    [
        "0,0,0\n1,2,3\n",
        "x y z\n0 0 0\n1 2 3\n",
        "2\n0 0 0\n1 2 3\n",
        "// a\n0;0;0 # b\n\n1;2;3",
        "0\t0 0\r\n1 2 3",
    ],
)
def test_an_xyz_file_may_be_written_in_many_ways(text, tmp_path):
    np.testing.assert_array_equal(
        gt.read(place(tmp_path, "p.xyz", text)).points, [[0, 0, 0], [1, 2, 3]]
    )


def test_unit_normals_of_an_xyz_file_are_kept(tmp_path):
    cloud = gt.read(place(tmp_path, "p.xyz", "0 0 0 0 0 1\n1 0 0 0 1 0\n"))
    np.testing.assert_array_equal(cloud.normals, [[0, 0, 1], [0, 1, 0]])


def test_colours_of_an_xyz_file_are_not_taken_for_normals(tmp_path):
    path = place(tmp_path, "p.xyz", "0 0 0 255 128 0\n1 0 0 0 1 0\n")
    with pytest.warns(ReadWarning, match="columns 4 to 6 are not unit normals"):
        assert gt.read(path).normals is None


def test_normals_that_are_zero_are_left_out_with_a_warning(tmp_path):
    header = ply_header("ascii", ("vertex 2", [*XYZ, "float nx", "float ny", "float nz"])).decode()
    path = place(tmp_path, "p.ply", header + "0 0 0 0 0 1\n1 0 0 0 0 0\n")
    with pytest.warns(ReadWarning, match="the normals of the file were left out: normal 1 is zero"):
        cloud = gt.read(path)
    assert cloud.normals is None
    assert cloud.n_vertices == 2


def test_a_pcd_may_have_other_fields_and_no_count(tmp_path):
    header = (
        "VERSION .7\nFIELDS label _ x y z\nSIZE 4 1 4 4 4\nTYPE U U F F F\nCOUNT 1 3 1 1 1\n"
        "WIDTH 2\nHEIGHT 1\nDATA binary\n"
    )
    row = np.dtype([("label", "<u4"), ("pad", "u1", 3), ("xyz", "<f4", 3)])
    rows = np.zeros(2, dtype=row)
    rows["xyz"] = [[1, 2, 3], [4, 5, 6]]
    cloud = gt.read(place(tmp_path, "p.pcd", header.encode() + rows.tobytes()))
    np.testing.assert_array_equal(cloud.points, [[1, 2, 3], [4, 5, 6]])
    text = header.replace("DATA binary", "DATA ascii") + "9 0 0 0 1 2 3\n9 0 0 0 4 5 6\n"
    cloud = gt.read(place(tmp_path, "q.pcd", text))
    np.testing.assert_array_equal(cloud.points, [[1, 2, 3], [4, 5, 6]])


# -- graphs ---------------------------------------------------------------------------------------


def test_both_triangles_of_a_matrix_may_be_stored_and_the_shorter_length_counts(tmp_path):
    matrix = sparse.coo_array(([2.0, 3.0, 5.0, 9.0], ([0, 1, 1, 2], [1, 0, 2, 2])), shape=(4, 4))
    sparse.save_npz(tmp_path / "g.npz", matrix)
    graph = gt.read(tmp_path / "g.npz")
    assert graph.n_vertices == 4
    np.testing.assert_array_equal(graph.edges, [[0, 1], [1, 2]])
    np.testing.assert_array_equal(graph.lengths, [2.0, 5.0])


@pytest.mark.parametrize("form", ["csr", "csc", "coo", "bsr", "dia"])
def test_a_sparse_matrix_of_any_format_is_a_graph(form, tmp_path):
    matrix = sparse.coo_array((LENGTHS, tuple(EDGES.T)), shape=(6, 6)).asformat(form)
    if form == "dia":  # which stores the zeros of its diagonals too
        matrix = sparse.dia_array((np.ones((1, 6)), [1]), shape=(6, 6))
        sparse.save_npz(tmp_path / "g.npz", matrix)
        assert gt.read(tmp_path / "g.npz").n_edges == 5
    else:
        sparse.save_npz(tmp_path / "g.npz", matrix)
        check_octahedron(gt.read(tmp_path / "g.npz"))


def banner(kind):
    return f"%%MatrixMarket matrix {kind}\n% a comment\n"


@pytest.mark.parametrize(
    ("kind", "body", "lengths"),
    [
        ("coordinate real symmetric", "3 3 2\n2 1 0.5\n3 2 4\n", [0.5, 4.0]),
        ("coordinate pattern symmetric", "3 3 2\n2 1\n3 2\n", [1.0, 1.0]),
        ("coordinate integer general", "3 3 3\n2 1 7\n1 2 5\n2 3 4\n", [5.0, 4.0]),
        ("array real general", "3 3\n0\n0.5\n0\n0.5\n0\n4\n0\n4\n0\n", [0.5, 4.0]),
        ("array real symmetric", "3 3\n0\n0.5\n0\n0\n4\n0\n", [0.5, 4.0]),
    ],
)
def test_a_matrix_market_file_of_any_kind_is_a_graph(kind, body, lengths, tmp_path):
    graph = gt.read(place(tmp_path, "g.mtx", banner(kind) + body))
    np.testing.assert_array_equal(graph.edges, [[0, 1], [1, 2]])
    np.testing.assert_array_equal(graph.lengths, lengths)


def test_a_matrix_market_file_without_entries_is_a_graph_without_edges(tmp_path):
    graph = gt.read(place(tmp_path, "g.mtx", banner("coordinate real general") + "3 3 0\n"))
    assert (graph.n_vertices, graph.n_edges) == (3, 0)


@pytest.mark.parametrize(
    ("kind", "body", "says"),
    [
        ("coordinate complex general", "2 2 1\n1 2 1 0\n", "complex general matrix cannot hold"),
        ("coordinate real skew-symmetric", "2 2 1\n2 1 1\n", "skew-symmetric matrix cannot hold"),
        ("coordinate real general", "2 3 1\n1 2 1\n", "square, not 2 x 3"),
        ("coordinate real general", "2 2\n1 2 1\n", "the sizes of the matrix are '2 2'"),
        ("coordinate real general", "2 2 2\n1 2 1\n", "2 entries are announced, 1 follow"),
        ("coordinate real general", "2 2 1\n1 2\n", "entries have 2 columns, not 3"),
        ("coordinate real general", "2 2 1\n1 3 1\n", "entry 0 lies outside a matrix of 2 x 2"),
        ("coordinate real general", "2 2 1\n0 1 1\n", "entry 0 lies outside"),
        ("coordinate real general", "2 2 1\n1 2 -4\n", "edge 0 has length -4"),
        ("coordinate real general", "2 2 1\n1.5 2 1\n", "must be whole numbers"),
        ("array real general", "2 2\n1\n1\n1\n", "2 x 2 entries are announced, 3 follow"),
        ("array real general", "1 1\n1 1\n", "entries have 2 columns, not 1"),
        ("array real general", "0 0\n", "0 x 0 entries"),
    ],
)
def test_a_matrix_market_file_that_is_no_graph_is_refused(kind, body, says, tmp_path):
    with pytest.raises(ReadError, match=says):
        gt.read(place(tmp_path, "g.mtx", banner(kind) + body))


def test_an_explicit_zero_of_a_matrix_market_file_is_an_edge_of_length_0(tmp_path):
    body = banner("coordinate real general") + "3 3 2\n1 2 0\n2 3 4\n"
    graph = gt.read(place(tmp_path, "g.mtx", body))
    np.testing.assert_array_equal(gt.geodesic_distance(graph, 0), [0.0, 0.0, 4.0])


@pytest.mark.parametrize(
    ("text", "lengths"),
    [
        ("0 1\n1 2\n", [1, 1]),
        ("0,1,0.5\n1,2,2\n", [0.5, 2]),
        ("# i j\n0 1 3 # x\n% y\n1 2 4\n", [3, 4]),
    ],
)
@pytest.mark.parametrize("suffix", ["edges", "edgelist"])
def test_an_edge_list_is_a_graph(suffix, text, lengths, tmp_path):
    graph = gt.read(place(tmp_path, f"g.{suffix}", text))
    np.testing.assert_array_equal(graph.edges, [[0, 1], [1, 2]])
    np.testing.assert_array_equal(graph.lengths, lengths)


# -- compressed files -----------------------------------------------------------------------------


@pytest.mark.parametrize(("suffix", "make"), OWN, ids=[make.__name__ for _, make in OWN])
def test_every_format_may_be_compressed(suffix, make, tmp_path):
    path = place(tmp_path, f"octahedron.{suffix}.gz", gzip.compress(make()))
    plain = gt.read(place(tmp_path, f"octahedron.{suffix}", make()))
    assert repr(gt.read(path)) == repr(plain)


@pytest.mark.parametrize("name", WRITTEN)
def test_every_format_of_another_package_may_be_compressed(name, tmp_path):
    package, make = WRITTEN[name]
    pytest.importorskip(package)
    path = place(tmp_path, f"octahedron.{name.split()[0]}.GZ", gzip.compress(make(tmp_path)))
    check_octahedron(gt.read(path), exact=False)


@pytest.mark.parametrize(
    ("name", "contents", "says"),
    [
        ("t.off.gz", b"no archive", "t.off.gz: damaged, or not a .gz file"),
        ("t.off.gz", gzip.compress(off(), mtime=0)[:-9], "t.off.gz: damaged"),
        ("t.off.gz", gzip.compress(b"x", mtime=0), "t.off.gz: not an OFF file"),
        ("t.off.gz", b"", "t.off.gz is empty"),
        ("t.fbx.gz", gzip.compress(b"x", mtime=0), r"t.fbx.gz: there is no reader for \.fbx; can"),
        ("t.gz", gzip.compress(b"x", mtime=0), "t.gz: it has no suffix"),
    ],
    ids=["text", "cut", "of another format", "empty", "of an unknown suffix", "without a suffix"],
)
def test_a_compressed_file_that_cannot_be_read_is_named(name, contents, says, tmp_path):
    with pytest.raises(ReadError, match=says):
        gt.read(place(tmp_path, name, contents))


def test_tables_may_be_compressed(tmp_path):
    for name, text in (("v.txt.gz", b"3 5"), ("v.csv.gz", b"vertex\n3\n5\n")):
        path = place(tmp_path, name, gzip.compress(text))
        assert read_vertices(path).tolist() == [3, 5]
        assert np.flatnonzero(read_mask(path, 6)).tolist() == [3, 5]
    np.save(tmp_path / "v.npy", [[1.0, 2.0, 3.0]])
    path = place(tmp_path, "p.npy.gz", gzip.compress((tmp_path / "v.npy").read_bytes()))
    assert read_points(path).points.tolist() == [[1.0, 2.0, 3.0]]
    path = place(tmp_path, "p.csv.gz", gzip.compress(b"x,y,z\n1,2,3\n"))
    assert read_points(path).points.tolist() == [[1.0, 2.0, 3.0]]


# -- VTK's XML ------------------------------------------------------------------------------------


def test_a_vtp_may_have_polygons_strips_points_and_normals(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    path = tmp_path / "s.vtp"
    pyvista.PolyData(POINTS[:4], strips=[4, 0, 1, 2, 3]).save(path)
    np.testing.assert_array_equal(gt.read(path).faces, [[0, 1, 2], [2, 1, 3]])
    pyvista.PolyData([[0, 0, 0], [1.0, 0, 0], [1, 1, 0], [0, 1, 0]], [4, 0, 1, 2, 3]).save(path)
    with pytest.warns(ReadWarning, match=r"s\.vtp: 1 polygon was split into 2 triangles"):
        assert gt.read(path).n_faces == 2
    cloud = pyvista.PolyData(POINTS)
    cloud.point_data["Normals"] = np.sign(POINTS)
    cloud.point_data.active_normals_name = "Normals"
    cloud.save(path)
    np.testing.assert_array_equal(gt.read(path).normals, np.sign(POINTS))
    pyvista.Line().save(path)
    with pytest.raises(ReadError, match=r"s\.vtp: no faces, only lines"):
        gt.read(path)
    pyvista.PolyData().save(path)
    with pytest.raises(ReadError, match=r"s\.vtp: there are no points"):
        gt.read(path)


def test_the_pieces_of_a_vtp_are_one_surface(tmp_path):
    piece = (
        "<Piece NumberOfPoints='3' NumberOfPolys='1'><Points><DataArray type='Float32'>"
        "0 0 0 1 0 0 0 1 0</DataArray></Points><Polys>"
        "<DataArray type='Int32' Name='connectivity' format='ascii'>0 1 2</DataArray>"
        "<DataArray type='Int32' Name='offsets' format='ascii'>3</DataArray></Polys></Piece>"
    )
    text = f"<VTKFile type='PolyData'><PolyData>{piece * 2}</PolyData></VTKFile>"
    assert gt.read(place(tmp_path, "p.vtp", text)).faces.tolist() == [[0, 1, 2], [3, 4, 5]]
    for old, new, says in [
        ("0 1 2<", "0 1 3<", "a cell refers to vertex 3; there are 3"),
        (">3<", ">4<", "offsets of cells do not go together"),
        ("'Int32'", "'Bit'", "no connectivity, or of a type that is not known"),
        ("'ascii'", "'morse'", "connectivity of the format 'morse' are not known"),
        ("format='ascii'", "format='appended'", "the connectivity lie outside the file"),
        ("<VTKFile", "<!DOCTYPE a [<!ENTITY b 'c'>]><VTKFile", "it declares entities"),
        ("'PolyData'", "'ImageData'", "its root is VTKFile of ImageData"),
        ("'PolyData'", "'PolyData' header_type='Int8'", "the type of headers is not known"),
        ("'PolyData'", "'PolyData' compressor='vtkLZ4DataCompressor'", "save it with zlib"),
    ]:
        with pytest.raises(ReadError, match=says):
            gt.read(place(tmp_path, "p.vtp", text.replace(old, new)))


# -- FreeSurfer -----------------------------------------------------------------------------------

SURFACES = ["lh.pial", "rh.white", "lh.inflated", "lh.pial.T1", "lh.sphere.reg", "lh.orig", "rh"]


@pytest.mark.parametrize("name", [*SURFACES, "lh.white.preaparc", "lh.orig.nofix", "x.unheard"])
def test_a_surface_of_freesurfer_is_known_by_its_first_bytes(name, tmp_path):
    freesurfer = pytest.importorskip("nibabel.freesurfer")
    freesurfer.write_geometry(str(tmp_path / name), POINTS, FACES)
    check_octahedron(gt.read(tmp_path / name), exact=False)


@pytest.mark.parametrize("magic", [b"\xff\xff\xff", b"\xff\xff\xfd"])
def test_an_old_surface_of_quadrangles_is_read(magic, tmp_path):
    pytest.importorskip("nibabel")
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    places = (100 * corners).astype(">i2") if magic[2] == 0xFF else corners.astype(">f4")
    indices = b"".join(number.to_bytes(3, "big") for number in (0, 1, 2, 3))
    data = magic + (4).to_bytes(3, "big") + (1).to_bytes(3, "big") + places.tobytes() + indices
    mesh = gt.read(place(tmp_path, "lh.old", data))
    np.testing.assert_array_equal(mesh.vertices, corners)
    assert mesh.n_faces == 2
    with pytest.raises(ReadError, match="4 vertices and 1 faces are announced, more than"):
        gt.read(place(tmp_path, "lh.old", data[:-1]))


def test_what_is_no_surface_of_freesurfer_is_refused_by_name(tmp_path):
    freesurfer = pytest.importorskip("nibabel.freesurfer")
    freesurfer.write_morph_data(str(tmp_path / "lh.thickness"), np.ones(6))
    with pytest.raises(ReadError, match=r"lh\.thickness: it holds a number for each vertex"):
        gt.read(tmp_path / "lh.thickness")
    with pytest.raises(ReadError, match=r"lh\.pial: not a FreeSurfer surface: it begins with"):
        gt.read(place(tmp_path, "lh.pial", off()))
    with pytest.raises(ReadError, match=r"lh\.white: not a FreeSurfer surface: its header has no"):
        gt.read(place(tmp_path, "lh.white", b"\xff\xff\xfe and so on"))
    header = b"\xff\xff\xfecreated\n\n" + struct.pack(">ii", 2**30, 2**30)
    with pytest.raises(ReadError, match="are announced, more than the file holds"):
        gt.read(place(tmp_path, "lh.white", header + bytes(100)))


# -- what cannot be read --------------------------------------------------------------------------


def test_a_missing_file_does_not_exist(tmp_path):
    with pytest.raises(ReadError, match=r"none\.off does not exist"):
        gt.read(tmp_path / "none.off")


def test_a_directory_is_no_file(tmp_path):
    (tmp_path / "folder.off").mkdir()
    with pytest.raises(ReadError, match="is a directory"):
        gt.read(tmp_path / "folder.off")


@pytest.mark.skipif(sys.platform == "win32", reason="there are no device files")
def test_a_device_is_no_file():
    with pytest.raises(ReadError, match="not a regular file"):
        gt.read("/dev/zero")


def test_a_path_that_no_system_has_is_an_error_of_ours():
    with pytest.raises(ReadError, match=r"cannot be opened|does not exist"):
        gt.read("nul\0.off")


def test_a_file_that_may_not_be_opened_is_an_error_of_ours(tmp_path, monkeypatch):
    path = place(tmp_path, "t.off", off())

    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(type(path), "read_bytes", refuse)
    with pytest.raises(ReadError, match="Permission denied"):
        gt.read(path)


def test_an_unknown_suffix_is_named_with_those_that_can_be_read(tmp_path):
    with pytest.raises(ReadError, match=r"no reader for \.fbx; can be read: .*obj, off"):
        gt.read(place(tmp_path, "model.fbx", b"x"))
    with pytest.raises(ReadError, match="it has no suffix"):
        gt.read(place(tmp_path, "model", b"x"))


ALL_SUFFIXES = sorted({*SAMPLES, *(name.split()[0] for name in WRITTEN), "edgelist"})
PACKAGE_OF = {name.split()[0]: package for name, (package, _) in WRITTEN.items() if " " not in name}
GARBAGE = {
    "empty": b"",
    "blank": b"\n \n",
    "words": b"this is not a shape, it is a sentence\n",
    "zeros": b"\0" * 400,
    "noise": random.Random(1).randbytes(3000),
    "picture": b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + b"\7" * 100,
}


@pytest.mark.parametrize("suffix", ALL_SUFFIXES)
@pytest.mark.parametrize("contents", GARBAGE)
def test_garbage_is_refused_in_one_line_that_names_the_file(suffix, contents, tmp_path):
    if suffix in PACKAGE_OF:
        pytest.importorskip(PACKAGE_OF[suffix])
    path = place(tmp_path, f"garbage.{suffix}", GARBAGE[contents])
    with pytest.raises(ReadError) as caught:
        gt.read(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    assert len(message) < len(str(path)) + 400


@pytest.mark.parametrize(
    "suffix", sorted(set(SAMPLES) - {"obj", "xyz", "txt", "asc", "edges", "pts"})
)
@pytest.mark.parametrize("other", ["off", "obj", "ply", "stl"])
def test_a_file_of_another_format_is_refused(suffix, other, tmp_path):
    if suffix == other:
        pytest.skip("this is the right one")
    with pytest.raises(ReadError):
        gt.read(place(tmp_path, f"wrong.{suffix}", SAMPLES[other][0]()))


BAD = {
    "face-index.off": (
        "OFF\n3 1 0\n" + TRIANGLE + "3 0 1 3\n",
        "face 0 refers to vertex 3; there are 3",
    ),
    "nan.off": ("OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n", "vertex 1 is not finite"),
    "word.off": ("OFF\n3 1 0\n0 0 0\n1 x 0\n0 1 0\n3 0 1 2\n", "must be numbers .found 'x'"),
    "huge.off": ("OFF\n3 1 0\n" + TRIANGLE + f"3 0 1 {'9' * 30}\n", "must be integers .found '999"),
    "announced.off": ("OFF\n-3 1 0\n" + TRIANGLE, "-3 vertices and 1 faces are announced"),
    "four.off": ("4OFF\n3 1 0\n" + TRIANGLE, "four or more dimensions or in binary"),
    "short.off": (
        "OFF\n3 9 0\n" + TRIANGLE + "3 0 1 2\n",
        "the file ends before its 3 vertices and 9",
    ),
    "faces.off": ("OFF\n3 1 0\n" + TRIANGLE + "4 0 1 2\n", "face 0 is not a number of corners"),
    "scraps.off": ("OFF\n3 5 0\n" + TRIANGLE + "3 0 1 2 9\n", "ends before its 5 faces do"),
    "zero.obj": (SQUARE + "f 0 1 2\n", "face 0 refers to vertex 0; there are 4, numbered from 1"),
    "past.obj": (SQUARE + "f 1 2 5\n", "face 0 refers to vertex 5"),
    "before.obj": (SQUARE + "f 1 2 3\nf -5 1 2\n", "face 1 refers to vertex -5"),
    "flat.obj": ("v 0 0\n", "vertex 0 has 2 coordinates"),
    "corner.obj": (SQUARE + "f 1 a 3\n", "corners of faces must be integers .found 'a'"),
    "columns.xyz": ("0 0 0\n1 1\n", "not a table of numbers"),
    "flat.xyz": ("0 0\n1 1\n", "at least three columns, not 2"),
    "first.pts": ("many\n0 0 0\n", "first line, 'many', names 1 columns, and there are 3"),
    "short.pts": ("3\n0 0 0\n1 1 1\n", "announces 3 points, 2 follow"),
    "columns.edges": ("0 1 2 3\n", "columns i j .length., not 4"),
    "half.edges": ("0 1.5\n", "vertex numbers must be whole numbers .found 1.5"),
    "negative.edges": ("0 -1\n", "edge 0 refers to vertex -1"),
    "identifiers.edges": ("0 123456789012\n", "numbered from 0 without large gaps"),
    "length.edges": ("0 1 -2\n", "edge 0 has length -2.0"),
    "cut.stl": (stl()[:-1], "cut off: 8 faces take 484 bytes, there are 483"),
    "text.stl": (
        "solid x\nfacet normal 0 0 0\nvertex 0 0 0\n",
        "cut off or damaged: 0 facets with 1",
    ),
    "none.stl": (bytes(84), "the mesh has no vertices"),
    "header.ply": (
        "ply\nformat ascii 1.0\nelement vertex 3\n",
        "the header of the PLY file has no end",
    ),
    "format.ply": ("ply\nformat morse 1.0\nend_header\n", "format 'morse' are not known"),
    "type.ply": (ply_header("ascii", ("vertex 1", ["quad x"])), "a type that PLY has not: 'quad'"),
    "count.ply": (ply_header("ascii", ("vertex -1", XYZ)), "the number of elements vertex is '-1'"),
    "line.ply": (
        b"ply\nformat ascii 1.0\nwho knows\nend_header\n",
        "unrecognised line in the header",
    ),
    "list.ply": (
        ply_header("ascii", ("vertex 1", XYZ), ("face 1", ["list float int vertex_indices"])),
        "lists cannot count their entries in float",
    ),
    "flat.ply": (
        ply_header("ascii", ("vertex 1", XYZ[:2])) + b"0 0\n",
        "no element vertex with prop",
    ),
    "few.ply": (
        ply_header("ascii", ("vertex 2", XYZ)) + b"0 0 0\n",
        "ends before its 2 elements vertex",
    ),
    "few-binary.ply": (
        ply_header("binary_big_endian", ("vertex 2", XYZ)) + bytes(24),
        "ends before its 2 elements vertex",
    ),
    "no-list.ply": (
        ply_header("ascii", ("vertex 1", XYZ), ("face 1", ["int colour"])) + b"0 0 0\n1\n",
        "element face has no list vertex_indices",
    ),
    "half.ply": (
        ply_header("ascii", ("vertex 1", XYZ), ("face 1", ["list uchar float vertex_indices"]))
        + b"0 0 0\n3 0 0.5 0\n",
        "vertex indices of face must be whole numbers .found 0.5",
    ),
    "negative.ply": (
        ply_header("ascii", ("vertex 1", XYZ), ("face 1", LISTS)) + b"0 0 0\n-3 0 0 0\n",
        "a list vertex_indices of face has b'-3' entries",
    ),
    "negative-binary.ply": (
        ply_header(
            "binary_little_endian", ("vertex 1", XYZ), ("face 1", ["list char int vertex_indices"])
        )
        + bytes(24)
        + b"\xff" * 9,
        "a list vertex_indices of face has -1 entries",
    ),
    "long-list.ply": (
        ply_header("ascii", ("vertex 1", XYZ), ("face 1", LISTS)) + b"0 0 0\n3 0 0\n",
        "ends before its 1 elements face",
    ),
    "long-list-binary.ply": (
        ply_header("binary_little_endian", ("vertex 1", XYZ), ("face 1", LISTS))
        + bytes(24)
        + b"\x03" * 8,
        "ends before its 1 elements face",
    ),
    "few-lists.ply": (
        ply_header("ascii", ("vertex 1", XYZ), ("face 2", LISTS)) + b"0 0 0\n3 0 0 0\n",
        "ends before its 2 elements face",
    ),
    "header.pcd": ("FIELDS x y z\n", "its header has no DATA line"),
    "form.pcd": (pcd_header("morse"), "of the form 'morse' are not known"),
    "points.pcd": (pcd_header("ascii").replace(b"POINTS 6", b"POINTS six"), "how many points"),
    "none.pcd": (pcd_header("ascii").replace(b"POINTS 6", b"POINTS 0"), "announces 0 points"),
    "fields.pcd": (
        pcd_header("ascii").replace(b"FIELDS x y z", b"FIELDS x y"),
        "do not go together",
    ),
    "names.pcd": (
        pcd_header("ascii").replace(b"FIELDS x y z", b"FIELDS a b c") + b"0 0 0\n" * 6,
        "the fields are a b c: no x, y and z",
    ),
    "type.pcd": (pcd_header("ascii", sizes="8 8 3"), "field 'z' has type 'F' of size '3'"),
    "counts.pcd": (pcd_header("ascii").replace(b"COUNT 1 1 1", b"COUNT 1 1 x"), "count 'x'"),
    "few.pcd": (pcd_header("ascii") + b"0 0 0\n", "ends before its 6 points do"),
    "few-binary.pcd": (pcd_header("binary") + bytes(100), "ends before its 6 points do"),
    "few-packed.pcd": (
        pcd_header("binary_compressed") + b"\xff\0\0\0\x90\0\0\0",
        "compressed points do",
    ),
    "size.pcd": (pcd_header("binary_compressed") + bytes(8), "announce 0 bytes"),
    "back.pcd": (
        pcd_header("binary_compressed") + b"\2\0\0\0\x90\0\0\0\x20\0",
        "before their start",
    ),
    "within.pcd": (
        pcd_header("binary_compressed") + b"\1\0\0\0\x90\0\0\0\x20",
        "within a repetition",
    ),
    "less.pcd": (pcd_header("binary_compressed") + b"\2\0\0\0\x90\0\0\0\0\0", "1 bytes, not 144"),
    "other.npz": (npz_of(a=POINTS, b=FACES), "the archive holds a, b: no sparse matrix"),
    "pickle.npz": (npz_of(vertices=np.array([None]), faces=FACES), "ValueError"),
    "complex.npz": (npz_of(points=POINTS * 1j), "must hold real numbers"),
    "index.npz": (
        npz_of(
            format=np.array(b"csr"),
            shape=np.array([2, 2]),
            data=np.ones(1),
            indices=np.array([7], dtype=np.int32),
            indptr=np.array([0, 1, 1], dtype=np.int32),
        ),
        "ValueError",
    ),
    "strange.npz": (
        npz_of(format=np.array(b"coo"), shape=[2, 2], data=[1j], row=[0], col=[1]),
        "edge lengths are real numbers, not complex128",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_wrong_in_a_file_is_said(name, tmp_path):
    contents, says = BAD[name]
    with pytest.raises(ReadError, match=says) as caught:
        gt.read(place(tmp_path, name, contents))
    assert str(caught.value).startswith(str(tmp_path / name))


@pytest.mark.parametrize("text", ['{"asset": ', "[1]", "[" * 100_000])
def test_a_damaged_gltf_is_not_replaced_by_a_model_beside_it(text, tmp_path):
    place(tmp_path, "model.gltf", WRITTEN["gltf"][1](tmp_path))
    with pytest.raises(ReadError, match="not a glTF file"):
        gt.read(place(tmp_path, "other.gltf", text))


def test_a_gltf_without_shapes_is_refused(tmp_path):
    text = '{"asset": {"version": "2.0"}, "scenes": [{"nodes": []}], "scene": 0}'
    with pytest.raises(ReadError):
        gt.read(place(tmp_path, "empty.gltf", text))


def test_an_array_alone_is_no_archive(tmp_path):
    np.save(tmp_path / "a.npy", POINTS)
    with pytest.raises(ReadError):
        gt.read((tmp_path / "a.npy").rename(tmp_path / "a.npz"))


def test_a_gifti_without_a_surface_is_refused(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    data = nibabel.gifti.GiftiDataArray(np.zeros(3, dtype="f4"), intent="NIFTI_INTENT_SHAPE")
    nibabel.save(nibabel.gifti.GiftiImage(darrays=[data]), tmp_path / "thickness.gii")
    with pytest.raises(ReadError, match="holds no surface"):
        gt.read(tmp_path / "thickness.gii")


@pytest.mark.parametrize(
    ("at", "value", "says"),
    [
        (100, b"\xff\xff\xff\xff", "announces 4294967295 records"),
        (107, b"\xff\xff\xff\x0f", "ends before its 268435455 points do"),
    ],
)
def test_a_las_header_that_announces_too_much_is_refused(at, value, says, tmp_path):
    pytest.importorskip("laspy")
    data = bytearray(WRITTEN["las"][1](tmp_path))
    data[at : at + 4] = value
    with pytest.raises(ReadError, match=says):
        gt.read(place(tmp_path, "scan.las", bytes(data)))


@pytest.mark.parametrize(
    ("value", "says"), [(b"\xff\xff\xff\xff", "chunks is broken"), (None, "chunks has no place")]
)
def test_a_laz_table_that_would_end_the_process_is_refused(value, says, tmp_path):
    pytest.importorskip("lazrs")
    data = bytearray(WRITTEN["laz"][1](tmp_path))
    start = int.from_bytes(data[96:100], "little")
    place_of_table = int.from_bytes(data[start : start + 8], "little")
    if value is None:
        data[start : start + 8] = b"\xfe" + b"\xff" * 7
    else:
        data[place_of_table + 4 : place_of_table + 8] = value
    with pytest.raises(ReadError, match=says):
        gt.read(place(tmp_path, "scan.laz", bytes(data)))


def test_a_panic_of_the_laz_decompressor_is_an_error_of_ours(tmp_path, monkeypatch):
    laspy = pytest.importorskip("laspy")
    data = WRITTEN["las"][1](tmp_path)

    class PanicException(BaseException):
        """What lazrs raises."""

    def panic(*_, **__):
        raise PanicException("mid > len")

    monkeypatch.setattr(laspy, "open", panic)
    with pytest.raises(ReadError, match=r"compressed points are damaged \(mid > len"):
        gt.read(place(tmp_path, "scan.las", data))


def test_a_missing_laz_decompressor_is_named(tmp_path, monkeypatch):
    laspy = pytest.importorskip("laspy")
    pytest.importorskip("lazrs")
    data = WRITTEN["laz"][1](tmp_path)
    monkeypatch.setattr(laspy.LazBackend, "is_available", lambda _: False)
    with pytest.raises(MissingDependencyError, match="needs lazrs"):
        gt.read(place(tmp_path, "scan.laz", data))


@pytest.mark.parametrize(
    ("suffix", "module"),
    [
        ("msh", "meshio"),
        ("vtu", "meshio"),
        ("mesh", "meshio"),
        ("gii", "nibabel"),
        ("las", "laspy"),
    ],
)
def test_a_missing_package_is_named_with_its_extra(suffix, module, tmp_path, monkeypatch):
    for name in [name for name in sys.modules if name.partition(".")[0] == module]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, module, None)
    says = rf'\.{suffix} files needs {module}: pip install "geodesic-toolkit\[io\]"'
    with pytest.raises(MissingDependencyError, match=says):
        gt.read(place(tmp_path, f"x.{suffix}", b"x"))


# -- plugins --------------------------------------------------------------------------------------


@pytest.fixture
def reader(register):
    """Registers a reader of .shape files, which the test gives."""
    return partial(register, gt.readers, "shape")


def test_a_reader_may_be_registered(reader, tmp_path):
    reader(lambda path: gt.Graph(int(path.read_text()), [[0, 1]]))
    assert gt.read(place(tmp_path, "x.shape", b"4")).n_vertices == 4


@pytest.mark.parametrize(
    ("failure", "error"),
    [
        (RuntimeError("two\nlines"), ReadError),
        (RuntimeError("long " * 1000), ReadError),
        (MemoryError(), NotEnoughMemoryError),
        (PluginLoadError("as it is"), PluginLoadError),
    ],
)
def test_what_a_reader_raises_becomes_an_error_of_ours(failure, error, reader, tmp_path):
    def fail(path):
        raise failure

    reader(fail)
    with pytest.raises(error) as caught:
        gt.read(place(tmp_path, "x.shape", b"4"))
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 1000


def test_a_reader_that_returns_no_domain_is_at_fault(reader, tmp_path):
    reader(lambda path: 3)
    with pytest.raises(ReadError, match="returned int, no domain"):
        gt.read(place(tmp_path, "x.shape", b"4"))


# -- damage ---------------------------------------------------------------------------------------


def damaged(data, rng):
    """Cut the file, flip bits, overwrite or insert: what broken copies and broken writers do."""
    if rng.random() < 0.2:
        return data[: rng.randrange(len(data))]
    mutated = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 8])):
        at = rng.randrange(len(mutated))
        match rng.randrange(3):
            case 0:
                mutated[at] ^= 1 << rng.randrange(8)
            case 1:
                mutated[at : at + rng.randrange(5)] = rng.choice(
                    [b"-1", b"9" * 20, b"nan", b"\xff" * 4, b"\n"]
                )
            case _:
                mutated[at] = rng.randrange(256)
    return bytes(mutated)


def check_damaged(path, data, times):
    rng = random.Random(path.name)
    for _ in range(times):
        path.write_bytes(damaged(data, rng))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ReadWarning)
            try:
                outcome = gt.read(path)
            except GeodesicError as error:
                outcome = error
        assert isinstance(outcome, gt.Domain | GeodesicError)
        assert "\n" not in str(outcome)


@pytest.mark.parametrize(("suffix", "make"), OWN, ids=[make.__name__ for _, make in OWN])
def test_a_damaged_file_is_read_or_refused(suffix, make, tmp_path):
    check_damaged(tmp_path / f"damaged.{suffix}", make(), 60)


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
    with pytest.raises(ReadError, match="9 nodes are announced, and 6 follow"):
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


@pytest.mark.parametrize(
    ("name", "values", "read"),
    [
        ("points.npy", POINTS, read_points),
        ("mask.npy", np.arange(6) > 2, lambda path: read_mask(path, 6)),
        ("masked.npy", np.array([5, 1]), lambda path: read_mask(path, 6)),
        ("vertices.npy", np.array([5, 1]), read_vertices),
    ],
)
def test_a_damaged_array_is_read_or_refused(name, values, read, tmp_path):
    np.save(tmp_path / name, values)
    data, rng = (tmp_path / name).read_bytes(), random.Random(name)
    for _ in range(150):
        (tmp_path / name).write_bytes(damaged(data, rng))
        try:
            outcome = read(tmp_path / name)
        except GeodesicError as error:
            outcome = error
        assert isinstance(outcome, gt.PointCloud | np.ndarray | GeodesicError)
        assert "\n" not in str(outcome) or isinstance(outcome, np.ndarray)


def test_a_signalling_nan_of_a_damaged_scan_is_a_missing_point(tmp_path):
    signalling = struct.pack("<I", 0x7FA00000)
    header = ply_header("binary_little_endian", ("vertex 6", ["float x", "float y", "float z"]))
    data = POINTS.astype("<f4").tobytes()
    cloud = gt.read(place(tmp_path, "c.ply", header + data[:24] + signalling + data[28:]))
    assert cloud.present.tolist() == [True, True, False, True, True, True]
    points = np.frombuffer(data[:24] + signalling + data[28:], "<f4").reshape(-1, 3)
    assert gt.PointCloud(points).present.sum() == 5


@pytest.mark.parametrize("name", WRITTEN)
def test_a_damaged_file_of_another_package_is_read_or_refused(name, tmp_path):
    package, make = WRITTEN[name]
    pytest.importorskip(package)
    check_damaged(tmp_path / f"damaged.{name.split()[0]}", make(tmp_path), 40)


def test_grids_are_read_whatever_data_they_carry(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    grid = pyvista.PolyData.from_regular_faces(POINTS, FACES).cast_to_unstructured_grid()
    grid.point_data.active_normals = POINTS
    for binary in (True, False):
        grid.save(tmp_path / "n.vtk", binary=binary)
        check_octahedron(gt.read(tmp_path / "n.vtk"), exact=False)


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_a_comment_that_holds_the_last_word_of_a_ply_header_does_not_end_it(newline, tmp_path):
    head = ["ply", "format ascii 1.0", "comment end_header", "element vertex 3"]
    head += [f"property float {axis}" for axis in "xyz"]
    head += ["element face 1", "property list uchar int vertex_indices", "end_header"]
    rows = ["0 0 0", "1 0 0", "0 1 0", "3 0 1 2", ""]
    path = tmp_path / "t.ply"
    path.write_bytes(newline.join(head + rows).encode())
    assert gt.read(path).faces.tolist() == [[0, 1, 2]]
