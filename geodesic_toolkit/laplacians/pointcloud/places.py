"""The different places of a cloud, of which several points may be at one."""

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

LARGE = 100_000
"""Points from which on they are taken in an order in which near ones are together: those of a cloud
drawn at random are all over the memory otherwise."""


@dataclass(frozen=True, eq=False)
class Places:
    """The P places of a cloud of N points.

    Attributes
    ----------
    points : ndarray of shape (P, 3), float64
        Where they are, normalised in position and size.
    scale : float
        What a unit of them is in the unit of the cloud.
    present : ndarray of shape (N',), int64
        The points that are not missing.
    first : ndarray of shape (P,), int64
        The first of `present` at each place.
    place : ndarray of shape (N',), int64
        The place of each of them.
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
        """Return the places of a cloud, near ones together where they are many."""
        present = np.flatnonzero(cloud.present)
        points, scale = normalised(cloud.points, cloud.present)
        first, place = distinct_points(points)
        points = points[first]
        if len(first) > LARGE:
            order = along_curve(points)
            first, points, place = first[order], points[order], np.argsort(order)[place]
        return cls(points, scale, present, first, place, cloud.n_vertices)

    @property
    def count(self) -> int:
        """Number P of places."""
        return len(self.points)

    @cached_property
    def representatives(self) -> IntArray:
        """The (P,) first point of the cloud at each place."""
        return np.asarray(self.present[self.first])

    @cached_property
    def ties(self) -> IntArray:
        """The pairs (first point at the place, another point at it), of shape (D, 2)."""
        again = np.flatnonzero(self.first[self.place] != np.arange(len(self.place)))
        return np.column_stack([self.representatives[self.place[again]], self.present[again]])

    def shared(self, amounts: FloatArray) -> FloatArray:
        """Return amounts (P,) in equal parts for all points at a place, (N,); 0 where missing."""
        return self.told(amounts / np.bincount(self.place), 0.0)

    def told(self, values: NDArray[Scalar], missing: float | bool) -> NDArray[Scalar]:
        """Return what values (P,) are at each point, (N,)."""
        everywhere = np.full(self.n_vertices, missing, dtype=values.dtype)
        everywhere[self.present] = values[self.place]
        return everywhere
