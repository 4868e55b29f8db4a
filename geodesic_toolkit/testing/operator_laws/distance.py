"""Laws of the distances that the heat method computes from a discretization."""

from collections.abc import Iterable
from itertools import pairwise

import numpy as np

from geodesic_toolkit.testing.conformance import Measured
from geodesic_toolkit.testing.figures import ALGEBRA, relative
from geodesic_toolkit.testing.operator_laws.subject import OperatorSubject, heat_method

__all__ = ["DISTANCE_LAWS"]

SHRINK = 0.9
"""Largest share of the error that remains with half the edge length; first order leaves 0.5."""


def blocks_equal_their_columns(subject: OperatorSubject) -> Iterable[Measured]:
    """Distances of several source sets, and unit and adjoint, are the same in blocks and singly."""
    for sample, discretization in subject.cases():
        count, gradient = sample.domain.n_vertices, discretization.gradient
        scale = sample.distance.max()
        rng = np.random.default_rng(2)
        log_heat = np.stack([-3 * sample.distance, -rng.random(count), np.zeros(count)], axis=1)
        log_heat /= sample.spacing
        field = gradient.unit(log_heat)
        adjoint = gradient.adjoint(field)
        for k in range(3):
            alone = gradient.unit(log_heat[:, k : k + 1])
            yield Measured(relative(field[..., k : k + 1], alone), ALGEBRA, f"unit, {sample.name}")
            pull = gradient.adjoint(alone)
            apart = relative(adjoint[:, k : k + 1], pull, floor=np.abs(adjoint).max())
            yield Measured(apart, ALGEBRA, f"adjoint, {sample.name}")
        method = subject.method(sample)
        sets = [[sample.source], [0, count - 1], [count // 2]]
        together = method.distances(sets)
        for row, sources in zip(together, sets, strict=True):
            difference = np.abs(row - method.distance(sources)).max() / scale
            yield Measured(float(difference), ALGEBRA, f"distances, {sample.name}")


def spacing_is_the_edge_length(subject: OperatorSubject) -> Iterable[Measured]:
    """``spacing`` is the mean edge length, up to a factor of 2 (the figure is the log ratio)."""
    for sample, discretization in subject.cases():
        ratio = abs(np.log(discretization.spacing / sample.spacing))
        yield Measured(float(ratio), float(np.log(2)), sample.name)


def heat_is_positive(subject: OperatorSubject) -> Iterable[Measured]:
    """``(M + h² L) u = δ`` has u > 0 at every vertex (the figure counts the others)."""
    for sample, _ in subject.cases():
        report = subject.method(sample).heat_report(sample.source)
        yield Measured(float(report.non_positive), 0.0, sample.name)


def distance_is_accurate(subject: OperatorSubject) -> Iterable[Measured]:
    """On the finest sample of each family the distance is accurate (mean relative error)."""
    for kind in subject.samples:
        for family in kind.families:
            finest = family[-1]
            yield Measured(subject.error(finest), finest.error, finest.name)
            if subject.assemble(finest.domain).fronts is not None:
                yield Measured(subject.error_of_fronts(finest), finest.error, "its fronts")


def error_decreases_under_refinement(subject: OperatorSubject) -> Iterable[Measured]:
    """The mean error falls from the coarse sample of a family to the fine one (their ratio)."""
    for kind in subject.samples:
        for family in kind.families:
            for coarse, fine in pairwise(family):
                ratio = subject.error(fine) / subject.error(coarse)
                yield Measured(ratio, SHRINK, f"{coarse.name} -> {fine.name}")


def disconnected_parts_are_infinitely_far(subject: OperatorSubject) -> Iterable[Measured]:
    """Vertices not connected to a source are inf, others finite (the figure counts wrong ones)."""
    for kind in subject.samples:
        part = kind.families[0][0].domain
        if kind.united is None or kind.isolated is None:
            continue
        count, name = part.n_vertices, f"{kind.kind.__name__} of two parts"
        method = heat_method(subject.recipe.assemble(kind.united(part, part)))
        first, both = method.distance(0), method.distance([0, count])
        wrong = (~np.isfinite(first[:count])).sum() + np.isfinite(first[count:]).sum()
        yield Measured(float(wrong), 0.0, f"{name}, a source in one")
        yield Measured(float((~np.isfinite(both)).sum()), 0.0, f"{name}, a source in each")
        method = heat_method(subject.recipe.assemble(kind.isolated(part)))
        distance = method.distance(0)
        wrong = (~np.isfinite(distance[:-1])).sum() + np.isfinite(distance[-1])
        yield Measured(float(wrong), 0.0, f"{kind.kind.__name__} with an isolated vertex")


DISTANCE_LAWS = (
    blocks_equal_their_columns,
    spacing_is_the_edge_length,
    heat_is_positive,
    distance_is_accurate,
    error_decreases_under_refinement,
    disconnected_parts_are_infinitely_far,
)
