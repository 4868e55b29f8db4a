"""What points in space snap to: the faces of a mesh, or the points of a cloud."""

import threading
from typing import TYPE_CHECKING

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains import PointCloud, TriangleMesh
from geodesic_toolkit.geometry.closest import TriangleTree

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

__all__ = ["Ground"]


class Ground:
    """The nearest faces or points of one shape; the tree is built when it is first wanted, once.

    Safe to use from several threads.

    Parameters
    ----------
    domain : TriangleMesh or PointCloud
    """

    def __init__(self, domain: TriangleMesh | PointCloud) -> None:
        self.domain = domain
        self._present: IntArray | None = None
        self._points: cKDTree | None = None
        self._triangles: TriangleTree | None = None
        self._lock = threading.Lock()

    @property
    def triangles(self) -> TriangleTree:
        """The tree of all faces of a mesh."""
        assert isinstance(self.domain, TriangleMesh)  # for the type checker
        with self._lock:
            if self._triangles is None:
                self._triangles = TriangleTree(self.domain.vertices, self.domain.faces)
            return self._triangles

    def gaps(self, places: FloatArray) -> FloatArray:
        """Return how far each place is from the faces, or from the points of a cloud."""
        domain = self.domain
        if isinstance(domain, TriangleMesh):
            faces, weights = self.triangles.closest(places)
            feet = np.einsum("qc,qcd->qd", weights, domain.vertices[domain.faces[faces]])
        else:
            feet = domain.points[self.nearest_points(places)]
        return np.asarray(np.linalg.norm(places - feet, axis=1))

    def nearest_points(self, places: FloatArray) -> IntArray:
        """Return the point of a cloud that is nearest to each place; none that is missing."""
        from scipy.spatial import cKDTree

        assert isinstance(self.domain, PointCloud)  # for the type checker
        with self._lock:
            if self._points is None or self._present is None:
                self._present = np.flatnonzero(self.domain.present)
                self._points = cKDTree(self.domain.points[self._present])
        nearest: IntArray = self._present[self._points.query(places)[1]]
        return nearest
