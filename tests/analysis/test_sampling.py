"""Farthest point sampling and Voronoi cells keep their promises on shapes of every kind."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geodesic_toolkit as gt
from geodesic_toolkit import errors
from geodesic_toolkit.solver import solver as solver_module
from geodesic_toolkit.testing import shapes

SPHERE = gt.GeodesicSolver(shapes.icosphere(2))


@pytest.fixture(scope="module")
def solver():
    return gt.GeodesicSolver(shapes.torus(36, 18))


@pytest.fixture(scope="module")
def parts():
    """Three spheres of different sizes, and a vertex that no face uses."""
    spheres = [shapes.icosphere(level) for level in (1, 2, 1)]
    mesh = shapes.disjoint_union(*spheres)
    return gt.GeodesicSolver(
        gt.TriangleMesh(np.vstack([mesh.vertices, [[9.0, 9.0, 9.0]]]), mesh.faces), refine=True
    )


# -- farthest point sampling -----------------------------------------------------------------------


def test_each_sample_is_the_farthest_from_those_before_it(solver):
    samples = gt.farthest_point_sampling(solver, 12, start=7)
    assert samples.shape == (12,)
    assert samples.dtype == np.int64
    assert samples[0] == 7
    distances = solver.distances(samples)
    for position in range(1, 12):
        nearest = distances[:position].min(axis=0)
        assert nearest[samples[position]] == pytest.approx(nearest.max(), rel=1e-9)


def test_radii_are_how_far_the_farthest_vertex_is(solver):
    samples, radii = gt.farthest_point_sampling(solver, 8, return_radii=True)
    distances = solver.distances(samples)
    expected = [distances[: position + 1].min(axis=0).max() for position in range(8)]
    np.testing.assert_allclose(radii, expected, rtol=1e-9)


@pytest.mark.slow
@given(st.integers(1, 30), st.integers(0, 161))
def test_the_covering_radius_never_grows_and_samples_are_distinct(count, start):
    samples, radii = gt.farthest_point_sampling(SPHERE, count, start=start, return_radii=True)
    assert (np.diff(radii) <= 0).all()
    assert len(set(samples.tolist())) == count


def test_all_vertices_can_be_sampled(parts):
    samples, radii = gt.farthest_point_sampling(parts, 42 + 162 + 42, return_radii=True)
    assert sorted(samples) == list(range(246))
    assert radii[-1] == 0


def test_a_component_that_has_no_sample_gets_the_next_one(parts):
    samples, radii = gt.farthest_point_sampling(parts, 4, return_radii=True)
    components = parts.method.metric.components
    assert len(set(components[samples[:3]].tolist())) == 3
    assert np.isinf(radii[:2]).all()
    assert np.isfinite(radii[2:]).all()


def test_vertices_of_no_element_are_passed_over_unless_asked_for(parts):
    assert 246 not in gt.farthest_point_sampling(parts, 20)
    assert gt.farthest_point_sampling(parts, 2, start=246)[0] == 246


def test_masked_vertices_and_missing_points_are_passed_over():
    mesh = shapes.grid(9)
    mask = mesh.vertices[:, 0] > 0.6
    masked = gt.GeodesicSolver(mesh, mask=mask)
    assert not mask[gt.farthest_point_sampling(masked, 20)].any()
    points = shapes.icosphere(2).vertices.copy()
    points[::5] = np.nan
    cloud = gt.GeodesicSolver(gt.PointCloud(points))
    assert np.isfinite(points[gt.farthest_point_sampling(cloud, 20)]).all()


def test_a_shape_of_lonely_vertices_is_sampled_one_by_one():
    cloud = gt.Graph(4, np.zeros((0, 2), dtype=np.int64))
    samples, radii = gt.farthest_point_sampling(gt.GeodesicSolver(cloud), 4, return_radii=True)
    np.testing.assert_array_equal(samples, np.arange(4))
    np.testing.assert_array_equal(radii, [np.inf, np.inf, np.inf, 0])
    alone = gt.GeodesicSolver(gt.PointCloud([[np.nan] * 3, [0.0, 0.0, 0.0]]))
    np.testing.assert_array_equal(gt.farthest_point_sampling(alone, 1), [1])


def test_the_first_sample_is_an_extremity_unless_drawn(solver):
    path = gt.GeodesicSolver(gt.Graph(20, [[i, i + 1] for i in range(19)]))
    np.testing.assert_array_equal(gt.farthest_point_sampling(path, 2), [19, 0])
    drawn = [gt.farthest_point_sampling(solver, 3, rng=np.random.default_rng(5)) for _ in range(2)]
    np.testing.assert_array_equal(drawn[0], drawn[1])
    starts = {
        int(gt.farthest_point_sampling(solver, 1, rng=np.random.default_rng(seed))[0])
        for seed in range(5)
    }
    assert len(starts) > 1


def test_sampling_is_deterministic(solver):
    first, second = (gt.farthest_point_sampling(solver, 10) for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_sampling_counts_its_progress(solver):
    seen = []
    gt.farthest_point_sampling(solver, 3, progress=lambda done, total: seen.append((done, total)))
    assert seen == [(1, 3), (2, 3), (3, 3)]


@pytest.mark.parametrize(
    ("arguments", "options", "error", "message"),
    [
        ((0,), {}, errors.InvalidOptionError, "not 0"),
        ((163,), {}, errors.InvalidOptionError, "the 162 vertices"),
        ((2.5,), {}, errors.InvalidOptionError, "must be an integer"),
        ((True,), {}, errors.InvalidOptionError, "must be an integer"),
        (
            (2,),
            {"start": 1, "rng": np.random.default_rng(0)},
            errors.InvalidOptionError,
            "not both",
        ),
        ((2,), {"start": 162}, errors.InvalidSourceError, "vertex 162"),
        ((2,), {"start": [1, 2]}, errors.InvalidSourceError, "one vertex"),
        ((2,), {"start": 1.5}, errors.InvalidSourceError, "one vertex"),
    ],
)
def test_a_bad_sampling_is_refused(arguments, options, error, message):
    with pytest.raises(error, match=message):
        gt.farthest_point_sampling(SPHERE, *arguments, **options)


# -- Voronoi cells ---------------------------------------------------------------------------------


@pytest.mark.parametrize("block", [2, 64])
def test_labels_are_the_nearest_rows_of_the_matrix(solver, monkeypatch, block):
    monkeypatch.setattr(solver_module, "MOST_ROWS", block)
    sites = gt.farthest_point_sampling(solver, 7)
    matrix = gt.distance_matrix(solver, sites)
    labels, distances = gt.geodesic_voronoi(solver, sites, return_distances=True)
    assert labels.dtype == np.int64
    nearest = matrix[labels, np.arange(matrix.shape[1])]  # up to ties
    np.testing.assert_allclose(nearest, matrix.min(axis=0), rtol=1e-12)
    np.testing.assert_allclose(distances, matrix.min(axis=0), rtol=1e-12)
    np.testing.assert_array_equal(labels[sites], np.arange(7))
    np.testing.assert_array_equal(gt.geodesic_voronoi(solver, sites), labels)


def test_what_no_site_reaches_has_no_label(parts):
    labels, distances = gt.geodesic_voronoi(parts, [50, 3], return_distances=True)
    np.testing.assert_array_equal(labels[:42], 1)
    np.testing.assert_array_equal(labels[42:204], 0)
    np.testing.assert_array_equal(labels[204:], -1)
    assert np.isinf(distances[204:]).all()
    assert np.isfinite(distances[:204]).all()


def test_sites_are_of_every_kind():
    mesh = shapes.grid(17)
    solver = gt.GeodesicSolver(mesh, refine=True)
    left = np.flatnonzero(mesh.vertices[:, 0] == 0)
    right = gt.Curve([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]])
    labels = gt.geodesic_voronoi(solver, [left, right])
    x = mesh.vertices[:, 0]
    np.testing.assert_array_equal(labels[x < 0.49], 0)
    np.testing.assert_array_equal(labels[x > 0.51], 1)


def test_of_equally_near_sites_the_first_has_the_vertex(solver, monkeypatch):
    monkeypatch.setattr(gt.HeatMethod, "distances", lambda self, sets: np.ones((len(sets), 648)))
    labels, distances = gt.geodesic_voronoi(solver, range(70), return_distances=True)
    np.testing.assert_array_equal(labels, np.zeros(648))
    np.testing.assert_array_equal(distances, np.ones(648))


def test_voronoi_counts_its_progress(solver):
    seen = []
    gt.geodesic_voronoi(solver, range(70), progress=lambda done, total: seen.append((done, total)))
    assert seen == [(64, 70), (70, 70)]


@pytest.mark.parametrize(
    ("sites", "message"), [([], "no source sets"), ([0, 999_999], "set 1: vertex 999999")]
)
def test_bad_sites_are_refused(solver, sites, message):
    with pytest.raises(errors.InvalidSourceError, match=message):
        gt.geodesic_voronoi(solver, sites)
