"""Several inputs of one command: each has a status, and a failure does not end the rest."""

import json

import numpy as np
import pytest
from command_line import fails, run

import geodesic_toolkit as gt


@pytest.fixture
def shapes(tmp_path):
    """Write two meshes, and between them a file that is not one."""
    paths = [tmp_path / f"{name}.ply" for name in ("first", "broken", "last")]
    meshes = (gt.testing.shapes.icosphere(2), gt.testing.shapes.grid(9))
    for path, mesh in zip(paths[::2], meshes, strict=True):
        gt.write(path, mesh, np.zeros(mesh.n_vertices))
    paths[1].write_text("ply\n")
    return paths


def test_every_input_has_a_result_and_a_status(shapes, tmp_path):
    done = run("distance", *shapes, "--source", 0, "--output", tmp_path / "{name}.npy")
    assert done.exit_code == 3
    assert [line.split()[-1] for line in done.stdout.splitlines()[-3::2]] == ["done", "done"]
    assert f"{shapes[1]}  failed" in " ".join(done.stdout.splitlines()[-2].split(" "))
    assert "broken.ply" in done.stderr
    assert "[ReadError]" in done.stderr
    for path in shapes[::2]:
        expected = gt.geodesic_distance(gt.read(path), 0)
        np.testing.assert_allclose(np.load(tmp_path / f"{path.stem}.npy"), expected)
    assert not (tmp_path / "broken.npy").exists()


def test_json_has_one_object_with_all_results(shapes):
    done = run("distance", *shapes, "--source", 0, "--json")
    assert done.exit_code == 3
    results = json.loads(done.stdout)["results"]
    assert [one["status"] for one in results] == [0, 3, 0]
    assert [one["input"] for one in results] == list(map(str, shapes))
    assert results[1]["error"]["kind"] == "ReadError"
    assert results[0]["error"] is None
    assert results[2]["max"] == pytest.approx(np.sqrt(2), rel=1e-6)


def test_quiet_inputs_still_report_their_errors(shapes):
    done = run("distance", *shapes, "--source", 0, "--quiet")
    assert done.exit_code == 3
    assert "broken.ply" in done.stderr
    assert "[ReadError]" in done.stderr


def test_several_inputs_that_are_all_right_have_status_0(shapes):
    assert run("distance", shapes[0], shapes[2], "--source", 0).exit_code == 0


def test_outputs_of_several_inputs_have_names_of_their_own(shapes, tmp_path):
    result = run("distance", *shapes, "--source", 0, "--output", tmp_path / "d.npy")
    fails(result, 2, "{name}")
    fails(run("distance", shapes[0], shapes[0], "--source", 0), 2, "several times")
    other = tmp_path / "first.off"
    other.write_text("OFF\n")
    result = run("distance", shapes[0], other, "--source", 0, "--output", tmp_path / "{name}.npy")
    fails(result, 2, "first.npy")
