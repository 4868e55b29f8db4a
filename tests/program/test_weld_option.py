"""The option --weld: commands work on merged vertices and report those of the file."""

import json

import numpy as np
import pytest
from command_line import run

import geodesic_toolkit as gt
from geodesic_toolkit.io.readers.ply import encode_ply
from geodesic_toolkit.testing import shapes

BALL = shapes.icosphere(2)


def command(*arguments):
    done = run(*arguments)
    return done.exit_code, done.stdout, done.stderr


CORNERS = np.arange(960).reshape(-1, 3)
OF_BALL = BALL.faces.ravel()


@pytest.fixture
def soup(tmp_path):
    """A file with the facets of a sphere, each with corners of its own, apart by rounding."""
    rng = np.random.default_rng(0)
    places = BALL.vertices[OF_BALL] + 1e-9 * rng.uniform(-1, 1, (960, 3))
    path = tmp_path / "soup.ply"
    polygons = np.full(len(CORNERS), 3), CORNERS.ravel()
    path.write_bytes(encode_ply(dict(zip("xyz", places.T, strict=True)), polygons, []))
    return path


@pytest.mark.slow
def test_distances_are_those_of_the_surface_at_every_vertex_of_the_file(soup, tmp_path):
    output = tmp_path / "d.npy"
    arguments = ("distance", soup, "--source", 700, "--output", output)
    _, _, said = command(*arguments)
    assert "--weld" in said
    status, out, said = command(*arguments, "--weld", 1e-7, "--json")
    assert status == 0, said
    told = json.loads(out)
    assert (told["n_vertices"], told["n_merged"], told["reached"]) == (960, 162, 960)
    expected = gt.geodesic_distance(BALL, int(OF_BALL[700]))[OF_BALL]
    np.testing.assert_allclose(np.load(output), expected, atol=1e-6)


@pytest.mark.slow
def test_a_mask_of_one_copy_masks_the_vertex(soup, tmp_path):
    mask, output = tmp_path / "mask.txt", tmp_path / "d.npy"
    mask.write_text("5\n17\n")
    arguments = ("distance", soup, "--source", 700, "--weld", 1e-7)
    assert command(*arguments, "--mask", mask, "--output", output)[0] == 0
    masked = np.isin(OF_BALL, OF_BALL[[5, 17]])
    np.testing.assert_array_equal(np.isinf(np.load(output)), masked)


@pytest.mark.slow
def test_matrices_have_rows_and_columns_of_the_file(soup, tmp_path):
    output, rows = tmp_path / "m.npy", tmp_path / "rows.txt"
    rows.write_text("700 3\n")
    weld = ("--weld", 1e-7, "--output", output)
    assert command("matrix", soup, "--sources", rows, *weld)[0] == 0
    expected = gt.GeodesicSolver(BALL).distances(OF_BALL[[700, 3]])[:, OF_BALL]
    np.testing.assert_allclose(np.load(output), expected, atol=1e-6)
    status, out, _ = command("matrix", soup, "--landmarks", 3, *weld, "--json")
    assert status == 0
    landmarks = json.loads(out)["sources"]
    np.testing.assert_allclose(np.load(output)[np.arange(3), landmarks], 0.0)
    assert command("matrix", soup, *weld)[0] == 0
    square = np.load(output)
    assert square.shape == (960, 960)
    np.testing.assert_array_equal(square, square.T)


def test_a_shape_is_examined_as_it_is_welded(soup):
    status, out, _ = command("doctor", soup, "--weld", 1e-7, "--json")
    assert status == 0
    assert json.loads(out)["diagnosis"]["components"] == 1


@pytest.mark.slow
def test_what_was_merged_is_said_and_a_tolerance_that_merges_nothing_is_warned_of(soup):
    status, out, said = command("distance", soup, "--source", 0, "--weld", 1e-7)
    assert status == 0
    assert "merged 798 of 960 vertices into others" in said
    status, out, said = command("distance", soup, "--source", 0, "--weld", 1e-12, "--json")
    assert status == 0
    assert "merged none of the 960 vertices" in " ".join(json.loads(out)["warnings"])


def test_the_doctor_names_seams_and_the_tolerance_that_joins_them(soup):
    _, out, _ = command("doctor", soup, "--json")
    told = json.loads(out)
    assert told["diagnosis"]["seam_edges"] == 960
    tolerance = told["diagnosis"]["seam_tolerance"]
    assert any(f"--weld {tolerance:g}" in line for line in told["recommendations"])
    _, out, _ = command("doctor", soup, "--weld", tolerance, "--json")
    assert json.loads(out)["diagnosis"]["components"] == 1


@pytest.mark.slow
def test_a_matrix_has_rows_of_inf_where_a_mask_holds_a_copy_of_the_vertex(soup, tmp_path):
    mask, output = tmp_path / "mask.txt", tmp_path / "d.npy"
    mask.write_text("5\n17\n")
    weld = ("matrix", soup, "--weld", 1e-7, "--mask", mask, "--output", output)
    status, _, said = command(*weld)
    assert status == 0, said
    found, masked = np.load(output), np.isin(OF_BALL, OF_BALL[[5, 17]])
    assert found.shape == (960, 960)
    np.testing.assert_array_equal(np.isinf(found), masked[:, None] | masked)
    copy = int(np.flatnonzero(OF_BALL[17] == OF_BALL)[-1])
    rows = tmp_path / "rows.txt"
    rows.write_text(f"700 {copy}\n")
    status, _, said = command(*weld, "--sources", rows)
    assert status != 0
    assert f"vertex {copy} is masked, or a vertex merged with it is" in said
    status, _, said = command(*("distance", *weld[1:-2]), "--source", copy)
    assert status != 0
    assert f"vertex {copy} is masked" in said


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("--source", 0, "--weld", "100"), "more than the size of the mesh"),
        (("--source", 0, "--weld", "-1"), "--weld must be finite and not negative"),
        (("--source", 0, "--weld", "nan"), "--weld must be finite and not negative"),
        (("--source", 960, "--weld", "0"), "vertex 960 does not exist; there are 960"),
    ],
)
def test_what_cannot_be_welded_is_refused(soup, arguments, reason):
    status, _, said = command("distance", soup, *arguments)
    assert status != 0
    assert reason in said


def test_only_meshes_are_welded(graph_file):
    status, _, said = command("distance", graph_file, "--source", 0, "--weld", 0)
    assert status != 0
    assert "the input is a Graph" in said
