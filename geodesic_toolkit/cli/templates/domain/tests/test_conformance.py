import pytest

import geodesic_toolkit as gt
from package_name import WireLaplacian, Wires


@pytest.mark.parametrize("law", gt.testing.domain_checks(Wires.samples().generic), ids=str)
def test_the_kind_of_domain_keeps_the_contract(law):
    law()


@pytest.mark.parametrize("law", gt.testing.laplace_operator_checks(WireLaplacian()), ids=str)
def test_the_operator_keeps_the_contract(law):
    law()
