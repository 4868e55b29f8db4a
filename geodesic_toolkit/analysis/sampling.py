"""Samples of vertices spread over a shape, and the Voronoi cells of sites."""

from collections.abc import Iterable, Iterator
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.errors import InvalidOptionError, InvalidSourceError
from geodesic_toolkit.heat.method import Progress
from geodesic_toolkit.solver.solver import GeodesicSolver, check_solver

__all__ = ["farthest_point_sampling", "farthest_points", "geodesic_voronoi"]


@overload
def farthest_point_sampling(
    solver: GeodesicSolver,
    count: int,
    *,
    start: int | None = ...,
    rng: np.random.Generator | None = ...,
    return_radii: Literal[False] = ...,
    progress: Progress | None = ...,
) -> IntArray: ...
@overload
def farthest_point_sampling(
    solver: GeodesicSolver,
    count: int,
    *,
    start: int | None = ...,
    rng: np.random.Generator | None = ...,
    return_radii: Literal[True],
    progress: Progress | None = ...,
) -> tuple[IntArray, FloatArray]: ...


def farthest_point_sampling(
    solver: GeodesicSolver,
    count: int,
    *,
    start: int | None = None,
    rng: np.random.Generator | None = None,
    return_radii: bool = False,
    progress: Progress | None = None,
) -> IntArray | tuple[IntArray, FloatArray]:
    """Return vertices spread over a shape, each the farthest from all previous ones.

    Gonzalez's greedy choice covers the shape with balls whose radius is at most twice the optimum
    for as many balls.

    Parameters
    ----------
    solver : GeodesicSolver
    count : int
        Number of samples.
    start : int, optional
        The first sample. By default the vertex farthest from vertex 0 of the shape, which is an
        extremity.
    rng : numpy.random.Generator, optional
        Draws the first sample instead. It determines all others.
    return_radii : bool
        Whether to return the covering radii too.
    progress : callable, optional
        Called with the number of vertices chosen and `count` after each.

    Returns
    -------
    samples : ndarray of shape (count,), int64
        Distinct vertices, in the order of choice. A component without a sample is infinitely far,
        and gets the next one. Vertices that no element uses, masked ones and the missing points of
        a cloud are candidates only if there are no others.
    radii : ndarray of shape (count,), float64
        With `return_radii`. The largest distance, in the unit of the domain, of any candidate from
        the nearest of the samples up to that one: ``inf`` while a component has no sample, 0 if all
        candidates are taken. It never grows.

    Raises
    ------
    InvalidOptionError
        A count below 1 or above the number of candidates; or both `start` and `rng`.
    InvalidSourceError
        A start that cannot be a source.

    References
    ----------
    T. F. Gonzalez, *Clustering to minimize the maximum intercluster distance*, 1985,
    https://doi.org/10.1016/0304-3975(85)90224-5

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> solver = gt.GeodesicSolver(gt.testing.shapes.icosphere(3))
    >>> poles, radii = gt.farthest_point_sampling(solver, 2, start=0, return_radii=True)
    >>> poles
    array([0, 3])
    >>> radii.round(1)  # from one pole to the other is π, from both to the equator half of it
    array([3.1, 1.6])
    """
    check_solver(solver, "sampling")
    steps = farthest_points(solver, count, start=start, rng=rng)
    chosen, radii = np.empty(count, dtype=np.int64), np.empty(count)
    for position, (vertex, _, radius) in enumerate(steps):
        chosen[position], radii[position] = vertex, radius
        if progress is not None:
            progress(position + 1, count)
    return (chosen, radii) if return_radii else chosen


def farthest_points(
    solver: GeodesicSolver,
    count: int,
    *,
    start: int | None = None,
    rng: np.random.Generator | None = None,
) -> Iterator[tuple[int, FloatArray, float]]:
    """Return the samples of :func:`farthest_point_sampling` one by one, with their distances.

    Parameters and errors are those of that function.

    Returns
    -------
    iterator of (int, ndarray of shape (N,), float)
        A sample, the distances from it, and the covering radius up to it.
    """
    candidates = _candidates(solver)
    _check_count(count, len(candidates))
    return _spread(solver, count, candidates, _first(solver, candidates, start, rng))


def _spread(
    solver: GeodesicSolver, count: int, candidates: IntArray, first: int
) -> Iterator[tuple[int, FloatArray, float]]:
    nearest = np.full(solver.domain.n_vertices, -np.inf)  # never chosen: not a candidate, or taken
    nearest[candidates] = np.inf
    for position in range(count):
        vertex = first if position == 0 else int(nearest.argmax())
        distance = solver.distance(vertex)
        np.minimum(nearest, distance, out=nearest)
        nearest[vertex] = -np.inf
        yield vertex, distance, max(0.0, float(nearest.max()))


def _candidates(solver: GeodesicSolver) -> IntArray:
    """Return the vertices that may be chosen: those that elements use, or else all."""
    metric = solver.method.metric
    used = np.flatnonzero(np.bincount(metric.components)[metric.components] > 1)
    if len(used):
        return used
    return np.flatnonzero(solver.domain.present)


def _check_count(count: object, n_candidates: int) -> None:
    if isinstance(count, bool) or not isinstance(count, int | np.integer):
        raise InvalidOptionError(f"count must be an integer, not {count!r}")
    if not 1 <= count <= n_candidates:
        raise InvalidOptionError(
            f"count must be between 1 and the {n_candidates} vertices to choose from, not {count}"
        )


def _first(
    solver: GeodesicSolver,
    candidates: IntArray,
    start: int | None,
    rng: np.random.Generator | None,
) -> int:
    if start is not None and rng is not None:
        raise InvalidOptionError("give start or rng, not both")
    if rng is not None:
        return int(rng.choice(candidates))
    if start is not None:
        if isinstance(start, bool) or not isinstance(start, int | np.integer):
            raise InvalidSourceError(f"start must be one vertex index, not {start!r}")
        return int(start)  # the first distance raises if it is out of range
    distance = solver.distance(int(candidates[0]))
    return int(np.where(np.isfinite(distance), distance, -1.0).argmax())


@overload
def geodesic_voronoi(
    solver: GeodesicSolver,
    sites: ArrayLike | Iterable[Any],
    *,
    return_distances: Literal[False] = ...,
    progress: Progress | None = ...,
) -> IntArray: ...
@overload
def geodesic_voronoi(
    solver: GeodesicSolver,
    sites: ArrayLike | Iterable[Any],
    *,
    return_distances: Literal[True],
    progress: Progress | None = ...,
) -> tuple[IntArray, FloatArray]: ...


def geodesic_voronoi(
    solver: GeodesicSolver,
    sites: ArrayLike | Iterable[Any],
    *,
    return_distances: bool = False,
    progress: Progress | None = None,
) -> IntArray | tuple[IntArray, FloatArray]:
    """Return the index of the nearest site for each vertex: the Voronoi cells of the sites.

    For points other than vertices use :meth:`GeodesicSolver.nearest_source`.

    Parameters
    ----------
    solver : GeodesicSolver
    sites : array-like of int, or iterable of sources
        Each as for :meth:`GeodesicSolver.distance`: a one-dimensional array of integers means as
        many vertices; a site may also be a point in space, a curve, or a set of vertices.
    return_distances : bool
        Whether to return the distances from the sites too.
    progress : callable, optional
        Called with the number of sites done and their total after each block.

    Returns
    -------
    labels : ndarray of shape (N,), int64
        The position of the nearest site in the list, the first of those that are equally near; -1
        if no site is connected.
    distances : ndarray of shape (N,), float64
        With `return_distances`: from that site, in the unit of the domain; ``inf`` if there is
        none.

    Raises
    ------
    InvalidSourceError
        As for :meth:`GeodesicSolver.distances`, before any work.

    Examples
    --------
    >>> import numpy as np
    >>> import geodesic_toolkit as gt
    >>> strip = gt.testing.shapes.grid(9)  # the unit square
    >>> labels = gt.geodesic_voronoi(gt.GeodesicSolver(strip), [[0.0, 0.5, 0.0], [1.0, 0.5, 0.0]])
    >>> labels[np.isclose(strip.vertices[:, 0], 0.25)]
    array([0, 0, 0, 0, 0, 0, 0, 0, 0])
    """
    check_solver(solver, "a Voronoi diagram")
    located = solver.locate_sets(sites)
    labels = np.full(solver.domain.n_vertices, -1, dtype=np.int64)
    nearest = np.full(solver.domain.n_vertices, np.inf)
    first = 0
    for distances in solver.blocks(located):
        best = distances.argmin(axis=0)
        least = np.take_along_axis(distances, best[None], axis=0)[0]
        nearer = least < nearest
        labels[nearer] = first + best[nearer]
        nearest[nearer] = least[nearer]
        first += len(distances)
        if progress is not None:
            progress(first, len(located))
    return (labels, nearest) if return_distances else labels
