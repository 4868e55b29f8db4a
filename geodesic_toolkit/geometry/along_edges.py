"""The shortest path along the edges of a graph."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geodesic_toolkit.core.frozen import FrozenArrays
from geodesic_toolkit.core.near import NearRows
from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["AlongEdges", "shortest_parallel_edges"]

ROUNDING = 1e-9
"""Share by which a limit is raised, more than sums are rounded."""


@dataclass(frozen=True, eq=False)
class AlongEdges(FrozenArrays):
    """Edges with lengths, along which distance is exact by Dijkstra's algorithm.

    Parameters
    ----------
    n_vertices : int
    edges : ndarray of shape (E, 2), int64
        Distinct, without loops.
    lengths : ndarray of shape (E,), float64
        Not negative.
    instead_of_heat : str
        Reason why heat cannot measure this graph; empty if it can.

    References
    ----------
    E. W. Dijkstra, *A note on two problems in connexion with graphs*, Numerische Mathematik 1,
    1959, https://doi.org/10.1007/BF01386390

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.geometry.along_edges import AlongEdges
    >>> path = AlongEdges(3, np.array([[0, 1], [1, 2]]), np.array([1.0, 2.5]))
    >>> path.distances(np.array([0, 1]), np.array([2]), np.array([0.5]))
    array([[4. , 3. , 0.5]])
    """

    n_vertices: int
    edges: IntArray
    lengths: FloatArray
    instead_of_heat: str = ""

    @cached_property
    def matrix(self) -> Any:
        """The lengths as a symmetric csr_array of shape (N, N), zeros stored as well."""
        from scipy.sparse import coo_array, csr_array  # the import takes 0.2 s

        ends = np.concatenate([self.edges, self.edges[:, ::-1]]).T
        shape = (self.n_vertices, self.n_vertices)
        return csr_array(coo_array((np.tile(self.lengths, 2), tuple(ends)), shape=shape))

    def distances(
        self, begins: IntArray, vertices: IntArray, starts: FloatArray, limit: float = np.inf
    ) -> FloatArray:
        """Return the length of the shortest path from each of K sets of vertices.

        Parameters
        ----------
        begins : ndarray of shape (K + 1,), int64
            Index of the first vertex of each set, and P at the end.
        vertices : ndarray of shape (P,), int64
        starts : ndarray of shape (P,), float64
            Initial distance of each vertex, of any sign.
        limit : float
            Paths beyond it need not be found.

        Returns
        -------
        ndarray of shape (K, N), float64
            ``inf`` at vertices that edges do not connect to the set, and at some beyond the limit.
        """
        from scipy.sparse import csr_array
        from scipy.sparse.csgraph import dijkstra

        count, sets = self.n_vertices, np.diff(begins)
        offset = np.minimum.reduceat(starts, begins[:-1])  # Dijkstra's algorithm needs lengths >= 0
        late = starts - np.repeat(offset, sets)
        order = np.lexsort((late, vertices, np.repeat(np.arange(len(sets)), sets)))
        owner = np.repeat(np.arange(len(sets)), sets)[order]
        vertex, late = vertices[order], late[order]
        first = np.ones(len(order), dtype=np.bool_)  # SciPy would add repeated entries
        first[1:] = (owner[1:] != owner[:-1]) | (vertex[1:] != vertex[:-1])
        inner = self.matrix
        ends = np.cumsum(np.bincount(owner[first], minlength=len(sets)))
        graph = csr_array(  # with one more vertex per set, which has edges to its members only
            (
                np.concatenate([inner.data, late[first]]),
                np.concatenate([inner.indices, vertex[first].astype(inner.indices.dtype)]),
                np.concatenate([inner.indptr, inner.indptr[-1] + ends]),
            ),
            shape=(count + len(sets), count + len(sets)),
        )
        most = (limit - offset).max()
        most = max(most + ROUNDING * abs(most), 0.0)
        paths = dijkstra(graph, directed=True, indices=count + np.arange(len(sets)), limit=most)
        return np.asarray(paths[:, :count] + offset[:, None])

    def near(
        self, begins: IntArray, vertices: IntArray, starts: FloatArray, limits: FloatArray
    ) -> NearRows:
        """Return the distances up to a limit for each of K sets, (K,), to the bit as `distances`.

        Arguments are those of `distances`.
        """
        return NearRows.of_table(
            self.distances(begins, vertices, starts, float(limits.max())), limits
        )

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "matrix"}


def shortest_parallel_edges(edges: IntArray, lengths: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return distinct edges without loops, smaller vertex first, each with its smallest length."""
    ends = np.sort(edges, axis=1)
    order = np.lexsort((lengths, ends[:, 1], ends[:, 0]))
    ends, lengths = ends[order], lengths[order]
    keep = ends[:, 0] != ends[:, 1]
    keep[1:] &= (ends[1:] != ends[:-1]).any(axis=1)
    return ends[keep], lengths[keep]
