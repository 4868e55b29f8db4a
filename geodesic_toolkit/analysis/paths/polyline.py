"""Polylines: the base class of paths that are sequences of points in space."""

import abc
import math

import numpy as np

from geodesic_toolkit.core.types import FloatArray

__all__ = ["SAME", "Polyline", "extent_of", "without_repeats"]

SAME = 1e-12
"""Distance within which two points are equal, relative to the size of the shape."""


class Polyline(abc.ABC):
    """A path, as a sequence of points."""

    @property
    @abc.abstractmethod
    def points(self) -> FloatArray:
        """The (P, 3) positions of the points."""

    @property
    def length(self) -> float:
        """Length of the polyline, in the unit of the shape."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())

    def __repr__(self) -> str:
        return f"{type(self).__name__}({len(self.points)} points, length {self.length:.6g})"


def extent_of(points: FloatArray) -> float:
    """Return the longest side of the box around points (N, 3)."""
    return float(np.ptp(points, axis=0).max())


def without_repeats(positions: FloatArray, extent: float) -> list[int]:
    """Return the indices of points that differ in position from the previous one; both ends stay.

    Parameters
    ----------
    positions : ndarray of shape (P, 3)
    extent : float
        Size of the shape.
    """
    near = SAME * extent
    steps = np.diff(positions, axis=0)
    if (np.einsum("pc,pc->p", steps, steps) > (2 * near) ** 2).all():  # as almost always
        return list(range(len(positions)))
    places = positions.tolist()
    kept = [0]
    for index in range(1, len(places)):
        if math.dist(places[index], places[kept[-1]]) > near:
            kept.append(index)
    kept[-1] = len(places) - 1 if len(kept) > 1 else 0
    return kept
