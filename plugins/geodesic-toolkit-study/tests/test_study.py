"""The study: does it find what it is about, on any mesh, and say only what the figures bear out?"""

import json
import re
import warnings
from unittest.mock import patch

import numpy as np
import pytest
from typer.testing import CliRunner

import geodesic_toolkit as gt
import geodesic_toolkit_study as study
from geodesic_toolkit.cli import app, progress
from geodesic_toolkit.errors import (
    CoarseMeshWarning,
    InvalidSourceError,
    MissingDependencyError,
    UnsupportedDomainError,
    WriteError,
)
from geodesic_toolkit.testing import shapes
from geodesic_toolkit_study import conclusions, run
from geodesic_toolkit_study.beyond import study_beyond
from geodesic_toolkit_study.discretizations import study_discretizations
from geodesic_toolkit_study.document import (
    Bullets,
    Figure,
    Heading,
    Paragraph,
    Table,
    as_html,
    as_markdown,
)
from geodesic_toolkit_study.krylov import conjugate_gradients, heat_matrix, rings
from geodesic_toolkit_study.noise import rank_correlation, study_noise
from geodesic_toolkit_study.report import compose
from geodesic_toolkit_study.results import Results
from geodesic_toolkit_study.subject import Subject, choose_sources, error_of, reference_distance
from geodesic_toolkit_study.sweeps import study_sizes, study_times, subdivided
from geodesic_toolkit_study.time_step import study_time_step


def run_program(*arguments):
    """Run the program in this process, without lines of progress however slow the machine is."""
    with patch.object(progress, "FIRST_PLAIN_LINE", 3600.0):
        return CliRunner().invoke(app, [str(argument) for argument in arguments])


def write_off(path, mesh):
    """Write a mesh, and give its path."""
    lines = [f"OFF\n{mesh.n_vertices} {mesh.n_faces} 0"]
    lines += [" ".join(map(repr, row)) for row in mesh.vertices.tolist()]
    lines += [f"3 {a} {b} {c}" for a, b, c in mesh.faces.tolist()]
    path.write_text("\n".join(lines) + "\n")
    return path


def rows_of(rows, **wanted):
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


@pytest.fixture(scope="module")
def tube():
    """Long enough for conjugate gradients to stop half way."""
    return shapes.tube(60, 8)


@pytest.fixture(scope="module")
def small_sizes():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("geodesic_toolkit_study.sweeps.LARGEST_SIZE", 1000)
        patch.setattr("geodesic_toolkit_study.sweeps.LARGEST_SPHERE", 300)
        yield


@pytest.fixture(scope="module")
def results(tube, small_sizes):
    with warnings.catch_warnings():
        # The tube is coarse for plain heat; the tables have its error.
        warnings.simplefilter("ignore", CoarseMeshWarning)
        subject = Subject(tube, "a tube", [3, 479])
        return Results(
            subject=subject,
            time_step=study_time_step(subject),
            noise=study_noise(subject),
            discretizations=study_discretizations(subject),
            beyond=study_beyond(subject),
            times=study_times(subject),
            sizes=study_sizes(subject),
        )


# -- the finding -----------------------------------------------------------------------------------


@pytest.mark.parametrize(("source", "zeros", "error"), [(2000, 1714, 24.2), (500, 1176, 21.1)])
def test_the_bunny_shows_the_zeros_of_conjugate_gradients(shared_data, source, zeros, error):
    subject = Subject(gt.read(shared_data("igltut__bunny.off")), "bunny", [source])
    found = study_time_step(subject)
    wanted = {"source": source, "time": "h^2", "solver": "cg", "rtol": 1e-5, "zeros": zeros}
    assert wanted in found.heat_zeros
    direct = [row for row in found.heat_zeros if row["solver"] == "superlu"]
    assert [row["zeros"] for row in direct] == [0, 0, 0]
    assert {row["rtol"] for row in direct} == {None}
    (by_cg,) = rows_of(found.rows, time="h^2", solver="cg")
    (directly,) = rows_of(found.rows, time="h^2", solver="superlu")
    assert by_cg["mean_error"] == pytest.approx(error, abs=0.1)
    assert directly["mean_error"] < 2.7


def test_conjugate_gradients_reach_one_ring_a_step(tube):
    metric = gt.CotanLaplacian().assemble(tube)
    matrix = heat_matrix(metric, metric.spacing**2)
    spike = np.zeros(tube.n_vertices)
    spike[3] = 1.0
    run_of_it = conjugate_gradients(matrix, spike, 1e-5)
    steps = np.arange(run_of_it.iterations)
    within = (rings(matrix, 3)[:, None] <= steps).sum(axis=0)
    assert run_of_it.converged
    assert run_of_it.iterations < rings(matrix, 3).max()
    np.testing.assert_array_equal(run_of_it.non_zero, within)


def test_zeros_are_where_no_step_came_and_a_direct_solver_leaves_none(results):
    found = results.time_step
    for row in rows_of(found.rows, time="h^2", solver="cg"):
        assert row["zeros"] == (found.rings[row["source"]] >= row["iterations"]).sum() > 0
        assert row["mean_error"] > 10
    assert all(row["zeros"] == 0 for row in rows_of(found.rows, solver="superlu"))


def test_a_smaller_tolerance_takes_more_steps_and_leaves_fewer_zeros(results):
    for source in results.subject.sources:
        rows = rows_of(results.time_step.tolerances, source=source)
        assert (np.diff([row["rtol"] for row in rows]) < 0).all()
        assert (np.diff([row["iterations"] for row in rows]) > 0).all()
        assert (np.diff([row["zeros"] for row in rows]) <= 0).all()


def test_noise_keeps_the_order_of_the_heat_better_than_the_lengths(results):
    rows = rows_of(results.noise.rows, source=3)
    assert all(row["rank_correlation_of_u"] > 0.9 for row in rows)
    assert (np.diff([row["change_of_true"] for row in rows]) > 0).all()


def test_the_same_seed_gives_the_same_noise(tube, results):
    again = study_noise(Subject(tube, "a tube", [3]))
    assert again.rows == rows_of(results.noise.rows, source=3)


def test_on_a_sphere_errors_fall_with_size(results):
    for refined in (False, True):
        rows = rows_of(results.sizes, surface="sphere", refined=refined)
        assert (np.diff([row["mean_error"] for row in rows]) < 0).all()


def test_refined_distances_are_the_best_of_all(results):
    errors = {row["method"]: row["mean_error"] for row in rows_of(results.beyond.rows, source=3)}
    assert min(errors, key=errors.get) in ("heat, refined", "point cloud, refined")


# -- the parts -------------------------------------------------------------------------------------


def test_subdividing_keeps_the_surface_and_its_first_vertices():
    grid = shapes.grid(4)
    finer = subdivided(grid)
    assert finer.n_faces == 4 * grid.n_faces
    np.testing.assert_array_equal(finer.vertices[: grid.n_vertices], grid.vertices)
    exact = np.linalg.norm(finer.vertices - finer.vertices[0], axis=1)
    np.testing.assert_allclose(gt.exact_distance(finer, 0), exact, atol=1e-12)


def test_sources_are_the_usual_ones_where_the_largest_part_has_them():
    assert choose_sources(shapes.icosphere(4), None).tolist() == [500, 2000]
    split = shapes.disjoint_union(shapes.icosphere(2), shapes.icosphere(4))
    assert choose_sources(split, None).tolist() == [500, 2000]
    smaller = shapes.disjoint_union(shapes.icosphere(3), shapes.icosphere(4))
    chosen = choose_sources(smaller, None)
    assert len(chosen) == 2
    assert (chosen >= 642).all()


def test_given_sources_are_taken_once_each():
    assert choose_sources(shapes.grid(3), [4, 0, 4]).tolist() == [4, 0]
    with pytest.raises(InvalidSourceError, match="9"):
        choose_sources(shapes.grid(3), [9])


def test_where_no_exact_distance_is_available_the_reference_says_so(tube, monkeypatch):
    metric = gt.CotanLaplacian().assemble(tube)
    exact, kind = reference_distance(tube, 3, metric)
    assert kind == "exact"
    monkeypatch.setattr("geodesic_toolkit_study.subject.LARGEST_EXACT", 10)
    refined, kind = reference_distance(tube, 3, metric)
    assert kind == "refined"
    assert error_of(refined, exact)["mean"] < 1.0


def test_a_mesh_whose_exact_distances_are_given_up_is_measured_against_refined_ones(monkeypatch):
    monkeypatch.setattr("geodesic_toolkit.exact.MOST_WINDOWS", 1)
    assert Subject(shapes.icosphere(3), "a ball", [2]).reference(2) == "refined"


def test_errors_do_not_count_what_is_not_reached():
    true = np.array([0.0, 1.0, 2.0, np.inf])
    assert error_of(np.array([0.0, 1.0, np.inf, np.inf]), true) == {"mean": 0.0, "largest": 0.0}
    assert error_of(np.full(4, np.inf), true) == {"mean": 0.0, "largest": 0.0}


def test_values_that_do_not_vary_have_no_correlation():
    assert rank_correlation(np.ones(3), np.arange(3.0)) is None
    assert rank_correlation(np.array([1.0, np.inf]), np.array([np.inf, 1.0])) is None


# -- the report ------------------------------------------------------------------------------------


def test_a_document_is_the_same_in_markdown_and_html():
    blocks = [
        Heading(1, "A <b> & c"),
        Paragraph("**bold** and `code`"),
        Bullets(["one", "two"]),
        Table(["a", "b"], [["x|y", "1"]]),
        Figure("f.png", "a caption"),
    ]
    text = as_markdown(blocks)
    assert "# A <b> & c" in text
    assert "x\\|y" in text
    assert "![a caption](f.png)" in text
    page = as_html("t", blocks, {"f.png": b"abc"})
    assert "<h1>A &lt;b&gt; &amp; c</h1>" in page
    assert "<strong>bold</strong> and <code>code</code>" in page
    assert 'src="data:image/jpeg;base64,YWJj"' in page


def test_the_conclusions_quote_the_figures(results):
    (row,) = rows_of(results.time_step.rows, source=3, time="h^2", solver="cg")
    said = conclusions.on_the_solver(results)
    assert f"**{row['zeros']:,} of 480**" in said[0]
    assert "the very same ones" in said[0]
    assert "no property of t = h²" in said[-1]


def test_where_nothing_is_flat_nothing_is_said_of_it(small_sizes):
    subject = Subject(shapes.icosphere(1), "a ball", [0])
    found = study_time_step(subject)
    assert not any(row["zeros"] for row in found.rows)
    plain = Results(
        subject=subject, time_step=found, noise=None, discretizations=None, beyond=None,
        times=None, sizes=[],
    )  # fmt: skip
    assert "nothing is flat" in conclusions.on_the_solver(plain)[-1]
    assert any("No tolerance leaves zeros" in line for line in conclusions.on_the_step(plain))


def test_every_experiment_has_its_place_in_the_report(results):
    text = as_markdown(compose(results))
    headings = ("The time step", "Noise", "Diffusion by other operators", "More accurate methods")
    for number, heading in enumerate(headings, start=1):
        assert f"## {number}. {heading}" in text
    assert "nan" not in text
    json.dumps(results.figures, allow_nan=False)


# -- the whole, and the command --------------------------------------------------------------------


@pytest.fixture(scope="module")
def drawing():
    pytest.importorskip("pyvista", reason="pictures need the extra viz")
    pytest.importorskip("matplotlib", reason="pictures need the extra viz")
    from geodesic_toolkit.viz.opengl import check_opengl, quiet

    try:
        with quiet():
            check_opengl()
    except MissingDependencyError as error:
        pytest.skip(str(error))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("geodesic_toolkit_study.pictures.CELL", (240, 120))
        for module in ("noise", "pictures"):
            patch.setattr(f"geodesic_toolkit_study.{module}.LEVELS", (0.01,))
        yield


@pytest.fixture(scope="module")
def written(drawing, small_sizes, tmp_path_factory):
    """The command, on two spheres."""
    folder = tmp_path_factory.mktemp("study")
    mesh = shapes.disjoint_union(shapes.icosphere(2), shapes.icosphere(1))
    path = write_off(folder / "spheres.off", mesh)
    out = folder / "out"
    return run_program("study", path, "--out", out, "--sources", "5"), out


def test_the_command_writes_figures_tables_and_conclusions(written):
    result, folder = written
    assert result.exit_code == 0, result.output
    assert "study.html" in result.stdout
    found = json.loads((folder / "study.json").read_text())
    assert found["sources"] == [5]
    assert {row["source"] for row in found["heat_zeros"]} == {5}
    assert {row["solver"] for row in found["heat_zeros"]} == {"cg", "superlu"}
    assert {row["time"] for row in found["heat_zeros"]} == {"h^2", "h", "1"}
    for name in found["figures"]:
        assert (folder / name).read_bytes().startswith(b"\x89PNG")
    assert {path.name for path in folder.iterdir()} == {
        "study.json", "study.md", "study.html", *found["figures"],
    }  # fmt: skip


def test_the_report_shows_every_figure_and_the_page_needs_no_network(written):
    _, folder = written
    figures = json.loads((folder / "study.json").read_text())["figures"]
    text = (folder / "study.md").read_text()
    page = (folder / "study.html").read_text()
    assert set(re.findall(r"\]\(([a-z0-9_]+\.png)\)", text)) == set(figures)
    assert page.count("<img ") == len(figures)
    assert "://" not in page  # a colon, which no embedded picture has


def test_a_list_of_sources_that_is_none_is_wrong_usage(tmp_path):
    (tmp_path / "m.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    result = run_program("study", tmp_path / "m.off", "--sources", "1,x")
    assert result.exit_code == 2
    assert "--sources 1,x" in result.stderr


def test_a_cloud_has_nothing_to_study(tmp_path):
    with pytest.raises(UnsupportedDomainError, match="triangle meshes, not a PointCloud"):
        study.run_study(gt.PointCloud(np.eye(3)), tmp_path)


def test_a_folder_that_cannot_be_made_is_found_before_the_work(drawing, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(WriteError, match="cannot be made"):
        study.run_study(shapes.grid(3), tmp_path / "file" / "out")


def test_without_the_extra_it_says_what_to_install(monkeypatch, tmp_path):
    def missing(*_):
        raise MissingDependencyError("pip install")

    monkeypatch.setattr(run, "require", missing)
    with pytest.raises(MissingDependencyError, match="pip install"):
        study.run_study(shapes.grid(3), tmp_path / "out")
    assert not (tmp_path / "out").exists()
