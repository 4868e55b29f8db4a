import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit_knn import KNNGraph, KNNLaplacian


@pytest.mark.parametrize("law", gt.testing.laplace_operator_checks(KNNLaplacian()), ids=str)
def test_the_operator_keeps_the_contract(law):
    law()


@pytest.mark.parametrize(
    "law",
    gt.testing.domain_checks(KNNGraph(np.random.default_rng(0).normal(size=(60, 5)))),
    ids=str,
)
def test_the_domain_keeps_the_contract(law):
    law()
