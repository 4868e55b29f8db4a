"""Triangle meshes."""

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.domains.base import (
    Domain,
    as_floats,
    as_indices,
    check_corners,
    check_indices,
    first_bad_row,
)
from geodesic_toolkit.domains.graph import Graph
from geodesic_toolkit.errors import InvalidDomainError, InvalidOptionError

__all__ = ["TriangleMesh"]


@final
@dataclass(frozen=True, eq=False, repr=False, init=False)
class TriangleMesh(Domain):
    """A triangle mesh in space.

    Degenerate and repeated faces, unreferenced and duplicate vertices, non-manifold edges and
    several components are not errors: scans and models have them. Faces with the same three
    vertices, such as front and back of a triangle, count once; if front and back have different
    vertices, they are two sheets, and :func:`merge_vertices` joins them.

    Parameters
    ----------
    vertices : array-like of shape (N, 3)
        Positions, in any unit; distances are in the same one. Any real dtype and memory order;
        copied to float64. Vertices without faces may be NaN or infinite, as pixels without depth
        are.
    faces : array-like of shape (F, 3)
        Three vertex indices per face, counted from 0; floats must be whole numbers. Copied to
        int64.

    Attributes
    ----------
    vertices : ndarray of shape (N, 3), float64, read-only
    faces : ndarray of shape (F, 3), int64, read-only

    Raises
    ------
    InvalidDomainError
        Wrong shape or dtype, no vertices or no faces, a face that refers to a vertex that does not
        exist or is not finite. The message names the first invalid entry.

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
        check_corners(faces)
        triangles = as_indices(faces, "faces", "face", (None, 3))
        if len(triangles) == 0:
            raise InvalidDomainError("the mesh has no faces; for points alone use PointCloud")
        check_indices(triangles, len(points), "face")
        finite = np.isfinite(points)
        if not finite.all():
            _check_finite(points, triangles, np.asarray(finite.all(axis=1)))
        self._set(vertices=points, faces=triangles)

    @property
    def n_vertices(self) -> int:
        """Number of vertices, including unreferenced ones."""
        return len(self.vertices)

    @property
    def used(self) -> BoolArray:
        """A mask, (N,), of the vertices that belong to faces; others have a distance of ``inf``."""
        used = np.zeros(self.n_vertices, dtype=np.bool_)
        used[self.faces] = True
        return used

    @property
    def positions(self) -> FloatArray:
        """The vertices."""
        return self.vertices

    @property
    def triangles(self) -> IntArray:
        """The faces."""
        return self.faces

    def as_graph(self) -> Graph:
        """Return the distinct edges of positive length of faces with three different vertices.

        Returns
        -------
        Graph
        """
        a, b, c = self.faces.T
        proper = self.faces[(a != b) & (b != c) & (c != a)]
        edges = np.unique(np.sort(proper[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0)
        lengths = np.linalg.norm(np.diff(self.vertices[edges], axis=1)[:, 0], axis=1)
        some = lengths > 0
        return Graph(self.n_vertices, edges[some], lengths[some])

    def without(self, mask: BoolArray) -> "TriangleMesh":
        """Return the mesh with the same vertices, without the faces that have a masked vertex.

        Parameters
        ----------
        mask : ndarray of shape (N,), bool

        Returns
        -------
        TriangleMesh

        Raises
        ------
        InvalidOptionError
            All faces have a masked vertex.

        Examples
        --------
        >>> import numpy as np
        >>> import geodesic_toolkit as gt
        >>> gt.testing.shapes.grid(3).without(np.arange(9) == 8)
        TriangleMesh(9 vertices, 6 faces)
        """
        faces = self.faces[~mask[self.faces].any(axis=1)]
        if not len(faces):
            raise InvalidOptionError("the mask leaves no faces, and so no paths")
        return TriangleMesh(self.vertices, faces)

    @property
    def n_faces(self) -> int:
        """Number of faces, including degenerate and repeated ones."""
        return len(self.faces)

    def __repr__(self) -> str:
        plural = "" if self.n_faces == 1 else "s"
        return f"TriangleMesh({self.n_vertices} vertices, {self.n_faces} face{plural})"


def _check_finite(points: FloatArray, faces: IntArray, finite: BoolArray) -> None:
    """Raise for the first face that refers to a vertex that is not finite."""
    face = first_bad_row(finite[faces])
    if face is None:
        return
    bad = int(faces[face][~finite[faces[face]]][0])
    raise InvalidDomainError(
        f"vertex {bad} is not finite: {points[bad].tolist()}; face {face} refers to it. Remove "
        "such faces: faces[numpy.isfinite(vertices[faces]).all(axis=(1, 2))]; or use a PointCloud, "
        "which keeps such points as missing"
    )
