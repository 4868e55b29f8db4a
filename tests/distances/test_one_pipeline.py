"""Meshes, clouds and graphs take the same way through the heat method after `assemble`."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
import pytest
from sample_shapes import edge_graph
from scipy.sparse import csr_array

import geodesic_toolkit as gt
from geodesic_toolkit.testing import shapes

OPERATORS = {
    "mesh": gt.CotanLaplacian(),
    "cloud": gt.PointCloudLaplacian(),
    "graph": gt.UniformLaplacian(dim=2),
}


def sphere_as(kind):
    sphere = shapes.icosphere(3)
    if kind == "mesh":
        return sphere
    if kind == "cloud":
        return gt.PointCloud(sphere.vertices)
    return edge_graph(sphere)


class RecordedFactor(gt.Factor):
    """A factor that notes how many columns it is asked to solve for."""

    def __init__(self, factor, calls):
        self.factor, self.calls = factor, calls

    def solve(self, right_hand_side):
        self.calls.append(("solve", right_hand_side.shape[1:]))
        return self.factor.solve(right_hand_side)

    @property
    def nnz(self):
        return self.factor.nnz

    @property
    def nbytes(self):
        return self.factor.nbytes


@dataclass(frozen=True, kw_only=True)
class Recorded(gt.LinearSolver):
    """SuperLU, and notes of what is asked of it."""

    name: str
    calls: list = field(default_factory=list, compare=False)
    componentwise: ClassVar[bool] = gt.SuperLU.componentwise

    def factorize(self, matrix: csr_array) -> gt.Factor:
        self.calls.append(("factorize", self.name))
        return RecordedFactor(gt.SuperLU().factorize(matrix), self.calls)


def calls_of(kind, monkeypatch):
    """Return the calls of the method to its solvers and its gradient, in order."""
    operator, domain, calls = OPERATORS[kind], sphere_as(kind), []
    metric = operator.assemble(domain)
    gradient = type(metric.gradient)
    descent_load = gradient.descent_load

    def recorded(self, heat):
        calls.append(("descent_load", heat.values.shape[1:], heat.logarithmic))
        return descent_load(self, heat)

    method = gt.HeatMethod(
        metric,
        diffusion=operator.diffusion(metric),
        heat_solver=Recorded(name="heat", calls=calls),
        poisson_solver=Recorded(name="Poisson", calls=calls),
    )
    with monkeypatch.context() as patch:
        patch.setattr(gradient, "descent_load", recorded)
        method.distances([0, [5, 9]])
    return calls


@pytest.mark.parametrize("kind", ["cloud", "graph"])
def test_a_cloud_and_a_graph_ask_of_solvers_and_gradients_what_a_mesh_does(kind, monkeypatch):
    calls = calls_of("mesh", monkeypatch)
    assert [name for name, *_ in calls].count("descent_load") == 1
    assert {("factorize", "heat"), ("factorize", "Poisson")} <= set(calls)
    assert calls_of(kind, monkeypatch) == calls


def test_the_three_agree_on_the_sphere():
    mesh, *others = (
        gt.geodesic_distance(sphere_as(kind), 0) for kind in ("mesh", "cloud", "graph")
    )
    away = mesh > 0.3
    for distance in others:
        np.testing.assert_allclose(distance[away], mesh[away], rtol=0.06)
