"""Bounds of distances along a surface: the straight line below, the path along edges above."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.arrays import joined
from geodesic_toolkit.core.near import NearRows
from geodesic_toolkit.core.types import BoolArray, FloatArray, IndexArray, IntArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.domains import Domain, PointCloud, TriangleMesh
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["DistanceBounds", "bounds_of"]


@dataclass(frozen=True, eq=False)
class DistanceBounds:
    """A surface in space, and the bounds that it sets to distances.

    Parameters
    ----------
    vertices : ndarray of shape (N, 3), float64
        NaN at vertices without triangles.
    indptr, indices : ndarray of int32
        Edges that run along the surface, as a symmetric pattern in compressed rows with sorted
        columns; empty if that is not certain.
    """

    vertices: FloatArray
    indptr: IndexArray
    indices: IndexArray

    def hold(
        self, distances: FloatArray, block: Sequence[SourcePoints], *, n_threads: int = 1
    ) -> None:
        """Raise and lower distances (K, N) in place, one row for each of K source sets.

        Distances are raised to the straight line to the nearest source, and lowered to the shortest
        path along edges. Infinite ones stay.
        """
        self._kernel.hold(*self._sources(block), distances, n_threads)

    def hold_near(
        self, near: NearRows, block: Sequence[SourcePoints], limits: FloatArray
    ) -> BoolArray:
        """Do the same with the distances of some vertices, in place.

        Parameters
        ----------
        near : NearRows
            With all vertices up to a limit, and some beyond it.
        block : sequence of SourcePoints
        limits : ndarray of shape (K,), float64

        Returns
        -------
        ndarray of shape (K,), bool
            False for rows in which a vertex may be missing.
        """
        return self._kernel.hold_near(
            *self._sources(block), near.begins, near.vertices, near.distances, limits
        )

    def _sources(self, block: Sequence[SourcePoints]) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return where the points of each set begin, their positions, and what they start with."""
        begins, positions, starts = [0], [], []
        for points in block:
            begins.append(begins[-1] + points.count)
            positions.append(self._positions(points))
            starts.append(points.starts - self._reach(points, positions[-1]))
        return np.array(begins, dtype=np.int64), joined(positions), joined(starts)

    @cached_property
    def _kernel(self) -> _native.Bounds:
        return _native.Bounds(self.vertices, self.indptr, self.indices)

    def __getstate__(self) -> dict[str, Any]:
        """Return the state without the derived kernel."""
        return {name: value for name, value in self.__dict__.items() if name != "_kernel"}

    def prepare(self) -> None:
        """Compute the data that all sources share."""
        _ = self._kernel

    def _positions(self, points: SourcePoints) -> FloatArray:
        """Return the positions of the points, (P, 3)."""
        corners = self.vertices[points.vertices]
        if len(corners) == points.count:
            return corners
        return np.add.reduceat(points.shares[:, None] * corners, points.begins[:-1])

    def _reach(self, points: SourcePoints, positions: FloatArray) -> FloatArray | float:
        """Return the largest distance of a source from the (P,) points that sample it.

        For a curve on a mesh it is half of the longest step between its samples. The vertices of a
        cloud that sample a curve are not in order, and do not give a bound.
        """
        if points.front_curvatures is None or points.count == 1:
            return 0.0
        if len(points.vertices) == points.count:
            return np.inf
        return float(np.linalg.norm(np.diff(positions, axis=0), axis=1).max()) / 2


def bounds_of(domain: Domain, metric: Discretization) -> DistanceBounds | None:
    """Return the bounds for distances on a domain, None if it is not a surface in space.

    The stars of a cloud have edges across thin gaps, which are not on the surface. The edges of a
    mesh are those of its stiffness, if its triangles are the given ones.
    """
    if isinstance(domain, TriangleMesh):
        vertices = domain.vertices
        if not np.isfinite(vertices).all():  # unused vertices: as sources they still read 0
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
    """Return the faces without those that repeat a vertex, as operators do.

    Fronts do not cross such a face, and its remaining edge may lead straight through a solid.
    """
    a, b, c = faces.T
    repeats = (a == b) | (b == c) | (c == a)
    return faces[~repeats] if repeats.any() else faces
