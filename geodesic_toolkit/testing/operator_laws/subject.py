"""The subject of the laws: an operator, assembled on samples."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.domains import Domain
from geodesic_toolkit.heat.method import HeatMethod
from geodesic_toolkit.laplacians.base import LaplaceOperator
from geodesic_toolkit.linear.superlu import SuperLU
from geodesic_toolkit.testing.samples import DomainSamples, Sample

__all__ = ["OperatorSubject", "heat_method"]


class OperatorSubject:
    """An operator with the samples on which it is measured; each is assembled once."""

    def __init__(self, operator: LaplaceOperator, samples: Sequence[DomainSamples[Any]]) -> None:
        self.recipe = operator
        self.samples = samples
        self._methods: dict[int, HeatMethod] = {}
        self._assembled: dict[int, Discretization] = {}

    def assemble(self, domain: Domain) -> Discretization:
        """Return the operator's discretization of a domain, which the samples keep alive."""
        key = id(domain)
        if key not in self._assembled:
            self._assembled[key] = self.recipe.assemble(domain)
        return self._assembled[key]

    def method(self, sample: Sample) -> HeatMethod:
        """Return the heat method of a sample."""
        key = id(sample)
        if key not in self._methods:
            self._methods[key] = heat_method(self.assemble(sample.domain))
        return self._methods[key]

    def cases(self) -> Iterator[tuple[Sample, Discretization]]:
        """Iterate over all samples, assembled."""
        for kind in self.samples:
            for family in kind.families:
                for sample in family:
                    yield sample, self.assemble(sample.domain)

    def error(self, sample: Sample) -> float:
        """Return the mean relative error of the distance from the sample's source."""
        return _error(self.method(sample), sample)

    def error_of_fronts(self, sample: Sample) -> float:
        """Return the same of the fronts that the operator brings."""
        return _error(heat_method(self.assemble(sample.domain), across=True), sample)


def _error(method: HeatMethod, sample: Sample) -> float:
    distance, away = method.distance(sample.source), sample.distance > 0
    return float(np.mean(np.abs(distance[away] / sample.distance[away] - 1)))


def heat_method(discretization: Discretization, *, across: bool = False) -> HeatMethod:
    """Return the plain heat method on a discretization, or that of its fronts."""
    solver = SuperLU()
    return HeatMethod(discretization, across=across, heat_solver=solver, poisson_solver=solver)
