"""Triangles that have lengths of their own: a surface by edge lengths, a mesh with a cost."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, final

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.checks import is_one_of
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains.base import (
    Domain,
    as_floats,
    as_indices,
    check_corners,
    check_indices,
    first_bad_row,
)
from geodesic_toolkit.domains.costs import lengths_with_cost, lengths_with_tensor
from geodesic_toolkit.domains.graph import Graph
from geodesic_toolkit.domains.mesh import TriangleMesh
from geodesic_toolkit.errors import InvalidDomainError, InvalidOptionError, InvalidSourceError

__all__ = ["IntrinsicMesh", "MeasuredFaces", "MetricMesh"]

MAX_DISAGREEMENT_OF_LENGTHS = 1e-6
"""Relative difference up to which the lengths of an edge in two faces are rounding: single
precision has 6e-8."""

MAX_ROUNDING_OF_TRIANGLES = 1e-6
"""Excess of the longest edge over the sum of the others, relative to it, that is rounding."""


class MeasuredFaces(Domain):
    """Triangles with lengths of their own, which need not be those of positions in space.

    Attributes
    ----------
    faces : ndarray of shape (F, 3), int64, read-only
    lengths : ndarray of shape (F, 3), float64, read-only
        Edge lengths in the unit of the distances; column i is the edge opposite corner i. Two faces
        may disagree about the edge between them: a path along it has the shorter one.
    """

    faces: IntArray
    lengths: FloatArray

    @property
    def triangles(self) -> IntArray:
        """The faces."""
        return self.faces

    @property
    def measured_in_space(self) -> bool:
        """False: lengths are given."""
        return False

    @property
    def n_faces(self) -> int:
        """Number of faces."""
        return len(self.faces)

    @property
    def used(self) -> BoolArray:
        """A mask, (N,), of the vertices that belong to faces; others have a distance of ``inf``."""
        used = np.zeros(self.n_vertices, dtype=np.bool_)
        used[self.faces] = True
        return used

    @property
    def edges_agree(self) -> bool:
        """True if no two faces disagree about the length of an edge."""
        _, shortest, longest = self._edges
        return bool((longest - shortest <= MAX_DISAGREEMENT_OF_LENGTHS * longest).all())

    def as_graph(self) -> Graph:
        """Return the distinct edges of positive length, with the shorter of their lengths.

        Returns
        -------
        Graph
        """
        edges, shortest, _ = self._edges
        some = shortest > 0
        return Graph(self.n_vertices, edges[some], shortest[some])

    @cached_property
    def _edges(self) -> tuple[IntArray, FloatArray, FloatArray]:
        return distinct_edges(self.faces, self.lengths)

    def spans(self, vertices: IntArray, weights: FloatArray) -> FloatArray:
        """Return the straight distances of places in faces from the corners, (P, 3).

        Parameters
        ----------
        vertices : ndarray of shape (P, 3), int64
            The corners of the face of each place.
        weights : ndarray of shape (P, 3), float64

        Returns
        -------
        ndarray of shape (P, 3), float64

        Raises
        ------
        InvalidSourceError
            A place that is in no face.
        """
        squares = self._opposite(vertices) ** 2
        a, b, c = squares.T
        u, v, w = weights.T
        shared = v * w * a + w * u * b + u * v * c
        to_corners = np.column_stack([v * c + w * b, u * c + w * a, u * b + v * a])
        return np.asarray(np.sqrt(np.maximum(to_corners - shared[:, None], 0.0)))

    def _opposite(self, vertices: IntArray) -> FloatArray:
        """Return the edge lengths opposite the given corners of faces, (P, 3)."""
        near = np.zeros(self.n_vertices, dtype=np.bool_)
        near[vertices] = True
        rows = np.flatnonzero(near[self.faces].all(axis=1))[::-1]  # of equal faces the first counts
        numbers = dict(zip(map(tuple, np.sort(self.faces[rows], axis=1)), rows, strict=True))
        found = [numbers.get(tuple(place), -1) for place in np.sort(vertices, axis=1)]
        if vertices.shape[1] != 3 or -1 in found:
            bad = found.index(-1) if -1 in found else 0
            raise InvalidSourceError(
                f"place {bad} has the vertices {vertices[bad].tolist()}, which are not the corners "
                f"of a face; on {a_kind_of(self)} give a SurfacePoint, or vertex indices"
            )
        own = self.faces[found]
        column = (own[:, None, :] == vertices[:, :, None]).argmax(axis=2)
        return np.asarray(np.take_along_axis(self.lengths[found], column, axis=1))

    def __getstate__(self) -> dict[str, Any]:
        """Return the state without derived attributes."""
        return {name: value for name, value in self.__dict__.items() if name != "_edges"}

    def __repr__(self) -> str:
        plural = "" if self.n_faces == 1 else "s"
        return f"{type(self).__name__}({self.n_vertices} vertices, {self.n_faces} face{plural})"


@final
@dataclass(frozen=True, eq=False, repr=False, init=False)
class IntrinsicMesh(MeasuredFaces):
    """A surface that is given by its triangles and their edge lengths, without positions.

    Distances, masks, matrices and sources inside faces need no positions; pictures, points in
    space and curves do, and raise an `UnsupportedDomainError` or `InvalidSourceError`.

    Parameters
    ----------
    faces : array-like of shape (F, 3)
        Three vertex indices per face, counted from 0.
    lengths : array-like of shape (F, 3)
        Lengths of the edges of each face, column i opposite corner i: positive, and the same in all
        faces of an edge up to one part in a million, of which the mean is taken.
    n_vertices : int, optional
        Number of vertices, if the last ones have no faces.

    Raises
    ------
    InvalidDomainError
        Wrong shapes, no faces, a length that is not positive and finite, three lengths that do not
        make a triangle, two faces that disagree about an edge. The message names the first.

    Examples
    --------
    A square of side 1 with its diagonal:

    >>> import geodesic_toolkit as gt
    >>> faces = [[0, 1, 2], [0, 2, 3]]
    >>> square = gt.IntrinsicMesh(faces, [[1, 2**0.5, 1], [1, 1, 2**0.5]])
    >>> gt.geodesic_distance(square, 0).round(3)
    array([0.   , 1.   , 1.414, 1.   ])
    """

    faces: IntArray
    lengths: FloatArray
    _n_vertices: int

    def __init__(self, faces: ArrayLike, lengths: ArrayLike, n_vertices: int | None = None) -> None:
        check_corners(faces)
        triangles = as_indices(faces, "faces", "face", (None, 3))
        if len(triangles) == 0:
            raise InvalidDomainError("the surface has no faces")
        count = int(triangles.max()) + 1 if n_vertices is None else n_vertices
        if isinstance(count, bool) or not isinstance(count, int | np.integer):
            raise InvalidDomainError(f"n_vertices must be an integer, not {n_vertices!r}")
        check_indices(triangles, int(count), "face")
        sides = as_floats(lengths, "lengths", (len(triangles), 3))
        _check_lengths(sides)
        self._set(
            faces=triangles, lengths=_with_one_length(triangles, sides), _n_vertices=int(count)
        )

    @property
    def n_vertices(self) -> int:
        """Number of vertices."""
        return self._n_vertices

    def without(self, mask: BoolArray) -> IntrinsicMesh:
        """Return the surface without the faces that have a masked vertex.

        Parameters
        ----------
        mask : ndarray of shape (N,), bool

        Returns
        -------
        IntrinsicMesh

        Raises
        ------
        InvalidOptionError
            All faces have a masked vertex.
        """
        left = _unmasked(self.faces, mask)
        return IntrinsicMesh(self.faces[left], self.lengths[left], self.n_vertices)


@final
@dataclass(frozen=True, eq=False, repr=False, init=False)
class MetricMesh(MeasuredFaces):
    """A triangle mesh on which lengths are weighted: by a cost, or by a metric tensor.

    With a cost c, the slowness of a front, distances are travel times: ``|∇φ| = c``. With a metric
    tensor A a step v is ``sqrt(vᵀ A v)`` long, so that distance depends on the direction.

    Parameters
    ----------
    mesh : TriangleMesh
    cost : array-like of shape (F,) or (N,), or float, optional
        Positive cost per unit of length of each face, or at each vertex. One at vertices varies
        linearly between them, and is right for a cost that changes smoothly, second order in the
        edge length; one of faces is constant in each, and may jump from one to the next, where
        paths bend by Snell's law. A path along an edge has the lesser cost of its faces.
    tensor : array-like of shape (F, 2, 2), (F, 3, 3) or (N, 3, 3), optional
        Symmetric positive definite metric tensors instead: of faces in their frame, whose first
        axis is the edge from corner 0 to corner 1 and whose second one points to the side of corner
        2; or of faces or vertices in space, of which the part in the plane of a face counts.
    on : {"auto", "faces", "vertices"}
        The elements that `cost` or `tensor` belongs to; "auto" decides by its length.

    Attributes
    ----------
    vertices : ndarray of shape (N, 3), float64, read-only
        Positions, in their own unit.
    faces : ndarray of shape (F, 3), int64, read-only
    lengths : ndarray of shape (F, 3), float64, read-only
        Weighted edge lengths, in the unit of the distances.

    Raises
    ------
    InvalidDomainError
        An object that is not a mesh; a cost that is not positive and finite, or a tensor that is
        not symmetric and positive definite; the message names the first.
    InvalidOptionError
        Neither or both of `cost` and `tensor`; another value of `on`; a mesh of as many faces as
        vertices without a value of `on`.

    Notes
    -----
    A place that cannot be passed is not an infinite cost but a masked vertex. Exact distances, taut
    loops, tangent vectors and curves as sources measure a surface in space, and are errors here.

    References
    ----------
    J. A. Sethian, A. Vladimirsky, *Fast Methods for the Eikonal and Related Hamilton-Jacobi
    Equations on Unstructured Meshes*, PNAS 97, 2000, https://doi.org/10.1073/pnas.090060097

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> plane = gt.testing.shapes.grid(3)
    >>> gt.geodesic_distance(gt.MetricMesh(plane, cost=2.0), 0)[:3]
    array([0., 1., 2.])
    """

    vertices: FloatArray
    faces: IntArray
    lengths: FloatArray

    def __init__(
        self,
        mesh: TriangleMesh,
        *,
        cost: ArrayLike | None = None,
        tensor: ArrayLike | None = None,
        on: Literal["auto", "faces", "vertices"] = "auto",
    ) -> None:
        if not isinstance(mesh, TriangleMesh):
            raise InvalidDomainError(
                f"a cost is for a TriangleMesh, not {a_kind_of(mesh)}; convert it with "
                "as_domain, and give a Graph the cost of its edges as lengths"
            )
        if (cost is None) == (tensor is None):
            raise InvalidOptionError("give either a cost or a tensor")
        if not is_one_of(on, ("auto", "faces", "vertices")):
            raise InvalidOptionError(f'on must be "auto", "faces" or "vertices", not {on!r}')
        if cost is not None:
            lengths = lengths_with_cost(mesh, cost, on)
        else:
            assert tensor is not None  # for the type checker; one of them is given
            lengths = lengths_with_tensor(mesh, tensor, on)
        self._set(vertices=mesh.vertices, faces=mesh.faces, lengths=lengths)

    @property
    def n_vertices(self) -> int:
        """Number of vertices, including unreferenced ones."""
        return len(self.vertices)

    @property
    def positions(self) -> FloatArray:
        """The vertices, in their own unit, which is not that of the distances."""
        return self.vertices

    def without(self, mask: BoolArray) -> MetricMesh:
        """Return the mesh without the faces that have a masked vertex.

        Parameters
        ----------
        mask : ndarray of shape (N,), bool

        Returns
        -------
        MetricMesh

        Raises
        ------
        InvalidOptionError
            All faces have a masked vertex.
        """
        left = _unmasked(self.faces, mask)
        rest = object.__new__(MetricMesh)
        rest._set(vertices=self.vertices, faces=self.faces[left], lengths=self.lengths[left])
        return rest


def _unmasked(faces: IntArray, mask: BoolArray) -> BoolArray:
    left = ~mask[faces].any(axis=1)
    if not left.any():
        raise InvalidOptionError("the mask leaves no faces, and so no paths")
    return np.asarray(left)


def distinct_edges(faces: IntArray, lengths: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the edges (E, 2) of proper faces, and their shortest and longest lengths, (E,)."""
    edges, place, proper = _numbered_edges(faces)
    sides = lengths[proper].ravel()
    shortest, longest = np.full(len(edges), np.inf), np.zeros(len(edges))
    np.minimum.at(shortest, place, sides)
    np.maximum.at(longest, place, sides)
    return edges, shortest, longest


def _numbered_edges(faces: IntArray) -> tuple[IntArray, IntArray, BoolArray]:
    """Return the edges, the edge opposite each corner of proper faces, and a mask of these."""
    a, b, c = faces.T
    proper = (a != b) & (b != c) & (c != a)
    ends = np.sort(faces[proper][:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2), axis=1)
    edges, place = np.unique(ends, axis=0, return_inverse=True)
    return edges, place.ravel(), proper


def _check_lengths(lengths: FloatArray) -> None:
    bad = first_bad_row(np.isfinite(lengths) & (lengths > 0))
    if bad is not None:
        raise InvalidDomainError(
            f"face {bad} has the edge lengths {lengths[bad].tolist()}; they must be positive and "
            "finite"
        )
    longest = lengths.max(axis=1)
    excess = longest - (lengths.sum(axis=1) - longest)
    bad = first_bad_row(excess <= MAX_ROUNDING_OF_TRIANGLES * longest)
    if bad is not None:
        raise InvalidDomainError(
            f"the edge lengths {lengths[bad].tolist()} of face {bad} make no triangle: the longest "
            "exceeds the sum of the others. Column i must be the edge opposite corner i"
        )


def _with_one_length(faces: IntArray, lengths: FloatArray) -> FloatArray:
    """Return lengths that are the same in all faces of an edge: the means of nearly equal ones.

    Raises
    ------
    InvalidDomainError
        Two faces disagree.
    """
    edges, place, proper = _numbered_edges(faces)
    sides = lengths[proper].ravel()
    mean = np.bincount(place, sides) / np.bincount(place) if len(place) else sides
    off = np.abs(sides - mean[place]) > MAX_DISAGREEMENT_OF_LENGTHS * mean[place]
    if off.any():
        edge = int(place[off.argmax()])
        values = np.unique(sides[place == edge]).tolist()
        raise InvalidDomainError(
            f"faces disagree about the edge between vertices {edges[edge, 0]} and "
            f"{edges[edge, 1]}, which is {values[0]} and {values[-1]} long. Column i must be the "
            "edge opposite corner i; a mesh whose cost jumps is a MetricMesh"
        )
    result = lengths.copy()
    result[proper] = mean[place].reshape(-1, 3)
    return result
