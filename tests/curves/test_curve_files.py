"""Curves in files, in pictures, and from the command line."""

import csv
import json

import numpy as np
import pytest
from command_line import fails, run
from sample_files import write_off

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, InvalidSourceError, WriteError
from geodesic_toolkit.testing import shapes

TORUS = shapes.torus(24, 12)
LOOP = gt.geodesic_loop(gt.GeodesicSolver(TORUS), [0, 4, 8])
OPEN = gt.Curve([[0, 0, 0], [1, 0, 0], [1, 1, 0]])


@pytest.fixture(scope="module")
def torus_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("shapes") / "torus.ply"
    gt.write(path, TORUS, np.zeros(TORUS.n_vertices))
    return path


def lines_in(path):
    """The polylines of a file."""
    if path.suffix == ".vtp":
        import pyvista

        shape = pyvista.read(path)
        return [np.asarray(shape.get_cell(k).points) for k in range(shape.n_cells)]
    if path.suffix == ".csv":
        with path.open(newline="") as file:
            rows = list(csv.DictReader(file))
        numbers = sorted({int(row["curve"]) for row in rows})
        return [
            np.array([[float(r[a]) for a in "xyz"] for r in rows if int(r["curve"]) == n])
            for n in numbers
        ]
    rows = [line.split() for line in path.read_text().splitlines()]
    if path.suffix == ".obj":
        points = np.array([[float(x) for x in row[1:]] for row in rows if row[0] == "v"])
        return [points[[int(n) - 1 for n in row[1:]]] for row in rows if row[0] == "l"]
    n_points = next(int(row[2]) for row in rows if row[:2] == ["element", "vertex"])
    body = rows[rows.index(["end_header"]) + 1 :]
    points = np.array([[float(x) for x in row] for row in body[:n_points]])
    edges = np.array([[int(n) for n in row] for row in body[n_points:]])
    ends = np.flatnonzero(edges[1:, 0] != edges[:-1, 1]) + 1
    return [points[[*part[:, 0], part[-1, 1]]] for part in np.split(edges, ends)]


@pytest.mark.parametrize("suffix", ["obj", "ply", "vtp", "csv"])
def test_curves_come_back_from_a_file_with_all_digits(suffix, tmp_path):
    if suffix == "vtp":
        pytest.importorskip("pyvista", reason="it reads the file that is written")
    path = tmp_path / f"curves.{suffix}"
    gt.write_curves(path, TORUS, [LOOP, OPEN])
    loop, line = lines_in(path)
    np.testing.assert_array_equal(loop, np.vstack([LOOP.points, LOOP.points[:1]]))
    np.testing.assert_array_equal(line, OPEN.points)


def test_curves_that_cannot_be_written_are_refused(tmp_path):
    with pytest.raises(InvalidOptionError, match=r"\.obj"):
        gt.write_curves(tmp_path / "curve.stl", TORUS, LOOP)
    with pytest.raises(WriteError):
        gt.write_curves(tmp_path / "nowhere" / "curve.obj", TORUS, LOOP)
    with pytest.raises(InvalidSourceError, match="curve 1 is an int"):
        gt.write_curves(tmp_path / "curve.obj", TORUS, [LOOP, 5])
    assert not list(tmp_path.iterdir())


def test_a_picture_shows_curves():
    pytest.importorskip("pyvista", reason="it draws")
    plain, drawn = (
        gt.viz.plot(TORUS, TORUS.vertices[:, 0], curves=curves, sources=[], size=(400, 200))
        for curves in ([], [LOOP])
    )
    changed = drawn[(plain != drawn).any(axis=2)].astype(int)
    assert len(changed) > 50
    assert (changed[:, 0] > changed[:, 2] + 60).mean() > 0.5  # orange
    widget = gt.viz.show(TORUS, TORUS.vertices[:, 0], curves=LOOP)
    assert "curve" in [item.name for item in widget.objects]


def test_the_command_loop_prints_and_writes_the_loop(torus_file, tmp_path):
    output = tmp_path / "loop.obj"
    result = run("loop", torus_file, "--through", "0,4,8", "--output", output)
    assert result.exit_code == 0
    assert result.stderr == ""
    assert f"length {LOOP.length:.6g}" in result.stdout
    assert str(output) in result.stdout
    assert len(lines_in(output)) == 1


def test_the_command_loop_takes_points_and_prints_json(torus_file):
    places = [",".join(map(repr, TORUS.vertices[v].tolist())) for v in (0, 4, 8)]
    options = [word for place in places for word in ("--through", place)]
    report = json.loads(run("loop", torus_file, *options, "--json").stdout)
    assert report["length"] == pytest.approx(LOOP.length, rel=1e-6)
    assert len(report["points"]) == report["n_points"]
    assert report["keep"] is False
    kept = json.loads(run("loop", torus_file, *options, "--keep", "--json").stdout)
    assert kept["length"] >= report["length"] - 1e-9


def test_the_command_loop_fails_in_a_line(torus_file, tmp_path):
    fails(run("loop", torus_file, "--through", "0,1,13"), 4, "shrinks to a point")
    fails(run("loop", torus_file, "--through", "0,1"), 2, "three places")
    fails(run("loop", torus_file, "--through", "0,1,5000"), 2, "5000")
    fails(run("loop", torus_file, "--through", "a,b"), 2, "neither vertices")
    fails(run("loop", torus_file, "--through", "0,4", "--through", "0.5,1,2"), 2, "one kind")
    fails(run("loop", torus_file, "--through", "0,4,8", "--output", "loop.stl"), 2, ".obj")
    fails(run("loop", torus_file, "--through", "0,4,8", "--output", torus_file), 2, "overwrite")
    cloud = tmp_path / "cloud.xyz"
    np.savetxt(cloud, TORUS.vertices)
    fails(run("loop", cloud, "--through", "0,4,8"), 3, "loops need a triangle mesh")


def test_the_command_loop_without_places_finds_the_shortest(torus_file, tmp_path):
    output = tmp_path / "girth.obj"
    solver = gt.GeodesicSolver(gt.read(torus_file))
    girth = gt.shortest_loop(solver).length
    result = run("loop", torus_file, "--output", output)
    assert result.exit_code == 0
    assert f"shortest loop  length {girth:.6g}" in result.stdout
    assert len(lines_in(output)) == 1
    report = json.loads(run("loop", torus_file, "--at", 30, "--min-hole", 2, "--json").stdout)
    assert report["length"] == pytest.approx(gt.shortest_loop(solver, 30).length)
    assert (report["shortest"], report["through"]) == (True, None)
    assert (report["at"], report["min_hole"]) == (30, 2.0)
    assert len(report["points"]) == report["n_points"]


def test_the_command_loop_says_which_options_go_together(torus_file, tmp_path):
    fails(run("loop", torus_file, "--through", "0,4,8", "--at", "3"), 2, "without --through")
    fails(run("loop", torus_file, "--keep"), 2, "--through places")
    fails(run("loop", torus_file, "--at", "3,4"), 2, "one place")
    fails(run("loop", torus_file, "--min-hole", "-1"), 2, "min_hole")
    sphere = tmp_path / "sphere.off"
    write_off(sphere, gt.testing.shapes.icosphere(1))
    fails(run("loop", sphere), 4, "shrinks to a point")


def test_the_command_isolines_measures_what_it_draws(torus_file, tmp_path):
    output = tmp_path / "lines.csv"
    levels = ["--level", 0.4, "--level", 3.0]
    result = run("isolines", torus_file, "--source", 0, *levels, "--output", output, "--json")
    first, second = json.loads(result.stdout)["levels"]
    mesh = gt.read(torus_file)
    distance = gt.geodesic_distance(mesh, 0)
    (line,) = gt.isolines(mesh, distance, 0.4)
    assert (first["n_lines"], first["n_closed"], second["n_lines"]) == (1, 1, 2)
    assert first["length"] == pytest.approx(gt.curve_length(mesh, line))
    assert first["area_within"] == pytest.approx(gt.area_above(mesh, -distance, -0.4))
    assert len(lines_in(output)) == 3


def test_the_command_isolines_warns_where_there_are_none(torus_file):
    result = run("isolines", torus_file, "--source", 0, "--level", 100)
    assert result.exit_code == 0
    assert "no line is at these distances" in result.stderr
    assert "0 lines" in result.stdout
