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
    merged_places,
    movable_by,
    rounding_of,
)

__all__ = ["COINCIDENCE_TOLERANCE", "Seams", "find_seams"]

COINCIDENCE_TOLERANCE = 3e-5
"""How far apart the sides of a seam may lie, over the diagonal of the bounding box: six significant
digits, as many programs write numbers, leave up to 1.7e-5.

Measured on the facets of nine shapes, each corner rounded to six digits or moved by 3e-6 of the
diagonal: all nine are whole again from 1e-5 to 3e-4, eight with 1e-3, not all of them with 3e-6. Up
to 3e-4 none of 22 models and scans is warned of, with 1e-3 one."""

MIN_SHARE_OF_SEAM = 0.5
"""Share of a loop of the boundary, or of all of it, that lies upon other edges where it is a seam
that has come open by so much. Of 22 models and scans one, a truck of sheets put together by hand,
has such edges without being cut apart there: 22 of a loop of 139 and 16 of one of 91."""

MAX_EDGES_OF_SHORT_LOOP = 8
"""Edges of a loop up to which it does not tell by itself: that truck has panels of four that lie
upon other ones."""

MAX_FACES_PER_COMPONENT_OF_SOUP = 2.0
"""Faces of a connected part, in the mean, up to which a mesh is a soup that nothing connects."""


@dataclass(frozen=True)
class Seams:
    """The seams of a surface.

    Attributes
    ----------
    edges : int
        Edges of the boundary that lie upon others.
    boundary : int
        All edges of the boundary.
    tolerance : float
        What joins them: no corner on a seam lies farther from the one that it becomes.
    """

    edges: int
    boundary: int
    tolerance: float

    @property
    def finding(self) -> str:
        """The finding as a sentence."""
        return (
            f"{self.edges} of the {self.boundary} edges of the boundary lie upon others: the "
            "surface is cut there, and no path crosses"
        )

    @property
    def cure(self) -> str:
        """The advice as a sentence."""
        return (
            "merge what lies together: mesh, new = geodesic_toolkit.merge_vertices(mesh, "
            f"tolerance={self.tolerance:g}), on the command line --weld {self.tolerance:g}"
        )


def find_seams(vertices: FloatArray, faces: IntArray, boundary: BoolArray) -> Seams | None:
    """Return where a mesh is cut apart along edges of its boundary, None where it is not.

    Edges that lie upon each other to the rounding of single precision are a seam, be they few. With
    a gap of six digits most of a loop of the boundary must lie upon other edges, so that surfaces
    which only come near do not count. In a soup, where nothing is connected, the gap may be a
    quarter of the edges.

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
        if joined.upon.sum() > MIN_SHARE_OF_SEAM * len(rim.edges):
            return rim.seams(joined)
    near = rim.joined(COINCIDENCE_TOLERANCE * extent)
    loops, upon = np.bincount(rim.loops), np.bincount(rim.loops, near.upon)
    cut = (upon > MIN_SHARE_OF_SEAM * loops) & (loops > MAX_EDGES_OF_SHORT_LOOP)
    if near.upon.sum() > MIN_SHARE_OF_SEAM * len(rim.edges) or cut.any():
        return rim.seams(near)
    same = rim.joined(rounding_of(rim.points))
    return rim.seams(same) if same.upon.any() else None


def _extent(vertices: FloatArray, faces: IntArray) -> float:
    """Return the diagonal of the bounding box of what faces use."""
    used = np.zeros(len(vertices), dtype=np.bool_)
    used[faces] = True
    return float(np.linalg.norm([np.ptp(column[used]) for column in vertices.T]))


@dataclass(frozen=True)
class _Joined:
    """Vertices of the boundary made one, and which of its edges lie upon others then."""

    owner: IntArray
    upon: BoolArray


class _Rim:
    """The boundary of a mesh, in vertices of its own."""

    def __init__(self, vertices: FloatArray, faces: IntArray, boundary: BoolArray) -> None:
        beside = _native.faces_at(faces, boundary)
        self._all = len(beside) == len(faces)
        around = faces[beside]
        around = around[proper_faces(around)]
        used, corners = np.unique(around, return_inverse=True)
        corners = corners.reshape(-1, 3)
        edges, counts = edges_and_counts(corners)
        # An edge that has one of these faces alone has no other face: those were taken in too.
        inside = boundary[used][edges].all(axis=1)
        self.edges = edges[(counts == 1) & inside]
        places = vertices[used]
        on_rim = distinct(self.edges)
        self.points = places[on_rim]
        self._limit = movable_by(places, edges, rounding_of(places))[on_rim]
        own = np.zeros(len(used), dtype=np.int64)
        own[on_rim] = np.arange(len(on_rim))
        self.edges = own[self.edges]
        self._faces, self._n_used = corners, len(used)

    @property
    def loops(self) -> IntArray:
        """The loop of the boundary that each edge is in."""
        return np.asarray(connected_by_edges(self.edges, len(self.points))[self.edges[:, 0]])

    @property
    def is_soup(self) -> bool:
        """Return whether hardly any face is connected to another face."""
        if not self._all:
            return False
        parts = connected_by_faces(self._faces, self._n_used)
        return len(self._faces) <= MAX_FACES_PER_COMPONENT_OF_SOUP * (int(parts.max()) + 1)

    def joined(self, tolerance: float) -> _Joined:
        """Return the boundary with vertices made one that are no farther apart."""
        owner = merged_places(self.points, np.minimum(self._limit, tolerance))
        ends = np.sort(owner[self.edges], axis=1)
        _, edge, counts = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
        return _Joined(owner, (counts[edge.ravel()] > 1) & (ends[:, 0] != ends[:, 1]))

    def best_joined(self, most: float) -> _Joined:
        """Return the same with the first tolerance, of each power of ten, that joins most edges."""
        tolerance = rounding_of(self.points)
        best = self.joined(tolerance)
        while not best.upon.all() and 0 < tolerance < most:
            tolerance *= 10
            joined = self.joined(tolerance)
            if joined.upon.sum() > best.upon.sum():
                best = joined
        return best

    def seams(self, joined: _Joined) -> Seams:
        """Return what is to be said of edges that lie upon others."""
        on_seams = distinct(joined.owner[self.edges[joined.upon]])
        corners = np.flatnonzero(np.isin(joined.owner, on_seams))
        steps = self.points[corners] - self.points[joined.owner[corners]]
        gap = float(np.linalg.norm(steps, axis=1).max())
        return Seams(int(joined.upon.sum()), len(self.edges), _rounded_up(gap))


def _rounded_up(length: float) -> float:
    """Return a length of two digits that is no less than the given one."""
    if length == 0:
        return 0.0
    unit = 10.0 ** (np.floor(np.log10(length)) - 1)
    return float(f"{(np.floor(length / unit) + 1) * unit:.2g}")
