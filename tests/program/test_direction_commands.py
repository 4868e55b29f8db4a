"""The commands `logmap` and `signed`, and the files of curves and maps."""

import json

import numpy as np
import pytest
from command_line import fails, run

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, InvalidSourceError, ReadError
from geodesic_toolkit.testing import shapes

SQUARE = shapes.grid(7)
LOG = gt.log_map(gt.GeodesicSolver(SQUARE), 24)
UPWARDS = gt.Curve([[0.5, 0, 0], [0.5, 1, 0]])
TRIANGLE = gt.Curve([[0, 0, 0], [1, 0, 0], [1, 1, 0]], closed=True)


@pytest.fixture(scope="module")
def square_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("shapes") / "square.ply"
    gt.write(path, SQUARE, np.zeros(SQUARE.n_vertices))
    return path


@pytest.fixture
def curve_file(tmp_path):
    path = tmp_path / "upwards.csv"
    gt.write_curves(path, SQUARE, UPWARDS)
    return path


@pytest.mark.parametrize("suffix", ["obj", "ply", "vtp", "csv"])
def test_curves_that_were_written_are_read_again(suffix, tmp_path):
    path = tmp_path / f"curves.{suffix}"
    gt.write_curves(path, SQUARE, [TRIANGLE, UPWARDS])
    closed, line = gt.read_curves(path, SQUARE)
    assert (closed.closed, line.closed) == (True, False)
    np.testing.assert_array_equal(closed.points, TRIANGLE.points)
    np.testing.assert_array_equal(line.points, UPWARDS.points)


def test_curves_are_read_from_points_and_from_vertices(tmp_path):
    np.save(tmp_path / "points.npy", UPWARDS.points)
    np.save(tmp_path / "vertices.npy", [3, 10, 17])
    (tmp_path / "vertices.txt").write_text("0 6 48 0\n")
    (tmp_path / "points.csv").write_text("x,y,z\n0.5,0,0\n0.5,1,0\n")
    for name in ("points.npy", "points.csv"):
        (curve,) = gt.read_curves(tmp_path / name, SQUARE)
        np.testing.assert_array_equal(curve.points, UPWARDS.points)
    (line,) = gt.read_curves(tmp_path / "vertices.npy", SQUARE)
    np.testing.assert_array_equal(line.points, SQUARE.vertices[[3, 10, 17]])
    (closed,) = gt.read_curves(tmp_path / "vertices.txt", SQUARE)
    assert closed.closed
    np.testing.assert_array_equal(closed.points, SQUARE.vertices[[0, 6, 48]])


@pytest.mark.parametrize(
    ("name", "text", "error", "words"),
    [
        ("a.obj", "v 0 0 0\nv 1 0 0\n", ReadError, "no lines"),
        ("a.obj", "v 0 0 0\nl 1 2\n", ReadError, "line 0 refers to vertex 2"),
        ("a.obj", "v 0 0\nl 1 2\n", ReadError, "less than 3"),
        ("a.obj", "v 0 0 0\nl 1 1\n", InvalidSourceError, None),
        ("a.ply", "ply\nformat ascii 1.0\nend_header\n", ReadError, "no vertices with edges"),
        ("a.csv", "x,y,z\n0,0,0\nnan,0,0\n", ReadError, "point 1 is not finite"),
        ("a.csv", "x,y,z\n0,0,0\n", InvalidSourceError, "two points or more"),
        ("a.txt", "0 1 49\n", InvalidSourceError, "vertex 49"),
        ("a.stl", "solid", ReadError, "a.stl"),
    ],
)
def test_a_file_without_curves_is_refused(name, text, error, words, tmp_path):
    (tmp_path / name).write_text(text)
    if words is None:  # a line from a point to itself is refused where it is laid
        (curve,) = gt.read_curves(tmp_path / name, SQUARE)
        with pytest.raises(error, match="single place"):
            gt.signed_distance(gt.GeodesicSolver(SQUARE), curve)
        return
    with pytest.raises(error, match=words):
        gt.read_curves(tmp_path / name, SQUARE)


def test_an_edge_beyond_the_vertices_of_a_ply_file_is_refused(tmp_path):
    path = tmp_path / "a.ply"
    gt.write_curves(path, SQUARE, UPWARDS)
    path.write_text(path.read_text().replace("\n0 1\n", "\n0 5\n"))
    with pytest.raises(ReadError, match="vertex 5"):
        gt.read_curves(path, SQUARE)
    np.save(tmp_path / "pairs.npy", np.zeros((4, 2)))
    with pytest.raises(ReadError, match="shape"):
        gt.read_curves(tmp_path / "pairs.npy", SQUARE)


def test_a_log_map_is_written_with_all_digits(tmp_path):
    for suffix in ("npy", "csv", "json", "obj", "ply"):
        gt.write_log_map(tmp_path / f"log.{suffix}", SQUARE, LOG)
    np.testing.assert_array_equal(np.load(tmp_path / "log.npy"), LOG.coordinates)
    table = np.loadtxt(tmp_path / "log.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(table[:, 4:6], LOG.coordinates)
    content = json.loads((tmp_path / "log.json").read_text())
    assert content["coordinates"] == LOG.coordinates.tolist()
    assert content["frame"] == LOG.frame.tolist()
    rows = [row.split() for row in (tmp_path / "log.obj").read_text().splitlines()]
    texture = [[float(x) for x in row[1:]] for row in rows if row[0] == "vt"]
    np.testing.assert_array_equal(texture, LOG.coordinates)
    for name in ("log.obj", "log.ply"):
        np.testing.assert_array_equal(gt.read(tmp_path / name).faces, SQUARE.faces)
    assert b"property double s" in (tmp_path / "log.ply").read_bytes()


def test_vertices_that_are_not_connected_have_no_texture_coordinates(tmp_path):
    two = shapes.disjoint_union(SQUARE, SQUARE)
    log = gt.log_map(gt.GeodesicSolver(two), 0)
    gt.write_log_map(tmp_path / "log.obj", two, log)
    gt.write_log_map(tmp_path / "log.json", two, log)
    text = (tmp_path / "log.obj").read_text()
    assert text.count("vt ") == SQUARE.n_vertices
    assert "nan" not in text
    assert text.splitlines()[-1].count("/") == 0
    assert json.loads((tmp_path / "log.json").read_text())["coordinates"][-1] == [None, None]


def test_a_log_map_that_does_not_fit_is_refused(tmp_path):
    with pytest.raises(InvalidOptionError, match="49 vertices does not fit"):
        gt.write_log_map(tmp_path / "log.csv", shapes.grid(3), LOG)
    with pytest.raises(InvalidOptionError, match="needs a mesh"):
        gt.write_log_map(tmp_path / "log.obj", gt.PointCloud(SQUARE.vertices), LOG)
    with pytest.raises(InvalidOptionError, match=r"\.obj"):
        gt.write_log_map(tmp_path / "log.stl", SQUARE, LOG)
    assert not list(tmp_path.iterdir())


def test_the_command_logmap_writes_texture_coordinates(square_file, tmp_path):
    output = tmp_path / "uv.npy"
    result = run("logmap", square_file, "--source", 24, "--output", output)
    assert result.exit_code == 0
    assert result.stderr == ""
    assert "longest" in result.stdout
    np.testing.assert_allclose(np.load(output), LOG.coordinates, atol=1e-6)


def test_the_command_logmap_prints_json(square_file):
    report = json.loads(run("logmap", square_file, "--source", "0.5,0.5,0", "--json").stdout)
    assert report["longest"] == pytest.approx(np.sqrt(0.5), rel=1e-5)
    assert (report["reached"], report["refined"]) == (49, True)
    np.testing.assert_allclose(np.cross(*report["frame"]), [0, 0, 1], atol=1e-9)
    plain = json.loads(run("logmap", square_file, "--source", 24, "--no-refine", "--json").stdout)
    assert plain["refined"] is False


def test_the_command_logmap_keeps_the_vertices_of_a_welded_file(tmp_path):
    cut = tmp_path / "cut.ply"
    copies = gt.TriangleMesh(
        SQUARE.vertices[SQUARE.faces].reshape(-1, 3), np.arange(3 * SQUARE.n_faces).reshape(-1, 3)
    )
    gt.write(cut, copies, np.zeros(copies.n_vertices))
    output = tmp_path / "uv.npy"
    assert run("logmap", cut, "--source", 0, "--weld", 0, "--output", output).exit_code == 0
    assert np.load(output).shape == (copies.n_vertices, 2)
    assert np.isfinite(np.load(output)).all()


def test_the_command_logmap_fails_in_a_line(square_file, tmp_path):
    fails(run("logmap", square_file, "--source", 49), 2, "49")
    fails(run("logmap", square_file, "--source", "a,b"), 2, "neither a vertex")
    fails(run("logmap", square_file, "--source", 0, "--output", "uv.stl"), 2, ".obj")
    fails(run("logmap", square_file, "--source", 0, "--output", square_file), 2, "overwrite")
    fails(run("logmap", square_file, "--source", 0, "--picture", "uv.jpg"), 2, ".png")
    edges = tmp_path / "graph.edges"
    edges.write_text("0 1\n1 2\n")
    fails(run("logmap", edges, "--source", 0), 3, "angle")


def test_the_command_signed_gives_sides(square_file, curve_file, tmp_path):
    output = tmp_path / "d.npy"
    result = run("signed", square_file, "--curve", curve_file, "--output", output)
    assert result.exit_code == 0
    assert result.stderr == ""
    np.testing.assert_allclose(np.load(output), 0.5 - SQUARE.vertices[:, 0], atol=1e-3)


def test_the_command_signed_prints_json_and_takes_unsigned_curves(
    square_file, curve_file, tmp_path
):
    (tmp_path / "edge.txt").write_text("0 1 2 3 4 5 6\n")
    options = ["--curve", curve_file, "--unsigned", tmp_path / "edge.txt", "--json"]
    report = json.loads(run("signed", square_file, *options).stdout)
    assert (report["n_curves"], report["n_closed"], report["n_unsigned"]) == (1, 0, 1)
    assert report["minimum"] == pytest.approx(-report["maximum"], abs=1e-3)
    assert report["n_negative"] == 18  # three columns, without the vertices on the edge


def test_the_command_signed_fails_in_a_line(square_file, curve_file, tmp_path):
    (tmp_path / "far.txt").write_text("0 99\n")
    fails(run("signed", square_file, "--curve", tmp_path / "none.csv"), 2, "none.csv")
    fails(run("signed", square_file, "--curve", tmp_path / "far.txt"), 2, "99")
    fails(run("signed", square_file, "--curve", square_file), 3, "no vertices with edges")
    fails(run("signed", square_file, "--curve", curve_file, "--output", curve_file), 2, "overwrite")


def test_a_ply_of_signed_values_has_two_colours(tmp_path):
    pytest.importorskip("matplotlib", reason="it makes the colours")
    from geodesic_toolkit.io.writing import _colours

    red, blue = np.asarray(_colours(np.array([-1.0, 1.0]))).astype(int)
    assert red[0] > red[2] + 50
    assert blue[2] > blue[0] + 50
