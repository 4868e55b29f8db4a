"""The estimators in pipelines, and with the clusterings of scikit-learn."""

import numpy as np
import pytest
from sklearn.cluster import DBSCAN, HDBSCAN, AgglomerativeClustering
from sklearn.datasets import make_moons, make_swiss_roll
from sklearn.linear_model import Ridge
from sklearn.metrics import adjusted_rand_score
from sklearn.model_selection import GridSearchCV, cross_val_score
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline

from geodesic_toolkit.sklearn import GeodesicDistances, GeodesicIsomap, GeodesicNeighbors

MOONS, MOON = make_moons(300, noise=0.04, random_state=0)
FAR = 100.0
"""More than any distance on a moon."""


def agreement(labels):
    return adjusted_rand_score(MOON, labels)


def test_dbscan_takes_the_graph_within_a_radius():
    graph = GeodesicNeighbors(radius=0.2, graph_neighbors=8)
    clustering = DBSCAN(eps=0.2, min_samples=4, metric="precomputed")
    assert agreement(make_pipeline(graph, clustering).fit_predict(MOONS)) == 1


def test_dbscan_takes_a_filled_matrix():
    matrix = GeodesicDistances(landmarks="all", n_neighbors=8, fill=FAR)
    clustering = DBSCAN(eps=0.2, min_samples=4, metric="precomputed")
    assert agreement(make_pipeline(matrix, clustering).fit_predict(MOONS)) == 1


@pytest.mark.parametrize("fill", [None, FAR])
@pytest.mark.parametrize("refine", ["auto", False])
@pytest.mark.filterwarnings("ignore:The default value of `copy` will change:FutureWarning")
@pytest.mark.filterwarnings("ignore:The minimum spanning tree contains edge weights:UserWarning")
def test_hdbscan_takes_the_symmetric_matrix(fill, refine):
    matrix = GeodesicDistances(landmarks="all", n_neighbors=8, fill=fill, refine=refine)
    clustering = HDBSCAN(min_cluster_size=20, metric="precomputed")
    assert agreement(make_pipeline(matrix, clustering).fit_predict(MOONS)) > 0.95


@pytest.mark.parametrize("linkage", ["average", "complete", "single"])
def test_agglomerative_clustering_takes_a_filled_matrix(linkage):
    matrix = GeodesicDistances(landmarks="all", n_neighbors=8, fill=FAR)
    clustering = AgglomerativeClustering(n_clusters=2, metric="precomputed", linkage=linkage)
    assert agreement(make_pipeline(matrix, clustering).fit_predict(MOONS)) == 1


def test_a_classifier_takes_the_graph_of_new_samples():
    graph = GeodesicNeighbors(n_neighbors=5, graph_neighbors=8)
    model = make_pipeline(graph, KNeighborsClassifier(n_neighbors=5, metric="precomputed"))
    model.fit(MOONS[:200], MOON[:200])
    assert model.score(MOONS[200:], MOON[200:]) == 1


@pytest.mark.slow
def test_an_embedding_straightens_a_roll_for_a_linear_model():
    samples, angle = make_swiss_roll(2000, random_state=0)
    length = (angle * np.sqrt(1 + angle**2) + np.arcsinh(angle)) / 2
    model = make_pipeline(GeodesicIsomap(landmarks=30), Ridge())
    assert cross_val_score(model, samples, length, cv=2).min() > 0.99
    assert cross_val_score(Ridge(), samples, length, cv=2).max() < 0.5
    search = GridSearchCV(model, {"geodesicisomap__n_components": [1, 2]}, cv=2)
    assert search.fit(samples, length).best_score_ > 0.99
