import pytest

import geodesic_toolkit as gt
from package_name import PivotedLU


@pytest.mark.parametrize("law", gt.testing.linear_solver_checks(PivotedLU()), ids=str)
def test_the_solver_keeps_the_contract(law):
    law()
