"""Distances added to a file: all else that it says of its points is kept."""

import sys

import numpy as np
import pytest
from sample_files import pcd, pcd_compressed

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, MissingDependencyError, ReadError
from geodesic_toolkit.io import write
from geodesic_toolkit.testing import shapes

FIELD = np.array([0.0, 0.1, np.inf, 1 / 3, 2.5, 1e-9])
N = 6
PLACES = np.random.default_rng(0).uniform(0, 1, (N, 3)).round(3)

PLY = """ply
format ascii 1.0
comment by hand
obj_info scanner 7
element vertex 6
property float x
property float y
property double z
property uchar red
property uchar green
property uchar blue
property int quality
element face 2
property list uchar int vertex_indices
property uchar flag
element camera 1
property list int float view
end_header
0 0 0 1 2 3 -7
1 0 0 4 5 6 8
1 1 0 7 8 9 9
0 1 0 1 1 1 10
2 0 0 2 2 2 11
2 1 0.5 3 3 3 12
4 0 1 2 3 5
3 1 4 2 6
2 0.25 0.5
"""


def lasfile(path, version="1.2", point_format=3, dimension=None):
    laspy = pytest.importorskip("laspy")
    header = laspy.LasHeader(point_format=point_format, version=version)
    header.scales, header.offsets = [0.001] * 3, [5e5, 5.4e6, 0]
    if dimension is not None:
        header.add_extra_dim(laspy.ExtraBytesParams(dimension, np.float32))
    points = laspy.LasData(header)
    points.x, points.y, points.z = np.add(PLACES, [5e5, 5.4e6, 0]).T
    points.classification, points.red = np.arange(N), np.arange(N) * 1000
    points.gps_time = np.linspace(0, 1, N)
    if dimension is not None:
        points[dimension] = np.arange(N)
    points.write(str(path))
    return path


# -- LAS -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["in.las", "in.laz"])
@pytest.mark.parametrize("out", ["out.las", "out.laz"])
@pytest.mark.parametrize(("version", "kind"), [("1.2", 3), ("1.4", 7)])
def test_a_las_file_gains_a_dimension_and_keeps_the_others(tmp_path, name, out, version, kind):
    laspy = pytest.importorskip("laspy")
    given = lasfile(tmp_path / name, version, kind, "reflectance")
    write(tmp_path / out, gt.read(given), FIELD, like=given)
    before, after = laspy.read(tmp_path / name), laspy.read(tmp_path / out)
    np.testing.assert_array_equal(after["distance"], FIELD)
    for each in before.point_format.dimension_names:
        np.testing.assert_array_equal(after[each], before[each], err_msg=each)
    np.testing.assert_array_equal(after.header.scales, before.header.scales)
    assert after.header.version == before.header.version
    np.testing.assert_array_equal(gt.read(tmp_path / out).points, gt.read(given).points)


def test_chunks_of_points_follow_each_other(tmp_path, monkeypatch):
    laspy = pytest.importorskip("laspy")
    monkeypatch.setattr("geodesic_toolkit.io.readers.las.POINTS_PER_CHUNK", 4)
    given = lasfile(tmp_path / "in.laz")
    write(tmp_path / "out.laz", gt.read(given), FIELD, like=given)
    np.testing.assert_array_equal(laspy.read(tmp_path / "out.laz")["distance"], FIELD)


def test_a_distance_that_is_there_is_replaced(tmp_path):
    laspy = pytest.importorskip("laspy")
    given = lasfile(tmp_path / "in.las", dimension="distance")
    write(tmp_path / "out.las", gt.read(given), FIELD, like=given)
    again = laspy.read(tmp_path / "out.las")
    assert list(again.point_format.extra_dimension_names) == ["distance"]
    np.testing.assert_array_equal(again["distance"], FIELD)


@pytest.mark.parametrize("unit", [1e-12, 1.0, 1e12])
def test_a_las_file_is_made_of_any_points(tmp_path, unit):
    pytest.importorskip("laspy")
    cloud = gt.PointCloud(np.add(PLACES, [7.0, -3.0, 0.0]) * unit)
    write(tmp_path / "d.las", cloud, FIELD)
    again = gt.read(tmp_path / "d.las")
    np.testing.assert_allclose(again.points, cloud.points, atol=1e-8 * unit)


def test_las_has_no_place_for_missing_points(tmp_path):
    pytest.importorskip("laspy")
    cloud = gt.PointCloud([[0.0, 0, 0], [np.nan] * 3])
    with pytest.raises(InvalidOptionError, match=r"point 1 is missing, .*write \.pcd or \.ply"):
        write(tmp_path / "d.las", cloud, [0.0, np.inf])
    assert not (tmp_path / "d.las").exists()


def test_without_laspy_the_cure_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "laspy", None)
    with pytest.raises(MissingDependencyError, match=r"writing \.laz files needs laspy: pip inst"):
        write(tmp_path / "d.laz", gt.PointCloud(PLACES), FIELD)


def test_without_lazrs_a_laz_is_refused(tmp_path, monkeypatch):
    laspy = pytest.importorskip("laspy")
    monkeypatch.setattr(laspy.LazBackend, "detect_available", lambda: ())
    with pytest.raises(MissingDependencyError, match=r"writing \.laz files needs lazrs"):
        write(tmp_path / "d.laz", gt.PointCloud(PLACES), FIELD)


# -- PCD -------------------------------------------------------------------------------------------


def pcd_rows(path):
    """The header and the rows of a binary PCD file, read without the code under test."""
    head, _, data = path.read_bytes().partition(b"DATA binary\n")
    lines = dict(line.split(" ", 1) for line in head.decode().splitlines() if line[0] != "#")
    columns = zip(*(lines[key].split() for key in ("FIELDS", "TYPE", "SIZE", "COUNT")), strict=True)
    kinds = [(name, f"<{kind.lower()}{size}", (int(n),)) for name, kind, size, n in columns]
    return lines, np.frombuffer(data, kinds)


def test_a_pcd_file_gains_a_field_and_keeps_the_others(tmp_path):
    given = tmp_path / "in.pcd"
    kinds = [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("label", "<u4"), ("_", "u1", 4)]
    rows = np.zeros(N, kinds)
    rows["x"], rows["y"], rows["z"] = PLACES.T
    rows["x"][2] = np.nan
    rows["label"], rows["_"] = 2**31 + np.arange(N), 7
    head = (
        "VERSION 0.7\nFIELDS x y z label _\nSIZE 4 4 4 4 1\nTYPE F F F U U\nCOUNT 1 1 1 1 4\n"
        "WIDTH 3\nHEIGHT 2\nVIEWPOINT 1 2 3 1 0 0 0\nPOINTS 6\nDATA binary\n"
    )
    given.write_bytes(head.encode() + rows.tobytes())
    write(tmp_path / "out.pcd", gt.read(given), FIELD, like=given)
    lines, after = pcd_rows(tmp_path / "out.pcd")
    for name in rows.dtype.names:
        np.testing.assert_array_equal(after[name].squeeze(), rows[name], err_msg=name)
    np.testing.assert_array_equal(after["distance"][:, 0], FIELD)
    assert (lines["WIDTH"], lines["HEIGHT"]) == ("3", "2")
    assert lines["VIEWPOINT"] == "1 2 3 1 0 0 0"
    np.testing.assert_array_equal(gt.read(tmp_path / "out.pcd").points, gt.read(given).points)
    write(tmp_path / "again.pcd", gt.read(given), FIELD, like=tmp_path / "out.pcd")
    assert (tmp_path / "again.pcd").read_bytes() == (tmp_path / "out.pcd").read_bytes()


@pytest.mark.parametrize("make", [pcd, pcd_compressed])
def test_text_and_compressed_pcd_files_are_kept_as_binary_ones(tmp_path, make):
    (tmp_path / "in.pcd").write_bytes(make())
    shape = gt.read(tmp_path / "in.pcd")
    write(tmp_path / "out.pcd", shape, FIELD, like=tmp_path / "in.pcd")
    np.testing.assert_array_equal(gt.read(tmp_path / "out.pcd").points, shape.points)
    np.testing.assert_array_equal(pcd_rows(tmp_path / "out.pcd")[1]["distance"][:, 0], FIELD)


def test_a_pcd_file_is_made_of_any_points(tmp_path):
    cloud = gt.PointCloud(PLACES, normals=PLACES)
    write(tmp_path / "d.pcd", cloud, FIELD)
    again = gt.read(tmp_path / "d.pcd")
    np.testing.assert_array_equal(again.points, cloud.points)
    np.testing.assert_allclose(again.normals, cloud.normals, atol=1e-15)


# -- PLY -------------------------------------------------------------------------------------------


@pytest.fixture
def given_ply(tmp_path):
    path = tmp_path / "in.ply"
    path.write_text(PLY)
    return path


@pytest.mark.filterwarnings("ignore::geodesic_toolkit.errors.ReadWarning")
def test_a_ply_file_gains_a_property_and_keeps_the_others(tmp_path, given_ply):
    out = tmp_path / "out.ply"
    write(out, gt.read(given_ply), FIELD, like=given_ply, sources=[0])
    head, _, data = out.read_bytes().partition(b"end_header\n")
    lines = head.decode().splitlines()
    assert "comment geodesic distance from vertices 0" in lines
    assert {"comment by hand", "obj_info scanner 7", "property int quality"} <= set(lines)
    vertex = [("p", "<f4", 2), ("z", "<f8"), ("rgb", "u1", 3), ("quality", "<i4"), ("d", "<f8")]
    rows = np.frombuffer(data, vertex, N)
    np.testing.assert_array_equal(rows["d"], FIELD)
    np.testing.assert_array_equal(rows["quality"], [-7, 8, 9, 10, 11, 12])
    np.testing.assert_array_equal(rows["rgb"][1], [4, 5, 6])
    rest = data[rows.nbytes :]
    polygons = (
        b"\4" + np.array([0, 1, 2, 3], "<i4").tobytes() + b"\5"
        b"\3" + np.array([1, 4, 2], "<i4").tobytes() + b"\6"
    )
    assert rest == polygons + np.int32(2).tobytes() + np.array([0.25, 0.5], "<f4").tobytes()
    np.testing.assert_array_equal(gt.read(out).faces, gt.read(given_ply).faces)
    write(tmp_path / "b.ply", gt.read(given_ply), FIELD, like=out, sources=[0])
    assert (tmp_path / "b.ply").read_bytes() == out.read_bytes()


def test_a_ply_file_without_colours_is_coloured(tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    mesh = shapes.grid(3)
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "matplotlib", None)
        write(tmp_path / "plain.ply", mesh, np.zeros(9))
    write(tmp_path / "a.ply", mesh, np.ones(9))
    write(tmp_path / "b.ply", mesh, np.ones(9), like=tmp_path / "plain.ply")
    assert (tmp_path / "b.ply").read_bytes() == (tmp_path / "a.ply").read_bytes()


def test_an_element_without_rows_is_kept(tmp_path):
    text = PLY.replace("element camera 1", "element camera 0").replace("2 0.25 0.5\n", "")
    text = text.replace("4 0 1 2 3 5", "3 0 1 2 5")
    (tmp_path / "in.ply").write_text(text)
    shape = gt.read(tmp_path / "in.ply")
    write(tmp_path / "out.ply", shape, FIELD, like=tmp_path / "in.ply")
    assert b"element camera 0\nproperty list int float view" in (tmp_path / "out.ply").read_bytes()
    np.testing.assert_array_equal(gt.read(tmp_path / "out.ply").faces, shape.faces)


# -- what cannot be --------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", ["pcd", "ply", "las"])
def test_a_file_of_other_points_is_refused(tmp_path, suffix):
    if suffix == "las":
        pytest.importorskip("laspy")
    path = tmp_path / f"in.{suffix}"
    write(path, gt.PointCloud(PLACES), FIELD)
    with pytest.raises(InvalidOptionError, match=rf"in\.{suffix} has 6 points, not 9"):
        write(tmp_path / f"d.{suffix}", shapes.grid(3), np.zeros(9), like=path)
    assert not (tmp_path / f"d.{suffix}").exists()


def test_a_file_of_another_format_is_not_looked_at(tmp_path):
    write(tmp_path / "d.pcd", gt.PointCloud(PLACES), FIELD, like=tmp_path / "none.ply")
    assert gt.read(tmp_path / "d.pcd").n_vertices == N


def test_a_file_that_is_damaged_or_gone_is_named(tmp_path):
    with pytest.raises(ReadError, match=r"none\.pcd does not exist"):
        write(tmp_path / "d.pcd", gt.PointCloud(PLACES), FIELD, like=tmp_path / "none.pcd")
    (tmp_path / "bad.pcd").write_text("nothing")
    with pytest.raises(ReadError, match=r"bad\.pcd: not a PCD file"):
        write(tmp_path / "d.pcd", gt.PointCloud(PLACES), FIELD, like=tmp_path / "bad.pcd")


@pytest.mark.parametrize("name", ["d.pcd", "d.las"])
def test_a_graph_has_no_positions(tmp_path, name):
    pytest.importorskip("laspy")
    with pytest.raises(InvalidOptionError, match="a Graph has no positions to write to a"):
        write(tmp_path / name, gt.Graph(2, [[0, 1]]), [0, 1])
