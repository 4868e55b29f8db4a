"""Sources of every kind, as convex combinations of vertices."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from geodesic_toolkit._typing import FloatArray, IntArray
from geodesic_toolkit.domains import Domain, PointCloud, SurfacePoint, TriangleMesh
from geodesic_toolkit.errors import InvalidSourceError
from geodesic_toolkit.geometry.closest import closest_on_triangles, closest_points
from geodesic_toolkit.source_points import SourcePoints, as_vertices

__all__ = ["locate_sources"]


def locate_sources(domain: Domain, sources: Any, name: str = "sources") -> SourcePoints:
    """Return one set of sources on `domain`.

    Parameters
    ----------
    domain : Domain
    sources : int, array-like of int, array-like of float, SurfacePoint or sequence of them
        Vertex indices; points in space, of shape (3,) or (P, 3), snapped to the nearest point of
        the surface (or of the cloud); or points inside faces.
    name : str
        What to call them in messages.

    Returns
    -------
    SourcePoints

    Raises
    ------
    InvalidSourceError
        None at all, an index out of range, a missing point of a cloud, coordinates that are not
        finite, or something that names no place.
    """
    surface_points = _as_surface_points(sources)
    if surface_points is not None:
        return _on_faces(domain, surface_points, name)
    try:
        array = np.asarray(sources)
    except (ValueError, TypeError) as error:
        raise InvalidSourceError(f"{name} cannot be read: {error}") from error
    if array.dtype.kind == "f" and array.size:
        return _in_space(domain, array, name)
    vertices = as_vertices(sources, domain.n_vertices, name)
    if isinstance(domain, PointCloud) and not domain.present[vertices].all():
        missing = int(vertices[~domain.present[vertices]][0])
        raise InvalidSourceError(f"{name}: point {missing} of the cloud is missing (not finite)")
    return SourcePoints.at_vertices(vertices, domain.n_vertices)


def _as_surface_points(sources: Any) -> Sequence[SurfacePoint] | None:
    if isinstance(sources, SurfacePoint):
        return [sources]
    if isinstance(sources, Sequence) and any(isinstance(item, SurfacePoint) for item in sources):
        return sources
    return None


def _on_faces(domain: Domain, points: Sequence[Any], name: str) -> SourcePoints:
    if not isinstance(domain, TriangleMesh):
        raise InvalidSourceError(
            f"{name}: a SurfacePoint lies on a TriangleMesh, not on a {type(domain).__name__}"
        )
    for position, point in enumerate(points):
        if not isinstance(point, SurfacePoint):
            raise InvalidSourceError(f"{name}: {point!r} stands among SurfacePoints; use one kind")
        if not 0 <= point.face < domain.n_faces:
            raise InvalidSourceError(
                f"{name}: point {position} lies on face {point.face}; there are {domain.n_faces}"
            )
    faces = np.array([point.face for point in points], dtype=np.int64)
    return _barycentric(domain, faces, np.array([point.barycentric for point in points]))


def _in_space(domain: Domain, array: Any, name: str) -> SourcePoints:
    points = np.atleast_2d(array).astype(np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InvalidSourceError(
            f"{name}: floats are points in space, of shape (3,) or (P, 3), not {array.shape}; "
            "vertex indices must be integers"
        )
    if not np.isfinite(points).all():
        bad = int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])
        raise InvalidSourceError(f"{name}: point {bad} is not finite: {points[bad].tolist()}")
    if isinstance(domain, TriangleMesh):
        faces, barycentric = closest_on_triangles(points, domain.vertices, domain.faces)
        return _barycentric(domain, faces, barycentric)
    if isinstance(domain, PointCloud):
        present = np.flatnonzero(domain.present)
        nearest = present[closest_points(points, domain.points[present])]
        return SourcePoints.at_vertices(nearest, domain.n_vertices)
    raise InvalidSourceError(
        f"{name}: a {type(domain).__name__} has no positions; give vertex indices"
    )


def _barycentric(mesh: TriangleMesh, faces: IntArray, barycentric: FloatArray) -> SourcePoints:
    """Return points in faces; their corners lie at their straight distances."""
    corners = mesh.faces[faces]
    places = mesh.vertices[corners]
    at = np.einsum("pc,pcd->pd", barycentric, places)
    distances = np.linalg.norm(places - at[:, None], axis=2)
    used = barycentric > 0
    starts = np.concatenate([[0], np.cumsum(used.sum(axis=1))])
    shape = (len(faces), mesh.n_vertices)
    weights = csr_array((barycentric[used], corners[used], starts), shape=shape)
    return SourcePoints(weights, distances[used])
