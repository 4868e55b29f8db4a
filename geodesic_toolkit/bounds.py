"""What no distance along a surface can be: less than the straight line, more than along edges."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit._typing import FloatArray, IntArray
from geodesic_toolkit.domains import Domain, PointCloud, TriangleMesh
from geodesic_toolkit.source_points import SourcePoints

__all__ = ["DistanceBounds", "bounds_of"]


@dataclass(frozen=True, eq=False)
class DistanceBounds:
    """A surface in space, which distances are held to.

    Parameters
    ----------
    vertices : ndarray of shape (N, 3), float64
        NaN where no triangle is.
    triangles : ndarray of shape (E, 3), int64
        Those whose edges are ways along the surface; none where that is not certain.
    """

    vertices: FloatArray
    triangles: IntArray

    def hold(
        self, distances: FloatArray, block: Sequence[SourcePoints], *, n_threads: int = 1
    ) -> None:
        """Raise and lower distances (K, N) in place, one row for each of K source sets.

        None stays below the straight line to the nearest source, and none above the shortest way
        along edges. Infinite ones stay.
        """
        begins = np.cumsum([0, *(points.count for points in block)])
        places = np.concatenate([self._places(points) for points in block])
        starts = np.concatenate(
            [
                points.starts - self._reach(points, places[first : first + points.count])
                for points, first in zip(block, begins[:-1].tolist(), strict=True)
            ]
        )
        _native.hold_within_bounds(
            self.vertices, self.triangles, begins, places, starts, distances, n_threads
        )

    def _places(self, points: SourcePoints) -> FloatArray:
        """Return where the (P, 3) points are."""
        corners = self.vertices[points.vertices]
        if len(corners) == points.count:
            return corners
        return np.add.reduceat(points.shares[:, None] * corners, points.begins[:-1])

    def _reach(self, points: SourcePoints, places: FloatArray) -> FloatArray | float:
        """Return how far from the (P,) points a source may be that lies between them.

        Of a curve on a mesh: half of the longest step between its samples. The vertices of a cloud
        that stand for a curve are in no order, and tell nothing.
        """
        if points.front_curvatures is None or points.count == 1:
            return 0.0
        if len(points.vertices) == points.count:
            return np.inf
        return float(np.linalg.norm(np.diff(places, axis=0), axis=1).max()) / 2


def bounds_of(domain: Domain) -> DistanceBounds | None:
    """Return the bounds for distances on a domain, None where it is not a surface in space.

    The stars of a cloud have edges that are no way along the surface, across thin gaps.
    """
    if isinstance(domain, TriangleMesh):
        vertices = domain.vertices
        if not np.isfinite(vertices).all():  # where no face is; as a source each still reads 0
            vertices = np.where(np.isfinite(vertices), vertices, 0.0)
        return DistanceBounds(vertices, _without_repeats(domain.faces))
    if isinstance(domain, PointCloud):
        return DistanceBounds(domain.points, np.empty((0, 3), dtype=np.int64))
    return None


def _without_repeats(faces: IntArray) -> IntArray:
    """Leave out faces with a repeated vertex, as operators do: no front gets across.

    The line that is left of such a face may lead straight through a solid.
    """
    a, b, c = faces.T
    repeats = (a == b) | (b == c) | (c == a)
    return faces[~repeats] if repeats.any() else faces
