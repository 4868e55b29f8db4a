"""Graphs with edge lengths."""

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.domains.base import (
    Domain,
    as_floats,
    as_indices,
    check_indices,
    first_bad_row,
)
from geodesic_toolkit.errors import InvalidDomainError, InvalidOptionError

__all__ = ["Graph"]


@final
@dataclass(frozen=True, eq=False, repr=False, init=False)
class Graph(Domain):
    """An undirected graph whose edges have lengths.

    Loops are ignored and the shortest of parallel edges is used; several components and isolated
    vertices are not errors.

    Parameters
    ----------
    n_vertices : int
        Number of vertices.
    edges : array-like of shape (E, 2)
        Two vertex indices per edge, counted from 0, in either order.
    lengths : array-like of shape (E,), optional
        Edge lengths, 0 or positive; 1 each if omitted. Vertices connected by edges of length 0 are
        one position with several indices.

    Attributes
    ----------
    edges : ndarray of shape (E, 2), int64, read-only
    lengths : ndarray of shape (E,), float64, read-only

    Raises
    ------
    InvalidDomainError
        No vertices, wrong shapes, an edge that refers to a vertex that does not exist, a length
        that is negative or not finite. The message names the first invalid entry.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.Graph(3, [[0, 1], [1, 2]])
    Graph(3 vertices, 2 edges)
    """

    edges: IntArray
    lengths: FloatArray
    _n_vertices: int

    def __init__(self, n_vertices: int, edges: ArrayLike, lengths: ArrayLike | None = None) -> None:
        if isinstance(n_vertices, bool) or not isinstance(n_vertices, int | np.integer):
            raise InvalidDomainError(f"n_vertices must be an integer, not {n_vertices!r}")
        if n_vertices > np.iinfo(np.int64).max:
            raise InvalidDomainError(f"n_vertices is {n_vertices}, more than indices can count")
        if n_vertices < 1:
            raise InvalidDomainError("the graph has no vertices")
        pairs = as_indices(edges, "edges", "edge", (None, 2))
        check_indices(pairs, int(n_vertices), "edge")
        if lengths is None:
            metric = np.ones(len(pairs))
        else:
            metric = as_floats(lengths, "lengths", (len(pairs),))
            bad = first_bad_row(np.isfinite(metric) & (metric >= 0))
            if bad is not None:
                raise InvalidDomainError(
                    f"edge {bad} has length {metric[bad]}; lengths must be finite and not negative"
                )
        self._set(_n_vertices=int(n_vertices), edges=pairs, lengths=metric)

    @property
    def n_vertices(self) -> int:
        """Number of vertices, including isolated ones."""
        return self._n_vertices

    @property
    def n_edges(self) -> int:
        """Number of edges as given."""
        return len(self.edges)

    def as_graph(self) -> "Graph":
        """Return the graph itself."""
        return self

    def without(self, mask: BoolArray) -> "Graph":
        """Return the graph without the edges of masked vertices.

        Parameters
        ----------
        mask : ndarray of shape (N,), bool

        Returns
        -------
        Graph

        Raises
        ------
        InvalidOptionError
            All vertices are masked.
        """
        if mask.all():
            raise InvalidOptionError("the mask leaves no vertices, and so no paths")
        free = ~mask[self.edges].any(axis=1)
        return Graph(self.n_vertices, self.edges[free], self.lengths[free])

    def __repr__(self) -> str:
        plural = "" if self.n_edges == 1 else "s"
        return f"Graph({self.n_vertices} vertices, {self.n_edges} edge{plural})"
