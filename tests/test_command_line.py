"""The command line: what it prints where, what it writes, and how it ends."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from importlib import metadata
from typing import ClassVar

import numpy as np
import pytest
from scipy.sparse import csr_array
from typer.testing import CliRunner

import geodesic_toolkit as gt
from geodesic_toolkit import errors, viz
from geodesic_toolkit.cli import app, doctor, exits, probes, progress
from geodesic_toolkit.io import write_distances
from geodesic_toolkit.testing import shapes

# -- how to run it -------------------------------------------------------------------------------


def run(*arguments, **options):
    """Run the program in this process."""
    return CliRunner().invoke(app, [str(argument) for argument in arguments], **options)


def run_process(*arguments, **environment):
    """Run the program in a process of its own, as a person does."""
    return subprocess.run(
        [sys.executable, "-m", "geodesic_toolkit", *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, **environment},
    )


def fails(result, status, *words):
    """Check an exit status, and that there is a short, clear line and nothing else."""
    assert result.exit_code == status, result.output
    assert result.stdout == ""
    lines = result.stderr.splitlines()
    assert 1 <= len(lines) <= 3
    assert "Traceback" not in result.stderr
    for word in words:
        assert word in result.stderr


def write_off(path, mesh):
    lines = ["OFF", f"{mesh.n_vertices} {mesh.n_faces} 0"]
    lines += [" ".join(map(repr, row)) for row in mesh.vertices.tolist()]
    lines += [f"3 {a} {b} {c}" for a, b, c in mesh.faces.tolist()]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture(autouse=True)
def patience(monkeypatch):
    """Keep lines of progress out of what the tests compare, on however slow a machine."""
    monkeypatch.setattr(progress, "FIRST_PLAIN_LINE", 3600.0)


@pytest.fixture
def sphere(tmp_path):
    return write_off(tmp_path / "sphere.off", shapes.icosphere(2))


@pytest.fixture
def graph(tmp_path):
    path = tmp_path / "path.edges"
    path.write_text("0 1 1.0\n1 2 2.0\n")
    return path


@pytest.fixture
def register():
    """The function that registers a plugin for the time of a test."""
    registered = []

    def register(registry, name, plugin):
        registry.register(name, plugin)
        registered.append((registry, name))

    yield register
    for registry, name in registered:
        registry.unregister(name)


@dataclass(frozen=True, kw_only=True)
class Failing(gt.LinearSolver):
    """A solver that raises what it is told to."""

    componentwise: ClassVar[bool] = True
    what: ClassVar[BaseException]

    def factorize(self, matrix: csr_array) -> gt.Factor:
        raise self.what


@pytest.fixture
def failing(register):
    register(gt.solvers, "failing", Failing)

    def set_error(error):
        Failing.what = error

    return set_error


# -- distance: results ---------------------------------------------------------------------------


def test_distance_prints_a_summary_on_stdout_and_nothing_on_stderr(sphere):
    result = run("distance", sphere, "--source", 5)
    assert result.exit_code == 0
    assert result.stderr == ""
    assert "TriangleMesh(162 vertices, 320 faces)" in result.stdout
    assert "vertex 5" in result.stdout
    assert "162 vertices, 0 unreachable" in result.stdout
    largest = gt.geodesic_distance(gt.read(sphere), 5).max()
    assert f"max {largest:.6g}" in result.stdout


def test_distance_writes_every_output_that_it_is_asked_for(sphere, tmp_path):
    outputs = [tmp_path / f"d.{suffix}" for suffix in ("npy", "csv", "ply")]
    options = [argument for output in outputs for argument in ("--output", output)]
    result = run("distance", sphere, "--source", 5, *options)
    assert result.exit_code == 0
    expected = gt.geodesic_distance(gt.read(sphere), 5)
    np.testing.assert_array_equal(np.load(outputs[0]), expected)
    with outputs[1].open(newline="") as file:
        table = [float(row["distance"]) for row in csv.DictReader(file)]
    np.testing.assert_array_equal(table, expected)
    assert gt.read(outputs[2]).n_vertices == 162
    for output in outputs:
        assert str(output) in result.stdout


def test_json_is_one_object_with_everything_in_it(sphere, tmp_path):
    output = tmp_path / "d.npy"
    result = run("distance", sphere, "--source", 5, "--output", output, "--json")
    report = json.loads(result.stdout)
    distance = np.load(output)
    assert report["schema_version"] == 1
    assert report["input"] == str(sphere)
    assert report["domain"] == "TriangleMesh"
    assert report["sources"] == [5]
    assert report["n_vertices"] == report["reached"] == 162
    assert report["unreachable"] == 0
    assert report["max"] == distance.max()
    assert report["mean"] == pytest.approx(distance.mean())
    assert report["time"] == pytest.approx(report["spacing"] ** 2)
    assert report["warnings"] == []
    assert report["notes"]["triangulation"] == "given"
    assert report["outputs"] == [str(output)]
    assert set(report["timings"]) == {"reading", "factorising", "solving", "writing", "total"}
    assert report["versions"]["numpy"] == np.__version__
    assert set(report["versions"]) == {"geodesic-toolkit", "python", "numpy", "scipy"}
    assert "CotanLaplacian" in report["operator"]
    assert report["solver"]["heat"] in {"Supernodal()", "SuperLU()"}


def test_json_has_no_infinity_and_no_nan(tmp_path):
    two = shapes.disjoint_union(shapes.icosphere(1), shapes.icosphere(1))
    path = write_off(tmp_path / "two.off", two)
    result = run("distance", path, "--source", 0, "--json")

    def refuse(constant):
        raise AssertionError(constant)

    report = json.loads(result.stdout, parse_constant=refuse)
    assert (report["reached"], report["unreachable"]) == (42, 42)


@pytest.mark.parametrize(
    ("options", "keywords"),
    [
        (["--time-factor", "4"], {"time_factor": 4.0}),
        (["--time", "0.25"], {"time": 0.25}),
        (["--boundary", "dirichlet"], {"boundary": "dirichlet"}),
        (["--boundary", "average"], {"boundary": "average"}),
        (["--diffusion", "uniform"], {"diffusion": "uniform"}),
        (["--operator", "uniform"], {"operator": "uniform"}),
        (["--solver", "cg"], {"solver": "cg"}),
    ],
)
def test_options_reach_the_solver(options, keywords, tmp_path):
    path = write_off(tmp_path / "square.off", shapes.grid(7))
    output = tmp_path / "d.npy"
    result = run("distance", path, "--source", 24, *options, "--output", output)
    assert result.exit_code == 0, result.output
    expected = gt.geodesic_distance(gt.read(path), 24, **keywords)
    np.testing.assert_array_equal(np.load(output), expected)


def test_many_sources_make_one_set(sphere, tmp_path):
    output = tmp_path / "d.npy"
    run("distance", sphere, "--source", 5, "--source", 9, "--output", output)
    np.testing.assert_array_equal(np.load(output), gt.geodesic_distance(gt.read(sphere), [5, 9]))


def test_a_source_may_be_a_point(sphere, tmp_path):
    output = tmp_path / "d.npy"
    result = run("distance", sphere, "--source", "-1,0.5,2", "--output", output)
    assert "point (-1, 0.5, 2)" in result.stdout
    expected = gt.geodesic_distance(gt.read(sphere), [-1.0, 0.5, 2.0])
    np.testing.assert_array_equal(np.load(output), expected)


@pytest.mark.parametrize("suffix", ["npy", "csv", "xyz", "ply"])
def test_distances_at_points_of_a_file(sphere, tmp_path, suffix):
    solver = gt.GeodesicSolver(shapes.icosphere(2))
    places = np.random.default_rng(0).normal(size=(30, 3))
    places /= np.linalg.norm(places, axis=1, keepdims=True)
    places[7] *= 9
    points = tmp_path / f"places.{suffix}"
    if suffix == "npy":
        np.save(points, places)
    elif suffix == "csv":
        np.savetxt(points, places, fmt="%.17g", delimiter=",", header="x,y,z", comments="")
    elif suffix == "xyz":
        np.savetxt(points, places, fmt="%.17g")
    else:
        write_distances(points, gt.PointCloud(places), np.zeros(30))
    out = [tmp_path / "d.npy", tmp_path / "d.csv", tmp_path / "d.ply"]
    options = [word for path in out for word in ("--output", path)]
    result = run("distance", sphere, "--source", 5, "--at", points, *options)
    assert result.exit_code == 0, result.output
    assert "29 points, 1 unreachable" in result.stdout
    distances = np.load(out[0])
    np.testing.assert_allclose(distances, solver.query(places, 5), atol=1e-6)
    assert distances[7] == np.inf
    rows = list(csv.DictReader(out[1].read_text().splitlines()))
    assert [float(row["distance"]) for row in rows] == distances.tolist()
    np.testing.assert_allclose(gt.read(out[2]).points, places, atol=1e-12)


def test_missing_points_of_at_stay_in_their_rows(sphere, tmp_path):
    np.save(tmp_path / "at.npy", [[0, 0, 1.0], [np.nan, 0, 0], [1.0, 0, 0]])
    out = tmp_path / "d.npy"
    run("distance", sphere, "--source", 0, "--at", tmp_path / "at.npy", "--output", out)
    assert np.isfinite(np.load(out)).tolist() == [True, False, True]


def test_the_reach_of_at_can_be_told(sphere, tmp_path):
    np.save(tmp_path / "at.npy", [[0, 0, 2.0]])
    told = ["distance", sphere, "--source", 0, "--at", tmp_path / "at.npy", "--json"]
    near, far = run(*told), run(*told, "--reach", 1.5)
    assert json.loads(near.stdout)["reached"] == 0
    assert json.loads(near.stdout)["max"] is None
    assert "has a distance" in near.stderr
    found = json.loads(far.stdout)
    assert (found["n_points"], found["reached"], found["n_vertices"]) == (1, 1, 162)


def test_pictures_show_the_shape_wherever_the_points_are(sphere, tmp_path, monkeypatch):
    shown = []
    monkeypatch.setattr(viz, "plot", lambda *what, **look: shown.append((what, look)))
    np.save(tmp_path / "at.npy", [[0, 0, 1.0], [1e6, 0, 0]])
    told = ("distance", sphere, "--source", 150, "--at", tmp_path / "at.npy")
    assert run(*told, "--picture", tmp_path / "p.png").exit_code == 0
    [((domain, distances), look)] = shown
    assert isinstance(domain, gt.TriangleMesh)
    assert len(distances) == 162
    assert look["sources"] == [150]


def test_points_that_cannot_be_asked_for_are_refused(sphere, graph, tmp_path):
    at = tmp_path / "at.csv"
    at.write_text("0,0,1\n")
    asked = ("--source", 0, "--at", at)
    fails(run("distance", graph, *asked), 2, "a graph has no positions")
    fails(run("distance", sphere, *asked, "--reach", 0), 2, "--reach must be positive")
    fails(run("distance", sphere, "--source", 0, "--reach", 1), 2, "--reach is for the points")
    fails(run("distance", sphere, *asked, "--output", at), 2, "would overwrite the input")
    at.write_text("0,0\n")
    fails(run("distance", sphere, *asked), 3, "at.csv", "no columns x, y and z")
    fails(run("distance", sphere, "--source", 0, "--at", tmp_path / "none.npy"), 2, "none.npy")


def test_a_mask_keeps_paths_out(tmp_path):
    square = shapes.grid(7)
    path, wall = write_off(tmp_path / "square.off", square), np.zeros(49, dtype=bool)
    wall[3:35:7] = True  # the middle column, but for its end
    np.save(tmp_path / "wall.npy", wall)
    (tmp_path / "wall.txt").write_text(" ".join(map(str, np.flatnonzero(wall))))
    expected = gt.geodesic_distance(square, [0.0, 0.0, 0.0], mask=wall)
    for file in ("wall.npy", "wall.txt"):
        told = ["distance", path, "--source", "0,0,0", "--mask", tmp_path / file, "--json"]
        result = run(*told, "--output", tmp_path / "d.npy")
        assert result.exit_code == 0, result.output
        np.testing.assert_array_equal(np.load(tmp_path / "d.npy"), expected)
        report = json.loads(result.stdout)
        assert report["mask"] == str(tmp_path / file)
        assert report["unreachable"] == wall.sum()
    shown = run("distance", path, "--source", 0, "--mask", tmp_path / "wall.txt")
    assert f"mask       {tmp_path / 'wall.txt'}" in shown.stdout


def test_points_in_a_mask_are_not_reached(tmp_path):
    square = shapes.grid(7)
    path, wall = write_off(tmp_path / "square.off", square), tmp_path / "wall.txt"
    wall.write_text(" ".join(map(str, range(3, 49, 7))))
    np.save(tmp_path / "at.npy", square.vertices[[8, 10, 13]])
    told = ["distance", path, "--source", 0, "--mask", wall, "--at", tmp_path / "at.npy"]
    result = run(*told, "--reach", 0.01, "--output", tmp_path / "d.npy")
    assert result.exit_code == 0, result.output
    assert np.isfinite(np.load(tmp_path / "d.npy")).tolist() == [True, False, False]


def test_a_mask_that_cannot_be_used_is_refused_before_the_work(sphere, tmp_path, monkeypatch):
    monkeypatch.setattr("geodesic_toolkit.solver.GeodesicSolver.__init__", None)  # never called
    wall = tmp_path / "wall.txt"
    asked = ("distance", sphere, "--source", 5, "--mask", wall)
    fails(run(*asked), 2, "wall.txt")
    for text, status, word in [
        ("1 2 162", 2, "none is 162"),
        ("true false", 2, "2 booleans, where the shape has 162 vertices"),
        ("wall", 3, "wall.txt: booleans or vertex indices must be numbers"),
        ("4 5", 2, "vertex 5 is masked"),
        (" ".join(map(str, range(162))), 2, "the mask leaves no face"),
    ]:
        wall.write_text(text)
        fails(run(*asked), status, word)
    table = tmp_path / "wall.csv"
    table.write_text("4")
    told = ("--mask", table, "--output", table)
    fails(run("distance", sphere, "--source", 5, *told), 2, "would overwrite the input")


def test_graphs_go_through_the_same_command(graph):
    report = json.loads(run("distance", graph, "--source", 0, "--json").stdout)
    assert report["domain"] == "Graph"
    assert report["max"] == pytest.approx(3.0, rel=0.05)


def test_a_source_that_is_connected_to_nothing_is_warned_of(tmp_path):
    path = tmp_path / "lonely.off"
    path.write_text("OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 0\n5 5 5\n3 0 1 2\n")
    result = run("distance", path, "--source", 3, "--json")
    report = json.loads(result.stdout)
    assert (report["reached"], report["unreachable"]) == (1, 3)
    assert "connected to no other vertex" in report["warnings"][0]
    assert result.stderr.startswith("warning: ")


# -- distance: stdout is for results -------------------------------------------------------------


def test_warnings_are_lines_on_stderr_and_strings_in_the_json(tmp_path):
    path = tmp_path / "quad.off"
    path.write_text("OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n")
    result = run("distance", path, "--source", 0, "--refine", "--json")
    (warning,) = json.loads(result.stdout)["warnings"]
    assert "split into 2 triangles" in warning
    assert result.stderr == f"warning: {warning}\n"


def test_what_a_library_prints_on_stdout_does_not_get_into_the_results(register, tmp_path, capfd):
    def read_noisily(path):
        os.write(1, b"noise from a compiled library\n")
        return shapes.icosphere(1)

    register(gt.readers, "noisy", read_noisily)
    path = tmp_path / "shape.noisy"
    path.write_text("x")
    result = run("distance", path, "--source", 0, "--json")
    printed = capfd.readouterr()
    assert json.loads(result.stdout)["n_vertices"] == 42
    assert "noise" not in printed.out
    assert "noise" in printed.err


# -- exit status 2 -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "source", ["x", "1.5", "1,2", "1,2,3,4", "1,2,x", "nan,0,0", "inf,0,0", "", ",,"]
)
def test_a_source_that_is_no_place_is_wrong_usage(sphere, source):
    fails(run("distance", sphere, "--source", source), 2, "--source")


def test_vertices_and_points_do_not_mix(sphere):
    fails(run("distance", sphere, "--source", 1, "--source", "0,0,1"), 2, "all of one kind")


@pytest.mark.parametrize("vertex", [162, -1, 10**30])
def test_a_source_out_of_range_is_wrong_usage(sphere, vertex):
    fails(run("distance", sphere, "--source", vertex), 2, "error: sources")


def test_a_point_on_a_graph_is_wrong_usage(graph):
    fails(run("distance", graph, "--source", "0,0,0"), 2, "no positions")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ([], ["--source"]),
        (["--source", "0", "--operator", "cotna"], ["did you mean 'cotan'"]),
        (["--source", "0", "--diffusion", "nope"], ["no operator 'nope'"]),
        (["--source", "0", "--solver", "nope"], ["no solver 'nope'"]),
        (["--source", "0", "--boundary", "open"], ["--boundary", "neumann"]),
        (["--source", "0", "--time", "0"], ["--time must be positive"]),
        (["--source", "0", "--time", "nan"], ["--time must be positive"]),
        (["--source", "0", "--time-factor", "inf"], ["--time-factor must be positive"]),
        (["--source", "0", "--time-factor", "x"], ["--time-factor"]),
        (["--source", "0", "--time", "1", "--time-factor", "1"], ["not both"]),
        (["--source", "0", "--output", "d.txt"], [".ply, .npy, .csv"]),
        (["--source", "0", "--output", "d"], ["no suffix"]),
        (["--source", "0", "--picture", "d.jpg"], [".png"]),
        (["--source", "0", "--html", "d.png"], [".html"]),
        (["--source", "0", "--output", "nowhere/d.ply"], ["no directory"]),
        (["--source", "0", "--output", "d.npy", "--output", "./d.npy"], ["another output"]),
        (["--source", "0", "--nonsense"], ["--nonsense"]),
    ],
)
def test_wrong_usage_is_found_before_any_work(options, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    broken = tmp_path / "broken.off"  # reading it would end with status 3
    broken.write_text("no mesh at all")
    fails(run("distance", broken, *options), 2, *words)
    assert [path.name for path in tmp_path.iterdir()] == ["broken.off"]


def test_an_unknown_colour_map_is_wrong_usage(sphere):
    pytest.importorskip("matplotlib")
    fails(run("distance", sphere, "--source", 0, "--cmap", "virdis"), 2, "virdis")


def test_the_input_is_not_overwritten(tmp_path):
    path = tmp_path / "cloud.ply"
    path.write_text("precious")
    fails(run("distance", path, "--source", 0, "--output", path), 2, "would overwrite the input")
    assert path.read_text() == "precious"


def test_a_graph_has_nothing_to_draw(graph, tmp_path):
    fails(run("distance", graph, "--source", 0, "--output", tmp_path / "d.ply"), 2, "no positions")


@pytest.mark.parametrize("command", ["distance", "doctor"])
def test_a_missing_file_is_wrong_usage(command, tmp_path):
    options = ["--source", "0"] if command == "distance" else []
    fails(run(command, tmp_path / "nope.off", *options), 2, "nope.off", "does not exist")


def test_a_directory_is_no_input(tmp_path):
    fails(run("distance", tmp_path, "--source", "0"), 2, "directory")


def test_an_unknown_command_is_wrong_usage():
    fails(run("distnce"), 2, "distance")


def test_no_command_is_wrong_usage_and_shows_the_help():
    result = run()
    assert result.exit_code == 2
    assert result.stdout == ""
    assert "Usage: geodesic-toolkit" in result.stderr


def test_a_picture_without_the_package_that_draws_it_is_refused_before_the_work(
    sphere, tmp_path, monkeypatch
):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    output = tmp_path / "d.npy"
    result = run(
        "distance", sphere, "--source", 0, "--output", output, "--picture", tmp_path / "d.png"
    )
    fails(result, 2, "pyvista", "geodesic-toolkit[viz]")
    assert not output.exists()


# -- exit statuses 3, 4 and 130 ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "content", "word"),
    [
        ("garbage.off", "no mesh at all", "garbage.off"),
        ("empty.ply", "", "empty"),
        ("strange.xxx", "x", "no reader for .xxx"),
        ("hole.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "vertex 7"),
        ("nan.off", "OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n", "vertex 1 is not finite"),
    ],
)
@pytest.mark.parametrize("command", ["distance", "doctor"])
def test_bad_input_is_status_3(command, name, content, word, tmp_path):
    path = tmp_path / name
    path.write_text(content)
    options = ["--source", "0"] if command == "distance" else []
    fails(run(command, path, *options), 3, word)


def test_a_shape_that_the_operator_does_not_take_is_status_3(graph):
    fails(run("distance", graph, "--source", 0, "--operator", "cotan"), 3, "not Graph")


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (errors.SolverError("the matrix is singular"), ["error: the matrix is singular"]),
        (errors.NotEnoughMemoryError("needs 90 GB"), ["error: needs 90 GB"]),
        (errors.InvalidDiscretizationError("not symmetric"), ["error: not symmetric"]),
        (MemoryError(), ["error: not enough memory"]),
        (RuntimeError("a\nb"), ["unexpected RuntimeError: a b", "report", "DEBUG=1"]),
    ],
)
def test_a_failing_solver_is_status_4(sphere, failing, error, words):
    failing(error)
    fails(run("distance", sphere, "--source", 0, "--solver", "failing"), 4, *words)


def test_the_traceback_is_shown_where_it_is_asked_for(sphere, failing):
    failing(RuntimeError("odd"))
    arguments = ("distance", sphere, "--source", 0, "--solver", "failing")
    result = run(*arguments, env={"GEODESIC_TOOLKIT_DEBUG": "1"})
    assert result.exit_code == 4
    assert "Traceback" in result.stderr
    assert "in factorize" in result.stderr


def test_an_endless_message_is_cut(sphere, failing):
    failing(errors.SolverError("x" * 10_000))
    result = run("distance", sphere, "--source", 0, "--solver", "failing")
    fails(result, 4, "…")
    assert len(result.stderr) < 1000


def test_ctrl_c_is_status_130(sphere, failing):
    failing(KeyboardInterrupt())
    fails(run("distance", sphere, "--source", 0, "--solver", "failing"), 130, "interrupted")


@pytest.mark.skipif(os.name != "posix", reason="sends a POSIX signal")
def test_ctrl_c_ends_a_computation_that_python_cannot_interrupt():
    program = (
        "import hashlib\n"
        "from geodesic_toolkit.cli import interrupts\n"
        "interrupts.GRACE = 0.1\n"
        "with interrupts.prompt_interrupts():\n"
        "    print('ready', flush=True)\n"
        "    hashlib.pbkdf2_hmac('sha256', b'', b'', 2**31 - 1)\n"  # an hour of one instruction
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.2)  # until it is in the midst of it
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert said == "interrupted\n"


STATUSES = {
    errors.ConformanceError: 4,
    errors.InvalidDiscretizationError: 4,
    errors.InvalidDomainError: 3,
    errors.InvalidOptionError: 2,
    errors.InvalidSourceError: 2,
    errors.MissingDependencyError: 2,
    errors.NotEnoughMemoryError: 4,
    errors.PluginConflictError: 2,
    errors.PluginLoadError: 2,
    errors.ReadError: 3,
    errors.SolverError: 4,
    errors.UnknownPluginError: 2,
    errors.UnsupportedDomainError: 3,
    errors.WriteError: 2,
}


@pytest.mark.parametrize("kind", STATUSES)
def test_each_error_has_its_exit_status(kind):
    assert exits.exit_status(kind("why")) == STATUSES[kind]


# -- plugins -------------------------------------------------------------------------------------


def test_plugins_lists_the_core_s_own():
    result = run("plugins")
    assert result.exit_code == 0
    for name in ("cotan", "uniform", "superlu", "cg", "off", "ply"):
        assert name in result.stdout.split()
    assert "doi:10.1080/10586458.1993.10504266" in result.stdout


def test_plugins_shows_broken_ones(tmp_path):
    information = tmp_path / "halfbaked-1.2.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: halfbaked\nVersion: 1.2\n")
    (information / "entry_points.txt").write_text(
        "[geodesic_toolkit.operators]\nraw = halfbaked.nowhere:Operator\n"
    )
    listing = run_process("plugins", PYTHONPATH=str(tmp_path))
    assert listing.returncode == 0
    assert "halfbaked.nowhere" in listing.stdout
    rows = json.loads(run_process("plugins", "--json", PYTHONPATH=str(tmp_path)).stdout)["plugins"]
    broken = [row for row in rows if row["state"] == "error"]
    assert [(row["kind"], row["name"], row["version"]) for row in broken] == [
        ("operator", "raw", "1.2")
    ]
    assert "No module named 'halfbaked'" in broken[0]["error"]
    assert {row["kind"] for row in rows} == {"operator", "solver", "reader"}


def test_distance_refines_where_it_is_told_to(sphere):
    plain = json.loads(run("distance", sphere, "--source", 3, "--json").stdout)
    refined = json.loads(run("distance", sphere, "--source", 3, "--refine", "--json").stdout)
    assert (plain["refine"], refined["refine"]) == (False, True)
    exact = gt.exact_distance(shapes.icosphere(2), 3).max()
    assert abs(refined["max"] - exact) < abs(plain["max"] - exact)
    assert refined["max"] == pytest.approx(
        gt.geodesic_distance(shapes.icosphere(2), 3, refine=True).max()
    )
    assert "refined" in run("distance", sphere, "--source", 3, "--refine").stdout


# -- doctor --------------------------------------------------------------------------------------


def test_doctor_says_what_a_shape_is_like(tmp_path):
    two = shapes.disjoint_union(shapes.grid(5), shapes.icosphere(1))
    path = write_off(tmp_path / "two.off", two)
    result = run("doctor", path)
    assert result.exit_code == 0
    assert "2 components" in result.stdout
    assert "16 vertices lie on a boundary" in result.stdout
    report = json.loads(run("doctor", path, "--json").stdout)
    assert report["diagnosis"]["components"] == 2
    assert len(report["recommendations"]) == 2


def test_doctor_finds_nothing_on_a_sphere(sphere):
    assert "Nothing stands out" in run("doctor", sphere).stdout


def test_doctor_advises_what_the_mesh_allows(tmp_path):
    sliver = gt.TriangleMesh([[0, 0, 0], [1, 0, 0], [0.5, 0.001, 0]], [[0, 1, 2]])
    result = run("doctor", write_off(tmp_path / "sliver.off", sliver))
    assert "intrinsic_delaunay=True" in result.stdout
    fins = gt.TriangleMesh(
        [[0, 0, 0], [1, 0, 0], [0.5, 0.001, 0], [0.5, 0, 1], [0.5, 0, -1]],
        [[0, 1, 2], [0, 1, 3], [0, 1, 4]],
    )
    result = run("doctor", write_off(tmp_path / "fins.off", fins))
    assert "1 edges have more than two faces" in result.stdout
    assert "intrinsic_delaunay=True" not in result.stdout


def test_doctor_examines_the_installation(monkeypatch):
    monkeypatch.setattr(
        doctor,
        "probe_all",
        lambda: {
            "open3d": probes.Probe(False, "libusb is missing"),
            "pictures": probes.Probe(True, "9 bytes"),
            "pages": probes.Probe(True, "9 bytes"),
        },
    )
    result = run("doctor")
    assert result.exit_code == 0
    assert f"numpy {metadata.version('numpy')}" in " ".join(result.stdout.split())
    assert "problem: open3d: libusb is missing" in result.stdout
    report = json.loads(run("doctor", "--json").stdout)
    assert report["open3d"] == {"works": False, "detail": "libusb is missing"}
    assert report["problems"] == ["open3d: libusb is missing"]
    packages = {row["package"]: row for row in report["packages"]}
    assert packages["numpy"]["version"] == np.__version__
    assert "pytest" not in packages


def test_a_probe_survives_what_kills_its_process(monkeypatch):
    missing = "libusb-1.0.so.0: cannot open shared object file: No such file or directory"
    monkeypatch.setattr(
        probes,
        "PROGRAMS",
        {
            "fine": "print(1); print(2)",
            "abort": "import os; os.abort()",
            "library": f"raise ImportError({missing!r})",
        },
    )
    found = probes.probe_all()
    assert found["fine"] == probes.Probe(True, "2")
    assert not found["abort"].works
    assert "apt-get install libusb-1.0-0" in found["library"].detail


def test_a_probe_does_not_wait_for_ever(monkeypatch):
    monkeypatch.setattr(probes, "PATIENCE", 0.1)
    monkeypatch.setattr(probes, "PROGRAMS", {"endless": "import time; time.sleep(100)"})
    assert probes.probe_all() == {"endless": probes.Probe(False, "no answer in 0.1 s")}


@pytest.mark.parametrize(("name", "package"), [("pictures", "pyvista"), ("pages", "k3d")])
def test_what_a_probe_tries_works_where_the_package_does(name, package, capsys):
    pytest.importorskip(package)
    exec(probes.PROGRAMS[name])
    assert capsys.readouterr().out.endswith(" bytes\n")


# -- demo ----------------------------------------------------------------------------------------


def test_demo_writes_numbers_a_picture_and_a_page(tmp_path):
    pytest.importorskip("pyvista")
    pytest.importorskip("k3d")
    out = tmp_path / "new" / "folder"
    result = run("demo", "--out", out)
    assert result.exit_code == 0, result.output
    assert {path.name for path in out.iterdir()} == {
        "knot.ply",
        "knot.csv",
        "knot.png",
        "knot.html",
    }
    assert "against the exact arc length" in result.stdout
    assert "geodesic-toolkit distance YOUR_MESH.ply" in result.stdout
    assert result.stderr == ""


def test_demo_writes_the_numbers_where_nothing_can_be_drawn(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    monkeypatch.setitem(sys.modules, "k3d", None)
    result = run("demo", "--out", tmp_path)
    assert result.exit_code == 0
    assert {path.name for path in tmp_path.iterdir()} == {"knot.ply", "knot.csv"}
    assert "warning: " in result.stderr
    assert "geodesic-toolkit[viz]" in result.stderr


def test_demo_refuses_a_folder_that_cannot_be(tmp_path):
    (tmp_path / "file").write_text("")
    fails(run("demo", "--out", tmp_path / "file" / "folder"), 2, "cannot be made")


# -- pictures ------------------------------------------------------------------------------------


def test_distance_draws_a_picture_and_a_page(sphere, tmp_path):
    pytest.importorskip("pyvista")
    pytest.importorskip("k3d")
    picture, page = tmp_path / "d.png", tmp_path / "d.html"
    options = ["--picture", picture, "--html", page, "--cmap", "brg"]
    result = run("distance", sphere, "--source", "0,0,2", *options, "--json")
    assert result.exit_code == 0, result.output
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert "<html" in page.read_text(encoding="utf-8").lower()
    assert json.loads(result.stdout)["outputs"] == [str(picture), str(page)]


# -- progress ------------------------------------------------------------------------------------


def test_progress_off_a_terminal_is_a_plain_line_now_and_then(monkeypatch, capsys):
    monkeypatch.setattr(progress, "FIRST_PLAIN_LINE", 0.05)
    with progress.Progress() as shown, shown.step("thinking"):
        time.sleep(0.3)
    lines = capsys.readouterr().err.splitlines()
    assert 1 <= len(lines) <= 5
    assert lines[0] == "still working: thinking (0 s)"


def test_quick_work_shows_no_progress(capsys):
    with progress.Progress() as shown, shown.step("thinking"):
        shown.advance(1, 2)
    assert capsys.readouterr().err == ""
    assert list(shown.timings) == ["thinking"]


@pytest.mark.skipif(os.name != "posix", reason="needs a pseudo-terminal")
def test_progress_on_a_terminal_is_a_line_that_goes_again():
    import pty

    program = (
        "import time\n"
        "from geodesic_toolkit.cli import progress\n"
        "progress.SILENCE = 0.05\n"
        "with progress.Progress() as shown, shown.step('thinking'):\n"
        "    shown.advance(3, 7)\n"
        "    time.sleep(1)\n"
        "    shown.say('warning: [bold] as it is')\n"
        "    time.sleep(0.3)\n"
    )
    ours, theirs = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "80"}
    with subprocess.Popen(
        [sys.executable, "-c", program], stderr=theirs, env=environment
    ) as process:
        os.close(theirs)
        said = b""
        while True:
            try:
                piece = os.read(ours, 4096)
            except OSError:  # how Linux says that the other end has closed
                break
            if not piece:
                break
            said += piece
    os.close(ours)
    assert process.returncode == 0
    assert b"thinking: 3 of 7 (" in said
    assert b"warning: [bold] as it is" in said
    assert said.endswith((b"\x1b[?25h", b"\x1b[2K"))  # the line is wiped and the cursor is back


# -- the program as a person starts it -----------------------------------------------------------


def test_the_program_runs_end_to_end(sphere, tmp_path):
    output = tmp_path / "d.npy"
    done = run_process("distance", sphere, "--source", 3, "--output", output, "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["reached"] == 162
    assert "warning" not in done.stderr
    assert np.load(output).shape == (162,)


def test_errors_leave_the_process_with_their_status(sphere):
    done = run_process("distance", sphere, "--source", 162)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1


@pytest.mark.skipif(sys.platform != "linux", reason="needs file names that are any bytes")
def test_a_file_name_that_is_no_text_does_no_harm(sphere, tmp_path):
    odd = os.fsdecode(b"\xff\xe9.off")
    sphere.rename(tmp_path / odd)
    done = run_process("distance", tmp_path / odd, "--source", 3, "--json")
    assert json.loads(done.stdout)["input"].endswith(odd)
    done = run_process(
        "distance", tmp_path / odd, "--source", 3, "--output", f"{tmp_path}/{odd}.npy"
    )
    assert "\\udcff\\udce9.off.npy" in done.stdout


def test_the_version_is_that_of_the_package():
    done = run_process("--version")
    assert done.stdout == f"geodesic-toolkit {gt.__version__}\n"


@pytest.mark.parametrize("option", ["--help", "-h"])
@pytest.mark.parametrize(
    "command", [[], ["demo"], ["distance"], ["compare"], ["plugins"], ["doctor"]]
)
def test_every_command_explains_itself(command, option):
    result = run(*command, option)
    assert result.exit_code == 0
    assert result.stdout.startswith("Usage: geodesic-toolkit")


def test_help_imports_nothing_heavy():
    program = (
        "import sys\n"
        "import geodesic_toolkit.cli\n"
        "print([name for name in ('numpy', 'scipy', 'rich') if name in sys.modules])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"


def test_the_entry_point_is_the_program():
    (point,) = metadata.entry_points(group="console_scripts", name="geodesic-toolkit")
    assert point.value == "geodesic_toolkit.cli:main"
    assert callable(point.load())
