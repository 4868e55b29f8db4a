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

__all__ = ["Ground", "distinct_triangles", "lies_in_triangles"]

N_POINTS_AROUND = 20
"""Number of nearest points of a cloud among whose triangles the foot of a place is searched: as
many as a star is made of."""


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
    stars : ndarray of shape (E, 3), int64, optional
        The triangles of the stars of a cloud, and its links (i, j, j), in which places are found;
        without them, they are points of the cloud.
    """

    def __init__(self, domain: Domain, stars: IntArray | None = None) -> None:
        self.domain, self._stars = domain, stars
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
        at_points = Located(nearest[:, None], np.ones((len(nearest), 1)))
        return at_points if self._stars is None else self._within_stars(points, at_points)

    def _within_stars(self, places: FloatArray, at_points: Located) -> Located:
        """Return the closest places of the triangles around some places, or the points there."""
        assert self._stars is not None
        near = np.zeros(self.domain.n_vertices, dtype=np.bool_)
        near[self._nearest(places, N_POINTS_AROUND)] = True
        around = distinct_triangles(self._stars[near[self._stars].any(axis=1)])
        if not len(around):
            return at_points
        faces, weights = TriangleTree(self._positions, around).closest(places)
        is_link = around[faces, 1] == around[faces, 2]
        weights[:, 1] += np.where(is_link, weights[:, 2], 0.0)
        weights[is_link, 2] = 0.0
        found = Located(around[faces], weights)
        gaps, gaps_of_points = (
            np.linalg.norm(places - located.positions(self.domain), axis=1)
            for located in (found, at_points)
        )
        kept = (gaps_of_points <= gaps)[:, None]  # at points, and where there are no triangles
        weight_of_first = np.array([1.0, 0.0, 0.0])
        return Located(
            np.where(kept, at_points.vertices, found.vertices),
            np.where(kept, weight_of_first, found.weights),
        )

    def gaps(self, places: FloatArray) -> FloatArray:
        """Return the distance of each place from the shape."""
        feet = self.closest(places).positions(self.domain)
        return np.asarray(np.linalg.norm(places - feet, axis=1))

    def nearest_points(self, places: FloatArray) -> IntArray:
        """Return the nearest vertex of each place, missing ones excluded."""
        return self._nearest(places, 1)[:, 0]

    def _nearest(self, places: FloatArray, count: int) -> IntArray:
        """Return the nearest vertices of each of Q places, (Q, count), or all if they are fewer."""
        from scipy.spatial import cKDTree

        with self._lock:
            if self._points is None or self._present is None:
                usable = self.domain.present & np.isfinite(self._positions).all(axis=1)
                self._present = np.flatnonzero(usable)
                self._points = cKDTree(self._positions[self._present])
        ranks = np.arange(1, min(count, len(self._present)) + 1)
        nearest: IntArray = self._present[self._points.query(places, k=ranks)[1]]
        return nearest


def distinct_triangles(elements: IntArray) -> IntArray:
    """Return the different triangles of stars, which neighbours share, with sorted vertices.

    Parameters
    ----------
    elements : ndarray of shape (E, 3), int64
        Triangles, and links (i, j, j) between two points.

    Returns
    -------
    ndarray of shape (F, 3), int64
        A link has its last two vertices equal.
    """
    small = np.int32 if elements.size == 0 or elements.max() < 2**31 else np.int64
    ordered = np.sort(elements.astype(small), axis=1)
    ordered = ordered[np.lexsort(ordered.T)]
    new = np.ones(len(ordered), dtype=np.bool_)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    triangles = ordered[new].astype(np.int64)
    twice = triangles[:, 0] == triangles[:, 1]
    triangles[twice] = triangles[twice][:, ::-1]
    surface: IntArray = triangles[triangles[:, 0] != triangles[:, 1]]
    return surface


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
