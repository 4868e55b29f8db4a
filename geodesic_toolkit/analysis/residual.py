"""The eikonal residual: the deviation of the slope of a distance from 1, an indicator of its error.

It does not need an exact distance for comparison. The true distance satisfies the eikonal equation
``|∇φ| = 1`` almost everywhere. If a computed one does not, on an element or along an edge, it is
wrong nearby, or the element holds a crease of the true distance: a source, or points where shortest
paths of equal length meet.
"""

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.checks import real_numbers
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.discretization.edge_gradient import EdgeGradient
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.solver.solver import GeodesicSolver, check_solver

__all__ = ["eikonal_residual", "mean_eikonal_residual"]


def eikonal_residual(solver: GeodesicSolver, distance: ArrayLike) -> FloatArray:
    """Return the deviation of ``|∇φ|`` from 1, by element or by edge.

    Parameters
    ----------
    solver : GeodesicSolver
        The gradient is taken in its metric.
    distance : array-like of shape (N,)
        At the vertices.

    Returns
    -------
    ndarray of shape (E,), float64
        ``||∇φ| - 1|``, dimensionless. On elements (triangles of meshes and clouds) by element; on
        graphs by edge, with the slope pooled at the vertices and averaged over the two ends. NaN
        if a distance is not finite.

    Raises
    ------
    InvalidOptionError
        The number of distances is not the number of vertices.
    UnsupportedDomainError
        A gradient of a plugin's own kind.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> plane = gt.testing.shapes.grid(5)
    >>> solver = gt.GeodesicSolver(plane)
    >>> bool(gt.eikonal_residual(solver, plane.vertices[:, 0]).max() < 1e-12)  # distance from x = 0
    True
    """
    residual, _ = _measured(solver, distance)
    return residual


def mean_eikonal_residual(solver: GeodesicSolver, distance: ArrayLike) -> float:
    """Return the mean of :func:`eikonal_residual`, weighted by area (or by the measure of edges).

    It indicates with one number how accurate a distance is. It compares distances on one shape, and
    shapes with each other for one method; it is not a bound. If the true distance has creases, it
    is not 0 for the exact distance either, but falls with the mean edge length.

    Parameters
    ----------
    solver, distance
        As for :func:`eikonal_residual`.

    Returns
    -------
    float
        NaN if no element has finite distances.

    Raises
    ------
    InvalidOptionError, UnsupportedDomainError
        As for :func:`eikonal_residual`.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit.analysis.residual import mean_eikonal_residual
    >>> solver = gt.GeodesicSolver(gt.testing.shapes.icosphere(3))
    >>> round(mean_eikonal_residual(solver, solver.distance(0)), 2)
    0.02
    """
    residual, measure = _measured(solver, distance)
    known = np.isfinite(residual)
    total = measure[known].sum()
    return float(residual[known] @ measure[known] / total) if total > 0 else float("nan")


def _measured(solver: GeodesicSolver, distance: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return the residual and the measure of each element or edge."""
    check_solver(solver, "a residual")
    gradient = solver.method.metric.on_surface
    values = real_numbers(distance, "distance")
    if values.shape != (gradient.n_vertices,):
        raise InvalidOptionError(
            f"distance must have shape ({gradient.n_vertices},), one number per vertex, "
            f"not {values.shape}"
        )
    if isinstance(gradient, ElementGradient):
        slopes = _differences(values, gradient.elements)
        squared = np.zeros(len(slopes))
        for axis in range(gradient.coefficients.shape[1]):
            squared += np.einsum("em,em->e", gradient.coefficients[:, axis], slopes) ** 2
        return np.abs(np.sqrt(squared) - 1), np.asarray(gradient.measure)
    if isinstance(gradient, EdgeGradient):
        slopes = _differences(values, gradient.edges)[:, 1]
        energy = gradient.edge_weights * slopes**2
        pooled = sum(
            np.bincount(gradient.edges[:, end], energy, minlength=gradient.n_vertices)
            for end in range(2)
        )
        mass = 2 * gradient.measure
        length = np.sqrt(np.divide(pooled, mass, out=np.zeros(len(mass)), where=mass > 0))
        residual = np.abs(length[gradient.edges].mean(axis=1) - 1)
        return residual, gradient.measure[gradient.edges].sum(axis=1)
    raise UnsupportedDomainError(f"the slope of a distance cannot be computed from {gradient!r}")


def _differences(values: FloatArray, elements: IntArray) -> FloatArray:
    """Return the values at the corners minus that at the first; NaN if one is not finite."""
    corners = np.where(np.isfinite(values), values, np.nan)[elements]
    return np.asarray(corners - corners[:, :1])
