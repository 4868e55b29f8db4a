"""Local Delaunay stars: the triangles that surround each point of a cloud in its tangent plane.

The kernel is ``native/clouds/stars.cpp``, with the measurements behind its constants.
"""

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.geometry.threads import threads_for

__all__ = ["delaunay_stars", "tie_breakers", "tie_widths"]

RELATIVE_JITTER = 1e-8
"""Perturbation of four points on a circle, relative to squared nearest distances: larger than
rounding, so that the stars of a square grid agree on its diagonals."""


def delaunay_stars(
    points: FloatArray,
    normals: FloatArray,
    neighbours: IntArray,
    *,
    k: int,
    oriented: bool,
    smooth: bool,
    centres: IntArray | None = None,
    reaches: FloatArray | None = None,
    weights: FloatArray | None = None,
) -> tuple[IntArray, FloatArray, BoolArray]:
    """Return the stars of all points as one triangle soup.

    The neighbours of a point are the k nearest that lie on its sheet, at less than 45° from the
    tangent plane (with oriented normals, neighbours with an opposite normal are excluded too). A
    star is known to be Delaunay if the circle of every triangle lies in the ball of these
    neighbours; otherwise all of `neighbours` are used, beyond the first k of a smooth cloud only
    those within 27° of the sheet. Triangles that even then reach past the neighbours are excluded
    if they are obtuse: they bridge the outside of a boundary, or an empty region.

    A star is measured in the tangent plane of its centre: a neighbour keeps its direction there,
    but lies at its distance across the mean of both tangent planes. That is the chord of a circle
    through both with these normals, and noise along the normals does not lengthen it. A neighbour
    on the sheet is preferred to one that is off that mean plane.

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
        Distinct.
    normals : ndarray of shape (N, 3), float64
        Of length 1.
    neighbours : ndarray of shape (M, m), int64
        Nearest first, more than k if stars are to grow.
    k : int
        Initial number of neighbours.
    oriented : bool
        True if the signs of the normals are meaningful.
    smooth : bool
        True if the points lie on the surface almost without noise.
    centres : ndarray of shape (M,), int64, optional
        The points whose stars are made, ascending; all of them unless given.
    reaches : ndarray of shape (M,), float64, optional
        Maximum diameter of the circle through a triangle of each star; unlimited unless given.
    weights : ndarray of shape (N,), float64, optional
        Result of :func:`tie_breakers`, needed if `neighbours` are not those of all points.

    Returns
    -------
    triangles : ndarray of shape (E, 3), int64
        The centre of the star first; sorted by it.
    frames : ndarray of shape (E, 3), float64
        The planar frames ``(l, a, b)`` of the triangles, as in `geometry.triangles`.
    open : ndarray of shape (M,), bool
        True if the star does not surround its point.

    References
    ----------
    K. Q. Brown, *Voronoi diagrams from convex hulls*, Information Processing Letters 9, 1979,
    https://doi.org/10.1016/0020-0190(79)90074-7
    """
    if centres is None:
        centres = np.arange(len(points))
    if reaches is None:
        reaches = np.full(len(centres), np.inf)
    if weights is None:
        weights = tie_breakers(points, neighbours)
    return _native.delaunay_stars(
        np.ascontiguousarray(points),
        np.ascontiguousarray(normals),
        centres,
        np.ascontiguousarray(neighbours),
        reaches,
        weights,
        k=k,
        oriented=oriented,
        smooth=smooth,
        n_threads=threads_for(len(centres)),
    )


def tie_breakers(points: FloatArray, neighbours: IntArray) -> FloatArray:
    """Return perturbations (N,) of squared distances, so that four points never share a circle.

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
    neighbours : ndarray of shape (N, m), int64
        Nearest first.
    """
    if neighbours.shape[1] == 0:
        return np.zeros(len(points))
    with np.errstate(invalid="ignore"):  # from overflowing coordinates
        steps = points[neighbours[:, 0]] - points
    return tie_widths(np.einsum("nd,nd->n", steps, steps))


def tie_widths(squared_nearest: FloatArray) -> FloatArray:
    """Return the same of points whose squared distances to the nearest are these, (N,)."""
    shares = np.random.default_rng(0).random(len(squared_nearest))  # the same ones every time
    return np.asarray(RELATIVE_JITTER * shares * squared_nearest)
