"""Shapes of any quality have an answer: units, slivers, parts of other sizes, soups of faces."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    CoarseMeshWarning,
    GeodesicError,
    InvalidDomainError,
    NonPositiveHeatWarning,
    SeamWarning,
    UnsupportedDomainError,
)
from geodesic_toolkit.testing import shapes

MESH = shapes.icosphere(2)
V, F = MESH.vertices, MESH.faces
N = len(V)


# -- meshes of any quality -------------------------------------------------------------------------


def test_a_few_vertices_earn_a_warning_by_name_and_refinement_needs_none():
    square = gt.TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [[0, 1, 2], [1, 3, 2]])
    with pytest.warns(CoarseMeshWarning, match=r"has 4 vertices.*refine=True"):
        gt.geodesic_distance(square, 0, refine=False)
    distance = gt.geodesic_distance(square, 0)
    np.testing.assert_allclose(distance[:3], [0, 1, 1])
    mixed = gt.GeodesicSolver(shapes.disjoint_union(MESH, square), refine=False)
    assert np.isfinite(mixed.distance(0)[:N]).all()  # no warning: the source is elsewhere
    assert mixed.diagnosis.coarse_components == 1
    with pytest.warns(CoarseMeshWarning):
        mixed.distances([0, N])


@pytest.mark.parametrize("scale", [1e-12, 1e-6, 1e6, 1e12])
def test_the_unit_of_length_does_not_matter(scale):
    expected = scale * gt.geodesic_distance(MESH, 3)
    distance = gt.geodesic_distance((scale * V, F), 3)
    np.testing.assert_allclose(distance, expected, rtol=1e-7, atol=1e-12 * scale)


@pytest.mark.parametrize("refine", [False, True])
@pytest.mark.parametrize("ratio", [1e-3, 1e-6, 1e-9, 1e6])
def test_parts_of_any_size_beside_each_other_read_what_each_reads_alone(refine, ratio):
    flat = gt.TriangleMesh(  # with a face without area
        np.vstack([V, (V[F[7, 0]] + V[F[7, 1]]) / 2]), np.vstack([F, [F[7, 0], F[7, 1], N]])
    )
    other = gt.TriangleMesh(flat.vertices * ratio, flat.faces)
    both = gt.GeodesicSolver(shapes.disjoint_union(MESH, other), refine=refine)
    for part, start in ((MESH, 0), (other, N)):
        alone = gt.geodesic_distance(part, 3, refine=refine)
        found = both.distance(start + 3)[start : start + part.n_vertices]
        np.testing.assert_allclose(found, alone, rtol=1e-9, atol=1e-9 * alone.max())


def test_surveyors_coordinates_cost_their_own_rounding_alone():
    shifted = gt.geodesic_distance((V + np.array([5e6, 4e6, 300]), F), 3)
    np.testing.assert_allclose(shifted, gt.geodesic_distance(MESH, 3), rtol=1e-6, atol=1e-6)


def test_slivers_of_a_hundredth_of_a_degree_do_no_harm():
    fine = shapes.grid(31)
    thin = fine.vertices * [1.0, 1.0, 1.0]
    middle = (fine.vertices[fine.faces[:, 0]] + fine.vertices[fine.faces[:, 1]]) / 2
    third = fine.vertices[fine.faces[:, 2]]
    vertices = np.concatenate([thin, middle + 1e-4 * (third - middle)])
    extra = len(thin) + np.arange(fine.n_faces)
    a, b, c = fine.faces.T
    faces = np.concatenate(
        [np.column_stack(side) for side in ((a, b, extra), (b, c, extra), (c, a, extra))]
    )
    mesh = gt.TriangleMesh(vertices, faces)
    assert gt.GeodesicSolver(mesh).diagnosis.minimum_angle < 0.02
    exact = np.linalg.norm(vertices - vertices[0], axis=1)
    for refine, bound in ((False, 0.1), (True, 0.01)):
        distance = gt.geodesic_distance(mesh, 0, refine=refine)
        away = exact > 0.1
        assert (np.abs(distance - exact)[away] / exact[away]).mean() < bound


# -- fuzzing ---------------------------------------------------------------------------------------


def answer_or_typed_error(domain, source, **options):
    """Return the distances, checked, or None where a typed error said why not."""
    import warnings

    with warnings.catch_warnings():
        for category in (CoarseMeshWarning, NonPositiveHeatWarning, SeamWarning):
            warnings.simplefilter("ignore", category)
        try:
            distance = gt.geodesic_distance(domain, source, **options)
        except GeodesicError:
            return None
    assert not np.isnan(distance).any()
    assert (distance >= 0).all()
    assert distance[source] == 0
    return distance


SMALL_FLOATS = st.floats(-2, 2, width=32).map(lambda x: round(x, 3))


@pytest.mark.slow
@settings(max_examples=80)
@given(
    hnp.arrays(np.float64, st.tuples(st.integers(3, 12), st.just(3)), elements=SMALL_FLOATS),
    hnp.arrays(np.int64, st.tuples(st.integers(1, 20), st.just(3)), elements=st.integers(0, 2**20)),
    st.booleans(),
    st.integers(0, 2**20),
)
def test_any_soup_of_faces_has_an_answer_or_a_typed_error(vertices, faces, refine, source):
    count = len(vertices)
    mesh = gt.TriangleMesh(vertices, faces % count)
    distance = answer_or_typed_error(mesh, source % count, refine=refine)
    if distance is None:
        with pytest.raises(UnsupportedDomainError, match="at one position"):
            gt.GeodesicSolver(mesh)


@pytest.mark.slow
@settings(max_examples=50)
@given(
    hnp.arrays(
        np.float64,
        st.tuples(st.integers(1, 30), st.just(3)),
        elements=st.one_of(SMALL_FLOATS, st.just(np.nan)),
    ),
)
def test_any_cloud_has_an_answer_which_refinement_reaches_as_far(points):
    present = np.flatnonzero(np.isfinite(points).all(axis=1))
    if not len(present):
        with pytest.raises(InvalidDomainError):
            gt.PointCloud(points)
        return
    pca = gt.PointCloudLaplacian(normals="pca")
    cloud = gt.PointCloud(points)
    plain, refined = (
        answer_or_typed_error(cloud, int(present[0]), operator=pca, refine=refine)
        for refine in (False, True)
    )
    assert plain is not None
    assert refined is not None
    np.testing.assert_array_equal(np.isfinite(plain), np.isfinite(refined))
    assert (plain[np.setdiff1d(np.arange(len(points)), present)] == np.inf).all()


@pytest.mark.slow
@settings(max_examples=60)
@given(
    st.integers(1, 15),
    hnp.arrays(np.int64, st.tuples(st.integers(0, 30), st.just(2)), elements=st.integers(0, 2**20)),
    st.randoms(use_true_random=False),
)
def test_any_graph_has_an_answer(count, edges, random):
    lengths = np.array([random.choice([0.01, 0.1, 1.0, 3.0, 100.0]) for _ in edges])
    graph = gt.Graph(count, edges % count, lengths)
    assert answer_or_typed_error(graph, count - 1) is not None
    lengths *= np.array(
        [random.choice([1.0, 1e-12, 1e12]) for _ in edges]
    )  # past float64: may fail
    answer_or_typed_error(gt.Graph(count, edges % count, lengths), count - 1)


def test_parts_of_a_mesh_of_other_sizes_read_what_each_reads_alone():
    fine, large = shapes.icosphere(4), shapes.icosphere(3, radius=30.0)
    both = gt.GeodesicSolver(shapes.disjoint_union(fine, large))
    alone = [gt.GeodesicSolver(part).distance(0) for part in (fine, large)]
    distance = both.distance([0, fine.n_vertices])
    np.testing.assert_allclose(distance[: fine.n_vertices], alone[0], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(distance[fine.n_vertices :], alone[1], rtol=1e-9, atol=1e-12)


@pytest.mark.filterwarnings("ignore::geodesic_toolkit.errors.CoarseMeshWarning")
def test_heat_has_the_time_to_cross_a_surface_of_long_triangles_with_a_fine_corner():
    """Half of the vertices in one corner make the mean edge say nothing about the surface."""
    side = np.concatenate([np.linspace(0, 0.02, 25), np.linspace(0.1, 1, 12)])
    x, y = (a.ravel() for a in np.meshgrid(side, side, indexing="ij"))
    corner = np.arange(37 * 36).reshape(36, 37)[:, :-1].ravel()
    faces = np.concatenate(
        [
            np.column_stack([corner, corner + 37, corner + 38]),
            np.column_stack([corner, corner + 38, corner + 1]),
        ]
    )
    mesh = gt.TriangleMesh(np.column_stack([x, y, np.zeros_like(x)]), faces)
    solver = gt.GeodesicSolver(mesh, refine=False)
    metric = solver.method.metric
    assert metric.scales[0] > 1.05 * metric.spacing
    assert solver.method.time == pytest.approx(metric.scales[0] ** 2)
    far = np.hypot(x, y) > 0.2
    plain = gt.GeodesicSolver(mesh, time=metric.spacing**2, refine=False)
    ours, theirs = (
        np.abs(each.distance(0)[far] / np.hypot(x, y)[far] - 1).mean() for each in (solver, plain)
    )
    assert ours < 0.09 < theirs


def test_a_part_with_edges_as_long_as_it_is_wide_warns():
    sphere, turn = shapes.icosphere(3), np.arange(12)
    rim = np.column_stack([np.cos(turn * np.pi / 6), np.sin(turn * np.pi / 6), 0 * turn])
    pipe = gt.TriangleMesh(
        np.concatenate([rim, rim + np.array([0, 0, 8.0])]),
        np.concatenate(
            [
                np.column_stack([turn, (turn + 1) % 12, turn + 12]),
                np.column_stack([(turn + 1) % 12, (turn + 1) % 12 + 12, turn + 12]),
            ]
        ),
    )
    coarse = gt.GeodesicSolver(shapes.disjoint_union(sphere, pipe), refine=False)
    assert np.isfinite(coarse.distance(0)[: sphere.n_vertices]).all()
    with pytest.warns(CoarseMeshWarning, match="has 24 vertices"):
        coarse.distance(sphere.n_vertices)
    assert coarse.diagnosis.coarse_components == 1
    gt.geodesic_distance(coarse.domain, sphere.n_vertices)


def test_refinement_on_the_flips_that_auto_makes_is_exact_on_a_sheared_plane():
    mesh = shapes.grid(20, shear=3.0)
    distance = gt.geodesic_distance(mesh, 210, refine=True)
    exact = np.linalg.norm(mesh.vertices - mesh.vertices[210], axis=1)
    np.testing.assert_allclose(distance, exact, atol=1e-9)
