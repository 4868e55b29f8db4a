"""Files of meshes in the ways in which they may be written: nothing merged, nothing dropped."""

import struct

import numpy as np
import pytest
from sample_files import (
    FACES,
    LISTS,
    POINTS,
    SQUARE,
    TRIANGLE,
    XYZ,
    check_octahedron,
    off,
    place,
    ply_header,
    stl,
)

import geodesic_toolkit as gt
from geodesic_toolkit.errors import ReadError, ReadWarning


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


def test_elements_of_a_ply_other_than_the_surface_are_skipped(tmp_path):
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


def test_colours_of_obj_vertices_are_not_coordinates(tmp_path):
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
        ("POLYGONS 2 3\nOFFSETS int\n0 4\nCONNECTIVITY int\n0 1 2\n", "do not match"),
        ("POLYGONS 2 3\nOFFSETS int\n0 3\n", "corners of cells are missing"),
        ("POLYGONS 2 4\n3 0 1 2\n", "sizes of cells"),
        ("POLYGONS 1 40\n3 0 1 2\n", "the file ends before"),
        ("POLYGONS -1 4\n3 0 1 2\n", "'-1' is not a number of entries"),
        ("POINTS 1 float128\n", "unknown type of numbers: 'float128'"),
    ],
)
def test_a_damaged_vtk_surface_is_refused(tail, says, tmp_path):
    with pytest.raises(ReadError, match=says):
        gt.read(place(tmp_path, "t.vtk", VTK + tail))


def test_a_vtk_surface_without_points_is_refused(tmp_path):
    text = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\n"
    with pytest.raises(ReadError, match="has no points"):
        gt.read(place(tmp_path, "t.vtk", text))


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
    with pytest.raises(ReadError, match=r"s\.vtp: the points are missing"):
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
        (">3<", ">4<", "offsets of cells do not match"),
        ("'Int32'", "'Bit'", "connectivity are missing, or of an unknown type"),
        ("'ascii'", "'morse'", "unknown format of the connectivity: 'morse'"),
        ("format='ascii'", "format='appended'", "the connectivity are outside the file"),
        ("<VTKFile", "<!DOCTYPE a [<!ENTITY b 'c'>]><VTKFile", "it declares entities"),
        ("'PolyData'", "'ImageData'", "its root is VTKFile of type ImageData"),
        ("'PolyData'", "'PolyData' header_type='Int8'", "unknown byte order or type of headers"),
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


def test_a_file_that_is_not_a_surface_of_freesurfer_is_refused_by_name(tmp_path):
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


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_a_comment_that_holds_the_last_word_of_a_ply_header_does_not_end_it(newline, tmp_path):
    head = ["ply", "format ascii 1.0", "comment end_header", "element vertex 3"]
    head += [f"property float {axis}" for axis in "xyz"]
    head += ["element face 1", "property list uchar int vertex_indices", "end_header"]
    rows = ["0 0 0", "1 0 0", "0 1 0", "3 0 1 2", ""]
    path = tmp_path / "t.ply"
    path.write_bytes(newline.join(head + rows).encode())
    assert gt.read(path).faces.tolist() == [[0, 1, 2]]
