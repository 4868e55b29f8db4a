"""Point clouds."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.types import BoolArray, FloatArray
from geodesic_toolkit.domains.base import Domain, as_floats, first_bad_row
from geodesic_toolkit.errors import InvalidDomainError, InvalidOptionError

__all__ = ["PointCloud"]


@final
@dataclass(frozen=True, eq=False, repr=False, init=False)
class PointCloud(Domain):
    """Points sampled from a surface, with or without its normals.

    Points that are not finite (a depth camera's missing pixels) are kept, so that indices stay
    those of the file; their distance is always ``inf``.

    Parameters
    ----------
    points : array-like of shape (N, 3)
        Positions, in any unit; distances are in the same one. Copied to float64.
    normals : array-like of shape (N, 3), optional
        Surface normals, of any length except zero; used as they are given. Normals of missing
        points are ignored.

    Attributes
    ----------
    points : ndarray of shape (N, 3), float64, read-only
    normals : ndarray of shape (N, 3), float64, read-only, or None
        Unit normals.
    present : ndarray of shape (N,), bool, read-only
        True at finite points.

    Raises
    ------
    InvalidDomainError
        Wrong shape or dtype, no points, no finite points, a normal that is zero or not finite at a
        finite point.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.PointCloud([[0, 0, 0], [1, 0, 0], [float("nan"), 0, 0]])
    PointCloud(3 points, 1 missing)
    """

    vertex_name: ClassVar[str] = "point"

    points: FloatArray
    _normals: FloatArray | None
    _present: BoolArray

    def __init__(self, points: ArrayLike, normals: ArrayLike | None = None) -> None:
        positions = as_floats(points, "points", (None, 3))
        if len(positions) == 0:
            raise InvalidDomainError("the point cloud has no points")
        present: BoolArray = np.asarray(np.isfinite(positions).all(axis=1))
        if not present.any():
            raise InvalidDomainError("the point cloud has no finite points")
        units = None if normals is None else _unit_normals(normals, present)
        self._set(points=positions, _normals=units, _present=present)

    @property
    def positions(self) -> FloatArray:
        """The points."""
        return self.points

    @property
    def present(self) -> BoolArray:
        """True at finite points, of shape (N,)."""
        return self._present

    @property
    def normals(self) -> FloatArray | None:
        """Unit normals, of shape (N, 3), or None."""
        return self._normals

    def without(self, mask: BoolArray) -> "PointCloud":
        """Return the cloud with masked points missing.

        Parameters
        ----------
        mask : ndarray of shape (N,), bool

        Returns
        -------
        PointCloud

        Raises
        ------
        InvalidOptionError
            All points are masked or missing.
        """
        if not (self.present & ~mask).any():
            raise InvalidOptionError("the mask leaves no points, and so no paths")
        return PointCloud(np.where(mask[:, None], np.nan, self.points), self.normals)

    @property
    def n_vertices(self) -> int:
        """Number of points, including missing ones."""
        return len(self.points)

    def __repr__(self) -> str:
        missing = self.n_vertices - int(self.present.sum())
        parts = [f"{self.n_vertices} point{'' if self.n_vertices == 1 else 's'}"]
        if missing:
            parts.append(f"{missing} missing")
        if self.normals is not None:
            parts.append("with normals")
        return f"PointCloud({', '.join(parts)})"


def _unit_normals(normals: ArrayLike, present: BoolArray) -> FloatArray:
    vectors = as_floats(normals, "normals", (len(present), 3))
    largest = np.abs(vectors).max(axis=1)
    bad = first_bad_row(~present | (np.isfinite(largest) & (largest > 0)))
    if bad is not None:
        raise InvalidDomainError(
            f"normal {bad} is zero or not finite: {vectors[bad].tolist()}; "
            "omit the normals to have them estimated"
        )
    vectors[~present] = 0.0
    vectors /= np.where(largest > 0, largest, 1.0)[:, None]  # prevents overflow of the square
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0, length, 1.0))
