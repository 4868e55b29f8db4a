"""Kinds of sources beyond places: curves, and places with offsets."""

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.checks import check_nothing_masked
from geodesic_toolkit.core.frozen import freeze
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.errors import InvalidSourceError
from geodesic_toolkit.sources.surface_point import SurfacePoint

__all__ = ["Curve", "OffsetSources", "check_one_kind"]

LONGEST_PLACE = 60
"""Number of characters of a place in a message."""

SURFACE_POINT, A_LIST = "a SurfacePoint", "a list"
"""Kinds of places."""


@final
@dataclass(frozen=True, eq=False)
class Curve:
    """A polyline on a surface, which is the source as a whole.

    Its segments are sampled densely and projected to the surface, each sample to the nearest place:
    give points that follow the surface. Refinement treats the curve as smooth at turns of less than
    half a radian, and fronts leave it with its curvature.

    Parameters
    ----------
    points : array-like of shape (P, 3), or sequence of SurfacePoint
        The corners of the polyline in order, two or more: in space, or on the faces of a mesh.
    closed : bool
        True if the last point is joined to the first.

    Raises
    ------
    InvalidSourceError
        Fewer than two points, another shape, a point that is not finite.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> square = gt.testing.shapes.grid(11)
    >>> side = gt.Curve([[0, 0, 0], [0, 1, 0]])
    >>> distance = gt.geodesic_distance(square, side, refine=True)
    >>> bool(abs(distance - square.vertices[:, 0]).max() < 0.02)
    True
    """

    points: Any
    closed: bool = False

    def __post_init__(self) -> None:
        points = self.points
        if isinstance(points, Sequence) and any(isinstance(p, SurfacePoint) for p in points):
            others = [p for p in points if not isinstance(p, SurfacePoint)]
            if others:
                raise InvalidSourceError(
                    f"curve: expected only SurfacePoints, but got {others[0]!r}; do not mix kinds"
                )
            count = len(points)
            object.__setattr__(self, "points", tuple(points))
        else:
            table = _floats(points, "curve")
            if table.ndim != 2 or table.shape[1] != 3:
                raise InvalidSourceError(
                    f"curve: points must have shape (P, 3), or be SurfacePoints, not {table.shape}"
                )
            _check_finite(table, "curve: point")
            count = len(table)
            object.__setattr__(self, "points", freeze(table))
        if count < 2:
            raise InvalidSourceError(f"curve: a curve needs two points or more, not {count}")


@final
@dataclass(frozen=True, eq=False, init=False)
class OffsetSources:
    """Sources with offsets: the distance is the minimum of offset plus length of path.

    A source whose offset exceeds its distance from other sources does not have an effect.

    Parameters
    ----------
    sources : int, array-like of int, array-like of float, SurfacePoint or sequence of them
        As :meth:`GeodesicSolver.distance` takes them.
    offsets : array-like of float
        One per source, in the unit of the domain, finite and not negative.

    Raises
    ------
    InvalidSourceError
        Offsets that are not numbers, not finite or negative. Their number is checked on use.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> path = gt.Graph(101, [[i, i + 1] for i in range(100)])
    >>> late = gt.OffsetSources([0, 100], [0.0, 50.0])
    >>> gt.geodesic_distance(path, late, operator=gt.UniformLaplacian(dim=1))[[0, 60, 100]].round()
    array([ 0., 60., 50.])
    """

    sources: Any
    offsets: FloatArray

    def __init__(self, sources: Any, offsets: ArrayLike) -> None:
        values = np.atleast_1d(_floats(offsets, "offsets"))
        if values.ndim != 1 or not len(values):
            raise InvalidSourceError(
                f"offsets must have shape (P,), one for each source, not {values.shape}"
            )
        _check_finite(values, "offset")
        if (values < 0).any():
            bad = int(values.argmin())
            raise InvalidSourceError(f"offset {bad} is {values[bad]}; it must not be negative")
        if isinstance(sources, Sequence) or hasattr(sources, "__array__"):
            sources = copy.deepcopy(sources)  # the user may change it later
        object.__setattr__(self, "sources", sources)
        object.__setattr__(self, "offsets", freeze(values))


def _floats(values: Any, name: str) -> FloatArray:
    check_nothing_masked(values, name, InvalidSourceError, "remove those rows")
    try:
        array = np.asarray(values)
    except (ValueError, TypeError) as error:
        raise InvalidSourceError(f"{name} cannot be read as an array: {error}") from error
    if array.dtype.kind not in "iuf":
        raise InvalidSourceError(f"{name} must hold real numbers, not dtype {array.dtype}")
    return np.array(array, dtype=np.float64)


def _check_finite(values: FloatArray, name: str) -> None:
    finite = np.isfinite(values).reshape(len(values), -1).all(axis=1)
    if not finite.all():
        bad = int(finite.argmin())
        raise InvalidSourceError(f"{name} {bad} is not finite: {values[bad].tolist()}")


def check_one_kind(sources: Any, name: str) -> None:
    """Raise an `InvalidSourceError` for a sequence of places of several kinds.

    Parameters
    ----------
    sources : object
        Anything but a sequence has one kind.
    name : str
        Name of the sources in messages.
    """
    if not isinstance(sources, list | tuple) and not (
        isinstance(sources, np.ndarray) and sources.ndim == 1
    ):
        return
    kinds = [_kind_of_place(place) for place in sources]
    other = next((position for position, kind in enumerate(kinds) if kind != kinds[0]), None)
    if other is None:
        return
    cure = "give places of one kind: for a vertex in a list of points, its position, vertices[i]"
    if SURFACE_POINT in kinds:
        cure += "; for a SurfacePoint, weights @ vertices[faces[face]]"
    if A_LIST in kinds:
        cure = "several sets are a list of lists, for distances; one set is a list of vertices"
    raise InvalidSourceError(
        f"{name} mix kinds of places: at position 0 {kinds[0]}, {_short(sources[0])}, and at "
        f"position {other} {kinds[other]}, {_short(sources[other])}; {cure}"
    )


def _kind_of_place(place: object) -> str:
    """Return the kind of one place of a sequence: a vertex, a point in space, a SurfacePoint."""
    if isinstance(place, int | np.integer):
        return "a vertex"
    if isinstance(place, SurfacePoint):
        return SURFACE_POINT
    if isinstance(place, list | tuple | np.ndarray):
        floats = len(place) == 3 and any(isinstance(x, float | np.floating) for x in place)
        return "a point in space" if floats else A_LIST
    return a_kind_of(place)


def _short(place: object) -> str:
    text = repr(place)
    return text if len(text) <= LONGEST_PLACE else f"{text[:LONGEST_PLACE]} ..."
