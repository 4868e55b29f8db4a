"""The estimators of the core take the operator of the plugin, and its kind of domain."""

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit_knn import KNNGraph, KNNLaplacian

sklearn = pytest.importorskip("geodesic_toolkit.sklearn", reason="scikit-learn is not installed")


def sheet(count=1200):
    """Samples of a square in five dimensions, and their places in it."""
    rng = np.random.default_rng(0)
    flat = rng.random((count, 2))
    frame = np.linalg.qr(rng.normal(size=(5, 2)))[0]
    return flat @ frame.T, flat


@pytest.mark.parametrize("operator", ["knn", KNNLaplacian()])
def test_an_estimator_makes_the_domain_of_the_operator(operator):
    samples, flat = sheet(400)
    model = sklearn.GeodesicDistances([0, 5], operator=operator).fit(samples)
    assert isinstance(model.domain_, KNNGraph)
    straight = np.linalg.norm(flat[[0, 5], None] - flat, axis=2)
    assert np.abs(model.distances_ - straight).sum() < 0.01 * straight.sum()


def test_an_estimator_takes_the_kind_of_domain():
    samples, flat = sheet(400)
    isomap = sklearn.GeodesicIsomap(landmarks=30).fit(KNNGraph(samples))
    spread = np.linalg.norm(isomap.embedding_[:, None] - isomap.embedding_, axis=2)
    straight = np.linalg.norm(flat[:, None] - flat, axis=2)
    assert np.abs(spread - straight).sum() < 0.02 * straight.sum()


def test_the_nearest_and_those_within_a_radius_are_those_of_the_whole_matrix():
    samples, _ = sheet()
    model = sklearn.GeodesicNeighbors(n_neighbors=4, operator="knn", symmetrize=None).fit(samples)
    some = [0, 100, 1199]
    rows = model.solver_.distances(some)
    distances, indices = model.kneighbors(model.domain_.points)
    np.testing.assert_allclose(distances[some], np.sort(rows, axis=1)[:, :4], atol=1e-12)
    near = gt.distance_matrix(model.solver_, some, max_distance=0.1)
    np.testing.assert_array_equal(near.toarray(), np.where(rows <= 0.1, rows, 0))
    assert (indices[some, 0] == some).all()
