import pytest

import geodesic_toolkit as gt
from geodesic_toolkit_polygon import PolygonLaplacian, samples


@pytest.mark.parametrize("law", gt.testing.laplace_operator_checks(PolygonLaplacian()), ids=str)
def test_the_operator_keeps_the_contract(law):
    law()


MIXED = samples.quad_sphere(3)


@pytest.mark.parametrize("law", gt.testing.domain_checks(MIXED), ids=str)
def test_the_kind_of_domain_keeps_the_contract(law):
    law()
