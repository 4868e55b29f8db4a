"""Paths on meshes as points in faces."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from geodesic_toolkit.analysis.paths.candidates import Candidate
from geodesic_toolkit.analysis.paths.insertion import Insertion
from geodesic_toolkit.analysis.paths.polyline import Polyline, extent_of, without_repeats
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.sources.curves import polyline_length
from geodesic_toolkit.sources.kinds import Curve
from geodesic_toolkit.sources.surface_point import SurfacePoint

__all__ = ["GeodesicPath", "joined_pieces", "path_from_candidate"]

_EXTENTS: WeakKeyDictionary[TriangleMesh, float] = WeakKeyDictionary()
"""Sizes of meshes."""


@dataclass(frozen=True, eq=False, repr=False)
class GeodesicPath(Polyline):
    """A polyline on a triangle mesh, from source to target, or closed.

    Between two of its points it runs straight through one face.

    Attributes
    ----------
    mesh : TriangleMesh
    surface_points : tuple of SurfacePoint
        P points; :meth:`GeodesicSolver.distance` takes them as sources.
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

    mesh: TriangleMesh
    surface_points: tuple[SurfacePoint, ...]
    closed: bool = False

    @cached_property
    def points(self) -> FloatArray:
        """The (P, 3) positions of the points."""
        faces = [point.face for point in self.surface_points]
        weights = np.array([point.barycentric for point in self.surface_points])
        corners = self.mesh.vertices[self.mesh.faces[faces]]
        positions: FloatArray = np.einsum("pc,pcd->pd", weights, corners)
        return positions

    @property
    def curve(self) -> Curve:
        """The path as a curve, two points or more: a source, and what pictures draw."""
        return Curve(self.surface_points, closed=self.closed)

    @property
    def length(self) -> float:
        """Length of the polyline, in the unit of the mesh."""
        return polyline_length(self.points, closed=self.closed)

    def __repr__(self) -> str:
        closed = "closed, " if self.closed else ""
        return f"GeodesicPath({closed}{len(self.points)} points, length {self.length:.6g})"


def path_from_candidate(
    mesh: TriangleMesh, original: IntArray, split: Insertion, way: Candidate
) -> GeodesicPath:
    """Return the path of a candidate over parts of faces.

    Parameters
    ----------
    mesh : TriangleMesh
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
    return _tidied(mesh, SurfacePoint.from_rows(faces, weights))


def joined_pieces(
    mesh: TriangleMesh, pieces: Sequence[GeodesicPath], *, closed: bool
) -> GeodesicPath:
    """Return paths of which each begins where the one before it ends as one path."""
    whole = _tidied(mesh, tuple(point for piece in pieces for point in piece.surface_points))
    points = whole.surface_points
    return GeodesicPath(mesh, points[:-1] if closed else points, closed=closed)


def _on_corners(corners: IntArray, split: Insertion, way: Candidate) -> FloatArray:
    """Return the weights of the points of a way on the corners of their old faces, both (P, 3)."""
    n_old = len(split.vertices) - len(split.added)
    weights = np.zeros(corners.shape)
    for ends, shares in zip(way.ends.T, way.weights.T, strict=True):
        own = (corners == ends[:, None]).astype(np.float64)
        for row in np.flatnonzero(ends >= n_old):
            own[row] = split.weights_on(corners[row], int(ends[row]))
        weights += shares[:, None] * own
    return weights


def _tidied(mesh: TriangleMesh, points: tuple[SurfacePoint, ...]) -> GeodesicPath:
    """Return a path without points that are where the one before them is."""
    path = GeodesicPath(mesh, points)
    kept = without_repeats(path.points, _extent(mesh))
    if len(kept) == len(points):
        return path
    return GeodesicPath(mesh, tuple(points[index] for index in kept))


def _extent(mesh: TriangleMesh) -> float:
    extent = _EXTENTS.get(mesh)
    if extent is None:
        extent = _EXTENTS[mesh] = extent_of(mesh.vertices[mesh.used])
    return extent
