"""The logarithmic map: directions and lengths of the shortest geodesics from a point."""

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from geodesic_toolkit.analysis.directions.traced import refines, trace
from geodesic_toolkit.core.frozen import FrozenArrays, freeze
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.errors import InvalidSourceError
from geodesic_toolkit.geometry.frames import ComplexArray, unit_vectors
from geodesic_toolkit.solver.solver import GeodesicSolver
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["LogMap", "log_map"]


@final
@dataclass(frozen=True, eq=False)
class LogMap(FrozenArrays):
    """The logarithmic map of a point: the shortest geodesics from there to all vertices.

    Attributes
    ----------
    coordinates : ndarray of shape (N, 2), float64
        The logarithm of each vertex in `frame`: the direction in which the geodesic leaves the
        source, times its length. NaN where nothing connects.
    distance : ndarray of shape (N,), float64
        The lengths, in the unit of the domain; ``inf`` where nothing connects.
    angle : ndarray of shape (N,), float64
        Their directions in radians from the first axis of `frame`, counterclockwise, in (-π, π]; 0
        at the source, NaN where nothing connects.
    arrival : ndarray of shape (N, 3), float64
        Unit vectors in space that touch the geodesics where they arrive, away from the source; 0 at
        the source, NaN where nothing connects.
    spread : ndarray of shape (N,), float64
        The Jacobi field: the distance, at each vertex, between geodesics that leave the source, per
        radian between their directions. ``inf`` in the shadow of a corner of the boundary, where
        all leave in one direction; NaN where nothing connects, and where angles come from heat.
    frame : ndarray of shape (2, 3), float64
        Two unit vectors at right angles in the tangent plane of the source.
    """

    coordinates: FloatArray
    distance: FloatArray
    angle: FloatArray
    arrival: FloatArray
    spread: FloatArray
    frame: FloatArray

    def __post_init__(self) -> None:
        for value in self.__dict__.values():
            freeze(value)

    @property
    def vectors(self) -> FloatArray:
        """The logarithms as vectors in space, tangent at the source, of shape (N, 3)."""
        return np.asarray(self.coordinates @ self.frame)

    def __repr__(self) -> str:
        reached = int(np.isfinite(self.distance).sum())
        return f"LogMap({reached} of {len(self.distance)} vertices)"


SHADOW = 1e50
"""Spread from which on all geodesics leave in one direction."""


def log_map(solver: GeodesicSolver, source: Any, *, refine: bool | None = None) -> LogMap:
    """Return the logarithmic map of a point: the direction and distance of every vertex from it.

    Refined, the direction in which the front left the source is carried along the path of the front
    to each vertex. On smooth surfaces angles are of second order, as distances are, and the only
    linear system is that of the heat. Plain angles are those of the vector heat method, beside
    distances by heat.

    Parameters
    ----------
    solver : GeodesicSolver
        Of a mesh or a point cloud.
    source : int, array-like of float, or SurfacePoint
        One place: a vertex, a point in space, which is projected to the surface, or a point in a
        face.
    refine : bool, optional
        As the solver does, by default.

    Returns
    -------
    LogMap

    Raises
    ------
    InvalidOptionError
        An argument that is not a solver; a `refine` that is neither True nor False.
    UnsupportedDomainError
        A graph, as an edge has no angle; a surface with one side; elements that are not triangles.
    InvalidSourceError
        Not exactly one place.

    References
    ----------
    N. Sharp, Y. Soliman, K. Crane, *The Vector Heat Method*, 2019,
    https://doi.org/10.1145/3243651

    Examples
    --------
    >>> import numpy as np
    >>> import geodesic_toolkit as gt
    >>> square = gt.testing.shapes.grid(5)
    >>> logarithm = gt.log_map(gt.GeodesicSolver(square), 12)
    >>> bool(np.allclose(logarithm.vectors, square.vertices - square.vertices[12]))
    True
    """
    refined = refines(solver, "log_map", refine)
    _ = solver.frames  # refuses what has no directions
    points = solver.locate(source, "source")
    if points.count != 1 or points.front_curvatures is not None:
        raise InvalidSourceError(
            f"source: a logarithmic map has one source, not {points.count}; ask for one of each"
        )
    return _refined(solver, points) if refined else _plain(solver, points)


def _refined(solver: GeodesicSolver, points: SourcePoints) -> LogMap:
    traced = trace(solver, points)
    distance = traced.distances
    reached = (traced.labels >= 0) & np.isfinite(distance)
    angle = np.where(reached, traced.angles, np.nan)
    arrival = np.where(distance == 0, 0.0, unit_vectors(traced.arrivals))
    return LogMap(
        coordinates=_pairs(np.where(reached, distance, np.nan) * unit_vectors(angle)),
        distance=distance,
        angle=angle - 2 * np.pi * np.ceil(angle / (2 * np.pi) - 0.5),
        arrival=np.where(reached[:, None], traced.frames.to_space(arrival), np.nan),
        spread=np.where(traced.spreads > SHADOW, np.inf, traced.spreads),
        frame=traced.sources.axes[0].copy(),
    )


def _plain(solver: GeodesicSolver, points: SourcePoints) -> LogMap:
    distance = solver.distance(points)
    plain = solver.vector_heat.log_map(points, distance)
    reached = np.isfinite(plain.coordinates)
    return LogMap(
        coordinates=_pairs(plain.coordinates),
        distance=distance,
        angle=np.where(reached, np.angle(plain.coordinates), np.nan),
        arrival=np.where(reached[:, None], solver.frames.to_space(plain.arrival), np.nan),
        spread=np.full(len(distance), np.nan),
        frame=plain.axes,
    )


def _pairs(numbers: ComplexArray) -> FloatArray:
    return np.column_stack([numbers.real, numbers.imag])
