"""Curves projected to a surface, and the vertices on their sides."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.sources.curves import bends_of_polyline, distance_to_segments
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["CurveSamples", "LaidCurve", "sides_of"]

N_NEAR_SAMPLES = 4
"""Range of samples, a quarter of an edge apart, that may be nearest to a corner of a face."""

MAX_WEIGHT_ON_EDGE = 1e-6
"""Barycentric weight below which a place is on the opposite edge."""


MIN_SHARE_OF_FRONT = 0.25
"""Minimum relative length of a front at the next vertex after it leaves a curve, for curves that
bend around a vertex with a radius below the edge length."""


class CurveSamples(NamedTuple):
    """A polyline with points in between, before projection to the surface.

    Attributes
    ----------
    points : ndarray of shape (S, 3), float64
    corners : ndarray of shape (P, 3), float64
        Corners without consecutive repeats; a closed curve repeats the first at the end.
    places : ndarray of shape (P,), int64
        Indices of the points at the corners.
    spacing : float
        Mean edge length of the shape.
    """

    points: FloatArray
    corners: FloatArray
    places: IntArray
    spacing: float


@dataclass(frozen=True, eq=False)
class LaidCurve:
    """Samples of a curve, projected to a surface.

    Attributes
    ----------
    points : ndarray of shape (S, 3), float64
        Samples in order along the curve; a closed one repeats the first at the end.
    vertices : ndarray of shape (S, 3), int64
        Vertices of the triangle of each sample.
    weights : ndarray of shape (S, 3), float64
        Barycentric coordinates in that triangle.
    samples : CurveSamples
        Samples of the curve before projection.
    closed : bool
    """

    points: FloatArray
    vertices: IntArray
    weights: FloatArray
    samples: CurveSamples
    closed: bool

    @property
    def lengths(self) -> FloatArray:
        """The length of the curve that each sample represents, of shape (S,)."""
        steps = np.linalg.norm(np.diff(self.points, axis=0), axis=1) / 2
        return np.asarray(np.append(steps, 0.0) + np.append(0.0, steps))

    def readings(self, values: FloatArray) -> FloatArray:
        """Return values at vertices, (N,), interpolated at the samples, (S,)."""
        return np.asarray((self.weights * values[self.vertices]).sum(axis=1))

    def as_sources(self, n_vertices: int) -> SourcePoints:
        """Return the samples as sources, weighted by the length that each represents."""
        none = np.zeros(self.weights.shape)
        return self._sources(n_vertices, self.weights * self.lengths[:, None], none, none)

    def as_fronts(
        self, places: FloatArray, normals: FloatArray, boundary: BoolArray | None = None
    ) -> SourcePoints:
        """Return the samples as sources whose fronts leave with the curvature of the curve.

        A front leaves with the geodesic curvature of the curve, as a converging front on one side,
        and after a distance s on a flat surface its curvature is ``κ / (1 + κ s)``. Around ends and
        kinks it is a circle.

        Parameters
        ----------
        places, normals : ndarray of shape (N, 3), float64
            Positions and normals of the vertices.
        boundary : ndarray of shape (N,), bool, optional
            True at vertices of the boundary: a curve that ends there would continue.
        """
        around = self._around()
        distances, nearest = distance_to_segments(places[around], self.points)
        bends, round_about = self._bends(self.normals(normals))
        if boundary is not None:
            round_about[[0, -1]] &= [not self._is_cut_off(boundary, end) for end in (0, -1)]
        left = np.cross(self.normals(normals), self.ahead())
        side = np.sign(np.einsum("scd,sd->sc", places[around] - self.points[:, None], left))
        leaving = -side * bends[:, None]
        with np.errstate(divide="ignore"):
            curvatures = np.where(
                (nearest >= 0) & round_about[nearest],
                1 / distances,
                leaving / np.maximum(1 + leaving * distances, MIN_SHARE_OF_FRONT),
            )
        # A corner may be nearest to a sample that is in another face. If that is an end of two
        # segments, its own row says on which side.
        elsewhere = (nearest >= 0) & (nearest != np.arange(len(nearest))[:, None])
        order = np.lexsort((elsewhere.ravel(), distances.ravel(), around.ravel()))
        vertices, first = np.unique(around.ravel()[order], return_index=True)
        place = np.searchsorted(vertices, self.vertices)
        distances, curvatures = (
            table.ravel()[order[first]][place] for table in (distances, curvatures)
        )
        return self._sources(len(places), self.weights, distances, curvatures)

    def _bends(self, normals: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return the curvature (S,) at samples, and a mask of ends and kinks."""
        corners, places = self.samples.corners, self.samples.places
        ends = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1)))
        along = np.interp(np.arange(len(self.points)), places, ends)
        bends, kinks = bends_of_polyline(
            corners, normals[places], along, self.samples.spacing, self.closed
        )
        round_about = np.zeros(len(self.points), dtype=np.bool_)
        round_about[places[kinks]] = True
        if not self.closed:
            round_about[[0, -1]] = True
        return bends, round_about

    def ahead(self) -> FloatArray:
        """Return the direction of the curve at the samples, (S, 3), of any length."""
        ahead = np.gradient(self.points, axis=0)
        if self.closed:
            ahead[[0, -1]] = ahead[[0, -1]].sum(axis=0)
        return ahead

    def _is_cut_off(self, boundary: BoolArray, end: int) -> bool:
        """Return True if an end of the curve is on the boundary."""
        return bool((boundary[self.vertices[end]] | (self.weights[end] < MAX_WEIGHT_ON_EDGE)).all())

    def _around(self) -> IntArray:
        """Return the vertices around each sample and around near samples of the curve."""
        steps = np.arange(len(self.points))[:, None] + [
            -N_NEAR_SAMPLES,
            -N_NEAR_SAMPLES // 2,
            0,
            N_NEAR_SAMPLES // 2,
            N_NEAR_SAMPLES,
        ]
        if self.closed:
            rows = steps % (len(self.points) - 1)
        else:
            rows = np.clip(steps, 0, len(self.points) - 1)
        return np.asarray(self.vertices[rows].reshape(len(self.points), -1))

    def normals(self, of_vertices: FloatArray) -> FloatArray:
        """Return unit normals at the samples, (S, 3), interpolated from those of the vertices."""
        normals = np.einsum("sc,scd->sd", self.weights, of_vertices[self.vertices])
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        return np.asarray(np.divide(normals, lengths, out=normals, where=lengths > 0))

    def _sources(
        self, n_vertices: int, shares: FloatArray, distances: FloatArray, curvatures: FloatArray
    ) -> SourcePoints:
        used = self.weights > 0
        return SourcePoints(
            vertices=self.vertices[used],
            shares=shares[used],
            begins=np.append(0, np.cumsum(used.sum(axis=1))),
            n_vertices=n_vertices,
            distances=distances[used],
            front_curvatures=curvatures[used],
        )


def sides_of(
    curves: list[LaidCurve], places: FloatArray, normals: FloatArray
) -> tuple[IntArray, BoolArray]:
    """Return the vertices beside curves, and a mask of those on the left.

    Vertices that are nearest to an end of an open curve are not beside it.

    Parameters
    ----------
    curves : list of LaidCurve
    places, normals : ndarray of shape (N, 3), float64
        Positions and normals of the vertices.

    Returns
    -------
    vertices : ndarray of shape (V,), int64
        Distinct vertices.
    left : ndarray of shape (V,), bool
    """
    parts = [_sides(curve, places, normals) for curve in curves]
    vertices, distances, beside, left = (np.concatenate(part) for part in zip(*parts, strict=True))
    order = np.lexsort((distances, vertices))
    order = order[np.append(True, np.diff(vertices[order]) != 0)]
    order = order[beside[order]]
    return vertices[order], left[order]


def _sides(
    curve: LaidCurve, places: FloatArray, normals: FloatArray
) -> tuple[IntArray, FloatArray, BoolArray, BoolArray]:
    """Return vertices around a curve, their distances, and masks: beside it, and on its left."""
    around = places[curve.vertices]
    distances, nearest = distance_to_segments(around, curve.points)
    beside = np.ones(distances.shape, dtype=np.bool_)
    if not curve.closed:
        beside = (nearest != 0) & (nearest != len(nearest) - 1)
    left = np.cross(curve.normals(normals), curve.ahead())
    aside = np.einsum("scd,sd->sc", around - curve.points[:, None], left)
    return curve.vertices.ravel(), distances.ravel(), beside.ravel(), aside.ravel() > 0
