"""The best of the ways down from a vertex, straightened; what paths on meshes and clouds share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["Way", "best_path"]


@dataclass(frozen=True, eq=False)
class Way:
    """The P points of a way over triangles, each on an edge of one.

    Attributes
    ----------
    faces : ndarray of shape (P,), int64
    ends : ndarray of shape (P, 2), int64
        The vertices of the edge; twice the same at a vertex.
    weights : ndarray of shape (P, 2), float64
        Their weights, non-negative with sum 1.
    """

    faces: IntArray
    ends: IntArray
    weights: FloatArray

    @property
    def backward(self) -> Way:
        """The same way from its end to its start."""
        return Way(self.faces[::-1], self.ends[::-1], self.weights[::-1])


def best_path(
    vertices: FloatArray,
    faces: IntArray,
    height: FloatArray,
    back: FloatArray,
    *,
    start: int,
    ends: IntArray,
) -> Way | None:
    """Return a geodesic over triangles from a vertex to one of several; None if none leads there.

    Steepest descent gives the strip of triangles that it runs through, and is also begun beside the
    start and in between (native/paths/ways.hpp). The shortest path through the strip is led around
    the other side of every vertex where that is shorter, of all such vertices at once.

    Parameters
    ----------
    vertices : ndarray of shape (N, 3), float64
    faces : ndarray of shape (F, 3), int64
        Each with three different vertices; any number may meet at an edge.
    height : ndarray of shape (N,), float64
        The distance from the ends, 0 there.
    back : ndarray of shape (N,), float64
        The distance from the start, 0 there.
    start : int
        A vertex that is none of the ends.
    ends : ndarray of shape (K,), int64

    Returns
    -------
    Way or None
    """
    passed, beside, shares = _native.best_path(
        np.ascontiguousarray(vertices), np.ascontiguousarray(faces), height, back, start, ends
    )
    if len(passed) == 0:
        return None
    return Way(passed, beside, np.column_stack([1 - shares, shares]))
