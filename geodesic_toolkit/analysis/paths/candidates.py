"""The best of the candidate paths from a vertex down to others, straightened."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["Candidate", "best_path"]


@dataclass(frozen=True, eq=False)
class Candidate:
    """A path of P points over triangles, each on an edge of one.

    Attributes
    ----------
    faces : ndarray of shape (P,), int64
    ends : ndarray of shape (P, 2), int64
        The vertices of the edge; the same one twice at a vertex.
    weights : ndarray of shape (P, 2), float64
        Weights of these vertices, non-negative with sum 1.
    """

    faces: IntArray
    ends: IntArray
    weights: FloatArray

    @property
    def backward(self) -> Candidate:
        """The same path from its end to its start."""
        return Candidate(self.faces[::-1], self.ends[::-1], self.weights[::-1])


def best_path(
    surface: _native.Surface,
    height: FloatArray,
    back: FloatArray,
    *,
    start: int,
    ends: IntArray,
) -> Candidate | None:
    """Return a geodesic over triangles from a vertex to one of several; None if unconnected.

    Steepest descent from the start, from points beside it and from points in between yields
    candidate strips of triangles (native/paths). The shortest path through the strip is moved to
    the other side of each vertex where that is shorter, at all such vertices at once.

    Parameters
    ----------
    surface : Surface
        Of N vertices.
    height : ndarray of shape (N,), float64
        The distance from the ends, 0 there.
    back : ndarray of shape (N,), float64
        The distance from the start, 0 there.
    start : int
        A vertex that is not one of the ends.
    ends : ndarray of shape (K,), int64

    Returns
    -------
    Candidate or None
    """
    passed, beside, shares = _native.best_path(surface, height, back, start, ends)
    if len(passed) == 0:
        return None
    return Candidate(passed, beside, np.column_stack([1 - shares, shares]))
