"""The command ``distance``: its output on stdout and stderr, and its files."""

import csv
import json
import os
import sys

import numpy as np
import pytest
from command_line import fails, run
from sample_files import write_off

import geodesic_toolkit as gt
from geodesic_toolkit import viz
from geodesic_toolkit.io import write
from geodesic_toolkit.testing import shapes

# -- results -------------------------------------------------------------------------------------


def test_distance_prints_a_summary_on_stdout_and_nothing_on_stderr(sphere_file):
    result = run("distance", sphere_file, "--source", 5)
    assert result.exit_code == 0
    assert result.stderr == ""
    assert "TriangleMesh(162 vertices, 320 faces)" in result.stdout
    assert "vertex 5" in result.stdout
    assert "162 vertices, 0 unreachable" in result.stdout
    largest = gt.geodesic_distance(gt.read(sphere_file), 5).max()
    assert f"max {largest:.6g}" in result.stdout


def test_distance_writes_every_output_that_it_is_asked_for(sphere_file, tmp_path):
    outputs = [tmp_path / f"d.{suffix}" for suffix in ("npy", "csv", "ply")]
    options = [argument for output in outputs for argument in ("--output", output)]
    result = run("distance", sphere_file, "--source", 5, *options)
    assert result.exit_code == 0
    expected = gt.geodesic_distance(gt.read(sphere_file), 5)
    np.testing.assert_array_equal(np.load(outputs[0]), expected)
    with outputs[1].open(newline="") as file:
        table = [float(row["distance"]) for row in csv.DictReader(file)]
    np.testing.assert_array_equal(table, expected)
    assert gt.read(outputs[2]).n_vertices == 162
    for output in outputs:
        assert str(output) in result.stdout


def test_json_is_one_object_with_everything_in_it(sphere_file, tmp_path):
    output = tmp_path / "d.npy"
    result = run("distance", sphere_file, "--source", 5, "--output", output, "--json")
    report = json.loads(result.stdout)
    distance = np.load(output)
    assert report["schema_version"] == 1
    assert report["input"] == str(sphere_file)
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
    assert report["solver"]["heat"].startswith(("Supernodal(", "SuperLU("))


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


def test_distance_refines_by_default(sphere_file):
    plain = json.loads(run("distance", sphere_file, "--source", 3, "--no-refine", "--json").stdout)
    refined = json.loads(run("distance", sphere_file, "--source", 3, "--json").stdout)
    assert (plain["refine"], refined["refine"]) == (False, True)
    exact = gt.exact_distance(shapes.icosphere(2), 3).max()
    assert abs(refined["max"] - exact) < abs(plain["max"] - exact)
    assert refined["max"] == pytest.approx(
        gt.geodesic_distance(shapes.icosphere(2), 3, refine=True).max()
    )
    assert "refined" in run("distance", sphere_file, "--source", 3).stdout
    assert "refined" not in run("distance", sphere_file, "--source", 3, "--no-refine").stdout


def test_many_sources_make_one_set(sphere_file, tmp_path):
    output = tmp_path / "d.npy"
    run("distance", sphere_file, "--source", 5, "--source", 9, "--output", output)
    np.testing.assert_array_equal(
        np.load(output), gt.geodesic_distance(gt.read(sphere_file), [5, 9])
    )


def test_a_source_may_be_a_point(sphere_file, tmp_path):
    output = tmp_path / "d.npy"
    result = run("distance", sphere_file, "--source", "-1,0.5,2", "--output", output)
    assert "point (-1, 0.5, 2)" in result.stdout
    expected = gt.geodesic_distance(gt.read(sphere_file), [-1.0, 0.5, 2.0])
    np.testing.assert_array_equal(np.load(output), expected)


def test_graphs_go_through_the_same_command(graph_file):
    report = json.loads(run("distance", graph_file, "--source", 0, "--json").stdout)
    assert report["domain"] == "Graph"
    assert report["max"] == pytest.approx(3.0, rel=0.05)


# -- at points of a file -------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", ["npy", "csv", "xyz", "ply"])
def test_distances_at_points_of_a_file(sphere_file, tmp_path, suffix):
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
        write(points, gt.PointCloud(places), np.zeros(30))
    out = [tmp_path / "d.npy", tmp_path / "d.csv", tmp_path / "d.ply"]
    options = [word for path in out for word in ("--output", path)]
    result = run("distance", sphere_file, "--source", 5, "--at", points, *options)
    assert result.exit_code == 0, result.output
    assert "29 points, 1 unreachable" in result.stdout
    distances = np.load(out[0])
    np.testing.assert_allclose(distances, solver.query(places, 5), atol=1e-6)
    assert distances[7] == np.inf
    rows = list(csv.DictReader(out[1].read_text().splitlines()))
    assert [float(row["distance"]) for row in rows] == distances.tolist()
    np.testing.assert_allclose(gt.read(out[2]).points, places, atol=1e-12)


@pytest.mark.slow
def test_a_file_of_the_format_of_the_input_keeps_what_is_in_it(tmp_path):
    laspy = pytest.importorskip("laspy")
    places = np.random.default_rng(0).uniform(0, 1, (300, 3)) * [1, 1, 0]
    points = laspy.create(point_format=3)
    points.header.scales = [1e-6] * 3
    points.x, points.y, points.z = places.T
    points.classification = np.arange(300) % 7
    points.write(str(tmp_path / "in.laz"))
    write(tmp_path / "at.pcd", gt.PointCloud(places[:50], places[:50] + 1), np.ones(50))
    out = tmp_path / "d.las"
    result = run("distance", tmp_path / "in.laz", "--source", 0, "--output", out)
    assert result.exit_code == 0, result.output
    again = laspy.read(out)
    np.testing.assert_array_equal(again.classification, points.classification)
    expected = gt.geodesic_distance(gt.read(tmp_path / "in.laz"), 0)
    np.testing.assert_array_equal(again["distance"], expected)
    at = ("--at", tmp_path / "at.pcd", "--output", tmp_path / "asked.pcd")
    result = run("distance", tmp_path / "in.laz", "--source", 0, *at)
    assert result.exit_code == 0, result.output
    asked = gt.read(tmp_path / "asked.pcd")
    np.testing.assert_array_equal(asked.normals, gt.read(tmp_path / "at.pcd").normals)


@pytest.mark.slow
def test_a_cloud_is_thinned_and_all_of_its_points_have_a_distance(tmp_path):
    rng = np.random.default_rng(0)
    points = rng.uniform(0, 1, (4000, 3)) * [1, 1, 0]
    np.savetxt(tmp_path / "plane.xyz", points, fmt="%.17g")
    asked = tmp_path / "at.npy"
    np.save(asked, points[:40])
    thin = ("--thin", 0.1, "--json")
    result = run(
        "distance", tmp_path / "plane.xyz", "--source", 7, *thin, "--output", tmp_path / "d.npy"
    )
    assert result.exit_code == 0, result.output
    report = json.loads(result.stdout)
    assert report["n_vertices"] == report["reached"] == 4000
    assert report["thin"] == 0.1
    assert report["n_kept"] < 200
    distance = np.load(tmp_path / "d.npy")
    exact = np.linalg.norm(points - points[7], axis=1)
    assert np.abs(distance - exact).max() < 0.1
    at = ("--at", asked, "--output", tmp_path / "a.npy")
    result = run("distance", tmp_path / "plane.xyz", "--source", 7, *thin, *at)
    assert result.exit_code == 0, result.output
    np.testing.assert_allclose(np.load(tmp_path / "a.npy"), distance[:40], atol=1e-9)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--thin", "-1"], "--thin must be positive and finite, not -1"),
        (["--thin", "0.1"], "--thin is for point clouds, not for a TriangleMesh"),
    ],
)
def test_a_thinning_that_cannot_be_is_refused(sphere_file, options, message):
    fails(run("distance", sphere_file, "--source", 0, *options), 2, message)


def test_a_mask_does_not_go_with_thinning(sphere_file, tmp_path):
    np.save(tmp_path / "mask.npy", np.zeros(162, dtype=bool))
    both = ("--mask", tmp_path / "mask.npy", "--thin", 1)
    fails(run("distance", sphere_file, "--source", 0, *both), 2, "cannot be given together")


def test_missing_points_of_at_stay_in_their_rows(sphere_file, tmp_path):
    np.save(tmp_path / "at.npy", [[0, 0, 1.0], [np.nan, 0, 0], [1.0, 0, 0]])
    out = tmp_path / "d.npy"
    run("distance", sphere_file, "--source", 0, "--at", tmp_path / "at.npy", "--output", out)
    assert np.isfinite(np.load(out)).tolist() == [True, False, True]


def test_the_reach_of_at_can_be_given(sphere_file, tmp_path):
    np.save(tmp_path / "at.npy", [[0, 0, 2.0]])
    told = ["distance", sphere_file, "--source", 0, "--at", tmp_path / "at.npy", "--json"]
    near, far = run(*told), run(*told, "--reach", 1.5)
    assert json.loads(near.stdout)["reached"] == 0
    assert json.loads(near.stdout)["max"] is None
    assert "has a distance" in near.stderr
    found = json.loads(far.stdout)
    assert (found["n_points"], found["reached"], found["n_vertices"]) == (1, 1, 162)


@pytest.mark.slow
def test_points_that_cannot_be_asked_for_are_refused(sphere_file, graph_file, tmp_path):
    at = tmp_path / "at.csv"
    at.write_text("0,0,1\n")
    asked = ("--source", 0, "--at", at)
    fails(run("distance", graph_file, *asked), 2, "a Graph has no positions")
    fails(run("distance", sphere_file, *asked, "--reach", 0), 2, "--reach must be positive")
    fails(run("distance", sphere_file, "--source", 0, "--reach", 1), 2, "--reach needs points")
    fails(run("distance", sphere_file, *asked, "--output", at), 2, "would overwrite the input")
    at.write_text("0,0\n")
    fails(run("distance", sphere_file, *asked), 3, "at.csv", "at least three columns, not 2")
    fails(run("distance", sphere_file, "--source", 0, "--at", tmp_path / "none.npy"), 2, "none.npy")


# -- with a mask ---------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_mask_keeps_paths_out(tmp_path):
    square = shapes.grid(7)
    path, wall = write_off(tmp_path / "square.off", square), np.zeros(49, dtype=bool)
    wall[3:35:7] = True  # the middle column, except its end
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


def test_a_mask_that_cannot_be_used_is_refused_before_the_work(sphere_file, tmp_path, monkeypatch):
    monkeypatch.setattr("geodesic_toolkit.solver.GeodesicSolver.__init__", None)  # never called
    wall = tmp_path / "wall.txt"
    asked = ("distance", sphere_file, "--source", 5, "--mask", wall)
    fails(run(*asked), 2, "wall.txt")
    for text, status, word in [
        ("1 2 162", 2, "no vertex 162"),
        ("true false", 2, "2 booleans, but the shape has 162 vertices"),
        ("wall", 3, "wall.txt: there are no numbers in the file, only 'wall'"),
        ("4 5", 2, "vertex 5 is masked"),
        (" ".join(map(str, range(162))), 2, "the mask leaves no face"),
    ]:
        wall.write_text(text)
        fails(run(*asked), status, word)
    table = tmp_path / "wall.csv"
    table.write_text("4")
    told = ("--mask", table, "--output", table)
    fails(run("distance", sphere_file, "--source", 5, *told), 2, "would overwrite the input")


# -- vertices from files --------------------------------------------------------------------------


def annotation(folder):
    freesurfer = pytest.importorskip("nibabel.freesurfer")
    path, regions = folder / "lh.atlas.annot", np.zeros(162, dtype=int)
    regions[:3], regions[100:] = 1, 2
    colours = np.array([[1, 2, 3, 0], [4, 5, 6, 0], [7, 8, 9, 0]])
    freesurfer.write_annot(str(path), regions, colours, ["rest", "V1", "wall"])
    return path


def test_sources_may_come_from_a_file_or_from_a_region_of_one(sphere_file, tmp_path):
    label = tmp_path / "lh.V1.label"
    label.write_text("#!ascii label\n3\n0 0 0 0 0\n1 0 0 0 0\n2 0 0 0 0\n")
    (tmp_path / "v.csv").write_text("vertex\n0\n1\n2\n")
    typed = [word for vertex in range(3) for word in ("--source", vertex)]
    expected = json.loads(run("distance", sphere_file, *typed, "--json").stdout)
    for source in (label, tmp_path / "v.csv", f"{annotation(tmp_path)}:V1"):
        report = json.loads(run("distance", sphere_file, "--source", source, "--json").stdout)
        assert report["sources"] == [0, 1, 2]
        assert report["mean"] == expected["mean"]


def test_a_region_may_be_the_mask(sphere_file, tmp_path):
    wall = f"{annotation(tmp_path)}:wall"
    report = json.loads(
        run("distance", sphere_file, "--source", 0, "--mask", wall, "--json").stdout
    )
    assert report["mask"] == wall
    assert report["unreachable"] >= 62


def test_files_of_vertices_that_cannot_be_used_are_refused(sphere_file, tmp_path):
    regions = annotation(tmp_path)
    table = tmp_path / "v.csv"
    table.write_text("5,0\n7,0\n")
    for told, status, *words in [
        (("--source", regions), 2, "lh.atlas.annot holds 3 regions"),
        (("--source", f"{regions}:V9"), 2, "no region 'V9'"),
        (("--source", tmp_path / "none.label"), 2, "nor a file of vertices"),
        (("--source", table), 3, "v.csv: '5,0' may be one number or two"),
        (("--source", 5, "--mask", tmp_path / "none.annot:V1"), 2, "does not exist"),
        (("--source", 5, "--mask", regions), 2, "choose a region: rest, V1, wall"),
    ]:
        fails(run("distance", sphere_file, *told), status, *words)
    table.write_text("5\n7\n")
    told = ("--source", table, "--output", table)
    fails(run("distance", sphere_file, *told), 2, "would overwrite the input")


@pytest.mark.slow
def test_outputs_for_other_programs_are_written(sphere_file, tmp_path):
    pytest.importorskip("vtk")
    pytest.importorskip("nibabel")
    outputs = [tmp_path / f"d.{suffix}" for suffix in ("vtp", "vtk", "vtu", "shape.gii", "txt")]
    options = [argument for output in outputs for argument in ("--output", output)]
    assert run("distance", sphere_file, "--source", 5, *options).exit_code == 0
    expected = gt.geodesic_distance(gt.read(sphere_file), 5)
    np.testing.assert_array_equal(np.loadtxt(outputs[-1]), expected)
    for output in outputs[:3]:
        assert gt.read(output).n_vertices == 162
    told = ("distance", sphere_file, "--source", 5, "--output", tmp_path / "d.obj")
    fails(run(*told), 2, "cannot hold distances", ".ply")


def test_what_a_format_needs_is_missed_before_the_work(sphere_file, tmp_path, monkeypatch):
    monkeypatch.setattr("geodesic_toolkit.solver.GeodesicSolver.__init__", None)  # never called
    for name in [name for name in sys.modules if name.partition(".")[0] == "vtkmodules"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "vtkmodules", None)
    told = ("distance", sphere_file, "--source", 5, "--output", tmp_path / "d.vtp")
    fails(run(*told), 2, "needs vtk: pip install")


# -- pictures ------------------------------------------------------------------------------------


def test_pictures_show_the_shape_wherever_the_points_are(sphere_file, tmp_path, monkeypatch):
    shown = []
    monkeypatch.setattr(viz, "plot", lambda *what, **look: shown.append((what, look)))
    np.save(tmp_path / "at.npy", [[0, 0, 1.0], [1e6, 0, 0]])
    told = ("distance", sphere_file, "--source", 150, "--at", tmp_path / "at.npy")
    assert run(*told, "--picture", tmp_path / "p.png").exit_code == 0
    [((domain, distances), look)] = shown
    assert isinstance(domain, gt.TriangleMesh)
    assert len(distances) == 162
    assert look["sources"] == [150]


@pytest.mark.slow
def test_distance_draws_the_parts(sphere_file, tmp_path):
    picture = tmp_path / "parts.png"
    result = run("distance", sphere_file, "--source", 0, "--parts", picture)
    assert result.exit_code == 0, result.output
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_distance_draws_a_picture_and_a_page(sphere_file, tmp_path):
    pytest.importorskip("pyvista")
    pytest.importorskip("k3d")
    picture, page = tmp_path / "d.png", tmp_path / "d.html"
    options = ["--picture", picture, "--html", page, "--cmap", "brg"]
    result = run("distance", sphere_file, "--source", "0,0,2", *options, "--json")
    assert result.exit_code == 0, result.output
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert "<html" in page.read_text(encoding="utf-8").lower()
    assert json.loads(result.stdout)["outputs"] == [str(picture), str(page)]


# -- stdout and stderr ---------------------------------------------------------------------------


def test_a_source_that_is_connected_to_nothing_is_warned_of(tmp_path):
    path = tmp_path / "lonely.off"
    path.write_text("OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 0\n5 5 5\n3 0 1 2\n")
    result = run("distance", path, "--source", 3, "--json")
    report = json.loads(result.stdout)
    assert (report["reached"], report["unreachable"]) == (1, 3)
    assert "connected to no other vertex" in report["warnings"][0]
    every = [word for vertex in range(4) for word in ("--source", vertex)]
    assert json.loads(run("distance", path, *every, "--json").stdout)["warnings"] == []
    assert result.stderr.startswith("warning: ")


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
