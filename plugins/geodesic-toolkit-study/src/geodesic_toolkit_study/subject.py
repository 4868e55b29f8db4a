"""The mesh under study, with what every experiment needs of it."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.errors import SolverError
from geodesic_toolkit.exact import exact_distance
from geodesic_toolkit.heat.method import HeatMethod
from geodesic_toolkit.laplacians.cotan import CotanLaplacian
from geodesic_toolkit.linear.superlu import SuperLU
from geodesic_toolkit.sources.points import as_vertices

__all__ = ["Subject", "choose_sources", "error_of", "reference_distance"]

USUAL_SOURCES = (500, 2000)
"""Those of the experiments on the bunny that this study repeats."""

LARGEST_EXACT = 20_000
"""Vertices up to which exact distances take seconds."""


class Subject:
    """A mesh, its cotangent Laplacian, the sources, and its reference distances.

    Parameters
    ----------
    mesh : TriangleMesh
    name : str
        What to call it.
    sources : sequence of int
    seed : int
        Of the noise.

    Attributes
    ----------
    metric : Discretization
        The plain cotangent Laplacian: no flips, nothing that saves a bad solver.
    h : float
        Mean edge length.
    method : HeatMethod
        With t = h² and the direct solver.
    """

    def __init__(
        self, mesh: TriangleMesh, name: str, sources: Sequence[int], *, seed: int = 0
    ) -> None:
        self.mesh, self.name, self.seed = mesh, name, seed
        self.sources = tuple(int(source) for source in sources)
        self.metric = CotanLaplacian().assemble(mesh)
        self.h = self.metric.spacing
        self.method = self.heat_method()
        self._true: dict[int, tuple[FloatArray, str]] = {}

    def heat_method(self, **options: Any) -> HeatMethod:
        """Return a heat method on the mesh, with direct solvers by default."""
        direct = SuperLU()
        solvers: dict[str, Any] = {"heat_solver": direct, "poisson_solver": direct}
        return HeatMethod(self.metric, **(solvers | options))

    @cached_property
    def times(self) -> dict[str, float]:
        """The three time steps of the study, by name."""
        return {"h^2": self.h**2, "h": self.h, "1": 1.0}

    @cached_property
    def diagonal(self) -> float:
        """Diagonal of the bounding box."""
        return float(np.linalg.norm(np.ptp(self.mesh.vertices[self.mesh.used], axis=0)))

    def true(self, source: int) -> FloatArray:
        """Return the reference distance from a source."""
        if source not in self._true:
            self._true[source] = reference_distance(self.mesh, source, self.metric)
        return self._true[source][0]

    def reference(self, source: int) -> str:
        """Return the kind of reference: "exact", or "refined" where that is not available."""
        self.true(source)
        return self._true[source][1]

    def reached(self, source: int) -> BoolArray:
        """Return which vertices are connected to a source, of shape (N,)."""
        components = self.metric.components
        return np.asarray(components == components[source])

    def error(self, distance: FloatArray, source: int) -> dict[str, float]:
        """Return the errors of a distance against the reference."""
        return error_of(distance, self.true(source))


def reference_distance(
    mesh: TriangleMesh, source: int, metric: Discretization
) -> tuple[FloatArray, str]:
    """Return the distance to measure errors against, and whether it is "exact" or "refined".

    Exact along the polyhedron where that is quick; else the refined distance, whose own error is a
    few times smaller than that of heat.
    """
    if mesh.n_vertices <= LARGEST_EXACT:
        try:
            return exact_distance(mesh, source), "exact"
        except SolverError:
            pass  # the second-best is below, and says so by its name
    direct = SuperLU()
    method = HeatMethod(metric, heat_solver=direct, poisson_solver=direct, refine=True)
    return method.distance(source), "refined"


def error_of(distance: FloatArray, true: FloatArray) -> dict[str, float]:
    """Return the mean relative error, and the largest as a share of the largest distance.

    Both in per cent, over the vertices that both reach, away from the source.

    Examples
    --------
    >>> import numpy as np
    >>> error_of(np.array([0.0, 1.1, 2.0]), np.array([0.0, 1.0, 2.0]))
    {'mean': 5.0, 'largest': 5.0}
    """
    away = np.isfinite(true) & np.isfinite(distance) & (true > 0)
    if not away.any():
        return {"mean": 0.0, "largest": 0.0}
    off = np.abs(distance[away] - true[away])
    mean, largest = 100 * (off / true[away]).mean(), 100 * off.max() / true[away].max()
    return {"mean": round(float(mean), 6), "largest": round(float(largest), 6)}


def choose_sources(mesh: TriangleMesh, sources: Sequence[int] | None) -> IntArray:
    """Return the source vertices to study.

    Those given; else 500 and 2000, if both lie on the largest part of the mesh; else the vertex
    of it that is farthest from its first one, and the one farthest from that.

    Raises
    ------
    InvalidSourceError
        A vertex that is not there.
    """
    if sources is not None:
        return np.array(
            list(dict.fromkeys(as_vertices(sources, mesh.n_vertices).tolist())), dtype=np.int64
        )
    metric = CotanLaplacian().assemble(mesh)
    largest = np.bincount(metric.components).argmax()
    inside = np.flatnonzero(metric.components == largest)
    if np.isin(USUAL_SOURCES, inside).all():
        return np.array(USUAL_SOURCES, dtype=np.int64)
    points = mesh.vertices[inside]
    first = np.linalg.norm(points - points[0], axis=1).argmax()
    second = np.linalg.norm(points - points[first], axis=1).argmax()
    return np.unique(inside[[first, second]])
