"""Refined fronts and the data that they carry, for log maps, transport and extension."""

from dataclasses import dataclass
from typing import cast

import numpy as np

from geodesic_toolkit.analysis.directions.curves import Course, places_of
from geodesic_toolkit.analysis.directions.seeds import Surroundings, surroundings
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.errors import InvalidOptionError
from geodesic_toolkit.geometry.frames import Frames
from geodesic_toolkit.solver.solver import GeodesicSolver, check_solver
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["Traced", "refines", "trace", "trace_curve"]

SHADOW = 1e100
"""Spread of geodesics from one place on a curve, such as a kink or an end."""

TURNING = 0.9
"""Least distance times curvature at which a front is a circle around one place."""


def refines(solver: object, what: str, refine: object) -> bool:
    """Return `refine`, or the option of the solver if it is None.

    Raises
    ------
    InvalidOptionError
        Something else than a solver, or than True, False and None.
    """
    check_solver(solver, what)
    if refine is None:
        return cast("GeodesicSolver", solver).method.refine
    if not isinstance(refine, bool | np.bool_):
        raise InvalidOptionError(f"refine must be True, False or None, not {refine!r}")
    return bool(refine)


@dataclass(frozen=True, eq=False)
class Traced:
    """Distances from the nearest of some sources, and the geodesics that they are measured along.

    Attributes
    ----------
    distances : ndarray of shape (N,), float64
        ``inf`` where nothing connects.
    angles : ndarray of shape (N,), float64
        The direction in which the geodesic leaves its source, in the frame of that; NaN where
        nothing connects.
    arrivals : ndarray of shape (N,), float64
        The direction in which it arrives, in the frame of the vertex.
    rotations : ndarray of shape (N,), float64
        The angle by which parallel transport along it turns a vector, from frame to frame.
    spreads : ndarray of shape (N,), float64
        How far geodesics are apart there that leave the source a unit of angle apart.
    labels : ndarray of shape (N,), int64
        Which source it comes from, -1 where none.
    sources : Surroundings
    frames : Frames
        Of the vertices.
    """

    distances: FloatArray
    angles: FloatArray
    arrivals: FloatArray
    rotations: FloatArray
    spreads: FloatArray
    labels: IntArray
    sources: Surroundings
    frames: Frames


def trace(solver: GeodesicSolver, points: SourcePoints) -> Traced:
    """Return refined distances from sources, with the geodesics.

    Parameters
    ----------
    solver : GeodesicSolver
        Of a mesh or a cloud; its heat gives the order of the sweeps.
    points : SourcePoints
        No curve.

    Raises
    ------
    UnsupportedDomainError
        A graph, a one-sided surface, or a metric that is not made of triangles.
    """
    tracer, frames, gradient = solver.tracer, solver.frames, solver.method.metric.on_surface
    assert isinstance(gradient, ElementGradient)  # for the type checker; the tracer has made sure
    assert frames.surface_mirrored is not None
    sight = solver.method.sweeper.in_sight(points)
    sources = surroundings(solver.passable, frames, points, sight)
    fronts = solver.method.fronts(points, sources.points)
    points = sources.points
    known = points.distances + points.starts[points.rows]
    angles, spreads, arrivals, rotations, labels, _, _, _ = tracer.carry(
        fronts.swept,
        fronts.curvatures,
        points.vertices,
        known,
        sources.angles,
        points.distances,
        sources.arrivals,
        points.rows.astype(np.int32),
        2 * np.pi,
        not gradient.stars and not frames.surface_mirrored.any(),
        True,
    )
    return Traced(
        fronts.distances,
        angles,
        arrivals,
        rotations,
        spreads,
        labels.astype(np.int64),
        sources,
        frames,
    )


def trace_curve(solver: GeodesicSolver, points: SourcePoints, course: Course) -> FloatArray:
    """Return the arc length, (N,), of the nearest place on a curve; NaN without a connection.

    Parameters
    ----------
    solver : GeodesicSolver
        Of a mesh or a cloud.
    points : SourcePoints
        The curve as it has been located.
    course : Course
        The same curve.

    Raises
    ------
    UnsupportedDomainError
        As for :func:`trace`.
    """
    fronts = solver.method.fronts(points)
    with np.errstate(invalid="ignore"):  # at an end of the curve it is not a number
        turning = points.curvatures * points.distances
    is_circle = ~(turning < TURNING)
    spreads = 1 / (1 - np.where(is_circle, 0.0, turning))
    along, _, _, _, labels, _, _, _ = solver.tracer.carry(
        fronts.swept,
        fronts.curvatures,
        points.vertices,
        points.distances,
        course.places_of(places_of(solver.passable)[points.vertices]),
        np.where(is_circle, SHADOW, spreads),
        np.full(len(points.vertices), np.nan),
        np.zeros(len(points.vertices), dtype=np.int32),
        course.period,
        False,
        False,
    )
    return np.where(labels < 0, np.nan, along)
