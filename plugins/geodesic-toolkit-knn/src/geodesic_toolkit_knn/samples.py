"""Samples about which the truth is known, for the checks of operators."""

from dataclasses import replace

import numpy as np

import geodesic_toolkit as gt
from geodesic_toolkit_knn.domain import KNNGraph
from geodesic_toolkit_knn.tables import FloatArray

__all__ = ["samples_of_neighbours"]

BESIDE = np.array([10.0, 0.0, 0.0])
"""Shift that sets one sample well apart from another."""


def samples_of_neighbours() -> "gt.testing.DomainSamples[KNNGraph]":
    """Return the shapes of point clouds as samples of a surface in space."""
    clouds = gt.testing.samples_of([gt.PointCloud])[0]
    return gt.testing.DomainSamples(
        kind=KNNGraph,
        families=[
            [replace(sample, domain=_surface(sample.domain.positions)) for sample in family]
            for family in clouds.families
        ],
        generic=_surface(clouds.generic.positions),
        permuted=lambda domain, order: _surface(_points(domain)[order]),
        united=lambda first, second: _surface(
            np.concatenate([_points(first), _points(second) + BESIDE])
        ),
        isolated=lambda domain: _surface(np.concatenate([_points(domain), [[np.nan] * 3]])),
        moved=lambda domain, rotation, shift: _surface(_points(domain) @ rotation.T + shift),
        scaled=lambda domain, factor: _surface(_points(domain) * factor),
        degenerate=[
            KNNGraph([[0.0, 0.0, 0.0]]),
            KNNGraph([[0.0, 0.0, 0.0], [np.nan] * 3]),
            KNNGraph([[0.0, 0.0], [1.0, 0.0]]),
            KNNGraph(np.zeros((40, 5))),
            KNNGraph(np.linspace(0, 1, 40)[:, None] * [1.0, 2.0, 3.0]),
            KNNGraph(np.linspace(0, 1, 40)[:, None] * [1.0, 2.0, 3.0], dimension=2),
            KNNGraph(np.linspace(0, 1, 40)[:, None]),
        ],
    )


def _surface(points: FloatArray) -> KNNGraph:
    return KNNGraph(points, dimension=2)


def _points(domain: KNNGraph) -> FloatArray:
    assert domain.points is not None  # for the type checker: none has given neighbours
    return domain.points
