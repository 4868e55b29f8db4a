"""Sources of every kind, as convex combinations of vertices."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from geodesic_toolkit.core.checks import check_nothing_masked
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.core.warning import warn
from geodesic_toolkit.domains import Domain, Graph, PointCloud, TriangleMesh
from geodesic_toolkit.errors import FarSourceWarning, InvalidSourceError
from geodesic_toolkit.geometry.triangles import face_edge_lengths
from geodesic_toolkit.sources.ground import Ground
from geodesic_toolkit.sources.kinds import Curve, OffsetSources
from geodesic_toolkit.sources.points import LEFT, SourcePoints, as_vertices
from geodesic_toolkit.sources.surface_point import SurfacePoint

__all__ = ["locate_sources"]

SAMPLES = 4
"""Samples of a curve to a mean edge length."""

FEW = 8
"""Vertices of a shape from which on repeated sources, as many as there are vertices, are labels."""

LEAST = 0.25
"""Share of its length to which a front that leaves a curve may have shrunk at the next vertex: one
that the curve bends about more closely than edges are long."""

MOST_SAMPLES = 10_000_000
"""A curve of more is in another unit than the shape."""


def locate_sources(
    domain: Domain,
    sources: Any,
    name: str = "sources",
    *,
    passable: Domain | None = None,
    ground: Ground | None = None,
) -> SourcePoints:
    """Return one set of sources on `domain`.

    Parameters
    ----------
    domain : Domain
    sources : int, array-like, SurfacePoint, sequence of them, Curve or OffsetSources
        Vertex indices; points in space, of shape (3,) or (P, 3), snapped to the nearest point of
        the surface (or of the cloud); points inside faces; a polyline; or any of the first three
        with offsets.
    name : str
        What to call them in messages.
    passable : Domain, optional
        What is left of the domain where paths may go: points in space snap to that.
    ground : Ground, optional
        That of `passable`, or else of `domain`, where it is kept from call to call.

    Returns
    -------
    SourcePoints

    Raises
    ------
    InvalidSourceError
        None at all, an index out of range, a missing point of a cloud, coordinates that are not
        finite, or something that names no place.
    """
    if isinstance(sources, int | np.integer):  # what is asked most, and soonest answered
        return _at_vertices(domain, as_vertices(sources, domain.n_vertices, name), name)
    if isinstance(sources, OffsetSources):
        places = locate_sources(domain, sources.sources, name, passable=passable, ground=ground)
        if isinstance(sources.sources, Curve) or len(sources.offsets) != places.count:
            raise InvalidSourceError(
                f"{name}: {len(sources.offsets)} offsets must be one for each source"
            )
        return replace(places, starts=sources.offsets, copy=False)
    if isinstance(sources, Curve):
        return _along(domain, ground or _ground(passable or domain, name), sources, name)
    check_nothing_masked(sources, name, InvalidSourceError, LEFT)
    surface_points = _as_surface_points(sources)
    if surface_points is not None:
        return _on_faces(domain, surface_points, name)
    try:
        array = np.asarray(sources)
    except (ValueError, TypeError) as error:
        raise InvalidSourceError(f"{name} cannot be read: {error}") from error
    if array.dtype.kind == "f" and array.size:
        _check_one_meaning(array, domain, name)
        points = _as_points(array, name)
        return _in_space(ground or _ground(passable or domain, name), points, name)
    if array.dtype.kind == "b" and array.shape == (domain.n_vertices,):
        raise InvalidSourceError(f"{name} must be indices, not a mask: use numpy.flatnonzero(mask)")
    _check_no_labels(array, domain.n_vertices, name)
    return _at_vertices(domain, as_vertices(sources, domain.n_vertices, name), name)


def _at_vertices(domain: Domain, vertices: IntArray, name: str) -> SourcePoints:
    if isinstance(domain, PointCloud) and not domain.present[vertices].all():
        missing = int(vertices[~domain.present[vertices]][0])
        raise InvalidSourceError(f"{name}: point {missing} of the cloud is missing (not finite)")
    return SourcePoints.at_vertices(vertices, domain.n_vertices)


# -- points inside faces -------------------------------------------------------------------------


def _as_surface_points(sources: Any) -> Sequence[SurfacePoint] | None:
    if isinstance(sources, SurfacePoint):
        return [sources]
    if isinstance(sources, Sequence) and any(isinstance(item, SurfacePoint) for item in sources):
        return sources
    return None


def _on_faces(domain: Domain, points: Sequence[Any], name: str) -> SourcePoints:
    faces, barycentric = _faces_of(domain, points, name)
    assert isinstance(domain, TriangleMesh)  # for the type checker; _faces_of has raised
    return _barycentric(domain, faces, barycentric)


def _faces_of(domain: Domain, points: Sequence[Any], name: str) -> tuple[IntArray, FloatArray]:
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
    return faces, np.array([point.barycentric for point in points])


# -- points in space -----------------------------------------------------------------------------


def _as_points(array: Any, name: str) -> FloatArray:
    points = np.atleast_2d(array).astype(np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InvalidSourceError(
            f"{name}: floats are points in space, of shape (3,) or (P, 3), not {array.shape}; "
            "vertex indices must be integers"
        )
    if not np.isfinite(points).all():
        bad = int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])
        raise InvalidSourceError(f"{name}: point {bad} is not finite: {points[bad].tolist()}")
    return points


def _check_one_meaning(array: Any, domain: Domain, name: str) -> None:
    """Raise where three floats may be a point or, from an array of floats, three vertices.

    Three vertices would be different ones: the point (0, 0, 1) is nothing else.
    """
    if isinstance(domain, Graph):  # which has no points
        return
    whole = array.shape == (3,) and (array == np.floor(array)).all() and len(set(array)) == 3
    if whole and array.min() >= 0 and array.max() < domain.n_vertices:
        vertices = array.astype(np.int64).tolist()
        raise InvalidSourceError(
            f"{name}: {array.tolist()} may be three vertices or one point; give vertices as "
            f"integers, {vertices} (of an array: {name}.astype(int)), and the point as an array of "
            f"shape (1, 3), [{array.tolist()}]"
        )


def _check_no_labels(array: Any, n_vertices: int, name: str) -> None:
    """Raise where integers may be a label, or 0 and 1, for each vertex: sources do not repeat."""
    if array.dtype.kind not in "iu" or array.shape != (n_vertices,) or n_vertices < FEW:
        return
    values = np.unique(array)
    if 2 * len(values) <= n_vertices:
        raise InvalidSourceError(
            f"{name}: {n_vertices} integers, of which only {len(values)} differ, for as many "
            "vertices seem to be labels or a mask: give the vertices of one, "
            f"numpy.flatnonzero({name} == {values[-1]})"
        )


def _ground(domain: Domain, name: str) -> Ground:
    if not isinstance(domain, TriangleMesh | PointCloud):
        raise InvalidSourceError(
            f"{name}: a {type(domain).__name__} has no positions; give vertex indices"
        )
    return Ground(domain)


def _in_space(ground: Ground, points: FloatArray, name: str) -> SourcePoints:
    domain = ground.domain
    if isinstance(domain, TriangleMesh):
        faces, barycentric = ground.triangles.closest(points)
        feet = np.einsum("pc,pcd->pd", barycentric, domain.vertices[domain.faces[faces]])
        _warn_if_far(points, feet, domain.vertices[domain.used], name)
        return _barycentric(domain, faces, barycentric)
    nearest = ground.nearest_points(points)
    _warn_if_far(points, domain.points[nearest], domain.points[domain.present], name)
    return SourcePoints.at_vertices(nearest, domain.n_vertices)


def _warn_if_far(points: FloatArray, feet: FloatArray, places: FloatArray, name: str) -> None:
    """Warn of points that lie farther from the shape than its size."""
    size = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0)))
    with np.errstate(over="ignore"):  # far in any case
        moved = np.linalg.norm(points - feet, axis=1)
    worst = int(moved.argmax())
    if moved[worst] > size:
        warn(
            f"{name}: point {worst} was moved by {moved[worst]:.4g} to the nearest place of a "
            f"shape whose size is {size:.4g}; are the units the same?",
            FarSourceWarning,
        )


# -- curves --------------------------------------------------------------------------------------


def _along(domain: Domain, ground: Ground, curve: Curve, name: str) -> SourcePoints:
    """Return samples of a curve; the corners around one lie at their distance from the curve."""
    from geodesic_toolkit.sources.curves import sample_polyline

    if isinstance(curve.points, tuple):
        faces, barycentric = _faces_of(domain, curve.points, name)
        assert isinstance(domain, TriangleMesh)  # for the type checker; _faces_of has raised
        corners = np.einsum("pc,pcd->pd", barycentric, domain.vertices[domain.faces[faces]])
    else:
        corners = curve.points
    passable = ground.domain
    spacing = _spacing(passable)
    step = spacing / SAMPLES
    if curve.closed:
        corners = np.concatenate([corners, corners[:1]])
    corners = corners[np.append(True, (corners[1:] != corners[:-1]).any(axis=1))]
    length = np.linalg.norm(np.diff(corners, axis=0), axis=1).sum()
    if not length < MOST_SAMPLES * step:
        raise InvalidSourceError(
            f"{name}: the curve is {length / (SAMPLES * step):.3g} times as long as the mean edge; "
            "is it in the unit of the shape?"
        )
    points, places = sample_polyline(corners, step)
    if isinstance(passable, PointCloud):
        nearest = ground.nearest_points(points)
        vertices, place = np.unique(nearest, return_inverse=True)
        off = np.full(len(vertices), np.inf)
        np.minimum.at(off, place, np.linalg.norm(passable.points[nearest] - points, axis=1))
        at = SourcePoints.at_vertices(vertices, domain.n_vertices)
        return replace(at, distances=off, front_curvatures=np.zeros(len(vertices)), copy=False)
    faces, barycentric = ground.triangles.closest(points)
    if len(points) == 1:
        return _barycentric(passable, faces, barycentric)
    around = passable.vertices[passable.faces[faces]]
    laid = np.einsum("pc,pcd->pd", barycentric, around)
    fronts = _fronts_beside(
        around,
        laid,
        _normals_at(passable, faces, barycentric),
        corners=corners,
        places=places,
        spacing=spacing,
        closed=curve.closed,
    )
    return _barycentric(passable, faces, barycentric, *fronts)


def _normals_at(mesh: TriangleMesh, faces: IntArray, barycentric: FloatArray) -> FloatArray:
    """Return unit normals at points in faces, (P, 3), between those of the corners."""
    corners = mesh.faces[faces]
    near = np.zeros(mesh.n_vertices, dtype=np.bool_)
    near[corners] = True
    around = mesh.faces[near[mesh.faces].any(axis=1)]
    a, b, c = (mesh.vertices[around[:, corner]] for corner in range(3))
    areas = np.cross(b - a, c - a)
    sums = np.zeros((mesh.n_vertices, 3))
    for corner in range(3):
        np.add.at(sums, around[:, corner], areas)
    normals = np.einsum("pc,pcd->pd", barycentric, sums[corners])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(np.divide(normals, lengths, out=normals, where=lengths > 0))


def _fronts_beside(
    around: FloatArray,
    laid: FloatArray,
    normals: FloatArray,
    *,
    corners: FloatArray,
    places: IntArray,
    spacing: float,
    closed: bool,
) -> tuple[FloatArray, FloatArray]:
    """Return how far vertices around the samples of a curve are from it, and the front there.

    A front leaves with the geodesic curvature of the curve, to the one side as if it converged, and
    after a way s on a flat surface has ``κ / (1 + κ s)``. About ends and kinks it is a circle.

    Parameters
    ----------
    around : ndarray of shape (S, 3, 3)
        Three vertices for each sample.
    laid, normals : ndarray of shape (S, 3)
        Where the samples lie on the surface, and its normals there.
    corners : ndarray of shape (P, 3)
        Of the curve as it was given.
    places : ndarray of shape (P,), int64
        The samples at the corners.
    spacing : float
    closed : bool

    Returns
    -------
    distances, curvatures : ndarray of shape (S, 3)
    """
    from geodesic_toolkit.sources.curves import bends_of_polyline, distance_to_segments

    distances, beside, at_sample = distance_to_segments(around, laid)
    if closed:
        beside[[0, -1]] = True
    steps = np.diff(corners, axis=0)
    ends = np.append(0.0, np.cumsum(np.linalg.norm(steps, axis=1)))
    along = np.interp(np.arange(len(laid)), places, ends)
    bends, kinks = bends_of_polyline(corners, normals[places], along, spacing, closed)
    at_kink = np.zeros(len(laid), dtype=np.bool_)
    at_kink[places[kinks]] = True
    beside &= ~(at_sample & at_kink[:, None])
    left = np.cross(normals, np.gradient(laid, axis=0))
    side = np.sign(np.einsum("scd,sd->sc", around - laid[:, None], left))
    leaving = -side * bends[:, None]
    with np.errstate(divide="ignore"):
        curvatures = np.where(
            beside, leaving / np.maximum(1 + leaving * distances, LEAST), 1 / distances
        )
    return distances, curvatures


def _spacing(domain: TriangleMesh | PointCloud) -> float:
    """Return the mean edge length, or how far the points of a cloud are apart."""
    if isinstance(domain, TriangleMesh):
        return float(face_edge_lengths(domain.vertices, domain.faces).mean())
    from scipy.spatial import cKDTree

    points = np.unique(domain.points[domain.present], axis=0)
    if len(points) == 1:
        return 1.0
    some = points[:: max(1, len(points) // 1000)]
    near = np.asarray(cKDTree(points).query(some, k=2)[0], dtype=np.float64)
    return float(np.median(near[:, 1]))


def _barycentric(
    mesh: TriangleMesh,
    faces: IntArray,
    barycentric: FloatArray,
    distances: FloatArray | None = None,
    curvatures: FloatArray | None = None,
) -> SourcePoints:
    """Return points in faces; their corners lie at their straight distances unless told."""
    corners = mesh.faces[faces]
    if distances is None:
        places = mesh.vertices[corners]
        at = np.einsum("pc,pcd->pd", barycentric, places)
        distances = np.linalg.norm(places - at[:, None], axis=2)
    used = barycentric > 0
    return SourcePoints(
        vertices=corners[used],
        shares=barycentric[used],
        begins=np.concatenate([[0], np.cumsum(used.sum(axis=1))]),
        n_vertices=mesh.n_vertices,
        distances=distances[used],
        front_curvatures=None if curvatures is None else curvatures[used],
    )
