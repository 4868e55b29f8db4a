"""Curves projected to a surface, and the vertices on their sides."""

from dataclasses import dataclass

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.sources.curves import distance_to_segments
from geodesic_toolkit.sources.locate import CurveSamples, fronts_beside
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["LaidCurve", "sides_of"]

N_NEAR_SAMPLES = 4
"""Range of samples, a quarter of an edge apart, that may be nearest to a corner of a face."""

MAX_WEIGHT_ON_EDGE = 1e-6
"""Barycentric weight below which a place is on the opposite edge."""


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
        self, places: FloatArray, normals: FloatArray, boundary: BoolArray
    ) -> SourcePoints:
        """Return the samples as sources whose fronts leave with the curvature of the curve.

        Parameters
        ----------
        places, normals : ndarray of shape (N, 3), float64
            Positions and normals of the vertices.
        boundary : ndarray of shape (N,), bool
            True at vertices of the boundary.
        """
        around = self._around()
        past = [self._is_cut_off(boundary, end) for end in (0, -1)]
        distances, curvatures = fronts_beside(
            places[around],
            self.points,
            self.normals(normals),
            corners=self.samples.corners,
            places=self.samples.places,
            spacing=self.samples.spacing,
            closed=self.closed,
            past=(past[0], past[1]),
        )
        # A corner may be nearest to a sample that is in another face.
        order = np.lexsort((distances.ravel(), around.ravel()))
        vertices, first = np.unique(around.ravel()[order], return_index=True)
        place = np.searchsorted(vertices, self.vertices)
        distances, curvatures = (
            table.ravel()[order[first]][place] for table in (distances, curvatures)
        )
        return self._sources(len(places), self.weights, distances, curvatures)

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
    distances, beside, _ = distance_to_segments(around, curve.points)
    if curve.closed:
        beside[[0, -1]] = True
    ahead = np.gradient(curve.points, axis=0)
    if curve.closed:
        ahead[[0, -1]] = ahead[[0, -1]].sum(axis=0)
    left = np.cross(curve.normals(normals), ahead)
    aside = np.einsum("scd,sd->sc", around - curve.points[:, None], left)
    return curve.vertices.ravel(), distances.ravel(), beside.ravel(), aside.ravel() > 0
