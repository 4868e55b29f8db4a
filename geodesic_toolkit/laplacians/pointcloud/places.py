"""The distinct positions of a cloud; several points may share one."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains import PointCloud
from geodesic_toolkit.laplacians.pointcloud.neighbours import (
    along_curve,
    distinct_points,
    normalised,
)

__all__ = ["Places"]

Scalar = TypeVar("Scalar", bound=np.generic)

MIN_POINTS_TO_REORDER = 100_000
"""Number of points above which they are sorted so that neighbours are close together in memory;
points of a cloud drawn at random are scattered otherwise."""


@dataclass(frozen=True, eq=False)
class Places:
    """The P distinct positions of a cloud of N points.

    Attributes
    ----------
    points : ndarray of shape (P, 3), float64
        Coordinates of the positions, normalised in position and size.
    scale : float
        Length of one unit of `points` in units of the cloud.
    present : ndarray of shape (N',), int64
        The points that are not missing.
    first : ndarray of shape (P,), int64
        Index into `present` of the first point at each position.
    place : ndarray of shape (N',), int64
        The position of each present point.
    n_vertices : int
        Number N of points, the missing ones among them.
    """

    points: FloatArray
    scale: float
    present: IntArray
    first: IntArray
    place: IntArray
    n_vertices: int

    @classmethod
    def of(cls, cloud: PointCloud) -> Places:
        """Return the positions of a cloud; in large clouds, near ones are together in the order."""
        present = np.flatnonzero(cloud.present)
        points, scale = normalised(cloud.points, cloud.present)
        first, place = distinct_points(points)
        points = points[first]
        if len(first) > MIN_POINTS_TO_REORDER:
            order = along_curve(points)
            first, points, place = first[order], points[order], np.argsort(order)[place]
        return cls(points, scale, present, first, place, cloud.n_vertices)

    @property
    def count(self) -> int:
        """Number P of positions."""
        return len(self.points)

    @cached_property
    def representatives(self) -> IntArray:
        """The first point of the cloud at each position, of shape (P,)."""
        return np.asarray(self.present[self.first])

    @cached_property
    def ties(self) -> IntArray:
        """The pairs (first point at a position, another point at it), of shape (D, 2)."""
        again = np.flatnonzero(self.first[self.place] != np.arange(len(self.place)))
        return np.column_stack([self.representatives[self.place[again]], self.present[again]])

    def shared(self, amounts: FloatArray) -> FloatArray:
        """Divide amounts (P,) equally among the points at a position, (N,); 0 for missing ones."""
        return self.at_points(amounts / np.bincount(self.place), 0.0)

    def at_points(self, values: NDArray[Scalar], missing: float | bool) -> NDArray[Scalar]:
        """Return the values (P,) of positions at each point, (N,)."""
        everywhere = np.full(self.n_vertices, missing, dtype=values.dtype)
        everywhere[self.present] = values[self.place]
        return everywhere
