"""Places to which points in space snap: those of a kind of domain, of triangles, or vertices."""

import threading
from typing import TYPE_CHECKING

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains import Domain, Located, positions_of, triangles_of
from geodesic_toolkit.errors import UnsupportedDomainError
from geodesic_toolkit.geometry.closest import TriangleTree

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

__all__ = ["Ground", "lies_in_triangles"]


def lies_in_triangles(domain: Domain) -> bool:
    """Return True if all places of a kind of domain are in its triangles, as those of a mesh."""
    return domain.has("triangles") and not domain.has("closest")


class Ground:
    """The nearest places of one shape; the tree is built once, on first use.

    It is safe to use from several threads.

    Parameters
    ----------
    domain : Domain
        A domain with positions.
    """

    def __init__(self, domain: Domain) -> None:
        self.domain = domain
        self._positions = positions_of(domain)
        self._present: IntArray | None = None
        self._points: cKDTree | None = None
        self._triangles: TriangleTree | None = None
        self._lock = threading.Lock()

    @property
    def triangles(self) -> TriangleTree:
        """The tree of all triangles of a surface."""
        with self._lock:
            if self._triangles is None:
                self._triangles = TriangleTree(self._positions, triangles_of(self.domain))
            return self._triangles

    def closest(self, points: FloatArray) -> Located:
        """Return the places closest to points (Q, 3), by the method of the domain if it has one.

        Raises
        ------
        UnsupportedDomainError
            A kind of domain that does not return as many places as there are points.
        """
        if self.domain.has("closest"):
            return _checked(self.domain, self.domain.closest(points), len(points))
        if lies_in_triangles(self.domain):
            faces, weights = self.triangles.closest(points)
            return Located(self.domain.triangles[faces], weights)
        nearest = self.nearest_points(points)
        return Located(nearest[:, None], np.ones((len(nearest), 1)))

    def gaps(self, places: FloatArray) -> FloatArray:
        """Return the distance of each place from the shape."""
        feet = self.closest(places).positions(self.domain)
        return np.asarray(np.linalg.norm(places - feet, axis=1))

    def nearest_points(self, places: FloatArray) -> IntArray:
        """Return the nearest vertex of each place, missing ones excluded."""
        from scipy.spatial import cKDTree

        with self._lock:
            if self._points is None or self._present is None:
                usable = self.domain.present & np.isfinite(self._positions).all(axis=1)
                self._present = np.flatnonzero(usable)
                self._points = cKDTree(self._positions[self._present])
        nearest: IntArray = self._present[self._points.query(places)[1]]
        return nearest


def _checked(domain: Domain, found: object, count: int) -> Located:
    """Return the checked result of a kind of domain."""
    kind = type(domain).__name__
    if not isinstance(found, Located) or len(found) != count:
        size = f" of {len(found)} places" if isinstance(found, Located) else ""
        raise UnsupportedDomainError(
            f"{kind}.closest returned {a_kind_of(found)}{size} for {count} points; it must "
            f"return a Located of {count} places"
        )
    found.check_on(domain, f"{kind}.closest")
    return found
