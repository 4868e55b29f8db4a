"""A point inside a face."""

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.errors import InvalidSourceError

__all__ = ["SurfacePoint", "barycentric_rows"]

LOWEST_WEIGHT = 1e-9
"""Lowest barycentric coordinate that is a 0 with rounding, as a negative number of this size."""

MOST_OFF_SUM = 1e-6
"""Difference of the sum of three coordinates from 1 that is rounding."""


@final
@dataclass(frozen=True)
class SurfacePoint:
    """A point of a triangle mesh, given by its face.

    Parameters
    ----------
    face : int
        Index of the face.
    barycentric : tuple of three floats
        Barycentric coordinates in that face: non-negative, with sum 1.

    Raises
    ------
    InvalidSourceError
        A face that is not an index, or coordinates that are not barycentric.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.SurfacePoint(4, (0.5, 0.5, 0.0))
    SurfacePoint(face=4, barycentric=(0.5, 0.5, 0.0))
    """

    face: int
    barycentric: tuple[float, float, float]

    @classmethod
    def from_rows(cls, faces: IntArray, weights: FloatArray) -> tuple["SurfacePoint", ...]:
        """Return P points at once, without a check of each.

        Parameters
        ----------
        faces : ndarray of shape (P,), int64
        weights : ndarray of shape (P, 3), float64
            Barycentric coordinates as :func:`barycentric_rows` returns them.
        """
        points = []
        for face, row in zip(faces.tolist(), weights.tolist(), strict=True):
            point = object.__new__(cls)  # its checks, one by one, take longer than the path
            vars(point).update(face=face, barycentric=tuple(row))
            points.append(point)
        return tuple(points)

    def __post_init__(self) -> None:
        if isinstance(self.face, bool) or not isinstance(self.face, int | np.integer):
            raise InvalidSourceError(f"face must be an integer index, not {self.face!r}")
        try:
            weights = np.array(self.barycentric, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InvalidSourceError(
                f"barycentric coordinates must be three numbers, not {self.barycentric!r}"
            ) from error
        if (
            weights.shape != (3,)
            or not (weights >= -LOWEST_WEIGHT).all()
            or not abs(weights.sum() - 1) <= MOST_OFF_SUM
        ):
            raise _not_barycentric(self.barycentric)
        weights = np.maximum(weights, 0.0)
        a, b, c = (weights / weights.sum()).tolist()
        object.__setattr__(self, "face", int(self.face))
        object.__setattr__(self, "barycentric", (a, b, c))


def barycentric_rows(weights: FloatArray) -> FloatArray:
    """Return weights (P, 3) in faces as barycentric coordinates, as :class:`SurfacePoint` does.

    Raises
    ------
    InvalidSourceError
        A row that is not barycentric.
    """
    a, b, c = weights.T
    fits = (weights >= -LOWEST_WEIGHT).all(axis=1)
    fits &= np.abs(a + b + c - 1) <= MOST_OFF_SUM
    if not fits.all():
        raise _not_barycentric(tuple(weights[np.argmin(fits)].tolist()))
    weights = np.maximum(weights, 0.0)
    a, b, c = weights.T
    return np.asarray(weights / (a + b + c)[:, None])


def _not_barycentric(given: Any) -> InvalidSourceError:
    return InvalidSourceError(
        f"barycentric coordinates must be three non-negative numbers with sum 1, not {given!r}"
    )
