"""The vector heat method, for any discretization that has tangent frames.

N. Sharp, Y. Soliman, K. Crane, *The Vector Heat Method*, ACM Transactions on Graphics 38, 2019,
https://doi.org/10.1145/3243651
"""

import threading
from functools import cached_property
from typing import NamedTuple

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.discretization.positivity import positive_part
from geodesic_toolkit.errors import InvalidSourceError
from geodesic_toolkit.geometry.frames import ComplexArray, Frames
from geodesic_toolkit.heat.method import HeatMethod
from geodesic_toolkit.linear.base import LinearSolver
from geodesic_toolkit.sources.points import SourcePoints
from geodesic_toolkit.vector_heat.connection import (
    Connection,
    connection_along_edges,
    connection_laplacian,
)
from geodesic_toolkit.vector_heat.flow import LogVectors, VectorFlow
from geodesic_toolkit.vector_heat.outward import outward_load

__all__ = ["PlainLogMap", "VectorHeatMethod"]


class PlainLogMap(NamedTuple):
    """A logarithmic map by heat.

    Attributes
    ----------
    coordinates : ndarray of shape (N,), complex128
        The logarithm of each vertex, in the frame of the source; NaN where nothing connects.
    arrival : ndarray of shape (N,), complex128
        The direction, of length 1, in which the distance grows there, in the frame of each vertex;
        0 where nothing connects.
    axes : ndarray of shape (2, 3), float64
        The frame of the source in space.
    """

    coordinates: ComplexArray
    arrival: ComplexArray
    axes: FloatArray


class VectorHeatMethod:
    """Transport of vectors and extension of values by heat, for any domain and Laplacian.

    ``(M + t L_c) x = b`` with the connection Laplacian L_c, Hermitian and positive semidefinite,
    goes to the linear solvers as a real system of twice as many unknowns; lengths are kept as
    logarithms, so that they may be arbitrarily small. Vectors flow where the scalar heat does:
    where that is not positive at a single vertex, both take the positive part of the diffusion.
    Boundaries are insulated.

    Parameters
    ----------
    heat : HeatMethod
        The scalar heat beside it: metric, diffusion, time step, linear solver.
    frames : Frames
        Those of the operator, for the metric.
    solver : LinearSolver, optional
        Another one than that of the scalar heat, which may be content with an order.
    time_factor : float
        Time step of the vectors in units of that of the scalar heat.

    References
    ----------
    N. Sharp, Y. Soliman, K. Crane, *The Vector Heat Method*, 2019, https://doi.org/10.1145/3243651

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit.vector_heat import VectorHeatMethod
    >>> solver = gt.GeodesicSolver(gt.testing.shapes.grid(5))
    >>> vectors = VectorHeatMethod(solver.method, solver.frames)
    >>> there = vectors.transport(solver.locate(0), [[0.0, 2.0, 0.0]])
    >>> vectors.frames.to_space(there)[24].round(9) + 0.0
    array([0., 2., 0.])
    """

    def __init__(
        self,
        heat: HeatMethod,
        frames: Frames,
        solver: LinearSolver | None = None,
        *,
        time_factor: float = 1.0,
    ) -> None:
        self.heat, self.frames = heat, frames
        self._times = time_factor * np.asarray(heat.times)
        self._solver = heat.heat_solver if solver is None else solver
        self._flows: dict[bool, VectorFlow] = {}
        self._lock = threading.Lock()

    @cached_property
    def connection(self) -> Connection:
        """The connection Laplacian of the metric."""
        return connection_laplacian(self.heat.metric, self.frames)

    @property
    def nbytes(self) -> int:
        """Bytes of the factors made so far."""
        return sum(flow.nbytes for flow in self._flows.values())

    def diffuse(self, load: ComplexArray) -> LogVectors:
        """Return vectors at vertices, complex (N,), after diffusion."""
        positive = not self.heat.stays_positive(np.abs(load))
        return self._flow(positive=positive).log_solve(load)

    def prepare(self) -> "VectorHeatMethod":
        """Factorise now rather than on first use, and return the method."""
        self._flow(positive=False)
        return self

    def _flow(self, *, positive: bool) -> VectorFlow:
        with self._lock:
            if positive not in self._flows:
                heat, metric = self.heat, self.heat.metric
                if positive:
                    its = positive_part(heat.diffusion)
                    connection = connection_along_edges(its, metric, self.frames)
                elif heat.diffusion is metric:
                    connection = self.connection
                else:
                    connection = connection_along_edges(heat.diffusion, metric, self.frames)
                matrix = connection.plus_mass(heat.diffusion.mass, self._times)
                self._flows[positive] = VectorFlow(
                    matrix, connection.pattern, self._solver, heat.known_analysis
                )
            return self._flows[positive]

    # -- what it is for ------------------------------------------------------------------------

    def transport(self, points: SourcePoints, vectors: FloatArray) -> ComplexArray:
        """Return at each vertex the vector of the nearest point, carried there in parallel.

        Parameters
        ----------
        points : SourcePoints
        vectors : array-like of shape (P, 3), float64
            In space; only their parts in the tangent planes count.

        Returns
        -------
        ndarray of shape (N,), complex128
            In the frame of each vertex; 0 where nothing connects.

        Raises
        ------
        InvalidSourceError
            A vector that is zero, or at a right angle to the surface.
        """
        at_corners = self._in_frames(points, np.asarray(vectors, dtype=np.float64))
        sizes = np.add.reduceat(points.shares * np.abs(at_corners), points.begins[:-1])
        _check_directions(sizes, np.asarray(vectors, dtype=np.float64))
        load = np.zeros(points.n_vertices, dtype=np.complex128)
        np.add.at(load, points.vertices, points.shares * _unit(at_corners))
        directions = self.diffuse(load).directions
        if np.ptp(sizes) <= ROUNDING * sizes.max():
            return np.asarray(directions * sizes[0])
        return directions * np.nan_to_num(self.extend(points, sizes))

    def extend(self, points: SourcePoints, values: FloatArray) -> FloatArray:
        """Return at each vertex the value of the nearest point, blurred by heat.

        It is the ratio of two diffusions, whose borders between cells get wider with distance.

        Parameters
        ----------
        points : SourcePoints
        values : array-like of shape (P,) or (P, k), float64

        Returns
        -------
        ndarray of shape (N,) or (N, k), float64
            NaN where nothing connects. No value is outside the range of those given.
        """
        given = np.asarray(values, dtype=np.float64)
        table = given.reshape(points.count, -1)
        low, span = table.min(axis=0), np.ptp(table, axis=0)
        varied = span > 0
        shares = np.divide(table - low, span, out=np.zeros_like(table), where=varied)
        loads = np.zeros((points.n_vertices, 1 + table.shape[1]))
        np.add.at(loads[:, 0], points.vertices, points.shares)
        for column in range(table.shape[1]):
            strength = points.shares * shares[points.rows, column]
            np.add.at(loads[:, 1 + column], points.vertices, strength)
        logs = self.heat.log_diffuse(loads)
        reached = logs[:, :1] > -np.inf
        ratio = np.exp(np.minimum(logs[:, 1:] - np.where(reached, logs[:, :1], 0.0), 0.0))
        result = np.where(reached, low + span * ratio, np.nan)
        return result.reshape(points.n_vertices, *given.shape[1:])

    def log_map(self, points: SourcePoints, distance: FloatArray) -> PlainLogMap:
        """Return the logarithmic map of one point, its angles by heat.

        The angle is that between what the outward normals of a small circle about the point become
        when they diffuse, and the axis of the point, carried along.

        Parameters
        ----------
        points : SourcePoints
            One of them.
        distance : ndarray of shape (N,), float64
            From the point.

        Returns
        -------
        PlainLogMap
        """
        centre = int(points.nearest_vertices[0])
        axes = np.array([self.frames.x_axes[centre], self.frames.y_axes[centre]])
        outward = outward_load(self.heat.metric, self.frames, points)
        arrival = self.diffuse(outward).directions
        axis = self.transport(points, axes[:1])
        angle = _unit(arrival * axis.conj())
        reached = np.isfinite(distance) & (angle != 0)
        coordinates = np.full(len(distance), complex(np.nan, np.nan))
        coordinates[reached] = distance[reached] * angle[reached]
        coordinates[distance == 0] = 0.0
        return PlainLogMap(coordinates, arrival, axes)

    def _in_frames(self, points: SourcePoints, vectors: FloatArray) -> ComplexArray:
        """Return vectors (P, 3) at points in the frames of the vertices around those, (nnz,)."""
        return self.frames.to_frames(vectors[points.rows], points.vertices)


ROUNDING = 1e-12
"""Relative difference of lengths up to which they count as equal."""


def _check_directions(sizes: FloatArray, vectors: FloatArray) -> None:
    """Raise where a vector has no direction along the surface."""
    none = ~(sizes > ROUNDING * np.linalg.norm(vectors, axis=1))
    if none.any():
        bad = int(none.argmax())
        raise InvalidSourceError(
            f"vector {bad}, {vectors[bad].tolist()}, has no direction along the surface: it is "
            "zero, not finite, or at a right angle to it"
        )


def _unit(numbers: ComplexArray) -> ComplexArray:
    sizes = np.abs(numbers)
    return np.divide(numbers, sizes, out=np.zeros_like(numbers), where=sizes > 0)
