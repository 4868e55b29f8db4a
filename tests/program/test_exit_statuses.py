"""Exit statuses: each failure has its own, and one short, clear line."""

import os
import signal
import subprocess
import sys
from dataclasses import dataclass
from typing import ClassVar

import pytest
from command_line import fails, run, run_process
from scipy.sparse import csr_array

import geodesic_toolkit as gt
from geodesic_toolkit import errors
from geodesic_toolkit.cli import exits

# -- exit status 2 -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "source", ["x", "1.5", "1,2", "1,2,3,4", "1,2,x", "nan,0,0", "inf,0,0", "", ",,"]
)
def test_a_source_that_is_not_a_place_is_wrong_usage(sphere_file, source):
    fails(run("distance", sphere_file, "--source", source), 2, "--source")


def test_vertices_and_points_do_not_mix(sphere_file):
    fails(run("distance", sphere_file, "--source", 1, "--source", "0,0,1"), 2, "all of one kind")


@pytest.mark.parametrize("vertex", [162, -1, 2**63, 10**30])
def test_a_source_out_of_range_is_wrong_usage(sphere_file, vertex):
    fails(run("distance", sphere_file, "--source", vertex), 2, f"vertex {vertex} does not exist")


def test_a_name_that_is_too_long_is_wrong_usage(sphere_file):
    name = 300 * "y"
    fails(run("distance", name, "--source", 0), 2, "does not exist")
    fails(run("distance", sphere_file, "--source", name), 2, "neither a vertex index")
    fails(run("distance", sphere_file, "--source", 0, "--mask", f"{name}:wall"), 2, "not exist")


def test_a_point_on_a_graph_is_wrong_usage(graph_file):
    fails(run("distance", graph_file, "--source", "0,0,0"), 2, "no positions")


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
        (["--source", "0", "--output", "d.dat"], [".ply, .pcd, .las, .laz, .vtp"]),
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


def test_an_unknown_colour_map_is_wrong_usage(sphere_file):
    pytest.importorskip("matplotlib")
    fails(run("distance", sphere_file, "--source", 0, "--cmap", "virdis"), 2, "virdis")


def test_the_input_is_not_overwritten(tmp_path):
    path = tmp_path / "cloud.ply"
    path.write_text("precious")
    fails(run("distance", path, "--source", 0, "--output", path), 2, "would overwrite the input")
    assert path.read_text() == "precious"


def test_a_graph_has_nothing_to_draw(graph_file, tmp_path):
    fails(
        run("distance", graph_file, "--source", 0, "--output", tmp_path / "d.ply"),
        2,
        "no positions",
    )


@pytest.mark.parametrize("command", ["distance", "doctor"])
def test_a_missing_file_is_wrong_usage(command, tmp_path):
    options = ["--source", "0"] if command == "distance" else []
    fails(run(command, tmp_path / "nope.off", *options), 2, "nope.off", "does not exist")


def test_a_directory_is_not_an_input(tmp_path):
    fails(run("distance", tmp_path, "--source", "0"), 2, "directory")


def test_an_unknown_command_is_wrong_usage():
    fails(run("distnce"), 2, "distance")


def test_no_command_is_wrong_usage_and_shows_the_help():
    result = run()
    assert result.exit_code == 2
    assert result.stdout == ""
    assert "Usage: geodesic-toolkit" in result.stderr


def test_a_picture_without_the_package_that_draws_it_is_refused_before_the_work(
    sphere_file, tmp_path, monkeypatch
):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    output = tmp_path / "d.npy"
    result = run(
        "distance", sphere_file, "--source", 0, "--output", output, "--picture", tmp_path / "d.png"
    )
    fails(result, 2, "pyvista", "geodesic-toolkit[viz]")
    assert not output.exists()


# -- exit statuses 3, 4 and 130 ------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Failing(gt.LinearSolver):
    """A solver that raises the exception that it was given."""

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


def test_a_shape_that_the_operator_does_not_take_is_status_3(graph_file):
    fails(run("distance", graph_file, "--source", 0, "--operator", "cotan"), 3, "not Graph")


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
def test_a_failing_solver_is_status_4(sphere_file, failing, error, words):
    failing(error)
    fails(run("distance", sphere_file, "--source", 0, "--solver", "failing"), 4, *words)


def test_the_traceback_is_shown_where_it_is_asked_for(sphere_file, failing):
    failing(RuntimeError("odd"))
    arguments = ("distance", sphere_file, "--source", 0, "--solver", "failing")
    result = run(*arguments, env={"GEODESIC_TOOLKIT_DEBUG": "1"})
    assert result.exit_code == 4
    assert "Traceback" in result.stderr
    assert "in factorize" in result.stderr


def test_an_endless_message_is_cut(sphere_file, failing):
    failing(errors.SolverError("x" * 10_000))
    result = run("distance", sphere_file, "--source", 0, "--solver", "failing")
    fails(result, 4, "…")
    assert len(result.stderr) < 1000


def test_ctrl_c_is_status_130(sphere_file, failing):
    failing(KeyboardInterrupt())
    fails(run("distance", sphere_file, "--source", 0, "--solver", "failing"), 130, "interrupted")


@pytest.mark.skipif(os.name != "posix", reason="sends a POSIX signal")
def test_ctrl_c_ends_a_computation_that_python_cannot_interrupt():
    program = (
        "import hashlib, sys, threading\n"
        "from geodesic_toolkit.cli import interrupts\n"
        "interrupts.GRACE_PERIOD = 0.1\n"
        "sys.setswitchinterval(1000)  # another thread runs when this one is in compiled code\n"
        "begun = threading.Event()\n"
        "def announce():\n"
        "    begun.wait()\n"
        "    print('ready', flush=True)\n"
        "threading.Thread(target=announce).start()\n"
        "with interrupts.prompt_interrupts():\n"
        "    begun.set()\n"
        "    hashlib.pbkdf2_hmac('sha256', b'', b'', 2**31 - 1)\n"  # an hour of one instruction
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert said == "interrupted\n"


# -- of errors and processes ---------------------------------------------------------------------


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


@pytest.mark.slow
@pytest.mark.parametrize("kind", STATUSES)
def test_each_error_has_its_exit_status(kind):
    assert exits.exit_status(kind("why")) == STATUSES[kind]


def test_errors_leave_the_process_with_their_status(sphere_file):
    done = run_process("distance", sphere_file, "--source", 162)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1


@dataclass(frozen=True, kw_only=True)
class Helping(gt.LinearSolver):
    """A solver in a process that only helps another one."""

    componentwise: ClassVar[bool] = True

    def leads(self):
        return False

    def factorize(self, matrix):
        raise AssertionError("a helping process does not run the program")


@pytest.mark.parametrize("command", ["distance", "matrix"])
def test_a_process_that_does_not_lead_ends_without_a_word(command, sphere_file, tmp_path, register):
    register(gt.solvers, "helping", Helping)
    output = tmp_path / "written.npy"
    sources = ["--source", 0] if command == "distance" else []
    result = run(command, sphere_file, *sources, "--output", output, "--solver", "helping")
    assert (result.exit_code, result.stdout, result.stderr) == (0, "", "")
    assert not output.exists()
