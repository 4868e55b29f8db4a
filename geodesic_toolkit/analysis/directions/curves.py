"""Places along a curve, by their arc length from its beginning."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import Domain, PointCloud, TriangleMesh
from geodesic_toolkit.sources.kinds import Curve
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["Course", "places_of", "positions"]

AT_ONCE = 1_000_000
"""Pairs of a place and a segment that are compared at once."""


@dataclass(frozen=True, eq=False)
class Course:
    """The corners of a polyline; a closed one repeats its first corner at the end.

    Attributes
    ----------
    corners : ndarray of shape (P, 3) or (P + 1, 3), float64
    closed : bool
    """

    corners: FloatArray
    closed: bool

    @classmethod
    def of(cls, curve: Curve, domain: Domain) -> "Course":
        """Return the course of a curve on a domain."""
        corners = curve.points
        if isinstance(corners, tuple):
            assert isinstance(domain, TriangleMesh)  # for the type checker; it has been located
            faces = domain.faces[[point.face for point in corners]]
            weights = np.array([point.barycentric for point in corners])
            corners = np.einsum("pc,pcd->pd", weights, domain.vertices[faces])
        if curve.closed:
            corners = np.concatenate([corners, corners[:1]])
        return cls(corners, curve.closed)

    @property
    def count(self) -> int:
        """Number P of corners."""
        return len(self.corners) - self.closed

    @property
    def ends(self) -> FloatArray:
        """The arc lengths of the corners."""
        steps = np.linalg.norm(np.diff(self.corners, axis=0), axis=1)
        return np.append(0.0, np.cumsum(steps))

    @property
    def period(self) -> float:
        """The length of a closed curve; infinite for others."""
        return float(self.ends[-1]) if self.closed else np.inf

    def places_of(self, points: FloatArray) -> FloatArray:
        """Return the arc length of the place that is nearest to each point, (Q, 3)."""
        tails, steps = self.corners[:-1], np.diff(self.corners, axis=0)
        squares = np.einsum("sd,sd->s", steps, steps)
        size = max(1, AT_ONCE // len(steps))
        along = np.empty(len(points))
        for first in range(0, len(points), size):
            off = points[first : first + size, None] - tails
            share = np.einsum("qsd,sd->qs", off, steps) / np.where(squares > 0, squares, 1.0)
            share = np.clip(share, 0.0, 1.0)
            off -= share[..., None] * steps
            nearest = np.einsum("qsd,qsd->qs", off, off).argmin(axis=1)
            rows = np.arange(len(nearest))
            along[first : first + size] = self.ends[nearest] + share[rows, nearest] * np.sqrt(
                squares[nearest]
            )
        return along

    def at(self, along: FloatArray, values: NDArray[Any]) -> NDArray[Any]:
        """Return values at places, (Q,) or (Q, k), from those at the corners.

        Integers are those of the nearest corner; floats are interpolated linearly.
        """
        ends = self.ends
        if self.closed:
            values = np.concatenate([values, values[:1]])
            along = np.mod(along, ends[-1])
        if values.dtype.kind != "f":
            middles = (ends[1:] + ends[:-1]) / 2
            return np.asarray(values[np.searchsorted(middles, along)])
        table = values.reshape(len(values), -1)
        columns = [np.interp(along, ends, column) for column in table.T]
        return np.stack(columns, axis=1).reshape(len(along), *values.shape[1:])


def places_of(domain: Domain) -> FloatArray:
    """Return the positions of the vertices of a mesh or a cloud, (N, 3)."""
    assert isinstance(domain, TriangleMesh | PointCloud)  # for the type checker
    return domain.vertices if isinstance(domain, TriangleMesh) else domain.points


def positions(domain: Domain, points: SourcePoints) -> FloatArray:
    """Return the positions of sources, (P, 3)."""
    corners = places_of(domain)[points.vertices]
    return np.add.reduceat(points.shares[:, None] * corners, points.begins[:-1])
