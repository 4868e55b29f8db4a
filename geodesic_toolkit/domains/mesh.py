"""Triangle meshes."""

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit._frozen import freeze
from geodesic_toolkit._typing import FloatArray, IntArray
from geodesic_toolkit.domains.base import (
    Domain,
    as_floats,
    as_indices,
    check_corners,
    check_indices,
    first_bad_row,
)
from geodesic_toolkit.errors import InvalidDomainError

__all__ = ["TriangleMesh"]


@final
@dataclass(frozen=True, eq=False, repr=False, init=False)
class TriangleMesh(Domain):
    """A triangle mesh in space.

    Degenerate faces, unreferenced and duplicate vertices, non-manifold edges and several
    components are not errors: scans and models have them.

    Parameters
    ----------
    vertices : array-like of shape (N, 3)
        Positions, in any unit; distances come out in the same one. Any real dtype and memory
        order; copied to float64.
    faces : array-like of shape (F, 3)
        Three vertex indices a face, counted from 0; floats must be whole numbers. Copied to int64.

    Attributes
    ----------
    vertices : ndarray of shape (N, 3), float64, read-only
    faces : ndarray of shape (F, 3), int64, read-only

    Raises
    ------
    InvalidDomainError
        Wrong shape or dtype, no vertices or no faces, a vertex that is not finite, a face that
        refers to a vertex that is not there. The message names the first offender.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    TriangleMesh(3 vertices, 1 face)
    """

    vertices: FloatArray
    faces: IntArray

    def __init__(self, vertices: ArrayLike, faces: ArrayLike) -> None:
        points = as_floats(vertices, "vertices", (None, 3))
        if len(points) == 0:
            raise InvalidDomainError("the mesh has no vertices")
        bad = first_bad_row(np.isfinite(points))
        if bad is not None:
            raise InvalidDomainError(
                f"vertex {bad} is not finite: {points[bad].tolist()}; remove it with its faces, "
                "or use a PointCloud, which keeps such points as missing"
            )
        check_corners(faces)
        triangles = as_indices(faces, "faces", "face", (None, 3))
        if len(triangles) == 0:
            raise InvalidDomainError("the mesh has no faces; for points alone use PointCloud")
        check_indices(triangles, len(points), "face")
        object.__setattr__(self, "vertices", freeze(points))
        object.__setattr__(self, "faces", freeze(triangles))

    @property
    def n_vertices(self) -> int:
        """Number of vertices, the unreferenced ones among them."""
        return len(self.vertices)

    @property
    def n_faces(self) -> int:
        """Number of faces, the degenerate ones among them."""
        return len(self.faces)

    def __repr__(self) -> str:
        plural = "" if self.n_faces == 1 else "s"
        return f"TriangleMesh({self.n_vertices} vertices, {self.n_faces} face{plural})"
