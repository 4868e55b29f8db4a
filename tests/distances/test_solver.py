"""The solver: sources of every kind, options, threads, pickles, errors before any work."""

import copy
import multiprocessing
import pickle
import warnings
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    NonPositiveHeatWarning,
    UnknownPluginError,
    UnsupportedDomainError,
)
from geodesic_toolkit.testing import shapes


@pytest.fixture(scope="module")
def sphere():
    return shapes.icosphere(3)


@pytest.fixture(scope="module")
def solver(sphere):
    return gt.GeodesicSolver(sphere)


def test_a_single_source_reads_exactly_zero(solver):
    for source in (0, 17, 641):
        assert solver.distance(source)[source] == 0


def test_distance_takes_one_index_or_an_array_of_them(solver):
    np.testing.assert_array_equal(solver.distance(5), solver.distance([5]))
    np.testing.assert_array_equal(solver.distance(5), solver.distance(np.uint8(5)))
    np.testing.assert_array_equal(solver.distance([5, 9]), solver.distance((5, 9)))


def test_several_sources_have_mean_zero(solver):
    distance = solver.distance([0, 100, 300])
    assert abs(distance[[0, 100, 300]].mean()) < 1e-12


def test_a_repeated_source_weighs_no_more_than_the_mean(solver):
    np.testing.assert_allclose(solver.distance([7, 7]), solver.distance(7), atol=1e-12)


@settings(max_examples=20, deadline=None)
@given(st.lists(st.integers(0, 641), min_size=1, max_size=6))
def test_the_order_of_sources_does_not_matter(sources):
    solver = gt.GeodesicSolver(SPHERE)
    np.testing.assert_allclose(solver.distance(sources), solver.distance(sources[::-1]), atol=1e-12)


SPHERE = shapes.icosphere(3)


def test_many_sources_equal_one_by_one(solver):
    sources = np.arange(0, 642, 17)
    together = solver.distances(sources)
    assert together.shape == (len(sources), 642)
    for row, source in zip(together, sources, strict=True):
        np.testing.assert_allclose(row, solver.distance(source), atol=1e-12)


def test_source_sets_may_differ_in_size_and_kind(solver):
    sets = [3, [4, 5], np.array([0.0, 0, 2]), gt.SurfacePoint(0, (0.2, 0.3, 0.5))]
    together = solver.distances(sets)
    for row, sources in zip(together, sets, strict=True):
        np.testing.assert_allclose(row, solver.distance(sources), atol=1e-12)


def test_progress_counts_the_sets(solver):
    calls = []
    solver.distances(range(40), progress=lambda done, total: calls.append((done, total)))
    assert calls == [(16, 40), (32, 40), (40, 40)]


def test_a_point_in_space_snaps_to_the_surface(solver, sphere):
    np.testing.assert_allclose(
        solver.distance(3 * sphere.vertices[11]), solver.distance(11), atol=1e-9
    )


def test_a_point_inside_a_face_measures_its_corners_right():
    mesh = shapes.grid(21)
    point = np.array([0.512, 0.481, 0.0])
    exact = np.linalg.norm(mesh.vertices - point, axis=1)
    distance = gt.GeodesicSolver(mesh).distance(point)
    far = exact > 0.2
    assert (np.abs(distance - exact)[far] / exact[far]).mean() < 0.035
    corners = exact < 0.05
    np.testing.assert_allclose(distance[corners].mean(), exact[corners].mean(), atol=0.01)


def test_a_surface_point_at_a_corner_is_that_vertex(solver, sphere):
    at_corner = gt.SurfacePoint(8, (0.0, 1.0, 0.0))
    np.testing.assert_allclose(
        solver.distance(at_corner), solver.distance(sphere.faces[8, 1]), atol=1e-12
    )


@pytest.mark.parametrize(
    "sources",
    [
        642,
        -1,
        10**12,
        [],
        [[1, 2]],
        True,
        "0",
        None,
        1.5,
        [0.5, 1.5],
        [np.nan, 0, 0],
        [[0.0, 0, np.inf]],
        {},
        [0, None],
        [[0, 1], [2]],
        gt.SurfacePoint(1280, (1, 0, 0)),
        gt.SurfacePoint(-1, (1, 0, 0)),
        [gt.SurfacePoint(0, (1, 0, 0)), 3],
    ],
    ids=repr,
)
def test_sources_that_name_no_place_are_refused(solver, sources):
    with pytest.raises(InvalidSourceError):
        solver.distance(sources)


@pytest.mark.parametrize(
    "sets", [7, "01", [], [3, -1], [3, []], np.zeros((2, 4)), [[0], [1.5]]], ids=repr
)
def test_source_sets_that_cannot_be_are_refused(solver, sets):
    with pytest.raises(InvalidSourceError):
        solver.distances(sets)


def test_a_bad_source_set_is_named(solver):
    with pytest.raises(InvalidSourceError, match="source set 2: vertex 900 does not exist"):
        solver.distances([3, 4, 900])


def test_a_graph_has_no_positions_to_snap_to():
    solver = gt.GeodesicSolver(gt.Graph(3, [[0, 1], [1, 2]]))
    with pytest.raises(InvalidSourceError, match="has no positions"):
        solver.distance([0.0, 0.0, 0.0])
    with pytest.raises(InvalidSourceError, match="needs a TriangleMesh"):
        solver.distance(gt.SurfacePoint(0, (1, 0, 0)))


@pytest.mark.parametrize(
    "options",
    [
        {"time": 0.0},
        {"time": -1.0},
        {"time": np.nan},
        {"time": "short"},
        {"time_factor": 0},
        {"time_factor": np.inf},
        {"time": 1.0, "time_factor": 2.0},
        {"boundary": "periodic"},
        {"solver": {"heat": "superlu", "wave": "cg"}},
        {"solver": {"heat": "cg"}},
        {"solver": 3},
        {"operator": 3},
        {"operator": gt.SuperLU},
    ],
    ids=repr,
)
def test_options_outside_their_values_are_refused(sphere, options):
    with pytest.raises(InvalidOptionError):
        gt.GeodesicSolver(sphere, **options)


def test_an_unknown_operator_is_named(sphere):
    with pytest.raises(UnknownPluginError, match="cotangent"):
        gt.GeodesicSolver(sphere, operator="cotangent")


def test_an_object_that_is_not_a_domain_is_refused(sphere):
    for thing in (7, {"vertices": sphere.vertices}, None, "bunny.off"):
        with pytest.raises(UnsupportedDomainError, match="is not a shape"):
            gt.GeodesicSolver(thing)
    with pytest.raises(UnsupportedDomainError, match="CotanLaplacian discretizes TriangleMesh"):
        gt.GeodesicSolver(gt.Graph(2, [[0, 1]]), operator="cotan")


def test_the_shapes_of_others_are_converted(sphere, solver):
    by_arrays = gt.GeodesicSolver((sphere.vertices, sphere.faces))
    assert isinstance(by_arrays.domain, gt.TriangleMesh)
    np.testing.assert_array_equal(by_arrays.distance(3), solver.distance(3))
    one_line = gt.geodesic_distance([sphere.vertices.tolist(), sphere.faces.tolist()], 3)
    np.testing.assert_array_equal(one_line, solver.distance(3))


def test_metric_and_diffusion_must_have_the_same_vertices(sphere):
    superlu = gt.SuperLU()
    with pytest.raises(UnsupportedDomainError, match="642 vertices"):
        gt.HeatMethod(
            gt.CotanLaplacian().assemble(shapes.grid(3)),
            diffusion=gt.CotanLaplacian().assemble(sphere),
            heat_solver=superlu,
            poisson_solver=superlu,
        )


def test_cg_serves_the_poisson_step(sphere, solver):
    by_cg = gt.GeodesicSolver(sphere, solver="cg", refine=False)
    assert by_cg.method.heat_solver == gt.Supernodal()
    assert by_cg.method.poisson_solver == gt.CG()
    direct = gt.GeodesicSolver(sphere, refine=False)
    np.testing.assert_allclose(by_cg.distance(0), direct.distance(0), atol=1e-5)


def test_cg_for_heat_needs_to_be_insisted_on_and_warns():
    mesh = shapes.grid(60)
    loose = gt.CG(rtol=1e-5, allow_heat=True)
    solvers = {"heat": loose, "poisson": gt.CG()}
    insisted = gt.GeodesicSolver(mesh, solver=solvers, refine=False)
    assert (insisted.heat(0) == 0).sum() > 500
    with pytest.warns(NonPositiveHeatWarning, match="an iterative solver cannot resolve it"):
        insisted.distance(0)
    # Without heat there is no order, and sweeps go on until the front is everywhere.
    refined = gt.geodesic_distance(mesh, 0, solver=solvers)
    np.testing.assert_allclose(refined, np.linalg.norm(mesh.vertices, axis=1), rtol=2e-3)


def test_the_uniform_diffusion_on_a_mesh_knows_no_lengths(sphere):
    uniform = gt.UniformLaplacian(mass="identity")
    solver = gt.GeodesicSolver(sphere, diffusion=uniform, time=1.0)
    discretization = solver.method.diffusion
    assert (discretization.mass == 1).all()
    assert (discretization.gradient.weights == 1).all()
    assert discretization.spacing == pytest.approx(solver.method.metric.spacing)
    distance = solver.distance(0)
    exact = 2 * np.arcsin(np.linalg.norm(sphere.vertices - sphere.vertices[0], axis=1) / 2)
    assert np.corrcoef(distance, exact)[0, 1] > 0.99


def test_eight_threads_get_the_same_bits_as_one(solver):
    sources = list(range(0, 640, 20))
    alone = [solver.distance(source) for source in sources]
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(solver.distance, sources))
    for one, other in zip(alone, together, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    "through", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))]
)
def test_a_copy_gives_the_same_bits(solver, through):
    twin = through(solver)
    np.testing.assert_array_equal(twin.distance(3), solver.distance(3))
    assert twin.operator == solver.operator


def test_pickles_do_not_carry_the_factors(sphere):
    discretization = gt.CotanLaplacian().assemble(sphere)
    superlu = gt.SuperLU()
    method = gt.HeatMethod(discretization, heat_solver=superlu, poisson_solver=superlu)
    before = len(pickle.dumps(method))
    method.prepare()
    assert method.nbytes > 0
    assert len(pickle.dumps(method)) == before


@pytest.mark.slow
@pytest.mark.parametrize("context", ["spawn", "fork"])
def test_it_works_in_process_pools(solver, context):
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context(context)) as pool:
        rows = list(pool.map(solver.distance, [0, 5]))
    np.testing.assert_array_equal(rows[0], solver.distance(0))
    np.testing.assert_array_equal(rows[1], solver.distance(5))


def test_the_representation_shows_sizes(solver):
    text = repr(solver)
    for part in ("642 vertices", "CotanLaplacian", "time=", "Supernodal", "MB"):
        assert part in text


def test_integrating_the_gradient_of_a_function_gives_it_back(sphere):
    method = gt.GeodesicSolver(sphere, refine=False).method
    gradient = method.metric.gradient
    height = sphere.vertices[:, 2]
    field = (gradient.matrix @ height).reshape(-1, 2)
    found = method.integrate(field)
    np.testing.assert_allclose(found - found[0], height - height[0], atol=1e-10)


def test_the_diagnosis_shows_the_findings():
    mesh = shapes.disjoint_union(shapes.grid(6), shapes.icosphere(1))
    lonely = gt.TriangleMesh(np.vstack([mesh.vertices, [[9.0, 9, 9]]]), mesh.faces)
    diagnosis = gt.GeodesicSolver(lonely).diagnosis
    assert diagnosis.components == 2
    assert diagnosis.isolated_vertices == 1
    assert diagnosis.boundary_vertices == 20
    assert diagnosis.non_manifold_edges == 0
    assert diagnosis.minimum_angle == pytest.approx(45)
    assert diagnosis.non_positive == 0
    assert diagnosis.stages == 1
    assert diagnosis.as_dict()["notes"]["triangulation"] == "given"
    assert "minimum_angle" in str(diagnosis)


def test_a_held_boundary_that_holds_every_vertex_of_a_part_breaks_nothing():
    lone = gt.TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    strip = shapes.grid(40, 4)  # from a corner, no heat gets past the boundary
    mesh = shapes.disjoint_union(lone, strip)
    solver = gt.GeodesicSolver(mesh, boundary="dirichlet").method
    with warnings.catch_warnings():
        # None, or almost none: the weights of the diagonals of right triangles are rounding.
        warnings.simplefilter("ignore", NonPositiveHeatWarning)
        distances = solver.distances([0, 3])
    assert (distances[0, :3] >= 0).all()
    assert (distances[0, 3:] == np.inf).all()
    assert (distances[1, :3] == np.inf).all()
