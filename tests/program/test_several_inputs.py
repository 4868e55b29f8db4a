"""Several inputs of one command: each has a status, and a failure does not end the rest."""

import json
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest
from command_line import fails, run

import geodesic_toolkit as gt
from geodesic_toolkit.cli.targets import Targets

COMMANDS = {
    "distance": (["--source", 0], ".npy"),
    "signed": (["--curve", "line.txt"], ".npy"),
    "logmap": (["--source", 0], ".csv"),
    "loop": (["--through", "0,2,4", "--keep"], ".obj"),
    "isolines": (["--source", 0, "--level", 0.5], ".obj"),
    "matrix": ([], ".npy"),
    "compare": (["--source", 0], ""),
    "doctor": ([], ""),
}
"""The options that a command needs, and the suffix of an output, of those that write tables."""

WRITING = [name for name, (_, suffix) in COMMANDS.items() if suffix]

every_command = pytest.mark.parametrize("name", COMMANDS)
every_writing_command = pytest.mark.parametrize("name", WRITING)


@pytest.fixture
def shapes(tmp_path, monkeypatch):
    """Enter a folder of two meshes, and between them a file that is not one."""
    monkeypatch.chdir(tmp_path)
    gt.write("first.ply", gt.testing.shapes.icosphere(1), np.zeros(42))
    gt.write("last.ply", gt.testing.shapes.grid(5), np.zeros(25))
    (tmp_path / "broken.ply").write_text("ply\n")
    (tmp_path / "line.txt").write_text("12 13\n")
    return ["first.ply", "broken.ply", "last.ply"]


def command(name, *inputs, output=None):
    """Return the arguments of a command with its options, and with an output if it writes any."""
    options, suffix = COMMANDS[name]
    return [name, *inputs, *options, *(["--output", f"{output}{suffix}"] if output else [])]


@every_command
def test_every_input_has_a_result_and_a_status(shapes, name):
    done = run(*command(name, *shapes, output="{name}" if name in WRITING else None))
    assert done.exit_code == 3
    *_, head, first, broken, last = done.stdout.splitlines()
    assert [line.split()[:2] for line in (head, first, last)] == [
        ["INPUT", "STATUS"],
        ["first.ply", "done"],
        ["last.ply", "done"],
    ]
    assert broken.split()[:2] == ["broken.ply", "failed"]
    assert done.stderr.startswith("broken.ply: error: broken.ply: ")
    assert "[ReadError]" in done.stderr


@every_writing_command
def test_every_input_has_the_output_that_it_has_alone(shapes, tmp_path, name):
    suffix = COMMANDS[name][1]
    run(*command(name, *shapes, output="{name}"))
    for each in ("first", "last"):
        alone = run(*command(name, f"{each}.ply", output="alone"))
        assert alone.exit_code == 0, alone.output
        written = (tmp_path / f"{each}{suffix}").read_bytes()
        assert written == (tmp_path / f"alone{suffix}").read_bytes()
    assert not (tmp_path / f"broken{suffix}").exists()


@every_command
def test_json_has_one_object_with_all_results(shapes, name):
    output = "{name}" if name in WRITING else None
    done = run(*command(name, *shapes, output=output), "--json")
    assert done.exit_code == 3
    content = json.loads(done.stdout)
    assert content["schema_version"] == 1
    first, broken, last = content["results"]
    assert [one["status"] for one in (first, broken, last)] == [0, 3, 0]
    assert [one["input"] for one in (first, broken, last)] == shapes
    assert set(broken) == {"input", "status", "error"}
    assert broken["error"]["kind"] == "ReadError"
    for one in (first, last):
        alone = run(*command(name, one["input"], output=output), "--json")
        assert set(one) == {*json.loads(alone.stdout), "error", "status"} - {"schema_version"}
        assert one["error"] is None


@every_command
def test_quiet_inputs_still_report_their_errors(shapes, name):
    done = run(*command(name, *shapes, output="{name}" if name in WRITING else None), "--quiet")
    assert done.exit_code == 3
    assert [line.split(": ")[:2] for line in done.stderr.splitlines()] == [["broken.ply", "error"]]


def test_several_inputs_that_are_all_right_have_status_0(shapes):
    assert run("distance", shapes[0], shapes[2], "--source", 0).exit_code == 0


def test_the_status_is_the_highest_of_those_of_the_inputs(shapes):
    done = run("distance", *shapes, "--source", 30, "--json")
    assert [one["status"] for one in json.loads(done.stdout)["results"]] == [0, 3, 2]
    assert done.exit_code == 3


@every_writing_command
def test_outputs_that_clash_are_refused_before_any_work(shapes, tmp_path, name):
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "first.off").write_text("OFF\n")
    for inputs, output in (
        (shapes, "one"),
        (["first.ply", "other/first.off"], "{name}"),
        (["first.ply", "other/../first.ply"], "{name}"),
        (["first.ply", "first.ply"], "{name}"),
    ):
        before = sorted(tmp_path.iterdir())
        result = run(*command(name, *inputs, output=output))
        fails(result, 2, "several times" if inputs[0] == inputs[1] else "{name}")
        assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("name", ["logmap", "isolines", "loop", "signed", "distance"])
def test_no_output_overwrites_another_input_or_a_file_of_an_option(shapes, tmp_path, name):
    options, suffix = COMMANDS[name]
    (tmp_path / f"used{suffix}").write_text("0\n")
    line = [name, "first.ply", *options, "--output", "{name}" + suffix]
    fails(run(*line, f"used{suffix}"), 2, f"used{suffix} would overwrite")
    line[-1] = f"used{suffix}"
    fails(run(*line, "--mask", f"used{suffix}"), 2, f"used{suffix} would overwrite")


def test_the_paths_of_many_inputs_are_resolved_a_few_times_each(tmp_path):
    paths = [tmp_path / f"{number}.ply" for number in range(100)]
    targets = Targets(tables=(tmp_path / "{name}.npy",))
    with patch.object(Path, "resolve", autospec=True, side_effect=Path.resolve) as resolve:
        assert len(targets.of_each(paths)) == 100
    assert resolve.call_count < 10 * len(paths)


def test_pictures_of_several_inputs_have_names_of_their_own(shapes):
    pair = [shapes[0], shapes[2]]
    fails(run("compare", *pair, "--source", 0, "--picture", "error.png"), 2, "{name}")
    fails(run("loop", *pair, "--through", "0,2,4", "--html", "loop.html"), 2, "{name}")


def test_a_compressed_file_is_named_without_both_suffixes(shapes, tmp_path):
    import gzip

    content = gzip.compress((tmp_path / "first.ply").read_bytes())
    (tmp_path / "packed.ply.gz").write_bytes(content)
    done = run("distance", "packed.ply.gz", "last.ply", "--source", 0, "--output", "{name}.npy")
    assert done.exit_code == 0, done.output
    assert (tmp_path / "packed.npy").exists()


def test_a_stream_may_be_one_of_several_inputs(shapes, tmp_path):
    content = (tmp_path / "first.ply").read_bytes()
    done = run("doctor", "-", "last.ply", "--json", input=content)
    assert [one["input"] for one in json.loads(done.stdout)["results"]] == ["-", "last.ply"]
    fails(run("signed", "-", "-", "--curve", "line.txt", input=content), 2, "the same stream")


def test_a_name_of_several_lines_stays_on_one(shapes, tmp_path):
    (tmp_path / "two\nlines.ply").write_bytes((tmp_path / "last.ply").read_bytes())
    done = run("distance", "first.ply", "two\nlines.ply", "--source", 0)
    assert done.stdout.splitlines()[-1].split() == ["two", "lines.ply", "done"]


def test_warnings_name_the_input_that_they_are_about(shapes):
    done = run("isolines", "first.ply", "last.ply", "--source", 0, "--level", 1.5, "--json")
    first, last = json.loads(done.stdout)["results"]
    assert first["warnings"] == []
    assert last["warnings"][0].startswith("no line is at these distances")
    assert done.stderr.startswith("last.ply: warning: no line is at these distances")


def test_ctrl_c_ends_all_inputs(shapes, tmp_path):
    with patch("geodesic_toolkit.io.read", side_effect=KeyboardInterrupt):
        done = run("matrix", "first.ply", "last.ply", "--output", "{name}.npy")
    fails(done, 130, "interrupted")


def test_an_error_of_an_unexpected_kind_does_not_end_the_rest(shapes):
    from geodesic_toolkit.solver.solver import GeodesicSolver

    def fail_at_spheres(self, domain, **options):
        if domain.n_vertices == 42:
            raise RuntimeError("boom")
        build(self, domain, **options)

    build = GeodesicSolver.__init__
    with patch.object(GeodesicSolver, "__init__", fail_at_spheres):
        done = run("doctor", "first.ply", "last.ply", "--json")
    assert done.exit_code == 4
    first, last = json.loads(done.stdout)["results"]
    assert first["error"] == {"kind": "RuntimeError", "message": "boom"}
    assert last["status"] == 0
    assert "first.ply: This is a bug" in done.stderr
