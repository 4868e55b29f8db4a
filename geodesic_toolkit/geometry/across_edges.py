"""Distances across the edges of a graph, by fronts through its corners.

A corner is two edges of a vertex whose ends are known to be how far apart: a triangle of the graph,
or a quadrangle that it leaves empty, which is laid out in the plane so that its area is the
largest. A rectangle of voxels is that as well, and what is parallel or at right angles in a lattice
follows from its rectangles. Vertices are settled from the nearest to the farthest, as in Dijkstra's
algorithm; each reads the shortest of the paths along its edges and of those that a front takes
straight across its corners.

Where noise lengthens the edges between samples of a surface, that is taken off for the most part,
unless triangles overlap so much that the shortest of many ways is short by itself.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.frozen import FrozenArrays
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.geometry.noise import squared_noise
from geodesic_toolkit.geometry.threads import threads_for

__all__ = ["MIN_GROWTH_OF_SOLIDS", "OF_TRIANGLES", "AcrossEdges"]

OF_TRIANGLES = 0.5
"""Share of the edges that triangles surround above which most corners are of overlapping triangles.
Neighbour graphs have 0.8 and more; lattices have 0, and meshes of triangles their rim, 0 to 0.3.
"""

MIN_GROWTH_OF_SOLIDS = 3.5
"""Vertices within two edges for each neighbour, above which a graph samples a solid. Neighbour
graphs of squares, rolls and spheres have 2.8 to 3.4, edges of meshes 3.1 to 3.4; neighbour graphs
of cubes 3.6 to 4.4, tetrahedra 4.7 to 5.5.
"""

DENSE, THIN = 0.99, 0.94
"""Share of the edges that triangles surround, between which noise is taken off less and less. They
surround 90 % with 8 neighbours in the plane, 95.5 % with 10, 98 % with 12 and 99.3 % with 15. Found
on squares, spheres and rolls of 500 and 2,500 samples with noise of 0, 0.05, 0.1 and 0.15 mean
distances in ten dimensions: mean errors are 0 to 6 %. With 0.93 and 0.98, or 0.92 and 0.99, they
are up to 2 % larger.
"""

MIN_SHARE_OF_LENGTH = 0.5
"""Part of its length that an edge keeps."""


@dataclass(frozen=True, eq=False)
class AcrossEdges(FrozenArrays):
    """A graph whose corners fronts cross.

    Parameters
    ----------
    n_vertices : int
    edges : ndarray of shape (E, 2), int64
        Each once, without loops.
    lengths : ndarray of shape (E,), float64
        Positive.
    representatives : ndarray of shape (N,), int64
        The vertex whose distance each vertex reads; empty where that is its own.

    References
    ----------
    R. Kimmel, J. A. Sethian, *Computing geodesic paths on manifolds*, PNAS 95, 1998,
    https://doi.org/10.1073/pnas.95.15.8431

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.geometry.across_edges import AcrossEdges
    >>> square = AcrossEdges(4, np.array([[0, 1], [0, 2], [1, 3], [2, 3]]), np.ones(4))
    >>> square.distances(np.array([0, 1]), np.array([0]), np.zeros(1)).round(3)
    array([[0.   , 1.   , 1.   , 1.414]])
    """

    n_vertices: int
    edges: IntArray
    lengths: FloatArray
    representatives: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    @property
    def corners(self) -> _native.GraphCorners:
        """The corners, found when they, or `noise`, are first asked for."""
        return self._corners_and_noise[0]

    @property
    def noise(self) -> float:
        """The correction that is subtracted from squared edge lengths, relative to their median."""
        return self._corners_and_noise[1]

    @cached_property
    def _corners_and_noise(self) -> tuple[_native.GraphCorners, float]:
        corners = _native.GraphCorners(self.n_vertices, self.edges, self.lengths)
        taken = float(np.clip((DENSE - corners.closed) / (DENSE - THIN), 0, 1))
        if (
            corners.lattice
            or corners.growth > MIN_GROWTH_OF_SOLIDS
            or not taken
            or corners.closed < OF_TRIANGLES
        ):
            return corners, 0.0
        off = taken * squared_noise(self.n_vertices, self.edges, self.lengths)
        if not off:
            return corners, 0.0
        shorter = np.sqrt(
            np.maximum(self.lengths**2 - off, (MIN_SHARE_OF_LENGTH * self.lengths) ** 2)
        )
        noise = off / float(np.median(self.lengths**2))
        return _native.GraphCorners(self.n_vertices, self.edges, shorter), noise

    def distances(self, begins: IntArray, vertices: IntArray, starts: FloatArray) -> FloatArray:
        """Return the distance from each of K sets of vertices, (K, N).

        Arguments are those of `AlongEdges.distances`; nothing is above what that returns.
        """
        others = self.representatives
        moved = others[vertices] if len(others) else vertices
        distances = np.empty((len(begins) - 1, self.n_vertices))
        self.corners.cross(
            np.ascontiguousarray(begins, dtype=np.int64),
            np.ascontiguousarray(moved, dtype=np.int64),
            np.ascontiguousarray(starts, dtype=np.float64),
            distances,
            threads_for(distances.size),
        )
        return distances[:, others] if len(others) else distances

    def __getstate__(self) -> dict[str, Any]:
        return {
            name: value for name, value in self.__dict__.items() if name != "_corners_and_noise"
        }
