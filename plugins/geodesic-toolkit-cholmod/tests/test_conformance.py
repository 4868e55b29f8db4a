"""The laws of linear solvers, on the one of this plugin."""

import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import MissingDependencyError
from geodesic_toolkit_cholmod import Cholmod


def laws():
    try:
        solver = Cholmod()
    except MissingDependencyError as error:
        return [pytest.param(None, marks=pytest.mark.skip(reason=str(error)))]
    return gt.testing.linear_solver_checks(solver)


@pytest.mark.parametrize("law", laws(), ids=str)
def test_the_solver_keeps_the_contract(law):
    law()
