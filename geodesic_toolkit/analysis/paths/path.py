"""Paths on meshes as points in faces."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias
from weakref import WeakKeyDictionary

import numpy as np

from geodesic_toolkit.analysis.paths.candidates import Candidate
from geodesic_toolkit.analysis.paths.insertion import Insertion
from geodesic_toolkit.analysis.paths.metric.length import steps_over
from geodesic_toolkit.analysis.paths.polyline import SAME, Polyline, extent_of, without_repeats
from geodesic_toolkit.core.frozen import FrozenArrays
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains import TriangleMesh, positions_of
from geodesic_toolkit.domains.measured import MeasuredFaces
from geodesic_toolkit.sources.curves import polyline_length
from geodesic_toolkit.sources.kinds import Curve
from geodesic_toolkit.sources.surface_point import SurfacePoint, barycentric_rows

__all__ = ["GeodesicPath", "closed_path", "joined_pieces", "path_from_candidate"]

AnyMesh: TypeAlias = TriangleMesh | MeasuredFaces

_EXTENTS: WeakKeyDictionary[TriangleMesh, float] = WeakKeyDictionary()
"""Sizes of meshes."""


@dataclass(frozen=True, eq=False, repr=False, init=False)
class GeodesicPath(FrozenArrays, Polyline):
    """A polyline on a triangle mesh, from source to target, or closed.

    Between two of its points it runs straight through one face. On a mesh with costs or edge
    lengths its length is that of the distances, and straight is what is so in the metric of the
    face.

    Attributes
    ----------
    mesh : TriangleMesh, MetricMesh or IntrinsicMesh
    faces : ndarray of shape (P,), int64, read-only
        The face of each point.
    barycentric : ndarray of shape (P, 3), float64, read-only
        Barycentric coordinates of each point in its face.
    closed : bool
        Whether the last of them is joined to the first, which is not repeated.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> solver = gt.GeodesicSolver(gt.testing.shapes.grid(5))
    >>> path = gt.geodesic_path(solver, 0, 23)
    >>> path
    GeodesicPath(10 points, length 1.25)
    >>> solver.distance(path.curve).shape
    (25,)
    """

    mesh: AnyMesh
    faces: IntArray
    barycentric: FloatArray
    closed: bool

    def __init__(
        self, mesh: AnyMesh, surface_points: Sequence[SurfacePoint], closed: bool = False
    ) -> None:
        points = tuple(surface_points)
        self._set(
            mesh=mesh,
            faces=np.array([point.face for point in points], dtype=np.int64),
            barycentric=np.array([point.barycentric for point in points]).reshape(-1, 3),
            closed=closed,
        )

    @classmethod
    def from_rows(
        cls, mesh: AnyMesh, faces: IntArray, weights: FloatArray, *, closed: bool = False
    ) -> "GeodesicPath":
        """Return the path of P points as rows.

        Parameters
        ----------
        mesh : TriangleMesh or MeasuredFaces
        faces : ndarray of shape (P,), int64
        weights : ndarray of shape (P, 3), float64
            Barycentric coordinates as :func:`barycentric_rows` returns them.
        closed : bool

        Returns
        -------
        GeodesicPath
        """
        path = object.__new__(cls)
        path._set(mesh=mesh, faces=faces, barycentric=weights, closed=closed)
        return path

    @cached_property
    def surface_points(self) -> tuple[SurfacePoint, ...]:
        """The P points; :meth:`GeodesicSolver.distance` takes them as sources."""
        return SurfacePoint.from_rows(self.faces, self.barycentric)

    @cached_property
    def points(self) -> FloatArray:
        """The (P, 3) positions of the points.

        Raises
        ------
        UnsupportedDomainError
            The mesh has no positions: it is an IntrinsicMesh.
        """
        corners = positions_of(self.mesh)[self.mesh.faces[self.faces]]
        positions: FloatArray = np.einsum("pc,pcd->pd", self.barycentric, corners)
        return positions

    @property
    def curve(self) -> Curve:
        """The path as a curve, two points or more: a source, and what pictures draw."""
        return Curve(self.surface_points, closed=self.closed)

    @property
    def length(self) -> float:
        """Length of the polyline, in the unit of the distances: with costs the travel time."""
        if isinstance(self.mesh, MeasuredFaces):
            return float(self.segment_lengths.sum())
        return self.length_in_space

    @property
    def length_in_space(self) -> float:
        """Length of the polyline between its positions, without costs.

        Raises
        ------
        UnsupportedDomainError
            The mesh has no positions: it is an IntrinsicMesh.
        """
        return polyline_length(self.points, closed=self.closed)

    @cached_property
    def segment_lengths(self) -> FloatArray:
        """Lengths between each point and the next, (P - 1,), in the unit of the distances.

        Of shape (P,) if the path is closed.
        """
        if isinstance(self.mesh, MeasuredFaces):
            return steps_over(self.mesh, self.faces, self.barycentric, closed=self.closed)
        points = np.vstack([self.points, self.points[:1]]) if self.closed else self.points
        return np.asarray(np.linalg.norm(np.diff(points, axis=0), axis=1))

    def __repr__(self) -> str:
        closed = "closed, " if self.closed else ""
        return f"GeodesicPath({closed}{len(self.faces)} points, length {self.length:.6g})"


def path_from_candidate(
    mesh: AnyMesh, original: IntArray, split: Insertion, way: Candidate
) -> GeodesicPath:
    """Return the path of a candidate over parts of faces.

    Parameters
    ----------
    mesh : TriangleMesh or MeasuredFaces
    original : ndarray of int64
        The faces of the mesh that were split.
    split : Insertion
    way : Candidate
        Over the faces of `split`.

    Returns
    -------
    GeodesicPath
        Open.
    """
    faces = original[split.parents[way.faces]]
    weights = _on_corners(mesh.faces[faces], split, way)
    return _tidied(mesh, faces, barycentric_rows(weights))


def joined_pieces(mesh: AnyMesh, pieces: Sequence[GeodesicPath], *, closed: bool) -> GeodesicPath:
    """Return paths of which each begins where the one before it ends as one path."""
    faces = np.concatenate([piece.faces for piece in pieces])
    whole = _tidied(mesh, faces, np.concatenate([piece.barycentric for piece in pieces]))
    return closed_path(whole) if closed else whole


def closed_path(path: GeodesicPath) -> GeodesicPath:
    """Return a path whose ends are one place as a closed one."""
    order = np.arange(len(path.faces) - 1)
    if isinstance(path.mesh, MeasuredFaces):
        order[0] = -1  # in the face of the last segment
    faces, weights = path.faces[order], path.barycentric[order]
    return GeodesicPath.from_rows(path.mesh, faces, weights, closed=True)


def _on_corners(corners: IntArray, split: Insertion, way: Candidate) -> FloatArray:
    """Return the weights of the points of a way on the corners of their old faces, both (P, 3)."""
    n_old = len(split.vertices) - len(split.added)
    weights = np.zeros(corners.shape)
    for ends, shares in zip(way.ends.T, way.weights.T, strict=True):
        own = (corners == ends[:, None]).astype(np.float64)
        if split.added:
            for row in np.flatnonzero(ends >= n_old):
                own[row] = split.weights_on(corners[row], int(ends[row]))
        weights += shares[:, None] * own
    return weights


def _tidied(mesh: AnyMesh, faces: IntArray, weights: FloatArray) -> GeodesicPath:
    """Return the path of rows without points that are where the one before them is."""
    path = GeodesicPath.from_rows(mesh, faces, weights)
    kept = _distinct(path)
    if len(kept) == len(faces):
        return path
    return GeodesicPath.from_rows(mesh, faces[kept], weights[kept])


def _distinct(path: GeodesicPath) -> list[int]:
    """Return the indices of points that are not where the previous one is."""
    if not isinstance(path.mesh, MeasuredFaces):
        return without_repeats(path.points, _extent(path.mesh))
    # The first of equal points stays: segments are in the face of the point where they end.
    long = path.segment_lengths > SAME * path.mesh.lengths.max()
    return [0, *(np.flatnonzero(long) + 1).tolist()]


def _extent(mesh: TriangleMesh) -> float:
    extent = _EXTENTS.get(mesh)
    if extent is None:
        extent = _EXTENTS[mesh] = extent_of(mesh.vertices[mesh.used])
    return extent
