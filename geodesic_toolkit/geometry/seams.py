"""Seams of a surface: boundary edges that coincide."""

from dataclasses import dataclass

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.arrays import distinct
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.geometry.components import connected_by_edges, connected_by_faces
from geodesic_toolkit.geometry.triangles import proper_faces
from geodesic_toolkit.geometry.welding import (
    edges_and_counts,
    merged_positions,
    movable_by,
    rounding_of,
)

__all__ = ["COINCIDENCE_TOLERANCE", "Seams", "find_seams"]

COINCIDENCE_TOLERANCE = 3e-5
"""Maximum distance of the two sides of a seam, relative to the diagonal of the bounding box: six
significant digits, which many programs write, leave up to 1.7e-5.

Measured on the facets of nine shapes, each corner rounded to six digits or moved by 3e-6 of the
diagonal: all nine are joined from 1e-5 to 3e-4, eight with 1e-3, not all of them with 3e-6. Up to
3e-4 there is not a warning for any of 22 models and scans, with 1e-3 there is one."""

MIN_SHARE_OF_SEAM = 0.5
"""Minimum share of coinciding edges in a loop of the boundary, or in all of it, for an open seam
with such a gap. Of 22 models and scans one, a truck assembled by hand from sheets, has such edges
without being cut apart there: 22 of a loop of 139 and 16 of one of 91."""

MAX_EDGES_OF_SHORT_LOOP = 8
"""Maximum number of edges in a loop that alone does not indicate a seam: that truck has panels of
four edges that coincide with others."""

MAX_FACES_PER_COMPONENT_OF_SOUP = 2.0
"""Maximum mean number of faces per component in a soup of unconnected faces."""


@dataclass(frozen=True)
class Seams:
    """The seams of a surface.

    Attributes
    ----------
    edges : int
        Edges of the boundary that coincide with others.
    boundary : int
        All edges of the boundary.
    tolerance : float
        Tolerance that joins them: the largest distance between a corner on a seam and the corner
        that it is merged with.
    """

    edges: int
    boundary: int
    tolerance: float

    @property
    def finding(self) -> str:
        """The finding as a sentence."""
        return (
            f"{self.edges} of the {self.boundary} edges of the boundary coincide with others: the "
            "surface is cut there, and paths do not cross"
        )

    @property
    def cure(self) -> str:
        """The advice as a sentence."""
        return (
            "merge coinciding vertices: mesh, new = geodesic_toolkit.merge_vertices(mesh, "
            f"tolerance={self.tolerance:g}), on the command line --weld {self.tolerance:g}"
        )


def find_seams(vertices: FloatArray, faces: IntArray, boundary: BoolArray) -> Seams | None:
    """Return the seams along which a mesh is cut at edges of its boundary, None without any.

    Edges that coincide to the rounding of single precision are a seam, even if they are few. With
    a gap of six digits most edges of a loop of the boundary must coincide with others, so that
    surfaces which are only near each other are excluded. In a soup of unconnected faces the gap may
    be a quarter of the edges.

    Parameters
    ----------
    vertices : ndarray of shape (N, 3)
    faces : ndarray of shape (F, 3), int64
    boundary : ndarray of shape (N,), bool
        True at least at the vertices of boundary edges.
    """
    if not boundary.any():
        return None
    rim = _Rim(vertices, faces, boundary)
    if not len(rim.edges):
        return None
    extent = _extent(vertices, faces)
    if rim.is_soup:
        joined = rim.best_joined(extent)
        if joined.coincide.sum() > MIN_SHARE_OF_SEAM * len(rim.edges):
            return rim.seams(joined)
    near = rim.joined(COINCIDENCE_TOLERANCE * extent)
    loops, coincide = np.bincount(rim.loops), np.bincount(rim.loops, near.coincide)
    cut = (coincide > MIN_SHARE_OF_SEAM * loops) & (loops > MAX_EDGES_OF_SHORT_LOOP)
    if near.coincide.sum() > MIN_SHARE_OF_SEAM * len(rim.edges) or cut.any():
        return rim.seams(near)
    same = rim.joined(rounding_of(rim.points))
    return rim.seams(same) if same.coincide.any() else None


def _extent(vertices: FloatArray, faces: IntArray) -> float:
    """Return the diagonal of the bounding box of the used vertices."""
    used = np.zeros(len(vertices), dtype=np.bool_)
    used[faces] = True
    return float(np.linalg.norm([np.ptp(column[used]) for column in vertices.T]))


@dataclass(frozen=True)
class _JoinedBoundary:
    """Merged vertices of the boundary, and a mask of its edges that then coincide with others."""

    owner: IntArray
    coincide: BoolArray


class _Rim:
    """The boundary of a mesh, with its own numbering of vertices."""

    def __init__(self, vertices: FloatArray, faces: IntArray, boundary: BoolArray) -> None:
        beside = _native.faces_at(faces, boundary)
        self._all = len(beside) == len(faces)
        around = faces[beside]
        around = around[proper_faces(around)]
        used, corners = np.unique(around, return_inverse=True)
        corners = corners.reshape(-1, 3)
        edges, counts = edges_and_counts(corners)
        # All faces at boundary vertices are included, so that an edge of one of them has one face.
        inside = boundary[used][edges].all(axis=1)
        self.edges = edges[(counts == 1) & inside]
        positions = vertices[used]
        on_rim = distinct(self.edges)
        self.points = positions[on_rim]
        self._limit = movable_by(positions, edges, rounding_of(positions))[on_rim]
        own = np.zeros(len(used), dtype=np.int64)
        own[on_rim] = np.arange(len(on_rim))
        self.edges = own[self.edges]
        self._faces, self._n_used = corners, len(used)

    @property
    def loops(self) -> IntArray:
        """The loop of the boundary that contains each edge."""
        return np.asarray(connected_by_edges(self.edges, len(self.points))[self.edges[:, 0]])

    @property
    def is_soup(self) -> bool:
        """True if almost all faces are unconnected."""
        if not self._all:
            return False
        parts = connected_by_faces(self._faces, self._n_used)
        return len(self._faces) <= MAX_FACES_PER_COMPONENT_OF_SOUP * (int(parts.max()) + 1)

    def joined(self, tolerance: float) -> _JoinedBoundary:
        """Return the boundary with vertices merged that are within the tolerance."""
        owner = merged_positions(self.points, np.minimum(self._limit, tolerance))
        ends = np.sort(owner[self.edges], axis=1)
        _, edge, counts = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
        return _JoinedBoundary(owner, (counts[edge.ravel()] > 1) & (ends[:, 0] != ends[:, 1]))

    def best_joined(self, limit: float) -> _JoinedBoundary:
        """Return the boundary joined with the smallest tolerance that joins most edges."""
        tolerance = rounding_of(self.points)
        best = self.joined(tolerance)
        while not best.coincide.all() and 0 < tolerance < limit:
            tolerance *= 10
            joined = self.joined(tolerance)
            if joined.coincide.sum() > best.coincide.sum():
                best = joined
        return best

    def seams(self, joined: _JoinedBoundary) -> Seams:
        """Return the seams of a joined boundary."""
        on_seams = distinct(joined.owner[self.edges[joined.coincide]])
        corners = np.flatnonzero(np.isin(joined.owner, on_seams))
        steps = self.points[corners] - self.points[joined.owner[corners]]
        gap = float(np.linalg.norm(steps, axis=1).max())
        return Seams(int(joined.coincide.sum()), len(self.edges), _rounded_up(gap))


def _rounded_up(length: float) -> float:
    """Return a length of two digits that is at least the given one."""
    if length == 0:
        return 0.0
    unit = 10.0 ** (np.floor(np.log10(length)) - 1)
    return float(f"{(np.floor(length / unit) + 1) * unit:.2g}")
