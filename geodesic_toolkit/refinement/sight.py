"""Vertices in sight of sources between vertices, at which fronts begin in addition."""

from dataclasses import dataclass

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["Sight", "in_sight", "missing_triangles"]


@dataclass(frozen=True, eq=False)
class Sight:
    """Vertices that straight lines from sources reach, besides those around the sources.

    Attributes
    ----------
    rows : ndarray of shape (S,), int64
        The source that each vertex is in sight of.
    vertices : ndarray of shape (S,), int64
    positions : ndarray of shape (S,), complex128
        The places of the vertices in a plane about the source: the farthest vertex around the
        source lies on the real axis, and the next of these has a positive imaginary part.
    """

    rows: IntArray
    vertices: IntArray
    positions: np.ndarray[tuple[int, ...], np.dtype[np.complex128]]

    @property
    def distances(self) -> FloatArray:
        """Their distances from the sources, of shape (S,)."""
        return np.abs(self.positions)


def in_sight(
    points: SourcePoints, gradient: ElementGradient, frames: FloatArray, hidden: BoolArray
) -> Sight:
    """Return the vertices in sight of sources that lie between the vertices of a triangle.

    These are the vertices opposite the edge on which a source lies; those that are nearer to the
    source than both ends of the edge between, so that no front comes to them across it; and those
    that may come between a source and the corners of its triangle where edges are flipped.

    Parameters
    ----------
    points : SourcePoints
        Sources at vertices, and those whose vertices do not form an edge or a triangle, see
        nothing.
    gradient : ElementGradient
        Its elements are the triangles of the domain, (E, 3), without flips.
    frames : ndarray of shape (E, 3), float64
        The inverse frames by which these triangles are measured.
    hidden : ndarray of shape (N,), bool
        The vertices of triangles whose edges are flipped, in whichever of them a source may be.

    Returns
    -------
    Sight
    """
    rows, own = _between(points)
    places, vertices, x, y = _native.in_sight(
        np.append(0, np.cumsum(np.diff(points.begins)[rows])),
        points.vertices[own],
        points.distances[own],
        gradient.elements,
        frames,
        gradient.stars,
        hidden,
    )
    return Sight(rows[places], vertices, x + 1j * y)


def missing_triangles(some: IntArray, others: IntArray) -> IntArray:
    """Return the triangles, (M, 3), of `some`, (F, 3), that are not among `others`, (G, 3)."""
    both = np.sort(np.concatenate([others, some]), axis=1)
    order = np.lexsort(both.T)  # stable: of equal triangles the others come first
    both = both[order]
    new = np.append(True, (both[1:] != both[:-1]).any(axis=1))
    first = order[np.flatnonzero(new)[np.cumsum(new) - 1]]
    return np.asarray(both[(order >= len(others)) & (first >= len(others))])


def _between(points: SourcePoints) -> tuple[IntArray, IntArray]:
    """Return the sources between two or three different vertices, and the entries of these."""
    sizes = np.diff(points.begins)
    chosen = np.zeros(points.count, dtype=np.bool_)
    for size in (2, 3):
        own = np.flatnonzero(sizes == size)
        entries = points.begins[own][:, None] + np.arange(size)
        around = np.sort(points.vertices[entries], axis=1)
        differ = (around[:, 1:] != around[:, :-1]).all(axis=1)
        chosen[own] = differ & (points.shares[entries] > 0).all(axis=1)
    return np.flatnonzero(chosen), np.flatnonzero(chosen[points.rows])
