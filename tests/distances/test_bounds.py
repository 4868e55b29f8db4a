"""No distance lies below the straight line to a source, and none above the path along edges."""

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

import geodesic_toolkit as gt
from geodesic_toolkit import _native
from geodesic_toolkit.errors import GeodesicWarning
from geodesic_toolkit.testing import shapes

ROUNDING = 1e-12

FILES = [
    "geomcentral__fox.ply",
    "igltut__3holes.off",
    "igltut__armadillo.obj",
    "igltut__bunny.off",
    "igltut__camelhead.off",
    "igltut__face.obj",
    "igltut__horse_quad.obj",
    "igltut__inspired_mesh_quads_Smooth.off",
    "igltut__octopus-low.mesh",
    "igltut__truck.obj",
    "jacobson__cow.obj",
    "jacobson__igea.ply",
    "jacobson__spot.obj",
    "jacobson__stanford-bunny.obj",
    "manifold__99865.stl",
    "meshlab__Laurana50k.ply",
    "meshlab__non_manif_hole.ply",
    "odedstein__koala_low_resolution.obj",
    "odedstein__spot_control_mesh.obj",
    "open3d__bunnyData.pts",
    "pcl__bun0.pcd",
    "pcldata__milk.pcd",
    "potpourri3d__bunny_poly.ply",
    "trimesh__counter.unitsmm.STL",
]


def positions(domain):
    return domain.points if isinstance(domain, gt.PointCloud) else domain.vertices


def straight_lines(domain, sources, offsets=0.0):
    places, starts = positions(domain), np.broadcast_to(offsets, np.shape(sources))
    least = np.full(len(places), np.inf)
    for source, start in zip(sources, starts, strict=True):
        away = places - places[source]
        np.minimum(least, start + np.sqrt((away**2).sum(axis=1)), out=least)
    return least


def along_edges(mesh, sources, offsets=0.0):
    edges = np.unique(np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    edges = edges[edges[:, 0] < edges[:, 1]]
    lengths = np.linalg.norm(np.diff(mesh.vertices[edges], axis=1)[:, 0], axis=1)
    # One more vertex, from which every source is as far as it is late; SciPy takes 0 for no edge.
    late = np.broadcast_to(offsets, np.shape(sources)).astype(float)
    begin = np.full(len(sources), mesh.n_vertices)
    ends = np.concatenate([edges.T, [begin, sources]], axis=1)
    graph = coo_array(
        (np.append(lengths, late + 1.0), tuple(ends)), shape=(mesh.n_vertices + 1,) * 2
    )
    found = dijkstra(graph.tocsr(), directed=False, indices=mesh.n_vertices)
    return found[:-1] - 1.0


def assert_possible(domain, distance, sources, offsets=0.0):
    reached = np.isfinite(distance)
    found = distance[reached]
    slack = ROUNDING * found.max()
    assert (found >= straight_lines(domain, sources, offsets)[reached] - slack).all()
    if isinstance(domain, gt.TriangleMesh):
        assert (found <= along_edges(domain, sources, offsets)[reached] + slack).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_distances_of_real_shapes_are_possible(shared_data, name):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GeodesicWarning)  # seams and the like are not in question
        domain = gt.read(shared_data(name))
        solver = gt.GeodesicSolver(domain)
        used = np.flatnonzero(solver.method.metric.mass > 0)
        several = np.random.default_rng(0).choice(used, 5, replace=False)
        for sources in (used[:1], several):
            assert_possible(domain, solver.distance(sources), sources)


@pytest.mark.slow
@given(
    seed=st.integers(0, 10_000),
    side=st.integers(3, 9),
    height=st.sampled_from([0.0, 0.02, 0.3, 3.0]),
    jitter=st.floats(0, 0.45),
    late=st.floats(0, 0.5),
)
def test_distances_on_rugged_ground_are_possible(seed, side, height, jitter, late):
    rng = np.random.default_rng(seed)
    flat = shapes.grid(side)
    shift = rng.uniform(-jitter, jitter, (flat.n_vertices, 3)) / (side - 1)
    shift[:, 2] = rng.uniform(0, height, flat.n_vertices)
    mesh = gt.TriangleMesh(flat.vertices + shift, flat.faces)
    sources = rng.choice(mesh.n_vertices, 3, replace=False)
    solver = gt.GeodesicSolver(mesh)
    assert_possible(mesh, solver.distance(sources), sources)
    offsets = late * rng.uniform(size=3)
    distance = solver.distance(gt.OffsetSources(sources, offsets))
    assert_possible(mesh, distance, sources, offsets)


@pytest.mark.slow
def test_a_region_of_many_vertices_holds_distances_by_its_nearest():
    sphere = shapes.icosphere(4)
    cap = np.flatnonzero(sphere.vertices[:, 2] > 0.7)
    assert len(cap) > 100
    for domain in (sphere, gt.PointCloud(sphere.vertices)):
        assert_possible(domain, gt.geodesic_distance(domain, cap), cap)


def test_rows_of_many_source_sets_are_held_like_single_ones():
    mesh = shapes.torus(24, 12)
    solver = gt.GeodesicSolver(mesh)
    sets = [[0], [3, 40, 90], [7, 8], [100]]
    for row, sources in zip(solver.distances(sets), sets, strict=True):
        np.testing.assert_array_equal(row, solver.distance(sources))


def test_a_point_in_a_face_and_a_curve_hold_them_too():
    ground = shapes.grid(15)
    bumps = 0.2 * np.sin(9 * ground.vertices[:, :1]) * np.cos(7 * ground.vertices[:, 1:2])
    mesh = gt.TriangleMesh(ground.vertices + bumps * [0, 0, 1], ground.faces)
    place = mesh.vertices[mesh.faces[30]].mean(axis=0)
    point = gt.SurfacePoint(30, (1 / 3, 1 / 3, 1 / 3))
    distance = gt.geodesic_distance(mesh, point)
    assert (distance >= np.linalg.norm(mesh.vertices - place, axis=1) - ROUNDING).all()
    corners = mesh.vertices[[16, 40, 130]]
    distance = gt.geodesic_distance(mesh, gt.Curve(corners))
    laid = gt.geodesic_distance(mesh, np.linspace(corners[0], corners[1], 200))
    assert (distance <= laid + 0.05).all()
    assert (distance >= 0).all()


# -- the kernel ------------------------------------------------------------------------------------


def held(mesh, distances, sources, offsets):
    rows = np.array(distances, dtype=float, ndmin=2)
    edges = _native.edges_of(mesh.faces, mesh.n_vertices)
    _native.Bounds(mesh.vertices, *edges).hold(
        np.array([0, len(sources)]),
        mesh.vertices[sources],
        np.asarray(offsets, dtype=float),
        rows,
    )
    return rows[0]


@given(seed=st.integers(0, 10_000), count=st.integers(1, 60))
def test_the_kernel_gives_the_nearest_values_that_are_possible(seed, count):
    rng = np.random.default_rng(seed)
    mesh = shapes.icosphere(2)
    sources = rng.choice(mesh.n_vertices, count, replace=False)
    offsets = rng.uniform(0, 0.5, count)
    wild = rng.uniform(0, 5, mesh.n_vertices)
    wild[sources] = np.minimum(wild[sources], offsets)
    found = held(mesh, wild, sources, offsets)
    raised = np.maximum(wild, straight_lines(mesh, sources, offsets))
    expected = along_edges(mesh, np.arange(mesh.n_vertices), raised)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_edges_of_triangles_are_each_there_from_both_ends_and_once():
    faces = np.array([[3, 1, 2], [2, 1, 0], [0, 1, 2], [5, 3, 2]])
    indptr, indices = _native.edges_of(faces, 7)
    rows = [part.tolist() for part in np.split(indices, indptr[1:-1])]
    assert rows == [[1, 2], [0, 2, 3], [0, 1, 3, 5], [1, 2, 5], [], [2, 3], []]
    assert [part.tolist() for part in _native.edges_of(faces[:0], 1)] == [[0, 0], []]
    with pytest.raises(ValueError, match="three vertices for each triangle"):
        _native.edges_of(faces[:, :2].copy(), 7)


def test_what_is_infinite_stays():
    two = shapes.disjoint_union(shapes.icosphere(1), shapes.icosphere(1))
    distance = np.where(np.arange(two.n_vertices) < 42, 1.0, np.inf)
    distance[0] = 0.0
    found = held(two, distance, np.array([0]), [0.0])
    np.testing.assert_array_equal(np.isinf(found), np.isinf(distance))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"begins": np.array([0, 2])}, "the places of each set"),
        ({"begins": np.array([0, 0, 1])}, "the places of each set"),
        ({"distances": np.zeros((1, 7))}, "a distance for each vertex"),
        ({"places": np.zeros((1, 2))}, "three coordinates for each place"),
        ({"n_threads": 0}, "at least one thread"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(change, message):
    mesh = shapes.icosphere(1)
    bounds = _native.Bounds(mesh.vertices, *_native.edges_of(mesh.faces, mesh.n_vertices))
    given = {
        "begins": np.array([0, 1]),
        "places": mesh.vertices[:1].copy(),
        "starts": np.zeros(1),
        "distances": np.zeros((1, mesh.n_vertices)),
    }
    with pytest.raises(ValueError, match=message):
        bounds.hold(**given | change)


def test_edges_that_do_not_fit_to_vertices_are_refused():
    mesh = shapes.icosphere(1)
    indptr, indices = _native.edges_of(mesh.faces, mesh.n_vertices)
    with pytest.raises(ValueError, match="the edges of each vertex"):
        _native.Bounds(mesh.vertices[:-1], indptr, indices)
    with pytest.raises(ValueError, match="indptr runs from 0"):
        _native.Bounds(mesh.vertices, indptr, indices[:-1])
    with pytest.raises(ValueError, match="three coordinates for each vertex"):
        _native.Bounds(mesh.vertices[:, :2].copy(), indptr, indices)


@pytest.mark.parametrize("scale", [1e-60, 1e60])
def test_lengths_beyond_single_precision_hold_distances_too(scale):
    mesh = shapes.icosphere(2)
    large = gt.TriangleMesh(mesh.vertices * scale, mesh.faces)
    wild = np.random.default_rng(0).uniform(0, 5, mesh.n_vertices)
    wild[0] = 0
    found = held(large, wild * scale, np.array([0]), [0.0])
    np.testing.assert_allclose(found / scale, held(mesh, wild, np.array([0]), [0.0]), rtol=1e-12)


@pytest.mark.parametrize("face", [(0, 0, 3), (0, 3, 3), (0, 3, 0)])
def test_a_face_with_a_repeated_vertex_does_not_lead_through_a_solid(face):
    sphere = shapes.icosphere(3)
    assert np.linalg.norm(sphere.vertices[0] + sphere.vertices[3]) < 1e-12  # opposite
    with_line = gt.TriangleMesh(sphere.vertices, np.concatenate([sphere.faces, [face]]))
    np.testing.assert_array_equal(
        gt.geodesic_distance(with_line, 0), gt.geodesic_distance(sphere, 0)
    )
