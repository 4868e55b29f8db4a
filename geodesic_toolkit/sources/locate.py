"""Sources of every kind, as convex combinations of vertices."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from geodesic_toolkit.core.checks import check_nothing_masked
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.core.warning import warn
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains import Domain, Located, check_present, positions_of, triangles_of
from geodesic_toolkit.errors import FarSourceWarning, InvalidSourceError
from geodesic_toolkit.geometry.triangles import face_edge_lengths
from geodesic_toolkit.geometry.welding import boundary_edges
from geodesic_toolkit.sources.ground import Ground, lies_in_triangles
from geodesic_toolkit.sources.kinds import Curve, OffsetSources
from geodesic_toolkit.sources.laid import CurveSamples, LaidCurve
from geodesic_toolkit.sources.points import ADVICE_ON_MASKED_SOURCES, SourcePoints, as_vertices
from geodesic_toolkit.sources.surface_point import SurfacePoint

__all__ = [
    "corners_of_curve",
    "locate_sources",
    "samples_of",
]

SAMPLES_PER_EDGE = 4
"""Number of samples of a curve per mean edge length."""

MIN_VERTICES_OF_LABELS = 8
"""Minimum number of vertices of a shape for which repeated sources, one per vertex, are labels."""

MOST_SAMPLES = 10_000_000
"""Maximum number of samples; a curve with more is in another unit than the shape."""


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
    sources : int, array-like, SurfacePoint, sequence of them, Located, Curve or OffsetSources
        Vertex indices; points in space, of shape (3,) or (P, 3), snapped to the nearest place of
        the surface, on a cloud of the triangles of its stars; points inside faces, or other
        elements; a polyline; or any of these except a polyline, with offsets.
    name : str
        Name of the sources in messages.
    passable : Domain, optional
        The unmasked part of the domain, to which points in space snap.
    ground : Ground, optional
        The ground of `passable`, or else of `domain`, if it is kept between calls.

    Returns
    -------
    SourcePoints

    Raises
    ------
    InvalidSourceError
        An empty set, an index out of range, a missing point of a cloud, coordinates that are not
        finite, or an object that is not a source.
    """
    if isinstance(sources, int | np.integer):  # the most frequent case first
        return _at_vertices(domain, as_vertices(sources, domain.n_vertices, name), name)
    if isinstance(sources, OffsetSources):
        places = locate_sources(domain, sources.sources, name, passable=passable, ground=ground)
        if isinstance(sources.sources, Curve) or len(sources.offsets) != places.count:
            raise InvalidSourceError(
                f"{name}: the {len(sources.offsets)} offsets must be one for each source"
            )
        return replace(places, starts=sources.offsets, copy=False)
    if isinstance(sources, Curve):
        return _along(domain, ground or _ground(passable or domain, name), sources, name)
    check_nothing_masked(sources, name, InvalidSourceError, ADVICE_ON_MASKED_SOURCES)
    located = _as_located(domain, sources, name)
    if located is not None:
        return _between(domain, located)
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
    check_present(domain, vertices, name)
    return SourcePoints.at_vertices(vertices, domain.n_vertices)


# -- points inside elements ----------------------------------------------------------------------


def _as_located(domain: Domain, sources: Any, name: str) -> Located | None:
    """Return places that are given by their vertices or by faces; None for other sources."""
    if isinstance(sources, Located):
        if not len(sources):
            raise InvalidSourceError(f"{name}: there are none; give at least one place")
        if domain.measured_in_space:
            _check_positions(domain, name)
        sources.check_on(domain, name)
        return sources
    if isinstance(sources, SurfacePoint):
        return _located(domain, [sources], name)
    if isinstance(sources, Sequence) and any(isinstance(item, SurfacePoint) for item in sources):
        return _located(domain, sources, name)
    return None


def _located(domain: Domain, points: Sequence[Any], name: str) -> Located:
    if not domain.has("triangles"):
        raise InvalidSourceError(
            f"{name}: a SurfacePoint needs a TriangleMesh, or another kind of domain that has "
            f"triangles, not {a_kind_of(domain)}"
        )
    triangles = triangles_of(domain)
    for position, point in enumerate(points):
        if not isinstance(point, SurfacePoint):
            raise InvalidSourceError(
                f"{name}: expected a SurfacePoint at position {position}, got {point!r}; do not "
                "mix kinds of source"
            )
        if not 0 <= point.face < len(triangles):
            raise InvalidSourceError(
                f"{name}: point {position} lies on face {point.face}; there are {len(triangles)}"
            )
    faces = np.array([point.face for point in points], dtype=np.int64)
    return Located(triangles[faces], np.array([point.barycentric for point in points]))


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
    """Raise if three floats may be a point or, from an array of floats, three vertices.

    Three vertices would be different: (0, 0, 1) can only be a point.
    """
    if not domain.has("positions"):  # a graph does not have points
        return
    whole = array.shape == (3,) and (array == np.floor(array)).all() and len(set(array)) == 3
    if whole and array.min() >= 0 and array.max() < domain.n_vertices:
        vertices = array.astype(np.int64).tolist()
        raise InvalidSourceError(
            f"{name}: {array.tolist()} may be three vertices or one point; give vertices as "
            f"integers, {vertices} (for an array: {name}.astype(int)), and the point as an array "
            f"of shape (1, 3), [{array.tolist()}]"
        )


def _check_no_labels(array: Any, n_vertices: int, name: str) -> None:
    """Raise if integers may be labels, or 0 and 1, of all vertices: sources do not repeat."""
    if (
        array.dtype.kind not in "iu"
        or array.shape != (n_vertices,)
        or n_vertices < MIN_VERTICES_OF_LABELS
    ):
        return
    values = np.unique(array)
    if 2 * len(values) <= n_vertices:
        raise InvalidSourceError(
            f"{name}: {n_vertices} integers, one per vertex, with only {len(values)} different "
            "values seem to be labels or a mask: give the vertices of one value, "
            f"numpy.flatnonzero({name} == {values[-1]})"
        )


def _check_positions(domain: Domain, name: str) -> None:
    if not domain.has("positions"):
        raise InvalidSourceError(
            f"{name}: {a_kind_of(domain)} has no positions; give vertex indices"
        )


def _ground(domain: Domain, name: str) -> Ground:
    _check_positions(domain, name)
    return Ground(domain)


def _in_space(ground: Ground, points: FloatArray, name: str) -> SourcePoints:
    domain = ground.domain
    places = ground.closest(points)
    _warn_if_far(points, places.positions(domain), _used_positions(domain), name)
    return _between(domain, places)


def _used_positions(domain: Domain) -> FloatArray:
    """Return the positions of the vertices of triangles, or without these the present ones."""
    if domain.has("triangles") and len(domain.triangles):
        used = np.zeros(domain.n_vertices, dtype=np.bool_)
        used[domain.triangles] = True
        return domain.positions[used]
    return domain.positions[domain.present]


def _warn_if_far(points: FloatArray, feet: FloatArray, places: FloatArray, name: str) -> None:
    """Warn of points whose distance from the shape exceeds its size."""
    size = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0)))
    with np.errstate(over="ignore"):  # infinity is far, too
        moved = np.linalg.norm(points - feet, axis=1)
    worst = int(moved.argmax())
    if moved[worst] > size:
        warn(
            f"{name}: point {worst} was moved by {moved[worst]:.4g} to the nearest place of a "
            f"shape whose size is {size:.4g}; are the units the same?",
            FarSourceWarning,
        )


# -- curves --------------------------------------------------------------------------------------


def samples_of(domain: Domain, passable: Domain, curve: Curve, name: str) -> CurveSamples:
    """Return samples of a curve, a quarter of a mean edge apart.

    Parameters
    ----------
    domain : Domain
        The domain whose faces may contain the points of the curve.
    passable : Domain
        The unmasked part of the domain, with positions.
    curve : Curve
    name : str
        Name of the curve in messages.

    Raises
    ------
    InvalidSourceError
        A face that does not exist; a curve in another unit.
    """
    from geodesic_toolkit.sources.curves import sample_polyline

    if not domain.measured_in_space:
        raise InvalidSourceError(
            f"{name}: a curve is measured in space, and {a_kind_of(domain)} has a metric of "
            "its own; give points of the curve as sources, closer together than the edges"
        )
    corners = corners_of_curve(domain, curve, name)
    spacing = _spacing(passable)
    step = spacing / SAMPLES_PER_EDGE
    if curve.closed:
        corners = np.concatenate([corners, corners[:1]])
    corners = corners[np.append(True, (corners[1:] != corners[:-1]).any(axis=1))]
    length = np.linalg.norm(np.diff(corners, axis=0), axis=1).sum()
    if not length < MOST_SAMPLES * step:
        raise InvalidSourceError(
            f"{name}: the curve is {length / (SAMPLES_PER_EDGE * step):.3g} times as long as the "
            "mean edge; is it in the unit of the shape?"
        )
    points, places = sample_polyline(corners, step)
    return CurveSamples(points, corners, places, spacing)


def _along(domain: Domain, ground: Ground, curve: Curve, name: str) -> SourcePoints:
    """Return samples of a curve; vertices around them have their distance from the curve."""
    passable = ground.domain
    samples = samples_of(domain, passable, curve, name)
    points = samples.points
    if not passable.has("triangles") and not passable.has("closest"):
        vertices, place = np.unique(ground.nearest_points(points), return_inverse=True)
        off = np.full(len(vertices), np.inf)
        gaps = np.linalg.norm(passable.positions[vertices[place]] - points, axis=1)
        np.minimum.at(off, place, gaps)
        near = SourcePoints.at_vertices(vertices, domain.n_vertices)
        return replace(near, distances=off, front_curvatures=np.zeros(len(vertices)), copy=False)
    at = ground.closest(points)
    if len(points) == 1 or not lies_in_triangles(passable):
        return _between(passable, at)
    normals, boundary = _surface_near(passable, at.vertices)
    laid = LaidCurve(at.positions(passable), at.vertices, at.weights, samples, curve.closed)
    return laid.as_fronts(passable.positions, normals, boundary)


def corners_of_curve(domain: Domain, curve: Curve, name: str = "curve") -> FloatArray:
    """Return where the corners of a curve are in space, (P, 3).

    Raises
    ------
    InvalidSourceError
        Points in faces that the domain does not have.
    """
    if isinstance(curve.points, tuple):
        return _located(domain, curve.points, name).positions(domain)
    return np.asarray(curve.points)


def _surface_near(surface: Domain, vertices: IntArray) -> tuple[FloatArray, BoolArray]:
    """Return normals of any length, (N, 3), and a mask of the boundary, (N,), near some vertices.

    Both are exact at these vertices only.
    """
    triangles, positions = surface.triangles, surface.positions
    near = np.zeros(surface.n_vertices, dtype=np.bool_)
    near[vertices] = True
    around = triangles[near[triangles].any(axis=1)]
    a, b, c = (positions[around[:, corner]] for corner in range(3))
    areas = np.cross(b - a, c - a)
    sums = np.zeros((surface.n_vertices, 3))
    for corner in range(3):
        np.add.at(sums, around[:, corner], areas)
    boundary = np.zeros(surface.n_vertices, dtype=np.bool_)
    boundary[boundary_edges(around)] = True
    return sums, boundary & near


def _spacing(domain: Domain) -> float:
    """Return the mean edge length of the triangles, or the median distance of vertices."""
    if domain.has("triangles"):
        return float(face_edge_lengths(domain.positions, domain.triangles).mean())
    from scipy.spatial import cKDTree

    points = np.unique(domain.positions[domain.present], axis=0)
    if len(points) == 1:
        return 1.0
    some = points[:: max(1, len(points) // 1000)]
    near = np.asarray(cKDTree(points).query(some, k=2)[0], dtype=np.float64)
    return float(np.median(near[:, 1]))


def _between(domain: Domain, places: Located) -> SourcePoints:
    """Return places as sources; the distances of their vertices are straight."""
    vertices, weights = places.vertices, places.weights
    if domain.measured_in_space:
        positions_of(domain)  # raises for positions of another shape
    distances = domain.spans(vertices, weights)
    used = weights > 0
    return SourcePoints(
        vertices=vertices[used],
        shares=weights[used],
        begins=np.concatenate([[0], np.cumsum(used.sum(axis=1))]),
        n_vertices=domain.n_vertices,
        distances=distances[used],
        copy=False,
    )
