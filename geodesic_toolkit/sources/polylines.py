"""Curves of every kind as polylines in space, for pictures and files."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains import Domain
from geodesic_toolkit.errors import InvalidSourceError
from geodesic_toolkit.sources.kinds import Curve
from geodesic_toolkit.sources.locate import corners_of_curve

__all__ = ["polylines"]


def polylines(domain: Domain, curves: Any) -> list[FloatArray]:
    """Return curves as polylines, each of shape (P, 3).

    Parameters
    ----------
    domain : Domain
        The domain of the curves.
    curves : Curve, GeodesicPath, CloudPath, or sequence of them

    Returns
    -------
    list of ndarray
        Closed polylines repeat the first point at the end.

    Raises
    ------
    InvalidSourceError
        An object that is not a curve; points in faces that do not exist in the domain.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit.sources.polylines import polylines
    >>> square = gt.testing.shapes.grid(3)
    >>> line, = polylines(square, gt.Curve([[0, 0, 0], [1, 0, 0], [1, 1, 0]], closed=True))
    >>> len(line)
    4
    """
    several = curves if isinstance(curves, Sequence) else [curves]
    return [_polyline(domain, curve, index) for index, curve in enumerate(several)]


def _polyline(domain: Domain, curve: Any, index: int) -> FloatArray:
    if isinstance(curve, Curve):
        points: Any = corners_of_curve(domain, curve, f"curve {index}")
    else:
        points = getattr(curve, "points", None)
    if not isinstance(points, np.ndarray) or points.ndim != 2 or points.shape[1] != 3:
        raise InvalidSourceError(f"curve {index} is {a_kind_of(curve)}; give a Curve or a path")
    closed = bool(getattr(curve, "closed", False))
    return np.concatenate([points, points[:1]]) if closed else points
