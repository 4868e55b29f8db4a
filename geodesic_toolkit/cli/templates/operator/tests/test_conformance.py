import pytest

import geodesic_toolkit as gt
from package_name import KernelLaplacian


@pytest.mark.parametrize("law", gt.testing.laplace_operator_checks(KernelLaplacian()), ids=str)
def test_the_operator_keeps_the_contract(law):
    law()
