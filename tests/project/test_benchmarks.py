"""The benchmarks run, and their own arithmetic is right; their figures are not checked."""

import importlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import geodesic_toolkit as gt

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"

if not BENCHMARKS.exists():
    pytest.skip("a source distribution has no benchmarks", allow_module_level=True)


@pytest.fixture
def module(monkeypatch):
    """The function that imports a module of the benchmarks."""
    monkeypatch.syspath_prepend(BENCHMARKS)
    return importlib.import_module


def run_script(name, *options, status=0):
    finished = subprocess.run(
        [sys.executable, str(BENCHMARKS / name), *options],
        env=dict(os.environ),
        capture_output=True,
        text=True,
        check=False,
    )
    assert finished.returncode == status, finished.stderr + finished.stdout
    return finished.stdout


@pytest.mark.parametrize("n_vertices", [12, 42, 92, 3500])
def test_a_sphere_of_about_any_size_is_closed_and_has_antipodes(module, n_vertices):
    vertices, faces = module("measuring.shapes").sphere(n_vertices)
    assert len(vertices) == pytest.approx(n_vertices, rel=0.1)
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    assert len(vertices) - len(edges) + len(faces) == 2
    assert (np.bincount(faces.ravel(), minlength=len(vertices)) >= 5).all()
    assert np.linalg.norm(vertices, axis=1) == pytest.approx(1.0)
    assert (vertices @ vertices[0]).min() == pytest.approx(-1.0)
    assert (np.linalg.det(vertices[faces]) > 0).all()  # counterclockwise from outside


@pytest.mark.parametrize(("size", "count"), [("642", 642), ("3.5k", 3500), ("5M", 5_000_000)])
def test_a_size_is_a_number_of_vertices(module, size, count):
    assert module("measuring.shapes").count(size) == count


def test_vertices_of_no_face_are_left_out(module):
    vertices = np.arange(15.0).reshape(5, 3)
    kept, faces = module("measuring.shapes").referenced(vertices, np.array([[4, 0, 2]]))
    assert kept.tolist() == vertices[[0, 2, 4]].tolist()
    assert faces.tolist() == [[2, 0, 1]]


def test_an_exponent_is_that_of_the_power_law_without_failed_sizes(module):
    rows = [{"vertices": n, "build": {"cpu": 3e-6 * n**1.2}} for n in (10, 100, 1000)]
    growth = module("growth")
    assert growth.fit([*rows, {"vertices": 10**6, "failure": "killed"}], "build", "cpu") == (
        pytest.approx(1.2)
    )
    assert growth.fit(rows[:2], "build", "cpu") is None


def test_a_ratio_is_the_median_of_the_rounds_against_the_faster_library(module):
    tables = module("measuring.performance_tables")

    def runs(*times):
        return {"build": [{"cpu": time, "wall": 2 * time} for time in times]}

    times = {"ours": runs(1, 2, 9), "potpourri3d": runs(8, 8, 9), "libigl": runs(99, 9, 1)}
    assert tables.faster_peer(times, "build") == "potpourri3d"
    assert tables.against_peers(times, "ours", "build") == "**4** (1-8)"
    times["libigl"]["failure"] = times["potpourri3d"]["failure"] = "over 1 s"
    assert tables.against_peers(times, "ours", "build") == "-"


def test_a_library_that_is_not_there_has_a_dash_and_is_named(module, capsys, monkeypatch):
    performance = module("performance")
    found = performance.importlib.util.find_spec
    monkeypatch.setattr(
        performance.importlib.util,
        "find_spec",
        lambda name: None if name == "potpourri3d" else found(name),
    )
    kept = performance.columns("ours;potpourri3d;libigl", "superlu")
    assert kept == ["ours", "libigl", "ours, solver=superlu"]
    assert "potpourri3d is left out" in capsys.readouterr().out
    tables = module("measuring.performance_tables")
    assert tables.against({"ours": {"start": [{"wall": 1.0}]}}, "ours", "potpourri3d", "start") == (
        "-"
    )


def test_rounds_are_given_for_all_sizes_or_for_each(module):
    performance = module("performance")
    assert performance.rounds_of("3", 2) == [3, 3]
    assert performance.rounds_of("9,2", 2) == [9, 2]
    assert performance.rounds_of("", 2) == [0, 0]
    with pytest.raises(ValueError, match="3 numbers for 2 sizes"):
        performance.rounds_of("1,2,3", 2)


def test_every_library_is_first_once_before_one_is_first_again(module):
    turned = module("performance").turned
    assert [turned(["a", "b", "c"], k)[0] for k in range(4)] == ["a", "b", "c", "a"]
    assert sorted(turned(["a", "b", "c"], 2)) == ["a", "b", "c"]


def test_the_default_columns_have_no_options(module):
    libraries = module("measuring.libraries")
    assert libraries.options(libraries.OURS) == {}
    assert libraries.options(libraries.PEER_DEFAULT) == {}
    assert libraries.options(libraries.PLAIN) == {"refine": False}
    assert libraries.options("potpourri3d") == {"use_robust": False}


def test_rows_of_other_parts_stay_in_a_file_and_figures_that_miss_their_bound_are_bold(
    module, tmp_path, capsys
):
    figures = module("measuring.figures")
    file = tmp_path / "some.json"

    def run(*options, error=0.5):
        parts = {
            "angles": lambda: iter([figures.Row("angle", error, 0.1, peer=2.0)]),
            "orders": lambda: iter(
                [figures.Row("order", 1.9, 1.8, at_least=True), figures.Row("loops", 3.0)]
            ),
        }
        figures.report(parts, figures.parser("").parse_args([*options, "--json", str(file)]))

    run()
    assert "angle" in capsys.readouterr().out
    assert "| angle | **0.5** | <= 0.1 | 2 |" in file.with_suffix(".md").read_text()
    run("--parts", "angles", error=0.05)
    printed = capsys.readouterr().out
    assert "MISSED" not in printed
    assert "order" not in printed
    table = file.with_suffix(".md").read_text()
    assert "| angle | 0.05 | <= 0.1 | 2 |" in table
    assert "| order | 1.9 | >= 1.8 |  |" in table
    assert "| loops | 3 |  |  |" in table


def test_closed_forms_around_a_hole_and_on_an_ellipsoid_are_right(module):
    pytest.importorskip("potpourri3d")
    directions = module("heat_family")
    plate = directions.plate_with_hole(500)
    exact = gt.exact_distance(plate.mesh, plate.source)
    lengths = np.linalg.norm(plate.logarithms, axis=1)
    np.testing.assert_allclose(lengths[plate.good], exact[plate.good], atol=1e-12)
    assert plate.good.mean() > 0.9
    shape = directions.ellipsoid(400)
    ends = directions.shot(shape.mesh.vertices[shape.source], shape.logarithms[shape.good], 200)
    np.testing.assert_allclose(ends, shape.mesh.vertices[shape.good], atol=1e-7)
    assert shape.good.sum() > 50


@pytest.mark.slow
def test_a_worker_has_imported_no_more_than_the_mesh_has_needed(tmp_path):
    np.savez(tmp_path / "mesh.npz", faces=np.eye(3))
    code = f"""
import sys, numpy
numpy.load({str(tmp_path / "mesh.npz")!r})["faces"]
before = set(sys.modules)
import measuring.worker
print(*set(sys.modules) - before)
"""
    finished = subprocess.run(
        [sys.executable, "-c", code], cwd=BENCHMARKS, capture_output=True, text=True, check=True
    )
    more = {name.partition(".")[0] for name in finished.stdout.split()}
    assert more <= {"measuring", "gc", "json", "_json"}


def test_a_phase_that_has_become_slower_is_named(module):
    regression = module("regression")
    slower = regression.Phase("3k", 4, "flips", times=[(1.0, 2.0), (1.0, 4.0), (1.0, 1.0)])
    faster = regression.Phase("3k", 4, "stars", times=[(2.0, 1.0)])
    other = regression.Phase("3k", 4, "poles")
    assert regression.complaints([slower, faster, other], 0.7) == [
        "flips at 3k, level 4: 0.50 of the speed of the base, below 0.7"
    ]
    assert regression.complaints([slower, faster, other], 0.4) == []
    assert "**0.50** (0.25-1.00), 2 s" in regression.table([slower, faster], 0.7)


def test_a_phase_may_be_missing_from_the_base_but_not_from_the_new_version(module):
    regression = module("regression")
    phases = [regression.Phase("3k", 0, name) for name in ("flips", "poles", "stars")]
    here, missing = {"cpu": 1.0}, {"failure": "ImportError: none"}
    for phase, base, new in zip(phases, (missing, here, here), (here, missing, here), strict=True):
        regression.note(phase, base, new)
    assert regression.left_out(phases) == ["flips: the base has none: ImportError: none"]
    assert regression.complaints(phases, 0.7) == [
        "poles at 3k: the new version fails: ImportError: none"
    ]


def test_a_base_is_an_interpreter_or_a_commit(module, monkeypatch):
    regression = module("regression")
    with regression.interpreter(sys.executable) as found:
        assert found == sys.executable
    commands = []
    monkeypatch.setattr(regression, "run", lambda *command: commands.append(command))
    with regression.interpreter("v1.2") as made:
        assert "geodesic-" in made
    assert [word for word in commands[0] if word in {"worktree", "add", "v1.2"}]
    assert "install" in commands[2]
    assert "remove" in commands[-1]


def test_the_errors_on_a_sphere_are_those_of_the_arc(module):
    points = np.array([[1.0, 0, 0], [0, 1.0, 0], [-1.0, 0, 0]])
    found = module("measuring.growing").errors(points, 0, np.pi * np.array([0, 0.55, 0.98]))
    assert found["mean_error"] == pytest.approx((10 + 2) / 2)
    assert found["antipode_error"] == pytest.approx(2)


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is read from /proc")
class TestProcesses:
    def test_a_process_that_is_killed_ran_out_of_memory(self, module):
        processes = module("measuring.processes")
        process = processes.Process("measuring.growing", "mesh", "none.npz", "none.npz")
        process._process.kill()
        with pytest.raises(processes.NoAnswerError, match="killed, out of memory"):
            process.answer(limit=60)

    @pytest.mark.slow
    def test_a_process_that_fails_says_why(self, module):
        processes = module("measuring.processes")
        process = processes.Process("measuring.growing", "mesh", "none.npz", "none.npz")
        with pytest.raises(processes.NoAnswerError, match=r"FileNotFoundError.*none\.npz"):
            process.answer(limit=60)

    def test_a_process_that_is_late_is_ended(self, module):
        processes = module("measuring.processes")
        process = processes.Process("measuring.growing", "mesh", "none.npz", "none.npz")
        with pytest.raises(processes.NoAnswerError, match="over 0 s"):
            process.answer(limit=0)
        assert process._process.returncode is not None

    @pytest.mark.slow
    def test_performance_is_measured_on_a_generated_mesh(self):
        options = ["--generated", "--sizes", "0.6k", "--rounds", "1", "--parts", "rounds,memory"]
        shown = run_script(
            "performance.py", *options, "--libraries", "ours;ours, plain heat;libigl"
        )
        for title in ("import and first distance", "a further source, alone", "peak memory"):
            assert title in shown
        assert "plain heat: build and one source | **" in shown
        assert "potpourri3d as it comes / this package as it comes | - |" in shown
        assert "Traceback" not in shown

    @pytest.mark.slow
    def test_every_phase_of_a_version_is_compared_with_its_own(self, module):
        options = ["--base", sys.executable, "--sizes", "0.6k", "--rounds", "1", "--bound", "0"]
        shown = run_script("regression.py", *options, "--seconds", "0")
        for name in module("measuring.phases").NAMES:
            assert f"| {name} | **" in shown
        assert "left out" not in shown

    @pytest.mark.slow
    def test_a_slower_phase_is_the_exit_status(self):
        options = ["--base", sys.executable, "--sizes", "0.6k", "--rounds", "1", "--bound", "1e9"]
        shown = run_script("regression.py", *options, "--phases", "flips", status=1)
        assert "SLOWER: flips at 0.6k, level" in shown

    @pytest.mark.slow
    def test_growth_is_measured_and_drawn(self, tmp_path):
        pytest.importorskip("matplotlib")
        picture = tmp_path / "growth.png"
        shown = run_script("growth.py", "--mesh", "0.6k", "--cloud", "", "--picture", str(picture))
        assert "| mesh | 642 |" in shown
        assert picture.stat().st_size > 10_000
