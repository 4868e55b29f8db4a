"""Right at any distance from the source, and infinite where nothing connects."""

import numpy as np
import pytest
from closed_forms import bent_path, mean_relative_error, on_plane, on_tube
from scipy.sparse import csr_array, eye_array

import geodesic_toolkit as gt
from geodesic_toolkit.heat.log_range import log_solve
from geodesic_toolkit.testing import shapes


@pytest.mark.parametrize(("rings", "around"), [(1200, 48), (4000, 16)])
def test_the_far_end_of_a_long_tube_is_right(rings, around):
    distance = gt.geodesic_distance(shapes.tube(rings, around), 0)
    far, exact = distance[-around:], on_tube(rings, around)[-around:]
    assert np.abs(far / exact - 1).max() < 0.005


@pytest.mark.slow
def test_the_far_corner_of_a_large_grid_is_right():
    mesh = shapes.grid(450, spacing=1.0)
    distance = gt.geodesic_distance(mesh, 0)
    assert abs(distance[-1] / np.hypot(449, 449) - 1) < 0.02
    assert mean_relative_error(distance, on_plane(mesh, 0)) < 0.01


def test_blocks_of_sources_at_different_ranges_agree_with_single_ones():
    solver = gt.GeodesicSolver(shapes.tube(1500, 6))
    sources = [0, 4500, 8999]
    together = solver.distances(sources)
    for row, source in zip(together, sources, strict=True):
        np.testing.assert_allclose(row, solver.distance(source), rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("kind", ["mesh", "cloud", "graph"])
def test_where_heat_is_level_blocks_agree_with_single_sources(kind):
    # from three corners of an icosahedron heat is level on the two triangles midway between them:
    # its rounding, another in a block, had a direction there, and turned distances by 2 %
    sphere = shapes.icosphere(3)
    edges = np.unique(np.sort(sphere.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    domain = {
        "mesh": sphere,
        "cloud": gt.PointCloud(sphere.vertices),
        "graph": gt.Graph(sphere.n_vertices, edges),
    }[kind]
    solver = gt.GeodesicSolver(domain, refine=False)
    corners = [3, 4, 5]
    for size in (2, 5, 16):
        together = solver.distances([corners, *range(size - 1)])
        np.testing.assert_allclose(together[0], solver.distance(corners), atol=1e-11)


def test_blocks_fill_negative_heat_where_single_sources_do():
    sphere, rng = shapes.icosphere(3), np.random.default_rng(2)
    bumps = 1 + rng.uniform(-0.25, 0.25, sphere.n_vertices)
    metric = gt.CotanLaplacian().assemble(
        gt.TriangleMesh(sphere.vertices * bumps[:, None], sphere.faces)
    )
    method = gt.HeatMethod(metric, heat_solver=gt.SuperLU(), poisson_solver=gt.SuperLU())
    sources = np.arange(0, sphere.n_vertices, 40)
    filled = [method.heat_report(source).non_positive for source in sources]
    assert set(filled) == {0, 1}  # of some of them, and harmless
    for row, source in zip(method.distances(sources), sources, strict=True):
        np.testing.assert_allclose(row, method.distance(source), rtol=1e-10, atol=1e-12)


def test_the_logarithm_of_heat_on_a_path_has_its_closed_form():
    graph, _ = bent_path(3000)
    log_heat = gt.GeodesicSolver(graph, operator=gt.UniformLaplacian(dim=1), refine=False).log_heat(
        0
    )
    # (1 + 2t) u_i = t (u_{i-1} + u_{i+1}) with t = h² = 1: a geometric sequence away from the end
    ratio = (3 - np.sqrt(5)) / 2
    np.testing.assert_allclose(np.diff(log_heat)[:2900], np.log(ratio), rtol=1e-9)


def test_restarts_agree_with_one_solve_where_both_are_possible():
    mesh = shapes.grid(60)
    discretization = gt.CotanLaplacian().assemble(mesh)
    method = gt.HeatMethod(  # so short a time that one solve passes the threshold of a restart
        discretization,
        time_factor=0.001,
        heat_solver=gt.SuperLU(),
        poisson_solver=gt.SuperLU(),
    )
    single = method.heat(0)
    log_heat = method.log_heat(0)
    resolved = single > 1e-290
    assert (single[resolved] < method._flow.own.systems()[0].smallest_final).sum() > 20
    np.testing.assert_allclose(log_heat[resolved], np.log(single[resolved]), rtol=1e-11)
    assert method.heat_report(0).stages > 1


def test_log_solve_leaves_what_is_not_connected_at_minus_infinity():
    two_paths = gt.Graph(5, [[0, 1], [2, 3], [3, 4]])
    discretization = gt.UniformLaplacian(dim=1).assemble(two_paths)
    matrix = csr_array(discretization.stiffness + eye_array(5))
    load = np.zeros((5, 1))
    load[0] = 1
    log_solution, stages = log_solve(matrix, gt.SuperLU().factorize(matrix), load)
    assert np.isfinite(log_solution[:2]).all()
    assert (log_solution[2:] == -np.inf).all()
    assert stages == 1


@pytest.fixture
def two_spheres():
    sphere = shapes.icosphere(2)
    apart = gt.TriangleMesh(sphere.vertices + 10, sphere.faces)
    return shapes.disjoint_union(sphere, apart), sphere.n_vertices


def test_another_component_is_infinitely_far(two_spheres):
    mesh, n = two_spheres
    distance = gt.geodesic_distance(mesh, 3)
    assert np.isfinite(distance[:n]).all()
    assert (distance[n:] == np.inf).all()


def test_a_source_in_each_component_reaches_everywhere(two_spheres):
    mesh, n = two_spheres
    distance = gt.geodesic_distance(mesh, [3, n + 3])
    assert np.isfinite(distance).all()
    np.testing.assert_allclose(distance[:n], distance[n:], atol=1e-12)
    assert distance[3] == distance[n + 3] == 0


def test_an_isolated_vertex_is_infinitely_far_and_alone_as_a_source():
    mesh = shapes.icosphere(2)
    lonely = gt.TriangleMesh(np.vstack([mesh.vertices, [[5.0, 5, 5]]]), mesh.faces)
    distance = gt.geodesic_distance(lonely, 0)
    assert distance[-1] == np.inf
    assert np.isfinite(distance[:-1]).all()
    alone = gt.geodesic_distance(lonely, mesh.n_vertices)
    assert alone[-1] == 0
    assert (alone[:-1] == np.inf).all()


def test_a_diffusion_that_does_not_reach_makes_infinity():
    strip = shapes.grid(12, 3)
    left = strip.faces[(strip.vertices[strip.faces][:, :, 0] <= 0.5).all(axis=1)]
    torn = gt.CotanLaplacian().assemble(gt.TriangleMesh(strip.vertices, left))
    superlu = gt.SuperLU()
    method = gt.HeatMethod(
        gt.CotanLaplacian().assemble(strip),
        diffusion=torn,
        heat_solver=superlu,
        poisson_solver=superlu,
    )
    distance = method.distance(0)
    cold = np.setdiff1d(np.arange(strip.n_vertices), left)
    assert (distance[cold] == np.inf).all()
    assert np.isfinite(distance[np.unique(left)]).all()
