"""Which samples are taken, which refused and how, and do matrices and AnnData fit?"""

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse import csr_array
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
        (np.zeros(4), "shape"),
        (np.zeros((0, 3)), "shape"),
        ([[0.0, 1.0], [0.0]], "table"),
        ([["a", "b"]], "table"),
        ([[np.nan, np.nan]], "all samples are missing"),
        ([[0.0, 0.0], [np.nan, 1.0]], "sample 1"),
        ([[0.0, 0.0], [np.inf, 1.0]], "sample 1"),
    ],
)
def test_what_is_no_table_of_samples_is_refused(points, message):
    with pytest.raises(InvalidDomainError, match=message):
        KNNGraph(points)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"k": 0}, "k must be a positive integer"),
        ({"k": 200}, "there are 199 samples at other places"),
        ({"k": True}, "k must be"),
        ({"dimension": 0}, "dimension must be"),
        ({"dimension": "two"}, "dimension must be"),
        ({"metric": "nearness"}, "nearness"),
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


@pytest.mark.parametrize("matrix", [csr_array((2, 3)), csr_array([[0.0, -1.0], [1.0, 0.0]])])
def test_a_matrix_that_holds_no_distances_is_refused(matrix):
    with pytest.raises(InvalidDomainError):
        KNNGraph.from_distances(matrix)


def test_a_dense_matrix_is_refused_by_name():
    with pytest.raises(InvalidDomainError, match="ndarray"):
        KNNGraph.from_distances(np.zeros((3, 3)))


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
