"""Intersections of a level of a field with faces: points on edges, the same in both faces."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.checks import real_number, real_numbers
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.domains.measured import MeasuredFaces
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.geometry.triangles import proper_faces
from geodesic_toolkit.interop.conversion import as_domain

__all__ = [
    "Cuts",
    "areas_of",
    "as_faces",
    "as_field",
    "as_level",
    "as_mesh",
    "cut_triangles",
    "finite_faces",
]


HUGE = np.finfo(np.float64).max / 2
"""Magnitude of values above which a difference of two may be infinite."""


def as_mesh(domain: Any, what: str) -> TriangleMesh:
    """Return a mesh from an argument of :func:`as_domain`; the error names `what` needs one."""
    mesh = as_domain(domain)
    if not isinstance(mesh, TriangleMesh):
        raise UnsupportedDomainError(
            f"{what} need a triangle mesh, whose faces lie in space; this is {a_kind_of(mesh)}"
        )
    return mesh


def as_faces(domain: Any, what: str) -> TriangleMesh | MeasuredFaces:
    """Return a mesh, or faces with lengths of their own; the error names `what` needs them."""
    found = as_domain(domain)
    return found if isinstance(found, MeasuredFaces) else as_mesh(found, what)


def as_field(values: ArrayLike, n_vertices: int, name: str = "values") -> FloatArray:
    """Return values as an array of shape (N,), not finite at vertices without a value.

    Raises
    ------
    InvalidOptionError
        Not one real number for each vertex.
    """
    field = real_numbers(values, name)
    if field.shape != (n_vertices,):
        raise InvalidOptionError(
            f"{name} must hold one real number for each of the {n_vertices} vertices, and have the "
            f"shape ({n_vertices},), not {field.shape}"
        )
    return field


def as_level(level: Any) -> float:
    """Return a level as a finite number.

    Raises
    ------
    InvalidOptionError
        Something else.
    """
    number = real_number(level, "a level")
    if not np.isfinite(number):
        raise InvalidOptionError(f"a level must be finite, not {number}")
    return number


def finite_faces(mesh: TriangleMesh | MeasuredFaces, field: FloatArray) -> IntArray:
    """Return the faces (G,) of three vertices, each once, with a value at every corner."""
    return np.flatnonzero(proper_faces(mesh.faces) & np.isfinite(field)[mesh.faces].all(axis=1))


def areas_of(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Return the (G,) areas of triangles in space, 0 where corners coincide."""
    origin, first, second = (vertices[triangles[:, corner]] for corner in range(3))
    return np.asarray(np.linalg.norm(np.cross(first - origin, second - origin), axis=1) / 2)


@dataclass(frozen=True, eq=False)
class Cuts:
    """The C triangles that a level cuts, each from the corner that is alone on its side.

    A vertex whose value is the level lies above it.

    Attributes
    ----------
    triangles : ndarray of shape (C,), int64
        Indices of the given triangles.
    corners : ndarray of shape (C, 3), int64
        The corners of each in its order, beginning with the one that is alone on its side.
    above : ndarray of shape (C,), bool
        True if that corner lies above.
    shares : ndarray of shape (C, 2), float64
        Positions of the cuts on the edges from the first corner to the second and to the third, as
        shares of the edge from its lower index to its higher one.
    """

    triangles: IntArray
    corners: IntArray
    above: BoolArray
    shares: FloatArray

    @cached_property
    def edges(self) -> IntArray:
        """The cut edges, (C, 2, 2), the lower index of each first."""
        first = self.corners[:, [0, 0]]
        return np.sort(np.stack([first, self.corners[:, 1:]], axis=2), axis=2)

    @property
    def from_alone(self) -> FloatArray:
        """The same shares, (C, 2), counted from the corner that is alone."""
        backward = self.corners[:, [0]] > self.corners[:, 1:]
        return np.where(backward, 1 - self.shares, self.shares)


def cut_triangles(triangles: IntArray, field: FloatArray, level: float) -> Cuts:
    """Return the intersections of a level with triangles.

    Parameters
    ----------
    triangles : ndarray of shape (G, 3), int64
    field : ndarray of shape (N,), float64
        Finite at their corners.
    level : float

    Returns
    -------
    Cuts
    """
    above = field[triangles] >= level
    count = above.sum(axis=1)
    cut = np.flatnonzero((count > 0) & (count < 3))
    single = count[cut] == 1
    alone = np.where(single, above[cut].argmax(axis=1), above[cut].argmin(axis=1))
    order = (alone[:, None] + np.arange(3)) % 3
    corners = np.take_along_axis(triangles[cut], order, axis=1)
    ends = np.sort(np.stack([corners[:, [0, 0]], corners[:, 1:]], axis=2), axis=2)
    low, high = field[ends[..., 0]], field[ends[..., 1]]
    scale = 0.5 if np.abs(field[triangles]).max(initial=0.0) > HUGE else 1.0
    steps = scale * high - scale * low  # finite, and not 0
    shares = np.clip((scale * level - scale * low) / steps, 0.0, 1.0)
    return Cuts(cut, corners, np.asarray(single), shares)
