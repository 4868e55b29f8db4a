"""The heat method on graphs: paths along edges or across corners, and the scale of heat."""

import threading
from collections.abc import Callable, Sequence

import numpy as np

from geodesic_toolkit.core.near import NearRows
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.edge_gradient import EdgeGradient
from geodesic_toolkit.discretization.gradient import Gradient
from geodesic_toolkit.discretization.heat import Heat
from geodesic_toolkit.geometry.along_edges import AlongEdges
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["ScaledGradient", "instead_of_heat", "limit_to_edges", "near_instead_of_heat"]


def instead_of_heat(
    metric: Discretization, across: bool, block: Sequence[SourcePoints], distances: FloatArray
) -> None:
    """Write what fronts find, or the shortest paths along the edges of a graph, (K, N)."""
    begins, vertices, known, starts = _entries(block)
    if across and metric.fronts is not None:
        distances[:] = metric.fronts.distances(begins, vertices, known, starts)
        return
    paths = metric.across_edges if across else metric.along_edges
    assert paths is not None  # for the type checker; the heat method has checked
    distances[:] = paths.distances(begins, vertices, known)


def near_instead_of_heat(
    metric: Discretization, across: bool, block: Sequence[SourcePoints], limits: FloatArray
) -> NearRows:
    """Return the same up to a limit for each source set, (K,)."""
    begins, vertices, known, starts = _entries(block)
    if across and metric.fronts is not None:
        return metric.fronts.near(begins, vertices, known, starts, limits)
    paths = metric.across_edges if across else metric.along_edges
    assert paths is not None  # for the type checker; the heat method has checked
    return paths.near(begins, vertices, known, limits)


def _entries(
    block: Sequence[SourcePoints],
) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """Return where vertices of each set begin, these, what is known of them, and the offsets."""
    begins = np.cumsum([0, *(len(points.vertices) for points in block)])
    starts = np.concatenate([points.starts[points.rows] for points in block])
    known = np.concatenate([points.distances for points in block]) + starts
    return begins, np.concatenate([points.vertices for points in block]), known, starts


def limit_to_edges(
    metric: Discretization, block: Sequence[SourcePoints], distances: FloatArray
) -> None:
    """Limit distances (K, N) in place to paths along edges, also of merged vertices."""
    if len(metric.representatives):
        distances[:] = distances[:, metric.representatives]
    if metric.along_edges is not None:
        paths = np.empty_like(distances)
        instead_of_heat(metric, False, block, paths)
        np.minimum(distances, paths, out=distances, where=np.isfinite(distances))


class ScaledGradient:
    """The gradient of a metric, with the local scale found from its potentials.

    Parameters
    ----------
    metric : Discretization
    diffuse : callable
        Function of source sets that returns their heat.
    integrate : callable
        Step 3: function of a right-hand side (N, K) that returns potentials.
    """

    def __init__(
        self,
        metric: Discretization,
        diffuse: Callable[[Sequence[SourcePoints]], Heat],
        integrate: Callable[[FloatArray], FloatArray],
    ) -> None:
        self._metric, self._diffuse, self._integrate = metric, diffuse, integrate
        self._scaled: EdgeGradient | None = None
        self._lock = threading.Lock()

    def __call__(self) -> Gradient:
        """Return the gradient; the scale is computed at the first call."""
        if not self._metric.local_scale:
            return self._metric.gradient
        with self._lock:
            if self._scaled is None:
                self._scaled = self._locally_scaled()
            return self._scaled

    def _locally_scaled(self) -> EdgeGradient:
        from geodesic_toolkit.heat.local_scale import rises

        metric, gradient = self._metric, self._metric.gradient
        assert isinstance(gradient, EdgeGradient)  # for the type checker

        def potentials(sets: list[IntArray]) -> FloatArray:
            n_vertices = metric.n_vertices
            heat = self._diffuse([SourcePoints.at_vertices(own, n_vertices) for own in sets])
            return self._integrate(gradient.descent_load(heat)).T

        lengths = 1 / np.sqrt(gradient.edge_weights)
        graph = AlongEdges(metric.n_vertices, gradient.edges, lengths)
        own = _dimensions_of_edges(gradient)
        dimension = max(1, round(own.sum() / gradient.measure.sum())) if own.any() else 1
        found = rises(graph, metric.components, dimension, potentials)
        # Never less than one dimension: in one dimension a potential rises entirely along the edge.
        measure = np.minimum(gradient.measure / found**2, own)
        return EdgeGradient(gradient.edges, gradient.edge_weights, measure, copy=False)

    def dimensions(self) -> FloatArray:
        """Return the effective dimension at each vertex by the scale, (N,); NaN without edges."""
        gradient = self()
        assert isinstance(gradient, EdgeGradient)  # for the type checker
        own = _dimensions_of_edges(gradient)
        unknown = np.full(len(own), np.nan)
        return np.asarray(np.divide(own, gradient.measure, out=unknown, where=own > 0))


def _dimensions_of_edges(gradient: EdgeGradient) -> FloatArray:
    """Return half the number of edges at each vertex, (N,)."""
    return np.asarray(np.bincount(gradient.edges.ravel(), minlength=gradient.n_vertices) / 2)
