"""The option, and the use for distances, which the contract does not cover."""

import numpy as np
import pytest

import geodesic_toolkit as gt
from package_name import PivotedLU


def test_an_unknown_ordering_is_refused():
    with pytest.raises(gt.errors.InvalidOptionError, match="not 'RANDOM'"):
        PivotedLU(ordering="RANDOM")


@pytest.mark.parametrize("ordering", ["COLAMD", "NATURAL"])
def test_distances_do_not_depend_on_the_solver(ordering):
    ball = gt.testing.shapes.icosphere(2)
    distance = gt.geodesic_distance(ball, 0, solver=PivotedLU(ordering=ordering), refine=False)
    expected = gt.geodesic_distance(ball, 0, refine=False)
    np.testing.assert_allclose(distance, expected, atol=1e-9)


def test_the_solver_is_found_by_its_name():
    assert gt.solvers.resolve("plugin-name") == PivotedLU()
