"""The option --cost: travel times instead of distances."""

import json

import numpy as np
import pytest
from command_line import fails, run

import geodesic_toolkit as gt


@pytest.fixture
def plane():
    return gt.testing.shapes.grid(9)


@pytest.fixture
def plane_file(tmp_path, plane):
    gt.write(tmp_path / "plane.ply", plane, np.zeros(plane.n_vertices))
    return tmp_path / "plane.ply"


@pytest.mark.parametrize("suffix", [".npy", ".txt", ".csv"])
@pytest.mark.parametrize("of_faces", [True, False])
def test_distances_are_travel_times(tmp_path, plane, plane_file, suffix, of_faces):
    at = plane.vertices[plane.faces].mean(axis=1) if of_faces else plane.vertices
    cost = 1 + at[:, 0]
    path = tmp_path / f"cost{suffix}"
    if suffix == ".npy":
        np.save(path, cost)
    else:
        np.savetxt(path, cost, fmt="%.17g", header="cost" if suffix == ".csv" else "", comments="")
    done = run(
        "distance", plane_file, "--source", 0, "--cost", path, "--output", tmp_path / "t.npy"
    )
    assert done.exit_code == 0, done.output
    expected = gt.geodesic_distance(gt.MetricMesh(plane, cost=cost), 0)
    np.testing.assert_allclose(np.load(tmp_path / "t.npy"), expected, rtol=1e-12)


def test_a_source_inside_a_face_has_its_cost(tmp_path, plane, plane_file):
    np.savetxt(tmp_path / "cost.txt", np.full(128, 3.0))
    options = ["--source", "0.5,0.51,0", "--cost", tmp_path / "cost.txt", "--json"]
    times = json.loads(run("distance", plane_file, *options).stdout)
    solver = gt.GeodesicSolver(gt.MetricMesh(plane, cost=3.0))
    assert times["max"] == pytest.approx(solver.distance([[0.5, 0.51, 0.0]]).max(), rel=1e-6)
    assert times["cost"] == str(tmp_path / "cost.txt")


def test_merged_vertices_have_the_cost_of_the_first(tmp_path):
    square = gt.testing.shapes.grid(3)
    corners = square.vertices[square.faces].reshape(-1, 3)
    apart = gt.TriangleMesh(corners, np.arange(24).reshape(-1, 3))
    path = tmp_path / "soup.ply"
    gt.write(path, apart, np.zeros(24))
    np.savetxt(tmp_path / "cost.txt", np.full(24, 2.0))
    done = run(
        "distance", path, "--source", 0, "--weld", 0, "--cost", tmp_path / "cost.txt", "--json"
    )
    assert json.loads(done.stdout)["max"] == pytest.approx(2 * np.sqrt(2), rel=1e-6)


def test_a_matrix_has_travel_times(tmp_path, plane_file):
    np.savetxt(tmp_path / "cost.txt", np.full(128, 2.0))
    for name, options in {"t": ["--cost", tmp_path / "cost.txt"], "d": []}.items():
        assert (
            run("matrix", plane_file, *options, "--output", tmp_path / f"{name}.npy").exit_code == 0
        )
    times, distances = np.load(tmp_path / "t.npy"), np.load(tmp_path / "d.npy")
    np.testing.assert_allclose(times, 2 * distances, rtol=1e-9)


@pytest.mark.parametrize(
    ("values", "status", "words"),
    [
        ("1\n2\n", 3, ["2 values", "128 faces"]),
        ("0\n" * 128, 3, ["face 0", "positive"]),
        ("x\n" * 128, 3, ["cost.txt"]),
    ],
)
def test_costs_that_do_not_fit_are_bad_input(tmp_path, plane_file, values, status, words):
    (tmp_path / "cost.txt").write_text(values)
    fails(
        run("distance", plane_file, "--source", 0, "--cost", tmp_path / "cost.txt"), status, *words
    )


def test_a_cost_needs_a_mesh(tmp_path):
    gt.write(tmp_path / "scan.ply", gt.PointCloud(np.eye(3)), np.zeros(3))
    np.savetxt(tmp_path / "cost.txt", np.ones(3))
    options = ["--source", 0, "--cost", tmp_path / "cost.txt"]
    fails(run("distance", tmp_path / "scan.ply", *options), 2, "PointCloud")
