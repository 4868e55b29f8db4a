"""Bounds of distances along a surface: the straight line below, the path along edges above."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.arrays import joined
from geodesic_toolkit.core.types import FloatArray, IndexArray, IntArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.domains import Domain, PointCloud, TriangleMesh
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["DistanceBounds", "bounds_of"]


@dataclass(frozen=True, eq=False)
class DistanceBounds:
    """A surface in space, which distances are held to.

    Parameters
    ----------
    vertices : ndarray of shape (N, 3), float64
        NaN where no triangle is.
    indptr, indices : ndarray of int32
        Edges that run along the surface, as a symmetric pattern in compressed rows with sorted
        columns; none where that is not certain.
    """

    vertices: FloatArray
    indptr: IndexArray
    indices: IndexArray

    def hold(
        self, distances: FloatArray, block: Sequence[SourcePoints], *, n_threads: int = 1
    ) -> None:
        """Raise and lower distances (K, N) in place, one row for each of K source sets.

        None stays below the straight line to the nearest source, and none above the shortest path
        along edges. Infinite ones stay.
        """
        begins, places, starts = [0], [], []
        for points in block:
            begins.append(begins[-1] + points.count)
            places.append(self._places(points))
            starts.append(points.starts - self._reach(points, places[-1]))
        self._kernel.hold(
            np.array(begins, dtype=np.int64), joined(places), joined(starts), distances, n_threads
        )

    @cached_property
    def _kernel(self) -> _native.Bounds:
        return _native.Bounds(self.vertices, self.indptr, self.indices)

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what derives from the rest."""
        return {name: value for name, value in self.__dict__.items() if name != "_kernel"}

    def prepare(self) -> None:
        """Compute what all sources share."""
        _ = self._kernel

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


def bounds_of(domain: Domain, metric: Discretization) -> DistanceBounds | None:
    """Return the bounds for distances on a domain, None where it is not a surface in space.

    The stars of a cloud have edges that are no way along the surface, across thin gaps. Those of a
    mesh are in its stiffness already, where the triangles are those that were given.
    """
    if isinstance(domain, TriangleMesh):
        vertices = domain.vertices
        if not np.isfinite(vertices).all():  # where no face is; as a source each still reads 0
            vertices = np.where(np.isfinite(vertices), vertices, 0.0)
        if metric.triangulation == "given":
            return DistanceBounds(vertices, metric.rows.indptr, metric.rows.indices)
        faces = np.ascontiguousarray(_without_repeats(domain.faces))
        return DistanceBounds(vertices, *_native.edges_of(faces, domain.n_vertices))
    if isinstance(domain, PointCloud):
        none = np.zeros(domain.n_vertices + 1, dtype=np.int32)
        return DistanceBounds(domain.points, none, none[:0])
    return None


def _without_repeats(faces: IntArray) -> IntArray:
    """Leave out faces with a repeated vertex, as operators do: no front gets across.

    The line that is left of such a face may lead straight through a solid.
    """
    a, b, c = faces.T
    repeats = (a == b) | (b == c) | (c == a)
    return faces[~repeats] if repeats.any() else faces
