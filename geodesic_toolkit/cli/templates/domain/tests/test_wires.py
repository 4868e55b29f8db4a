"""Refused wires, and the operator that "auto" chooses, which the contract does not cover."""

import numpy as np
import pytest

import geodesic_toolkit as gt
from package_name import WireLaplacian, Wires

CORNER = [[0, 0, 0], [1, 0, 0], [1, 2, 0]]


@pytest.mark.parametrize(
    ("points", "edges", "message"),
    [
        ([[0, 0]], [], "shape"),
        ([[0, 0, 0], [0, np.nan, 0]], [[0, 1]], "point 1 is not finite"),
        ([[0, 0, 0], [1, 0, 0]], [[0, 2]], "edge 0 refers to vertex 2"),
        ([[1, 0, 0], [1, 0, 0]], [[0, 1]], "wire 0 has no length"),
    ],
)
def test_wires_that_are_none_are_refused(points, edges, message):
    with pytest.raises(gt.errors.InvalidDomainError, match=message):
        Wires(points, edges)


def test_auto_is_the_operator_of_this_kind():
    solver = gt.GeodesicSolver(Wires(CORNER, [[0, 1], [1, 2]]))
    assert solver.operator == WireLaplacian()


def test_points_alone_are_refused():
    with pytest.raises(gt.errors.UnsupportedDomainError, match="not a single wire"):
        WireLaplacian().assemble(Wires(CORNER, []))


def test_a_path_follows_the_wires():
    path = gt.geodesic_path(gt.GeodesicSolver(Wires(CORNER, [[0, 1], [1, 2]])), 0, 2)
    assert path.length == pytest.approx(3.0)
