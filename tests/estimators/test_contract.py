"""The estimators obey scikit-learn's own contract."""

import pytest
from sklearn.utils.estimator_checks import parametrize_with_checks

from geodesic_toolkit.sklearn import GeodesicDistances, GeodesicIsomap, GeodesicNeighbors

ESTIMATORS = [
    GeodesicDistances(),
    GeodesicDistances(landmarks=4, refine=False),
    GeodesicNeighbors(),
    GeodesicNeighbors(radius=1.0, mode="connectivity"),
    GeodesicIsomap(),
    GeodesicIsomap(n_components=1, landmarks="all", refine=True),
]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::geodesic_toolkit.errors.FragmentedCloudWarning")
@parametrize_with_checks(ESTIMATORS)
def test_an_estimator_passes_a_check_of_scikit_learn(estimator, check):
    check(estimator)
