"""Exact distances on triangles in space: on a whole mesh, or on its small components.

Sweeps over triangles keep the distance and the curvature of one front at each vertex. On a cube of
twelve triangles two fronts, which crossed different faces, meet within every face, without a vertex
between them. There windows are exact, and take a similar time.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains import Domain, TriangleMesh
from geodesic_toolkit.errors import SolverError
from geodesic_toolkit.geometry.triangles import proper_faces
from geodesic_toolkit.sources.points import SourcePoints

__all__ = [
    "MOST_FACES",
    "MOST_FACES_OF_SUBDIVISIONS",
    "SmallParts",
    "exact_distances",
    "small_parts_of",
]

MOST_FACES = 500
"""Faces of a component up to which its distances are exact by default.

A source takes 0.04 ms of windows at 12 faces, 0.3 at 200, 0.5 to 1 at 500 and 2 to 3 at 1,500;
refined distances take 0.2 to 0.5. Refined distances on boxes, cylinders, the regular polyhedra and
hulls of random points are off by up to 14 % of the largest distance at 12 to 50 faces, up to 4.4 %
at 50 to 200, and up to 2 % beyond 500; on average up to 1.8, 1.0 and 0.3 %.
"""

MOST_FACES_OF_SUBDIVISIONS = 2 * MOST_FACES
"""The same of a subdivision: a quadrangle is two triangles where it is split, and four with a
vertex inside, and what is exact as the one is exact as the other."""

MOST_WINDOWS = 1000
"""Windows per face after which the search stops, so that it is bounded.

Regular shapes and hulls have 5 to 15, meshes of 100,000 faces up to 90.
"""


def exact_distances(shape: _native.Polyhedron, points: SourcePoints, most: int) -> FloatArray:
    """Return the exact distance of every vertex of a polyhedron, (N,), from the nearest point.

    Raises
    ------
    SolverError
        After more than `most` windows.
    """
    distances = shape.distances(
        points.begins,
        np.ascontiguousarray(points.vertices),
        np.ascontiguousarray(points.shares),
        np.ascontiguousarray(points.distances),
        np.ascontiguousarray(points.starts),
        most,
    )
    if distances is None:
        raise SolverError(
            f"exact distances were not found with {most} windows; refine=True takes a few "
            "milliseconds, with an error of half a per cent"
        )
    return distances


@dataclass(frozen=True, eq=False)
class SmallParts:
    """The components of a mesh that have few faces, with their own numbering.

    Parameters
    ----------
    vertices : ndarray of shape (M, 3), float64
        Vertices of these components.
    faces : ndarray of shape (E, 3), int64
    numbers : ndarray of shape (N,), int64
        The row in `vertices` of every vertex of the mesh; -1 in larger components.
    """

    vertices: FloatArray
    faces: IntArray
    numbers: IntArray

    def fill(self, distances: FloatArray, block: Sequence[SourcePoints]) -> None:
        """Overwrite distances (K, N) by exact ones in small components with a source.

        Distances from curves are not changed, because their fronts are not those of points.
        """
        for row, points in zip(distances, block, strict=True):
            if not self.has(points):
                continue
            own = self._own(points)
            exact = exact_distances(self.shape, own, MOST_WINDOWS * len(self.faces))
            reached = self._members[np.isfinite(exact)]
            row[reached] = exact[self.numbers[reached]]

    def has(self, points: SourcePoints) -> bool:
        """Return True if distances from a source set are exact on some component."""
        if points.front_curvatures is not None:
            return False
        return bool((self.numbers[points.first_vertices] >= 0).any())

    def _own(self, points: SourcePoints) -> SourcePoints:
        """Return the points on small components, in the numbering of these."""
        inside = self.numbers[points.first_vertices] >= 0
        entries = inside[points.rows]
        return SourcePoints(
            vertices=self.numbers[points.vertices[entries]],
            shares=points.shares[entries],
            begins=np.append(0, np.cumsum(np.diff(points.begins)[inside])),
            n_vertices=len(self.vertices),
            distances=points.distances[entries],
            starts=points.starts[inside],
        )

    @cached_property
    def shape(self) -> _native.Polyhedron:
        """The faces in the layout of the window kernel."""
        return _native.Polyhedron(self.vertices, self.faces)

    @cached_property
    def _members(self) -> IntArray:
        """The vertices of the mesh in these components, (M,), in their own order."""
        return np.flatnonzero(self.numbers >= 0)

    def __reduce__(self) -> tuple[Any, ...]:
        return SmallParts, (self.vertices, self.faces, self.numbers)


def small_parts_of(
    domain: Domain, components: IntArray, most: int = MOST_FACES
) -> SmallParts | None:
    """Return the components of a mesh with few faces; None without any.

    Parameters
    ----------
    domain : Domain
    components : ndarray of shape (N,), int64
        The connected component of every vertex.
    most : int
        Faces that a small part has at most.
    """
    if not isinstance(domain, TriangleMesh):
        return None
    sizes = np.bincount(components[domain.faces[:, 0]], minlength=components.max() + 1)
    if not ((sizes > 0) & (sizes <= 2 * most)).any():  # faces may be repeated
        return None
    faces = domain.faces[proper_faces(domain.faces)]
    part = components[faces[:, 0]]
    sizes = np.bincount(part, minlength=len(sizes))
    small = (sizes > 0) & (sizes <= most)
    faces = faces[small[part]]
    if not len(faces):
        return None
    members = np.zeros(len(components), dtype=np.bool_)
    members[faces] = True
    numbers = np.where(members, np.cumsum(members) - 1, -1)
    return SmallParts(domain.vertices[members], numbers[faces], numbers)
