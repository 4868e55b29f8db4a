"""Extension of values from sources: each place takes the value of its nearest source."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodesic_toolkit.analysis.directions.curves import Course, positions
from geodesic_toolkit.analysis.directions.traced import refines, trace, trace_curve
from geodesic_toolkit.core.checks import real_numbers
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.errors import InvalidOptionError
from geodesic_toolkit.solver.solver import GeodesicSolver
from geodesic_toolkit.sources.kinds import Curve

__all__ = ["extend"]


def extend(
    solver: GeodesicSolver, sources: Any, values: ArrayLike, *, refine: bool | None = None
) -> NDArray[Any]:
    """Return at each vertex the value of the nearest source.

    Refined, values are carried unchanged along the shortest geodesics: for the numbers of the
    sources, the result is their Voronoi cells, in one pass. Along a curve values are linear
    between its corners. Plain values are the ratio of two diffusions, which blends the values of
    neighbouring sources, over a wider range farther away.

    Parameters
    ----------
    solver : GeodesicSolver
        Of a mesh or a point cloud.
    sources : int, array-like, SurfacePoint, sequence of them, Curve or OffsetSources
        P places, as :meth:`GeodesicSolver.distance` takes them, or a curve of P corners.
    values : array-like of shape (P,) or (P, k)
        One for each source, or for each corner of the curve. Integers stay integers where they are
        refined.
    refine : bool, optional
        As the solver does, by default.

    Returns
    -------
    ndarray of shape (N,) or (N, k), float64 or int64
        NaN, or -1 among integers, at vertices without a connection to a source.

    Raises
    ------
    InvalidOptionError
        An argument that is not a solver; another number of values than of sources, or values that
        are not finite; a `refine` that is neither True nor False.
    UnsupportedDomainError
        Refined: a graph; a surface with one side; elements that are not triangles.
    InvalidSourceError
        No source.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> solver = gt.GeodesicSolver(gt.testing.shapes.grid(3))
    >>> gt.extend(solver, [0, 8], [10, 20])[[1, 7]]
    array([10, 20])
    """
    refined = refines(solver, "extend", refine)
    points = solver.locate(sources)
    course = Course.of(sources, solver.domain) if isinstance(sources, Curve) else None
    given = _values(values, points.count if course is None else course.count)
    if not refined:
        table = given.astype(np.float64)
        if course is not None:
            table = course.at(course.places_of(positions(solver.passable, points)), table)
        return solver.vector_heat.extend(points, table)
    if course is None:
        labels = trace(solver, points).labels
        extended, reached = given[labels], labels >= 0
    else:
        along = trace_curve(solver, points, course)
        reached = np.isfinite(along)
        extended = course.at(np.where(reached, along, 0.0), given)
    if given.dtype.kind == "f":
        extended[~reached] = np.nan
    else:
        extended[~reached] = -1
    return extended


def _values(values: ArrayLike, count: int) -> NDArray[Any]:
    """Return values as an array of float64 or int64, checked."""
    real_numbers(values, "values")
    table = np.atleast_1d(np.asarray(values))
    if len(table) != count or table.ndim > 2:
        raise InvalidOptionError(
            f"values must have shape ({count},) or ({count}, k), one for each source or corner of "
            f"the curve, not {table.shape}"
        )
    if table.dtype.kind != "f":
        return table.astype(np.int64)
    finite: FloatArray = np.isfinite(table).reshape(count, -1).all(axis=1)
    if not finite.all():
        bad = int(finite.argmin())
        raise InvalidOptionError(f"value {bad} is not finite: {table[bad].tolist()}")
    return table.astype(np.float64)
