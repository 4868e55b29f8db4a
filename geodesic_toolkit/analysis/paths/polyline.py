"""What paths have in common: points in space, one after the other."""

import abc

import numpy as np

from geodesic_toolkit.core.types import FloatArray

__all__ = ["Polyline", "without_repeats"]

SAME = 1e-12
"""Share of the size of the shape within which two points are one."""


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


def without_repeats(places: FloatArray, within: FloatArray) -> list[int]:
    """Return which points of a path are not where the one before them is; both ends stay.

    Parameters
    ----------
    places : ndarray of shape (P, 3)
    within : ndarray of shape (N, 3)
        Points that extend as far as the shape does.
    """
    near = SAME * float(np.ptp(within, axis=0).max())
    kept = [0]
    for index in range(1, len(places)):
        if np.linalg.norm(places[index] - places[kept[-1]]) > near:
            kept.append(index)
    kept[-1] = len(places) - 1 if len(kept) > 1 else 0
    return kept
