"""Shortest paths along the edges of a graph, or of another domain that has edges."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import dijkstra

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains import Domain, Graph, graph_of, positions_of
from geodesic_toolkit.errors import UnreachableError
from geodesic_toolkit.geometry.along_edges import shortest_parallel_edges
from geodesic_toolkit.solver.solver import GeodesicSolver
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["EdgePath", "path_along_edges"]


@dataclass(frozen=True, eq=False)
class EdgePath:
    """A shortest path along edges, from source to target.

    Attributes
    ----------
    domain : Domain
    vertices : ndarray of shape (P,), int64
        In order; an edge leads from each to the next.
    lengths : ndarray of shape (P - 1,), float64
        Lengths of these edges, in the unit of the domain.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> ring = gt.Graph(4, [[0, 1], [1, 2], [2, 3], [3, 0]], [1.0, 1.0, 1.0, 5.0])
    >>> path = gt.geodesic_path(gt.GeodesicSolver(ring), 0, 3)
    >>> path, path.vertices
    (EdgePath(4 vertices, length 3), array([0, 1, 2, 3]))
    """

    domain: Domain
    vertices: IntArray
    lengths: FloatArray

    @property
    def length(self) -> float:
        """Length of the path, in the unit of the domain."""
        return float(self.lengths.sum())

    @cached_property
    def points(self) -> FloatArray:
        """The (P, 3) positions of the vertices.

        Raises
        ------
        UnsupportedDomainError
            The domain has no positions: it is a graph.
        """
        return positions_of(self.domain)[self.vertices]

    def __repr__(self) -> str:
        return f"EdgePath({len(self.vertices)} vertices, length {self.length:.6g})"


def path_along_edges(solver: GeodesicSolver, sources: SourcePoints, goal: SourcePoints) -> EdgePath:
    """Return the shortest path along edges from the nearest source to a goal.

    If a source or the goal is between vertices, the path ends at the vertex for which it is
    shortest, including the straight line to that vertex.

    Parameters
    ----------
    solver : GeodesicSolver
        Of a domain with edges.
    sources, goal : SourcePoints
        The goal is a single one.

    Returns
    -------
    EdgePath

    Raises
    ------
    UnsupportedDomainError
        The domain has no edges.
    UnreachableError
        No edge connects the goal with a source.
    """
    domain, outside = solver.domain, solver.domain.n_vertices
    lengths_with_sources = _with_sources(graph_of(solver.passable), sources)
    distance, before = dijkstra(
        lengths_with_sources, directed=True, indices=np.array(outside), return_predecessors=True
    )
    last = int(goal.vertices[np.argmin(distance[goal.vertices] + goal.distances)])
    if not np.isfinite(distance[last]):
        raise UnreachableError(
            f"no edge connects the target with a source: {domain.vertex_name} {last} lies in "
            "another component, or behind masked vertices"
        )
    found = [last]
    while before[found[-1]] != outside:
        found.append(int(before[found[-1]]))
    vertices = np.array(found[::-1], dtype=np.int64)
    steps = [lengths_with_sources[start, end] for start, end in pairwise(vertices.tolist())]
    return EdgePath(domain, vertices, np.array(steps, dtype=np.float64))


def _with_sources(graph: Graph, sources: SourcePoints) -> csr_array:
    """Return the edge lengths, with an extra row for the offsets of the sources' vertices."""
    edges, lengths = shortest_parallel_edges(graph.edges, graph.lengths)
    offsets = sources.starts[sources.rows] + sources.distances
    order = np.argsort(offsets, kind="stable")
    vertices, first = np.unique(sources.vertices[order], return_index=True)
    count = graph.n_vertices
    starts = np.column_stack([np.full_like(vertices, count), vertices])
    ends = np.concatenate([edges, edges[:, ::-1], starts])
    weights = np.concatenate([lengths, lengths, offsets[order][first]])
    return csr_array(coo_array((weights, tuple(ends.T)), shape=(count + 1, count + 1)))
