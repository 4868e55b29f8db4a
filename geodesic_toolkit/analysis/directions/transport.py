"""Parallel transport of tangent vectors from sources to everywhere."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.analysis.directions.traced import refines, trace
from geodesic_toolkit.core.checks import real_numbers
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.errors import InvalidOptionError, InvalidSourceError
from geodesic_toolkit.geometry.frames import unit_vectors
from geodesic_toolkit.solver.solver import GeodesicSolver

__all__ = ["parallel_transport"]

FLAT = 1e-12
"""Tangent part of a vector, relative to its length, up to which it has no direction."""


def parallel_transport(
    solver: GeodesicSolver, sources: Any, vectors: ArrayLike, *, refine: bool | None = None
) -> FloatArray:
    """Return at each vertex the tangent vector of the nearest source, carried there in parallel.

    Refined, the vector is carried along the shortest geodesic, to which it keeps its angle, and no
    linear system besides that of the heat is solved. Plain transport is the vector heat method,
    which blurs vectors where the cells of sources meet; where many sources are asked for one after
    the other, it is faster.

    Parameters
    ----------
    solver : GeodesicSolver
        Of a mesh or a point cloud.
    sources : int, array-like, SurfacePoint, sequence of them, or OffsetSources
        P places, as :meth:`GeodesicSolver.distance` takes them; no curve.
    vectors : array-like of shape (P, 3), or (3,) of one source
        In space; their parts in the tangent planes count.
    refine : bool, optional
        As the solver does, by default.

    Returns
    -------
    ndarray of shape (N, 3), float64
        Tangent vectors in space, as long as those of their sources along the surface; 0 where
        nothing connects.

    Raises
    ------
    InvalidOptionError
        An argument that is not a solver; vectors of another shape or not finite; a `refine` that
        is neither True nor False.
    UnsupportedDomainError
        A graph, as an edge has no angle; a surface with one side; elements that are not triangles.
    InvalidSourceError
        Not a source, or a curve; a vector without a direction along the surface.

    References
    ----------
    N. Sharp, Y. Soliman, K. Crane, *The Vector Heat Method*, 2019,
    https://doi.org/10.1145/3243651

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> solver = gt.GeodesicSolver(gt.testing.shapes.grid(5))
    >>> gt.parallel_transport(solver, 0, [1.0, 2.0, 0.0])[24].round(6) + 0.0
    array([1., 2., 0.])
    """
    refined = refines(solver, "parallel_transport", refine)
    frames = solver.frames  # refuses what has no directions
    points = solver.locate(sources)
    if points.front_curvatures is not None:
        raise InvalidSourceError("sources: vectors are carried from points, not from a curve")
    given = _vectors(vectors, points.count)
    if not refined:
        return frames.to_space(solver.vector_heat.transport(points, given))
    traced = trace(solver, points)
    at_sources = traced.sources.to_frames(given)
    _check_directions(np.abs(at_sources), given)
    reached = traced.labels >= 0
    turned = at_sources[traced.labels] * unit_vectors(traced.rotations)
    return frames.to_space(np.where(reached, turned, 0.0))


def _vectors(values: ArrayLike, count: int) -> FloatArray:
    table = np.atleast_2d(real_numbers(values, "vectors"))
    if table.shape != (count, 3):
        raise InvalidOptionError(
            f"vectors must have shape {(count, 3)}, one for each source, not {np.shape(values)}"
        )
    finite = np.isfinite(table).all(axis=1)
    if not finite.all():
        bad = int(finite.argmin())
        raise InvalidOptionError(f"vector {bad} is not finite: {table[bad].tolist()}")
    return table


def _check_directions(sizes: FloatArray, vectors: FloatArray) -> None:
    none = ~(sizes > FLAT * np.linalg.norm(vectors, axis=1))
    if none.any():
        bad = int(none.argmax())
        raise InvalidSourceError(
            f"vector {bad}, {vectors[bad].tolist()}, has no direction along the surface: it is "
            "zero, or at a right angle to it"
        )
