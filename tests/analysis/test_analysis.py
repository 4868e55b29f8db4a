"""Analysis of distances: residuals without exact distances, and comparisons."""

import json

import numpy as np
import pytest
from command_line import run
from scipy.stats import spearmanr

import geodesic_toolkit as gt
from geodesic_toolkit.analysis.comparison import Comparison, compare
from geodesic_toolkit.analysis.residual import mean_eikonal_residual
from geodesic_toolkit.analysis.variants import Variant, variants_for
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.testing import shapes

# -- residuals -----------------------------------------------------------------------------------


def test_the_distance_from_a_line_has_no_residual():
    mesh = shapes.grid(7, shear=0.4)
    solver = gt.GeodesicSolver(mesh)
    residual = gt.eikonal_residual(solver, mesh.vertices[:, 1])
    assert residual.shape == (mesh.n_faces,)
    assert residual.max() < 1e-12
    assert mean_eikonal_residual(solver, 1.25 * mesh.vertices[:, 1]) == pytest.approx(0.25)


def test_a_path_graph_has_no_residual_inside():
    graph_file = gt.Graph(9, [[i, i + 1] for i in range(8)], np.full(8, 0.5))
    solver = gt.GeodesicSolver(graph_file, operator=gt.UniformLaplacian(dim=1))
    residual = gt.eikonal_residual(solver, np.arange(9) * 0.5)
    assert residual.shape == (8,)
    assert residual.max() < 1e-9


def test_elements_without_a_distance_have_no_residual():
    mesh = shapes.disjoint_union(shapes.grid(12), shapes.grid(3))
    solver = gt.GeodesicSolver(mesh)
    distance = solver.distance(0)
    residual = gt.eikonal_residual(solver, distance)
    np.testing.assert_array_equal(np.isnan(residual), np.arange(mesh.n_faces) >= 242)
    assert np.isfinite(mean_eikonal_residual(solver, distance))
    assert np.isnan(mean_eikonal_residual(solver, np.full(mesh.n_vertices, np.inf)))


def test_the_residual_is_larger_where_the_distance_is_worse():
    mesh = shapes.icosphere(3)
    solver = gt.GeodesicSolver(mesh)
    exact = gt.exact_distance(mesh, 0)
    noise = np.random.default_rng(0).normal(size=mesh.n_vertices)
    sizes = [0.0, 0.002, 0.01, 0.05]
    found = [mean_eikonal_residual(solver, exact + size * noise) for size in sizes]
    assert spearmanr(sizes, found).statistic == 1


def test_residuals_refuse_what_they_cannot_measure():
    solver = gt.GeodesicSolver(shapes.grid(3))
    with pytest.raises(InvalidOptionError, match=r"shape \(9,\)"):
        gt.eikonal_residual(solver, np.zeros(8))

    class Foreign(gt.Gradient):
        n_vertices = 9
        matrix = weights = None

        def unit(self, log_heat):
            raise NotImplementedError

        adjoint = stiffness = unit

    object.__setattr__(solver.method.metric, "gradient", Foreign())
    with pytest.raises(UnsupportedDomainError, match="cannot be computed from"):
        gt.eikonal_residual(solver, np.zeros(9))


# -- comparisons ---------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def on_a_sphere():
    return compare(shapes.icosphere(3), 0)


@pytest.mark.slow
def test_a_comparison_measures_against_the_exact_distance(on_a_sphere):
    mesh = shapes.icosphere(3)
    assert isinstance(on_a_sphere, Comparison)
    assert on_a_sphere.reference_name == "exact polyhedral distance"
    np.testing.assert_allclose(on_a_sphere.reference, gt.exact_distance(mesh, 0))
    refined, plain = on_a_sphere.row("auto"), on_a_sphere.row("plain heat")
    np.testing.assert_allclose(refined.distance, gt.geodesic_distance(mesh, 0), atol=1e-12)
    assert refined.mean < plain.mean / 5
    assert refined.asymmetry < plain.asymmetry
    assert plain.factor_bytes > refined.factor_bytes > 0
    error = on_a_sphere.error("auto")
    assert error[0] == 0
    assert error[1:].mean() == pytest.approx(refined.mean)
    assert error.max() == pytest.approx(refined.largest)


@pytest.mark.slow
def test_a_comparison_varies_all_that_there_is(on_a_sphere):
    groups = {row.variant.group for row in on_a_sphere.rows}
    assert groups == {"default", "refinement", "operator", "time", "diffusion", "solver", "domain"}
    names = [row.variant.name for row in on_a_sphere.rows]
    assert len(names) == len(set(names))
    assert {"cotan", "uniform", "cloud of the vertices", "graph of the edges"} <= set(names)
    assert all(row.failure is None for row in on_a_sphere.rows)
    open_groups = {variant.group for variant in variants_for(shapes.grid(4))}
    assert "boundary" in open_groups


def test_a_variant_that_fails_is_a_row_that_says_so():
    mesh = shapes.grid(5)
    bad = Variant("bad", "operator", {"operator": "pointcloud"})
    comparison = compare(mesh, 0, variants=[Variant("auto", "default"), bad])
    row = comparison.row("bad")
    assert "discretizes PointCloud" in row.failure
    assert np.isnan(row.mean)
    with pytest.raises(InvalidOptionError, match="failed and has no errors"):
        comparison.error("bad")
    with pytest.raises(InvalidOptionError, match="those compared are 'auto', 'bad'"):
        comparison.row("worse")


def test_the_reference_is_refined_where_exact_distance_is_expensive():
    mesh = shapes.icosphere(2)
    comparison = compare(mesh, 0, variants=[Variant("auto", "default")], affordable_faces=10)
    assert comparison.reference_name == "refined distance"


def test_graphs_and_clouds_are_compared_too():
    graph_file = gt.Graph(20, [[i, i + 1] for i in range(19)])
    comparison = compare(graph_file, 0)
    assert comparison.reference_name == "shortest path along edges"
    np.testing.assert_allclose(comparison.reference, np.arange(20))
    cloud = compare(gt.PointCloud(shapes.icosphere(2).vertices), [0.0, 0.0, 2.0])
    assert cloud.reference_name == "refined distance"
    assert cloud.row("auto").largest < 1e-9


def test_of_parallel_edges_the_shortest_is_the_reference_and_loops_are_none():
    graph = gt.Graph(3, [[0, 1], [1, 0], [1, 1], [1, 2]], [5.0, 2.0, 1.0, 3.0])
    np.testing.assert_array_equal(compare(graph, 0).reference, [0.0, 2.0, 5.0])


def test_progress_is_reported():
    told = []
    two = [Variant("auto", "default"), Variant("again", "default")]
    compare(shapes.grid(4), 0, variants=two, progress=lambda *done: told.append(done))
    assert told == [(1, 2), (2, 2)]


# -- the command ---------------------------------------------------------------------------------


def test_compare_prints_a_table(sphere_file):
    result = run("compare", sphere_file, "--source", 0)
    assert result.exit_code == 0, result.output
    lines = result.stdout.splitlines()
    assert lines[0].startswith("WAY")
    assert lines[1].startswith("auto ")
    assert "against  exact polyhedral distance" in result.stdout


def test_compare_prints_one_json_object(sphere_file):
    result = run("compare", sphere_file, "--source", "0,0,2", "--json")
    report = json.loads(result.stdout)
    assert report["reference"] == "exact polyhedral distance"
    ways = {way["name"]: way for way in report["ways"]}
    assert ways["auto"]["mean"] < ways["plain heat"]["mean"]
    assert ways["plain heat"]["options"] == {"refine": False}
    assert {"build", "per_source", "factor_bytes", "asymmetry"} <= set(ways["auto"])


@pytest.mark.slow
def test_compare_draws_the_error(sphere_file, tmp_path):
    pytest.importorskip("pyvista")
    picture = tmp_path / "error.png"
    result = run("compare", sphere_file, "--source", 0, "--picture", picture, "--of", "uniform")
    assert result.exit_code == 0, result.output
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert str(picture) in result.stdout


def test_compare_refuses_a_way_that_there_is_not(sphere_file, tmp_path):
    pytest.importorskip("pyvista")
    picture = tmp_path / "error.png"
    result = run("compare", sphere_file, "--source", 0, "--picture", picture, "--of", "fastest")
    assert result.exit_code == 2
    assert "not a variant 'fastest'" in result.stderr
    assert not picture.exists()
