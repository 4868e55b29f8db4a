"""Are sound samples accepted and others refused, and do matrices and AnnData fit?"""

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse import coo_array, csr_array
from sklearn.neighbors import kneighbors_graph

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidDomainError,
    InvalidOptionError,
    MissingDependencyError,
    UnsupportedDomainError,
)
from geodesic_toolkit_knn import KNNGraph, from_anndata, intrinsic_dimension, to_anndata

RNG = np.random.default_rng(0)
POINTS = RNG.normal(size=(200, 2)) @ RNG.normal(size=(2, 6))


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.zeros(4), r"shape \(N, D\), not \(4,\); for one coordinate each: points\[:, None\]"),
        (np.zeros((0, 3)), r"shape \(N, D\), not \(0, 3\): there are no samples"),
        (np.zeros((3, 0)), r"shape \(N, D\), not \(3, 0\): there are no coordinates"),
        ([], r"shape \(N, D\), not \(0,\)"),
        (np.zeros((2, 2, 2)), r"shape \(N, D\), not \(2, 2, 2\)"),
        (None, "points must be an array of numbers, not a NoneType"),
        ("samples.csv", "points must be an array of numbers, not a str"),
        (gt.PointCloud([[0, 0, 0]]), "points must be an array of numbers, not a PointCloud"),
        (POINTS.astype(object), "real numbers, not dtype object; convert them"),
        ([[0.0, 1.0], [0.0]], "row 1 has 1 entries"),
        ([["a", "b"]], "real numbers"),
        (POINTS + 1j, "real numbers"),
        (csr_array(POINTS), "sparse matrix; give points.toarray"),
        (np.ma.masked_greater(POINTS, 1.0), "masked"),
        (POINTS * 1e-200, "rescale"),
        (POINTS * 1e200, "rescale"),
        ([[np.nan, np.nan]], "all samples are missing"),
        ([[0.0, 0.0], [np.nan, 1.0]], "sample 1"),
        ([[0.0, 0.0], [np.inf, 1.0]], "sample 1"),
    ],
)
def test_points_that_are_not_a_table_of_samples_are_refused(points, message):
    with pytest.raises(InvalidDomainError, match=message):
        KNNGraph(points)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"k": 0}, "k must be a positive integer"),
        ({"k": 200}, "there are 199 samples at other places"),
        ({"k": True}, "k must be"),
        ({"k": np.array([5, 6])}, "k must be"),
        ({"k": 5.0}, "k must be"),
        ({"dimension": 0}, "dimension must be"),
        ({"dimension": 7}, "samples have 6 coordinates"),
        ({"dimension": "two"}, "dimension must be"),
        ({"metric": "nearness"}, "nearness"),
        ({"metric": "precomputed"}, "from_distances"),
        ({"metric": "seuclidean"}, "seuclidean"),
        ({"metric": lambda a, b: -1.0}, "returns -1.0"),
        ({"metric": lambda a, b: np.nan}, "returns nan"),
        ({"metric": lambda a, b: None}, "returns None"),
        ({"metric": lambda a, b: max(a[0] - b[0], 0.0)}, "not symmetric"),
        ({"metric": lambda a, b: 1.0, "search": "approximate"}, "takes metrics by name"),
        ({"search": "quick"}, "search must be"),
    ],
)
def test_an_option_that_cannot_be_is_refused(options, message):
    with pytest.raises(InvalidOptionError, match=message):
        KNNGraph(POINTS, **options)


def test_distances_are_those_of_scikit_learn():
    ours, theirs = KNNGraph(POINTS, k=7).distances, kneighbors_graph(POINTS, 7, mode="distance")
    assert (ours.indptr == theirs.indptr).all()
    np.testing.assert_allclose(ours.toarray(), theirs.toarray(), atol=1e-9)


def test_affinities_are_symmetric_and_fall_with_the_distance():
    domain = KNNGraph(POINTS, k=7)
    affinities = domain.affinities()
    assert abs(affinities - affinities.T).max() == 0
    assert 0 < affinities.data.min() < affinities.data.max() <= 1
    assert affinities.nnz == 2 * len(domain.as_graph().edges)


def test_samples_at_one_place_have_affinity_one():
    domain = KNNGraph(np.concatenate([POINTS, POINTS[:1]]))
    assert domain.affinities()[0, 200] == 1
    assert domain.distances[200].nnz == 1


def test_neighbours_that_are_known_give_the_same_graph():
    domain = KNNGraph(POINTS, k=7)
    known = KNNGraph.from_distances(domain.distances)
    assert (known.as_graph().edges == domain.as_graph().edges).all()
    assert known.k == 7
    assert known.dimension == 2
    np.testing.assert_array_equal(known.affinities().data, domain.affinities().data)


@pytest.mark.parametrize(
    "matrix",
    [
        csr_array((2, 3)),
        csr_array([[0.0, -1.0], [1.0, 0.0]]),
        csr_array([[0.0, np.nan], [1.0, 0.0]]),
        csr_array([[0.0, np.inf], [1.0, 0.0]]),
    ],
)
def test_a_matrix_that_holds_no_distances_is_refused(matrix):
    with pytest.raises(InvalidDomainError):
        KNNGraph.from_distances(matrix)


@pytest.mark.parametrize("known", [KNNGraph.from_distances, KNNGraph.from_affinities])
def test_a_dense_matrix_is_refused_by_name(known):
    with pytest.raises(InvalidDomainError, match="ndarray"):
        known(np.zeros((3, 3)))


def test_a_function_is_a_metric():
    named = KNNGraph(POINTS, k=7, metric="manhattan")
    function = KNNGraph(POINTS, k=7, metric=lambda a, b: np.abs(a - b).sum())
    np.testing.assert_allclose(named.distances.toarray(), function.distances.toarray())


def test_affinities_give_the_distances_that_they_are_made_of():
    steps = np.linspace(0.5, 1.5, 30)
    places = np.concatenate([[0.0], np.cumsum(steps)])
    gaps = np.exp(-(np.subtract.outer(places, places) ** 2))
    chain = csr_array(np.triu(np.tril(gaps, 1), -1))  # with 1 on the diagonal
    domain = KNNGraph.from_affinities(chain, dimension=1)
    np.testing.assert_allclose(gt.geodesic_distance(domain, 0), places, rtol=1e-12)


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (csr_array((2, 3)), "square"),
        (csr_array([[0, 1j], [1j, 0]]), "real numbers"),
        (csr_array([[0.0, -0.1], [-0.1, 0.0]]), "samples 0 and 1 is -0.1"),
        (csr_array([[0.0, 2.0], [2.0, 0.0]]), "Divide by the largest"),
        (csr_array([[0.0, np.nan], [np.nan, 0.0]]), "is nan"),
        (csr_array([[0.0, 0.5], [0.4, 0.0]]), "not symmetric: samples 0 and 1 have 0.5 and 0.4"),
    ],
)
def test_a_matrix_that_holds_no_affinities_is_refused(matrix, message):
    with pytest.raises(InvalidDomainError, match=message):
        KNNGraph.from_affinities(matrix)


@pytest.mark.parametrize("known", [False, True])
def test_masked_samples_are_missing(known):
    domain = KNNGraph(POINTS, k=7, dimension=2)
    if known:
        domain = KNNGraph.from_distances(domain.distances, dimension=2)
    mask = np.arange(200) % 10 == 3
    solver = gt.GeodesicSolver(domain, mask=mask)
    assert (np.isinf(solver.distance(0)) >= mask).all()
    with pytest.raises(InvalidOptionError, match="leaves no"):
        domain.without(np.ones(200, dtype=np.bool_))


def test_the_approximate_search_finds_nearly_the_same():
    pytest.importorskip("pynndescent", reason="pynndescent is not installed")
    exact = KNNGraph(POINTS, k=7)
    found = KNNGraph(POINTS, k=7, search="approximate")
    assert abs(found.distances.sum() / exact.distances.sum() - 1) < 0.01


def test_without_pynndescent_the_message_says_how_to_install_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "pynndescent", None)
    with pytest.raises(MissingDependencyError, match="pip install pynndescent"):
        KNNGraph(POINTS, search="approximate")


def test_too_few_samples_show_no_dimension():
    with pytest.raises(InvalidDomainError, match="different samples"):
        intrinsic_dimension(POINTS[:10])
    with pytest.raises(InvalidDomainError, match="sample 1 has"):
        intrinsic_dimension([[0.0, 1.0], [np.nan, 1.0]])
    assert np.isnan(KNNGraph(POINTS[:3]).dimension_estimate)


def annotated():
    return SimpleNamespace(shape=(200, 6), obsp={}, obsm={"X_pca": POINTS})


def test_neighbours_go_to_anndata_and_come_back():
    data, domain = annotated(), KNNGraph(POINTS, k=7)
    to_anndata(data, domain)
    assert set(data.obsp) == {"distances", "connectivities"}
    back = from_anndata(data)
    assert (back.distances != domain.distances).nnz == 0
    assert (from_anndata(data, representation="X_pca", k=7).distances != domain.distances).nnz == 0


def test_what_is_not_in_anndata_is_named():
    data = annotated()
    with pytest.raises(InvalidOptionError, match="scanpy"):
        from_anndata(data)
    with pytest.raises(InvalidOptionError, match="it has: X_pca"):
        from_anndata(data, representation="X_umap")
    with pytest.raises(UnsupportedDomainError, match="AnnData"):
        from_anndata(POINTS)
    to_anndata(data, KNNGraph(POINTS))
    with pytest.raises(InvalidOptionError, match=r'affinities; .* "distances"'):
        from_anndata(data, key="connectivities")
    with pytest.raises(InvalidOptionError, match="k: neighbours in obsp"):
        from_anndata(data, k=3)
    with pytest.raises(InvalidOptionError, match="200 observations"):
        to_anndata(data, KNNGraph(POINTS[:50]))


@pytest.mark.filterwarnings("ignore::FutureWarning", "ignore::DeprecationWarning")
def test_a_real_anndata_is_taken():
    anndata = pytest.importorskip("anndata", reason="anndata is not installed")
    data = anndata.AnnData(POINTS.copy(), obsm={"X_pca": POINTS.copy()})
    to_anndata(data, KNNGraph(POINTS, k=7))
    assert from_anndata(data).distances.nnz == 1400


def test_connections_are_not_affinities():
    ring = csr_array(np.roll(np.eye(5), 1, axis=1) + np.roll(np.eye(5), -1, axis=1))
    with pytest.raises(InvalidDomainError, match="matrix of connections"):
        KNNGraph.from_affinities(ring)


def test_affinities_of_one_axis_are_refused():
    with pytest.raises(InvalidDomainError, match=r"a square matrix .* of shape \(3,\)"):
        KNNGraph.from_affinities(coo_array(np.ones(3)))
