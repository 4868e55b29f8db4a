"""Distance at any points on or near a mesh or a cloud, from the distance of its vertices."""

import numbers
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodesic_toolkit.core.checks import check_nothing_masked
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.domains import Domain, positions_of, triangles_of
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.geometry.closest import TriangleTree
from geodesic_toolkit.geometry.entering import entered
from geodesic_toolkit.geometry.triangles import face_edge_lengths, proper_faces
from geodesic_toolkit.heat.method import Progress
from geodesic_toolkit.sources.ground import Ground, distinct_triangles, lies_in_triangles
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["Surface", "as_points", "check_reach", "interpolate"]

DEFAULT_REACH = 2.0
"""Default maximum distance of a point from the surface, in mean edge lengths."""

RADIUS_OF_STRAIGHT_LINES = 2.0
"""Radius around a source, in mean edge lengths, in which the straight line is more accurate; its
weight falls to 0 over as many again."""

MIN_WEIGHT_OF_CORNERS = 1e-9
"""Barycentric weight below which a corner is ignored: the accuracy of a foot."""

POINTS_PER_BATCH = 100_000
"""Points that are processed at once, with some 50 MB."""


def interpolate(
    domain: Domain,
    discretization: Discretization,
    distance: ArrayLike,
    points: ArrayLike,
    *,
    reach: float | None = None,
    sources: SourcePoints | None = None,
) -> FloatArray:
    """Return the distance at points on or near a surface.

    A point has the distance of its foot, the closest point of the surface: of the mesh, or of the
    local triangles of the cloud. Inside a triangle the distance of the corners is interpolated
    linearly. The distance has a kink at a source, which a linear function cannot have; if the
    sources are known, the excess of the distance over the straight line from a source is
    interpolated near it. For many calls on one surface use a :class:`Surface`, or a solver, which
    keeps one.

    Parameters
    ----------
    domain : Domain
        A TriangleMesh, a PointCloud, or a kind of a plugin's with positions.
    discretization : Discretization
        The discretization of `domain`: its spacing and, for a cloud, its triangles are used.
    distance : array-like of shape (N,)
        Distance at the vertices; ``inf`` at unreachable ones.
    points : array-like of shape (Q, 3) or (3,)
        In the unit of the domain.
    reach : float, optional
        Maximum distance of a point from its foot, in that unit; by default :data:`DEFAULT_REACH`
        times the mean edge length.
    sources : SourcePoints, optional
        The sources of `distance`.

    Returns
    -------
    ndarray of shape (Q,), float64
        ``inf`` past the reach, and if a corner with a weight has no distance.

    Raises
    ------
    UnsupportedDomainError
        A domain without positions, or a cloud whose operator makes no triangles.
    InvalidOptionError
        Points that are not finite or of another shape, a number of distances that is not that of
        the vertices, a reach that is not positive.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit.solver.queries import interpolate
    >>> square = gt.testing.shapes.grid(3)
    >>> discretization = gt.CotanLaplacian().assemble(square)
    >>> interpolate(square, discretization, square.vertices[:, 0], [[0.3, 0.2, 0.1], [0, 9, 0]])
    array([0.3, inf])
    """
    surface = Surface(domain, discretization)
    return surface.interpolate(distance, points, reach=reach, sources=sources)


@dataclass(frozen=True)
class _Feet:
    """Feet of points on the surface.

    Attributes
    ----------
    rows : ndarray of shape (F,), int64
        Indices of the points, which are those within reach.
    elements : ndarray of shape (E, C)
        Vertices of the triangles or other elements.
    faces : ndarray of shape (F,)
        Index of the element of each foot.
    weights : ndarray of shape (F, C)
        Barycentric coordinates.
    """

    rows: IntArray
    elements: IntArray
    faces: NDArray[Any]
    weights: FloatArray

    @property
    def corners(self) -> IntArray:
        """The vertices of the element of each foot, (F, C)."""
        corners: IntArray = self.elements[self.faces]
        return corners

    def chosen(self, which: NDArray[Any]) -> "_Feet":
        return _Feet(self.rows[which], self.elements, self.faces[which], self.weights[which])

    def compact(self) -> "_Feet":
        """Return the feet with small indices, which saves memory for ten million points."""
        small = np.int32 if len(self.elements) < 2**31 else np.int64
        return _Feet(self.rows, self.elements, self.faces.astype(small), self.weights)


class Surface:
    """The triangles of a domain in a tree: built once, then used for any number of points.

    It is safe to use from several threads.

    Parameters
    ----------
    domain : Domain
        A TriangleMesh, a PointCloud, or a kind of a plugin's with positions.
    discretization : Discretization
        The discretization of `domain`: its spacing and, for a cloud, its triangles are used.
    ground : Ground, optional
        The ground of `domain`, whose tree is used if it is the same, or of its unmasked part.
    mask : ndarray of shape (N,), bool, optional
        The vertices that paths may not cross. A place in a face with such a vertex is reached from
        the other corners, if it is within reach of the unmasked part.

    Raises
    ------
    UnsupportedDomainError
        A domain without positions, or a cloud whose operator makes no triangles.
    """

    def __init__(
        self,
        domain: Domain,
        discretization: Discretization,
        ground: Ground | None = None,
        *,
        mask: BoolArray | None = None,
    ) -> None:
        self._mask, self._left = mask, ground
        self._positions = positions_of(domain)
        self._spacing = discretization.spacing
        self._in_space = domain.measured_in_space
        self._box: tuple[FloatArray, FloatArray] | None = None
        self._own: Ground | None = None
        if domain.has("closest"):
            self._own = Ground(domain) if ground is None or ground.domain is not domain else ground
            places = self._positions[np.isfinite(self._positions).all(axis=1)]
            self._box = places.min(axis=0), places.max(axis=0)
            return
        self._faces = _triangles(domain, discretization)
        if len(self._faces) == 0:  # all faces are degenerate, or all points are equal
            return
        if not self._in_space:
            self._spacing = float(face_edge_lengths(self._positions, self._faces).mean())
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        for some in _batches(len(self._faces)):
            places = self._positions[self._faces[some]]
            low = np.minimum(low, places.min(axis=(0, 1)))
            high = np.maximum(high, places.max(axis=(0, 1)))
        self._box = low, high
        if ground is not None and ground.domain is domain and _every_face(domain, self._faces):
            self._tree = ground.triangles
        else:
            self._tree = TriangleTree(self._positions, self._faces)

    def interpolate(
        self,
        distance: ArrayLike,
        points: ArrayLike,
        *,
        reach: float | None = None,
        sources: SourcePoints | None = None,
        progress: Progress | None = None,
    ) -> FloatArray:
        """Return the distance at points on or near the surface, batch by batch.

        Parameters and errors are those of :func:`interpolate`; `progress` is called with the number
        of finished points and their total after each batch.
        """
        queries = as_points(points)
        check_reach(reach)
        check_nothing_masked(distance, "distance", InvalidOptionError, "{}.filled(numpy.inf)")
        values = np.asarray(distance, dtype=np.float64)
        if values.shape != (len(self._positions),):
            raise InvalidOptionError(
                f"distance must have shape ({len(self._positions)},), one number per vertex, "
                f"not {values.shape}"
            )
        kinks = self._kinks(sources)
        result = np.full(len(queries), np.inf)
        for feet in self._feet_within(queries, reach, progress):
            result[feet.rows] = self._values(values, feet, kinks)
        return result

    def feet(self, points: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the closest place of the surface to each of Q points, at any distance.

        Returns
        -------
        corners : ndarray of shape (Q, 3), int64
            The vertices of the triangle of each place.
        weights : ndarray of shape (Q, 3), float64
            The barycentric coordinates of each place.

        Raises
        ------
        UnsupportedDomainError
            The surface does not have triangles.
        """
        if len(self._faces) == 0:
            raise UnsupportedDomainError(
                "the shape has no triangles: all vertices are at one position"
            )
        faces, weights = self._tree.closest(points)
        return self._faces[faces], weights

    def nearest(
        self,
        points: ArrayLike,
        sets: list[SourcePoints],
        solve: Callable[[list[SourcePoints]], Iterator[FloatArray]],
        *,
        reach: float | None = None,
        progress: Progress | None = None,
    ) -> tuple[IntArray, FloatArray]:
        """Return the index of the nearest source set of each point, and its distance.

        Parameters
        ----------
        points : array-like of shape (Q, 3) or (3,)
        sets : list of SourcePoints
        solve : callable
            Yields the distances of the vertices, blocks of rows of shape (., N), set by set.
        reach, progress
            As for :meth:`interpolate`; sets are counted instead of points.

        Returns
        -------
        labels : ndarray of shape (Q,), int64
            -1 for points without a source.
        distances : ndarray of shape (Q,), float64
        """
        queries = as_points(points)
        check_reach(reach)
        labels = np.full(len(queries), -1, dtype=np.int64)
        nearest = np.full(len(queries), np.inf)

        def located(*_: int) -> None:
            if progress is not None:
                progress(0, len(sets))

        located_feet = [feet.compact() for feet in self._feet_within(queries, reach, located)]
        done = 0
        for block in solve(sets):
            for number, values in enumerate(block, done):
                kinks = self._kinks(sets[number])
                for feet in located_feet:
                    rows, found = self._nearer(values, feet, kinks, nearest)
                    labels[rows], nearest[rows] = number, found
            done += len(block)
            if progress is not None:
                progress(done, len(sets))
        return labels, nearest

    def _nearer(
        self, values: FloatArray, feet: _Feet, kinks: "_Kinks | None", nearest: FloatArray
    ) -> tuple[IntArray, FloatArray]:
        """Return the points at which values are below the minimum so far, and these values."""
        least = values[feet.corners].min(axis=1)
        # Except for rounding, and near kinks, values are not below the smallest at their corners.
        reached = 0.0 if kinks is None else 2 * RADIUS_OF_STRAIGHT_LINES * self._spacing
        limit = np.maximum((1 + 1e-12) * nearest[feet.rows], reached)
        some = feet.chosen(np.flatnonzero(least < limit))
        found = self._values(values, some, kinks)
        nearer = found < nearest[some.rows]
        return some.rows[nearer], found[nearer]

    def _feet_within(
        self, queries: NDArray[Any], reach: float | None, progress: Progress | None
    ) -> Iterator[_Feet]:
        """Yield the feet of the points within reach, batch by batch."""
        limit = DEFAULT_REACH * self._spacing if reach is None else float(reach)
        if self._box is None:
            return
        low, high = self._box
        for some in _batches(len(queries)):
            places = queries[some].astype(np.float64)
            near = np.flatnonzero(((places >= low - limit) & (places <= high + limit)).all(axis=1))
            places = places[near]
            if len(near):
                elements, faces, weights = self._closest(places)
                feet = np.einsum("qc,qcd->qd", weights, self._positions[elements[faces]])
                with np.errstate(over="ignore"):  # infinity is beyond the reach
                    is_near = _length(places - feet) <= limit
                if self._mask is not None and self._left is not None:
                    cut = np.flatnonzero(is_near & self._mask[elements[faces]].any(axis=1))
                    if len(cut):
                        is_near[cut] = self._left.gaps(places[cut]) <= limit
                yield _Feet(some.start + near[is_near], elements, faces[is_near], weights[is_near])
            if progress is not None:
                progress(some.stop, len(queries))

    def _closest(self, places: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
        """Return elements, the index of the closest one to each place, and its weights there."""
        if self._own is None:
            return self._faces, *self._tree.closest(places)
        at = self._own.closest(places)
        return at.vertices, np.arange(len(at)), at.weights

    def _values(self, values: FloatArray, feet: _Feet, kinks: "_Kinks | None") -> FloatArray:
        """Return values of the vertices, interpolated at the feet."""
        corners = feet.corners
        found = _mean(feet.weights, values[corners])
        beyond = np.flatnonzero(found == np.inf)
        if self._mask is not None and len(beyond) and self._in_space:
            found[beyond] = self._values_in_cut_faces(values, feet.chosen(beyond))
        if kinks is not None:
            rings = found / self._spacing
            rings[beyond] = np.inf  # not interpolated linearly
            near = np.flatnonzero(rings < 2 * RADIUS_OF_STRAIGHT_LINES)
            missed = kinks.missed(feet.weights[near], self._positions[corners[near]], rings[near])
            found[near] = np.maximum(found[near] + missed, 0.0)
        return found

    def _values_in_cut_faces(self, values: FloatArray, feet: _Feet) -> FloatArray:
        """Return values at feet in faces that a mask cuts, from the corners that have a value.

        A foot on a masked edge or corner is reached through any of the faces around that.
        """
        corners, least = feet.corners, np.full(len(feet.rows), np.inf)
        places = np.einsum("qc,qcd->qd", feet.weights, self._positions[corners])
        masked = ~np.isfinite(values[corners])
        inside = (feet.weights > MIN_WEIGHT_OF_CORNERS) & ~masked
        within = inside.any(axis=1)
        least[within] = entered(self._positions, values, corners[within], places[within])
        on = np.flatnonzero(~within)
        if len(on):
            rows, faces = self._faces_around(corners[on], feet.weights[on] > MIN_WEIGHT_OF_CORNERS)
            entered_distances = entered(
                self._positions, values, self._faces[faces], places[on[rows]]
            )
            np.minimum.at(least, on[rows], entered_distances)
        return least

    def _faces_around(self, corners: IntArray, held: BoolArray) -> tuple[IntArray, IntArray]:
        """Return the faces that contain all held corners of (Q, 3), as pairs of row and face."""
        order = np.argsort(self._faces, axis=None, kind="stable")
        sorted_corners = self._faces.ravel()[order]
        first = np.take_along_axis(corners, held.argmax(axis=1)[:, None], axis=1)[:, 0]
        begins = np.searchsorted(sorted_corners, first)
        counts = np.searchsorted(sorted_corners, first, side="right") - begins
        rows = np.repeat(np.arange(len(corners)), counts)
        offsets = np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts)
        faces = order[begins[rows] + offsets] // 3
        has = (corners[rows][:, :, None] == self._faces[faces][:, None, :]).any(axis=2)
        whole = (has | ~held[rows]).all(axis=1)
        return rows[whole], faces[whole]

    def _kinks(self, sources: SourcePoints | None) -> "_Kinks | None":
        if sources is None or not sources.radial or not self._in_space:
            return None
        return _Kinks(np.asarray(sources.weights @ self._positions))


class _Kinks:
    """Corrections of linear interpolation near sources, where distance is not a linear function.

    Parameters
    ----------
    starts : ndarray of shape (P, 3)
        Positions of the sources.
    """

    def __init__(self, starts: FloatArray) -> None:
        from scipy.spatial import cKDTree

        self._tree = cKDTree(starts)

    def missed(self, weights: FloatArray, corners: FloatArray, rings: FloatArray) -> FloatArray:
        """Return the correction by the straight distance from the nearest source, of shape (Q,).

        It is zero at the corners, and past some `rings` around the source, where a straight line
        would cross from one sheet of a thin shape to the other.
        """
        straight = self._straight(np.einsum("qc,qcd->qd", weights, corners))
        missed = straight - _mean(weights, self._straight(corners))
        fading = np.clip(2 - rings / RADIUS_OF_STRAIGHT_LINES, 0.0, 1.0)
        return np.asarray(missed * fading)

    def _straight(self, places: FloatArray) -> FloatArray:
        """Return the distance of the nearest source, which may differ from corner to corner."""
        return np.asarray(self._tree.query(places)[0])


def as_points(points: Any) -> NDArray[Any]:
    """Return points in space as an array of shape (Q, 3) of real numbers, not copied.

    Raises
    ------
    InvalidOptionError
        Another shape, values that are not numbers, or a row that is not finite.
    """
    check_nothing_masked(points, "points", InvalidOptionError, "remove those rows")
    try:
        array = np.asarray(points)
    except (ValueError, TypeError) as error:
        raise InvalidOptionError(f"points cannot be read as an array: {error}") from error
    if array.dtype.kind not in "iuf":
        raise InvalidOptionError(f"points must hold real numbers, not dtype {array.dtype}")
    if array.shape[-1:] != (3,) or array.ndim > 2:
        raise InvalidOptionError(f"points must have shape (Q, 3) or (3,), not {array.shape}")
    table = np.atleast_2d(array)
    for some in _batches(len(table)):
        finite = np.isfinite(table[some]).all(axis=1)
        if not finite.all():
            bad = some.start + int(finite.argmin())
            raise InvalidOptionError(
                f"point {bad} of the points is not finite: {table[bad].tolist()}; remove it"
            )
    return table


def _batches(count: int) -> Iterator[slice]:
    for start in range(0, count, POINTS_PER_BATCH):
        yield slice(start, min(start + POINTS_PER_BATCH, count))


def check_reach(reach: float | None) -> None:
    """Raise an `InvalidOptionError` unless `reach` is a positive length, or not given."""
    if reach is None:
        return
    if isinstance(reach, bool) or not isinstance(reach, numbers.Real) or not reach > 0:
        raise InvalidOptionError(f"reach must be a positive length, not {reach!r}")


def _every_face(domain: Domain, faces: IntArray) -> bool:
    return lies_in_triangles(domain) and len(faces) == len(domain.triangles)


def _triangles(domain: Domain, discretization: Discretization) -> IntArray:
    """Return the distinct triangles of the surface."""
    if domain.has("triangles"):
        faces = triangles_of(domain)
        return faces[proper_faces(faces)]
    gradient = discretization.gradient
    if not isinstance(gradient, ElementGradient) or gradient.elements.shape[1] != 3:
        raise UnsupportedDomainError(
            f"{gradient!r} has no triangles to interpolate in; queries on a cloud need an operator "
            "that makes triangles, such as PointCloudLaplacian, and queries on a kind of domain of "
            "a plugin need its triangles, or its method closest(points)"
        )
    return distinct_triangles(gradient.elements)


def _mean(weights: FloatArray, values: FloatArray) -> FloatArray:
    """Return weighted means, of shape (Q,), that ignore infinite values of weight 0."""
    counted = np.where(weights > 0, values, 0.0)
    return np.asarray(np.einsum("qc,qc->q", weights, counted))


def _length(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(vectors, axis=-1))
