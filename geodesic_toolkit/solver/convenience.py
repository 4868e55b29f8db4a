"""Distances on a shape by one call."""

from typing import Any

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.interop.conversion import check_one_shape
from geodesic_toolkit.laplacians.base import LaplaceOperator
from geodesic_toolkit.solver.solver import GeodesicSolver

__all__ = ["geodesic_distance"]


def geodesic_distance(
    domain: Any,
    sources: Any,
    *others: Any,
    operator: str | type[LaplaceOperator] | LaplaceOperator = "auto",
    **options: Any,
) -> FloatArray:
    """Return the geodesic distance of every vertex of `domain` from `sources`.

    For more than one source set on a shape use a :class:`GeodesicSolver`, which factorises once.

    Parameters
    ----------
    domain : Domain or object
        A TriangleMesh, PointCloud or Graph, or any object that :func:`as_domain` takes.
    sources : int, array-like of int, array-like of float, SurfacePoint or sequence of them
        One set of sources, as :meth:`GeodesicSolver.distance` takes it.
    *others
        Not used: an error explains how to pass vertices and faces, if they are two arguments.
    operator : str, class or instance
        The Laplace operator.
    **options
        Options of :class:`GeodesicSolver`.

    Returns
    -------
    ndarray of shape (N,), float64
        In the unit of the domain; ``inf`` at vertices that are not connected to a source.

    Raises
    ------
    GeodesicError
        An error of :class:`GeodesicSolver` or its `distance`.

    References
    ----------
    K. Crane, C. Weischedel, M. Wardetzky, *Geodesics in Heat*, 2013,
    https://doi.org/10.1145/2516971.2516977

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> strip = gt.TriangleMesh(
    ...     [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0], [9, 9, 9]],
    ...     [[0, 1, 3], [1, 4, 3], [1, 2, 4], [2, 5, 4]],
    ... )
    >>> distance = gt.geodesic_distance(strip, 0)
    >>> float(distance[0]), float(distance[6])
    (0.0, inf)
    """
    check_one_shape("geodesic_distance", others)
    return GeodesicSolver(domain, operator=operator, **options).distance(sources)
