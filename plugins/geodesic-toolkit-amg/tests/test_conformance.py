"""The laws of linear solvers, on the one of this plugin."""

import pytest

import geodesic_toolkit as gt
from geodesic_toolkit_amg import AMG


@pytest.mark.parametrize("law", gt.testing.linear_solver_checks(AMG()), ids=str)
def test_the_solver_keeps_the_contract(law):
    law()
