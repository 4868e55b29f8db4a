"""Tables of numbers: read as what they are, or refused; never other numbers."""

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import ReadError, ReadWarning
from geodesic_toolkit.io import read_mask, read_points, read_vertices

POINTS = np.round(np.random.default_rng(0).normal(size=(40, 3)), 4)
PLAIN = [f"{x:.4f} {y:.4f} {z:.4f}" for x, y, z in POINTS]
COMMAS = [row.replace(".", ",") for row in PLAIN]


def joined(rows, separator):
    return [row.replace(" ", separator) for row in rows]


def write(path, rows):
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


# -- points ---------------------------------------------------------------------------------------

RIGHT = {
    "blanks": PLAIN,
    "tabs": joined(PLAIN, "\t"),
    "commas": joined(PLAIN, ","),
    "commas and blanks": joined(PLAIN, ", "),
    "padded commas": [",".join(f"{float(x):12.4f}" for x in row.split()) for row in PLAIN],
    "semicolons": joined(PLAIN, ";"),
    "commas at the end": [row + "," for row in joined(PLAIN, ",")],
    "decimal commas, blanks": COMMAS,
    "decimal commas, tabs": joined(COMMAS, "\t"),
    "decimal commas, semicolons": joined(COMMAS, ";"),
    "decimal commas, semicolons and blanks": joined(COMMAS, " ; "),
    "decimal commas, semicolons at the end": [row + ";" for row in joined(COMMAS, ";")],
    "decimal commas, names": ["x;y;z", *joined(COMMAS, ";")],
    "decimal commas, names and tabs": ["X [m]\tY [m]\tZ [m]", *joined(COMMAS, "\t")],
    "decimal commas, a number": ["40", *COMMAS],
    "names": ["x y z", *PLAIN],
    "names and commas at the end": ["x,y,z,", *(row + "," for row in joined(PLAIN, ","))],
    "a comma at the end of the names": ["x,y,z,", *joined(PLAIN, ",")],
    "numbers in quotes": ['"' + row.replace(" ", '","') + '"' for row in PLAIN],
    "numbers in single quotes": ["'" + row.replace(" ", "' '") + "'" for row in PLAIN],
    "decimal commas in quotes": ['"' + row.replace(" ", '","') + '"' for row in COMMAS],
    "words in quotes with commas": [
        "name,x,y,z",
        *('"hut, lower",' + row for row in joined(PLAIN, ",")),
    ],
    "names in a comment": [
        "//Z,Y,X",
        *(",".join(row.split()[::-1]) for row in PLAIN),
    ],
    "colours first, names in a comment": ["# r g b x y z", *("255 0 7 " + row for row in PLAIN)],
    "names in quotes": ['"X","Y","Z"', *joined(PLAIN, ",")],
    "other names of three": ["easting,northing,height", *joined(PLAIN, ",")],
    "ParaView": [
        '"distance","Points:0","Points:1","Points:2"',
        *("7.5," + row for row in joined(PLAIN, ",")),
    ],
    "names in another order": [
        "id;z;x;y",
        *(f"{k};{r.split()[2]};{r.split()[0]};{r.split()[1]}" for k, r in enumerate(COMMAS)),
    ],
    "words beside named columns": ["name,x,y,z", *("nose," + row for row in joined(PLAIN, ","))],
    "comments": ["# a scan", "//X Y Z", *(row + " % noise" for row in PLAIN)],
    "marks of byte order": ["\ufeffx;y;z", *joined(COMMAS, ";")],
    "windows": [row + "\r" for row in PLAIN],
}


@pytest.mark.parametrize("suffix", ["xyz", "txt", "asc", "csv"])
@pytest.mark.parametrize("name", RIGHT)
def test_points_are_read_however_they_are_separated(name, suffix, tmp_path):
    path = write(tmp_path / f"p.{suffix}", RIGHT[name])
    np.testing.assert_array_equal(gt.read(path).points, POINTS)
    np.testing.assert_array_equal(read_points(path).points, POINTS)


THOUSANDS = [f"{1e4 * x:,.1f} {1e4 * y:,.1f} {1e4 * z:,.1f}" for x, y, z in POINTS]
REFUSED = {
    "thousands, blanks": (THOUSANDS, "is not a number with a decimal comma"),
    "thousands, semicolons": (joined(THOUSANDS, ";"), "is not a number with a decimal comma"),
    "thousands, commas and blanks": (joined(THOUSANDS, ", "), "separate columns or be in a number"),
    "decimal commas between commas": (joined(COMMAS, ","), "separate columns and to be decimal"),
    "decimal commas between commas, names": (["x,y,z", *joined(COMMAS, ",")], "and to be decimal"),
    "decimal commas between commas and blanks": (joined(COMMAS, ", "), "separate columns or be"),
    "thousands or decimals": (["1,000 2,500 3,125", "4,500 5,250 6,750"], "or group thousands"),
    "both": ([*PLAIN, *COMMAS], "has a comma and .* a point"),
    "three in one": (["1,2,3 4,5,6 7,8,9"], "'1,2,3' is not a number with a decimal comma"),
    "fewer names than columns": (["x,y,z", "1,5,2,5,3,5"], "names 3 columns, but there are 6"),
    "nothing but names": (["x,y,z"], "no numbers in the file, only 'x,y,z'"),
    "unknown names": (["id,a,b,c", "1,2,3,4"], "named id, a, b, c: which are x, y and z"),
    "an empty field": (["1;2;3", "1;;3"], "not a table of numbers"),
    "a raster": (["ncols 4", "nrows 4", "0 1 2 3"], "not a table of numbers"),
}


@pytest.mark.parametrize("suffix", ["xyz", "txt", "asc", "csv", "pts"])
@pytest.mark.parametrize("name", REFUSED)
def test_points_that_may_be_read_in_two_ways_are_refused(name, suffix, tmp_path):
    rows, says = REFUSED[name]
    path = write(tmp_path / f"p.{suffix}", rows)
    for read in (gt.read, read_points):
        with pytest.raises(ReadError, match=says):
            read(path)


@pytest.mark.parametrize("colours", ["255 0 7 ", "12 200 7 255 "])
def test_colours_before_the_points_are_not_taken_for_points(colours, tmp_path):
    path = write(tmp_path / "p.xyz", [colours + row for row in PLAIN])
    with pytest.raises(ReadError, match=r"like colours.*Name the columns"):
        gt.read(path)
    behind = write(tmp_path / "q.xyz", [row + " 255 0 7" for row in PLAIN])
    with pytest.warns(ReadWarning, match="not unit normals"):
        np.testing.assert_array_equal(gt.read(behind).points, POINTS)


def test_whole_points_with_colours_or_normals_behind_them_are_points(tmp_path):
    points = [f"{3 * i % 50} {i * i % 50} {i % 7}" for i in range(40)]
    path = write(tmp_path / "p.xyz", [row + " 0 0 1" for row in points])
    assert gt.read(path).normals is not None
    path = write(tmp_path / "q.xyz", [row + " 200 10 30" for row in points])
    with pytest.warns(ReadWarning, match="not unit normals"):
        assert gt.read(path).points[3].tolist() == [9, 9, 3]


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (["0,1,2", *joined(PLAIN, ",")], "may be a point, or number the columns"),
        (["x,x,y,z", *("9," + row for row in joined(PLAIN, ","))], "several columns are named 'x'"),
        (['"1,234";"5,678";"9,012"'] * 4, "may be decimal or group thousands"),
    ],
)
def test_first_lines_and_quotes_that_leave_the_numbers_open_are_refused(rows, says, tmp_path):
    with pytest.raises(ReadError, match=says):
        gt.read(write(tmp_path / "p.csv", rows))


def test_utf_16_is_read_as_spreadsheets_save_it(tmp_path):
    path = tmp_path / "p.txt"
    path.write_text("x\ty\tz\n" + "\n".join(joined(PLAIN, "\t")), encoding="utf-16")
    np.testing.assert_array_equal(gt.read(path).points, POINTS)
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(ReadError, match="it begins as UTF-16"):
        gt.read(path)


def test_normals_are_found_by_their_names(tmp_path):
    path = write(tmp_path / "n.csv", ["nz,ny,nx,x,y,z,label", "1,0,0,5.5,6,7,wall"])
    cloud = gt.read(path)
    assert cloud.points.tolist() == [[5.5, 6, 7]]
    assert cloud.normals.tolist() == [[0, 0, 1]]


def test_a_first_column_that_numbers_the_rows_is_not_taken_for_x_in_silence(tmp_path):
    points = np.random.default_rng(3).normal(size=(20, 3))
    path = tmp_path / "survey.csv"
    for first in (0, 1):
        rows = [f"{first + k},{x},{y},{z}\n" for k, (x, y, z) in enumerate(points)]
        path.write_text("".join(rows))
        with pytest.warns(ReadWarning, match="number the rows, was taken for x"):
            gt.read(path)
        path.write_text("id,x,y,z\n" + "".join(rows))
        np.testing.assert_array_equal(gt.read(path).points, points)


def test_edges_may_have_decimal_commas_where_that_is_clear(tmp_path):
    for rows in (["0;1;0,5", "1;2;2,0"], ["0 1 0,5", "1 2 2,0"], ["0, 1, 0.5", "1, 2, 2"]):
        graph = gt.read(write(tmp_path / "g.edges", rows))
        assert graph.lengths.tolist() == [0.5, 2.0]
    for rows, says in [
        (["0,1,0,5", "1,2,2,0"], "columns, i j .length., not 4"),
        (["i j length", "0 1 2"], "an edge list cannot have names of columns: i, j, length"),
    ]:
        with pytest.raises(ReadError, match=says):
            gt.read(write(tmp_path / "g.edges", rows))


# -- vertices and masks ---------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", ["txt", "csv"])
@pytest.mark.parametrize(
    "rows",
    [
        ["5 7 9"],
        ["5", "7", "9"],
        ["5,7", "9"],
        ["5;7;9"],
        ["5.0", "7.0", "9.0"],
        ["5,0;7,0;9,0"],
        ["5,0 7,0 9,0"],
        ["5,00\t7,00\t9,00"],
        ["vertex", "5", "7", "9"],
        ["vertex;x;y;z", "5;0,1;0,2;0,3", "7;0,1;0,2;0,3", "9;0,1;0,2;0,3"],
    ],
    ids=repr,
)
def test_vertices_are_read_however_they_are_separated(rows, suffix, tmp_path):
    path = write(tmp_path / f"v.{suffix}", rows)
    assert read_vertices(path).tolist() == [5, 7, 9]
    assert np.flatnonzero(read_mask(path, 10)).tolist() == [5, 7, 9]


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (["5,0", "7,0", "9,0"], "'5,0' may be one number or two"),
        (["5,00", "7,00"], "separate columns and to be decimal"),
        (["5,5 7,0"], "must be whole numbers .found 5.5"),
        (["1,000 2,000"], "may be decimal or group thousands"),
        (["5, 7,9"], "may separate columns or be in a number"),
        (["i,x", "5,0"], "no column is 'vertex'; there are i, x"),
        (["5,7;9"], "must be whole numbers .found 5.7"),
    ],
    ids=repr,
)
def test_vertices_that_may_be_read_in_two_ways_are_refused(rows, says, tmp_path):
    path = write(tmp_path / "v.csv", rows)
    for read in (read_vertices, lambda path: read_mask(path, 10)):
        with pytest.raises(ReadError, match=says):
            read(path)


def test_masks_of_truth_values_may_be_separated_by_anything(tmp_path):
    for text in ("1,0,0,1", "1;0;0;1", "1 0\n0 1", "1,0;0,0;0,0;1,0", "true,FALSE;false;true"):
        if "," in text and "true" in text:
            continue
        path = write(tmp_path / "m.csv", [text])
        assert np.flatnonzero(read_mask(path, 4)).tolist() == [0, 3], text


# -- formats that have no table -------------------------------------------------------------------


OTHERS = {
    "t.off": "OFF\n3 1 0\n0,5 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    "t.obj": "v 0,5 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "t.stl": "solid t\nfacet\nvertex 0,5 0 0\nvertex 1 0 0\nvertex 0 1 0\nendfacet\n",
    "t.ply": "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nend_header\n0,5 0 0\n1 0 0\n0 1 0\n",
    "t.mtx": "%%MatrixMarket matrix coordinate real general\n2 2 1\n1 2 0,5\n",
    "t.mesh": "MeshVersionFormatted 1\nDimension 3\nVertices\n3\n0,5 0 0 0\n1 0 0 0\n0 1 0 0\n"
    "Triangles\n1\n1 2 3 0\nEnd\n",
    "t.pcd": "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\n"
    "HEIGHT 1\nPOINTS 1\nDATA ascii\n0,5 0 0\n",
}


@pytest.mark.parametrize("name", OTHERS)
def test_decimal_commas_in_other_formats_are_refused(name, tmp_path):
    if name == "t.mesh":
        pytest.importorskip("meshio")
    (tmp_path / name).write_text(OTHERS[name])
    with pytest.raises(ReadError):
        gt.read(tmp_path / name)
