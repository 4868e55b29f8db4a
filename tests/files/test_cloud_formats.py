"""Files of points in the ways in which they may be written."""

import numpy as np
import pytest
from sample_files import XYZ, pcd_header, place, ply_header

import geodesic_toolkit as gt
from geodesic_toolkit.errors import ReadWarning

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
    with pytest.warns(ReadWarning, match="the normals of the file were omitted: normal 1 is zero"):
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
