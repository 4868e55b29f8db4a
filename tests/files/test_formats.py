"""Every format gives back what was written, compressed or not, and real files what they hold."""

import gzip

import numpy as np
import pytest
from sample_files import FACES, OWN, POINTS, SAMPLES, WRITTEN, check_octahedron, off, place
from shared_data import shared_file

import geodesic_toolkit as gt
from geodesic_toolkit.errors import ReadError, ReadWarning
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


@pytest.mark.slow
def test_the_triangle_strips_of_igea_close_the_surface():
    faces = gt.read(shared_file("jacobson__igea.ply")).faces
    half_edges = set(
        zip(faces.ravel().tolist(), np.roll(faces, -1, axis=1).ravel().tolist(), strict=True)
    )
    assert len(half_edges) == faces.size
    assert half_edges == {(head, tail) for tail, head in half_edges}


@pytest.mark.parametrize(("suffix", "make"), OWN, ids=[make.__name__ for _, make in OWN])
def test_every_format_gives_back_the_octahedron(suffix, make, tmp_path):
    domain = gt.read(place(tmp_path, f"octahedron.{suffix}", make()))
    if suffix == "stl":  # vertices are numbered by their first use in a face
        np.testing.assert_array_equal(domain.vertices[domain.faces], POINTS[FACES])
        assert domain.n_vertices == 6
    else:
        check_octahedron(domain)


@pytest.mark.slow
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
