"""The command ``matrix``: its files, interrupts and resumed runs, and its exit statuses."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import command_line
import numpy as np
import pytest
from command_line import fails
from sample_files import write_off
from scipy.sparse import load_npz

import geodesic_toolkit as gt
from geodesic_toolkit import errors
from geodesic_toolkit.analysis.matrix import matrix as matrix_module
from geodesic_toolkit.analysis.matrix import stores
from geodesic_toolkit.cli import interrupts
from geodesic_toolkit.cli.matrix import _children_that_ignore_interrupts, _processes
from geodesic_toolkit.io import read_vertices
from geodesic_toolkit.testing import shapes

run = partial(command_line.run, "matrix")


@pytest.fixture
def solver(sphere_file):
    return gt.GeodesicSolver(gt.read(sphere_file))


@pytest.fixture
def interrupted_after(monkeypatch):
    """The function that has Ctrl-C come once so many rows are written; and that lets it be."""
    usual = stores.DenseFile.put

    def interrupt_after(rows):
        def put(self, task, found):
            usual(self, task, found)
            if rows is not None and task.stop >= rows:
                raise KeyboardInterrupt

        monkeypatch.setattr(stores.DenseFile, "put", put)

    return interrupt_after


# -- results ---------------------------------------------------------------------------------------


def test_all_vertices_make_a_square_matrix(sphere_file, solver, tmp_path):
    result = run(sphere_file, "--output", tmp_path / "D.npy")
    assert result.exit_code == 0, result.output
    assert result.stderr == ""
    assert "162 x 162, float64" in result.stdout
    assert "every vertex" in result.stdout
    np.testing.assert_array_equal(np.load(tmp_path / "D.npy"), gt.distance_matrix(solver))


def test_float32_goes_to_a_zarr_store(sphere_file, solver, tmp_path):
    zarr = pytest.importorskip("zarr")
    result = run(sphere_file, "--output", tmp_path / "D.zarr", "--float32", "--symmetrize", "none")
    assert result.exit_code == 0, result.output
    store = zarr.open_array(tmp_path / "D.zarr", mode="r")
    expected = gt.distance_matrix(solver, dtype="float32", symmetrize=None)
    np.testing.assert_array_equal(store[:], expected)


@pytest.mark.parametrize("name", ["rows.txt", "rows.csv", "rows.npy"])
def test_sources_come_from_a_file(sphere_file, solver, tmp_path, name):
    sources = tmp_path / name
    if name.endswith(".npy"):
        np.save(sources, np.array([5, 7, 100]))
    else:
        sources.write_text("vertex\n5\n7\n100\n" if name.endswith(".csv") else "5 7 # two\n100\n")
    result = run(sphere_file, "--sources", sources, "--output", tmp_path / "D.npy", "--json")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert found["sources"] == [5, 7, 100]
    assert found["shape"] == [3, 162]
    assert found["dtype"] == "float64"
    assert found["outputs"] == [str(tmp_path / "D.npy")]
    assert found["warnings"] == []
    np.testing.assert_array_equal(np.load(tmp_path / "D.npy"), solver.distances([5, 7, 100]))


def test_landmarks_are_spread_over_the_shape(sphere_file, solver, tmp_path):
    result = run(sphere_file, "--landmarks", 10, "--output", tmp_path / "D.npy", "--json")
    assert result.exit_code == 0, result.output
    landmarks = gt.farthest_point_sampling(solver, 10)
    assert json.loads(result.stdout)["sources"] == landmarks.tolist()
    np.testing.assert_array_equal(np.load(tmp_path / "D.npy"), solver.distances(landmarks))
    shown = run(sphere_file, "--landmarks", 10, "--output", tmp_path / "D.npy").stdout
    assert "and 2 more (--json lists them)" in shown


def test_max_distance_makes_a_sparse_file(sphere_file, solver, tmp_path):
    result = run(sphere_file, "--max-distance", 0.5, "--output", tmp_path / "D.npz")
    assert result.exit_code == 0, result.output
    expected = gt.distance_matrix(solver, max_distance=0.5)
    found = load_npz(tmp_path / "D.npz")
    assert found.nnz == expected.nnz
    assert f"{expected.nnz} entries" in result.stdout
    np.testing.assert_array_equal(found.toarray(), expected.toarray())


def test_options_reach_the_solver(sphere_file, tmp_path):
    mask = tmp_path / "mask.txt"
    mask.write_text("3 4 5")
    options = ["--operator", "cotan", "--solver", "superlu", "--refine", "--mask", mask]
    result = run(sphere_file, *options, "--output", tmp_path / "D.npy")
    assert result.exit_code == 0, result.output
    assert "refined" in result.stdout
    masked = np.isin(np.arange(162), [3, 4, 5])
    solver = gt.GeodesicSolver(
        gt.read(sphere_file), operator="cotan", solver="superlu", refine=True, mask=masked
    )
    np.testing.assert_array_equal(np.load(tmp_path / "D.npy"), gt.distance_matrix(solver))


@pytest.mark.slow
def test_workers_write_the_same_bytes(sphere_file, tmp_path):
    for count in (1, 2):
        result = run(sphere_file, "--workers", count, "--output", tmp_path / f"D{count}.npy")
        assert result.exit_code == 0, result.output
    assert (tmp_path / "D1.npy").read_bytes() == (tmp_path / "D2.npy").read_bytes()


# -- interrupted and resumed -----------------------------------------------------------------------


def test_an_interrupted_run_says_how_it_goes_on_and_does(sphere_file, tmp_path, interrupted_after):
    run(sphere_file, "--output", tmp_path / "whole.npy")
    interrupted_after(80)
    output = tmp_path / "D.npy"
    result = run(sphere_file, "--output", output)
    assert result.exit_code == 130
    assert f"note: {output}.partial holds the rows so far; the same command" in result.stderr
    assert result.stderr.splitlines()[-1] == "interrupted"
    assert not output.exists()
    interrupted_after(None)
    assert run(sphere_file, "--output", output).exit_code == 0
    assert output.read_bytes() == (tmp_path / "whole.npy").read_bytes()
    assert not (tmp_path / "D.npy.partial").exists()


def test_another_command_does_not_resume_but_may_start_again(
    sphere_file, tmp_path, interrupted_after
):
    output = tmp_path / "D.npy"
    interrupted_after(80)
    run(sphere_file, "--output", output)
    interrupted_after(None)
    fails(run(sphere_file, "--no-refine", "--output", output), 2, "refine was True", "--restart")
    result = run(sphere_file, "--no-refine", "--restart", "--output", output)
    assert result.exit_code == 0, result.output
    plain = gt.GeodesicSolver(gt.read(sphere_file), refine=False)
    np.testing.assert_array_equal(np.load(output), gt.distance_matrix(plain))


def test_an_interrupt_before_there_are_rows_promises_nothing(sphere_file, tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(matrix_module, "distance_matrix", interrupted)
    fails(run(sphere_file, "--output", tmp_path / "D.npy"), 130, "interrupted")


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="needs process groups")
@pytest.mark.parametrize("workers", [1, 2])
def test_ctrl_c_in_a_terminal_ends_all_processes_and_the_run_can_be_resumed(tmp_path, workers):
    mesh = write_off(tmp_path / "mesh.off", shapes.icosphere(4))
    sources = tmp_path / "sources.npy"
    np.save(sources, np.arange(320))
    output, done = tmp_path / "D.npy", tmp_path / "D.npy.partial" / "done"
    command = [sys.executable, "-m", "geodesic_toolkit", "matrix", mesh, "--sources", sources]
    command = [*map(str, command), "--output", str(output), "--workers", str(workers)]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    while process.poll() is None and not (done.exists() and 1 in done.read_bytes()):
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGINT)  # all processes get it, as from a terminal
    stdout, stderr = process.communicate()
    assert process.returncode == 130, stderr
    assert stdout == ""
    assert "Traceback" not in stderr
    assert "holds the rows so far" in stderr
    assert process_group_ends(process.pid)
    assert 0 < sum(done.read_bytes()) < len(done.read_bytes())
    subprocess.run(command, check=True, capture_output=True)
    whole = tmp_path / "whole.npy"
    command[command.index(str(output))] = str(whole)
    subprocess.run(command, check=True, capture_output=True)
    np.testing.assert_array_equal(np.load(output), np.load(whole))


def process_group_ends(group):
    """Return whether no process of a group is left, within a while."""
    for _ in range(1000):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.01)
    return False


def test_the_end_of_the_program_finds_no_thread_of_a_pool_that_was_interrupted():
    """It would wake the thread, and fail where that ends just then."""
    usual = threading.excepthook
    before = set(threading.enumerate())

    def interrupted():
        with _processes(2) as pool:
            pool.submit(int).result()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert set(threading.enumerate()) <= before
    assert threading.excepthook is usual


def test_interrupts_are_ignored_while_processes_start_and_only_in_the_main_thread():
    usual = signal.getsignal(signal.SIGINT)
    with _children_that_ignore_interrupts():
        assert signal.getsignal(signal.SIGINT) == signal.SIG_IGN
    assert signal.getsignal(signal.SIGINT) == usual

    def elsewhere():
        with _children_that_ignore_interrupts():
            return signal.getsignal(signal.SIGINT)

    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(elsewhere).result() == usual


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="needs signals")
def test_where_the_interrupt_does_not_come_through_the_last_words_are_said():
    program = (
        "import os, signal, threading, time\n"
        "from geodesic_toolkit.cli.interrupts import last_words, prompt_interrupts\n"
        "signal.signal(signal.SIGINT, lambda *_: None)  # as if compiled code went on\n"
        "threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
        "with prompt_interrupts(), last_words('note: not all is lost'):\n"
        "    time.sleep(30)\n"
    )
    result = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert result.returncode == 130
    assert result.stderr.splitlines()[-2:] == ["note: not all is lost", "interrupted"]


def test_last_words_are_for_their_block_only():
    with interrupts.last_words("something"):
        assert interrupts._last_words == ["something"]
    assert interrupts._last_words == []


# -- how it ends otherwise -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "status", "words"),
    [
        (["--output", "D.txt"], 2, ["D.txt", "cannot write .txt"]),
        (["--output", "D.npz"], 2, ["give max_distance"]),
        (["--output", "D.npy", "--max-distance", "1"], 2, ["write a .npz"]),
        (["--output", "D.npz", "--max-distance", "-1"], 2, ["not -1"]),
        (["--output", "no/folder/D.npy"], 2, ["no directory"]),
        (["--output", "D.npy", "--sources", "rows.txt", "--landmarks", "3"], 2, ["not both"]),
        (["--output", "D.npy", "--sources", "none.txt"], 2, ["none.txt"]),
        (["--output", "D.npy", "--sources", "far.txt"], 2, ["vertex 162"]),
        (["--output", "D.npy", "--sources", "words.txt"], 3, ["words.txt", "vertex indices"]),
        (["--output", "D.npy", "--sources", "sphere.off"], 3, [".npy, .txt, .csv"]),
        (["--output", "rows.npy", "--sources", "rows.npy"], 2, ["overwrite"]),
        (["--output", "D.npy", "--landmarks", "163"], 2, ["between 1 and the 162"]),
        (["--output", "D.npy", "--landmarks", "0"], 2, ["--landmarks"]),
        (["--output", "D.npy", "--workers", "0"], 2, ["--workers"]),
        (["--output", "D.npy", "--operator", "cotann"], 2, ["cotann"]),
        (["--output", "D.npy", "--solver", "none"], 2, ["none"]),
        (["--output", "D.npy", "--symmetrize", "median"], 2, ["median"]),
        ([], 2, ["--output"]),
    ],
)
def test_what_is_wrong_is_said_in_a_line(
    sphere_file, tmp_path, monkeypatch, options, status, words
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rows.txt").write_text("1 2 3")
    (tmp_path / "far.txt").write_text("1 162")
    (tmp_path / "words.txt").write_text("1 two")
    np.save(tmp_path / "rows.npy", [1, 2])
    fails(run(sphere_file, *options), status, *words)
    assert not list(tmp_path.glob("*.partial"))


def test_a_worker_that_dies_is_a_failure_that_says_so(sphere_file, tmp_path, monkeypatch):
    def dead(*_, **__):
        raise errors.SolverError("executor: a worker ended abruptly (it is gone)")

    monkeypatch.setattr(matrix_module, "distance_matrix", dead)
    result = run(sphere_file, "--output", tmp_path / "D.npy", "--workers", 2)
    fails(result, 4, "ended abruptly")


def test_a_result_names_at_most_some_of_its_sources(sphere_file, tmp_path):
    for count, text in ((8, "vertices 0, 1, 2, 3, 4, 5, 6, 7\n"), (9, "7 and 1 more (--json")):
        np.save(tmp_path / "rows.npy", np.arange(count))
        options = ("--output", tmp_path / "D.npy", "--sources", tmp_path / "rows.npy", "--restart")
        assert text in run(sphere_file, *options).stdout


# -- the file of vertices --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("v.txt", b"", "is empty"),
        ("v.txt", b"# only a comment\n", "no numbers"),
        ("v.txt", b"1 2.5\n", "must be whole numbers .found 2.5"),
        ("v.csv", b"node,x\n1,0.5\n", "no column is 'vertex'; there are node, x"),
        ("v.txt", b"1\x002", "binary"),
        ("v.npy", b"no array", "v.npy"),
        ("v.dat", b"1 2", r"\.npy, \.txt, \.csv"),
    ],
)
def test_a_file_that_holds_no_vertices_is_refused(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(errors.ReadError, match=message):
        read_vertices(tmp_path / name)


@pytest.mark.parametrize(
    "array", [np.zeros((2, 2), dtype=int), np.array([]), np.array([True]), np.array([0.5])]
)
def test_an_array_that_holds_no_vertices_is_refused(tmp_path, array):
    np.save(tmp_path / "v.npy", array)
    with pytest.raises(errors.ReadError, match=r"v\.npy"):
        read_vertices(tmp_path / "v.npy")


def test_an_archive_of_vertices_is_refused(tmp_path):
    with (tmp_path / "v.npy").open("wb") as file:
        np.savez(file, a=np.arange(3))
    with pytest.raises(errors.ReadError, match="archive"):
        read_vertices(tmp_path / "v.npy")


def test_a_file_of_vertices_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(errors.ReadError, match="none"):
        read_vertices(tmp_path / "none.npy")


def test_whole_floats_are_vertices(tmp_path):
    np.save(tmp_path / "v.npy", np.array([3.0, 5.0]))
    np.testing.assert_array_equal(read_vertices(tmp_path / "v.npy"), [3, 5])
