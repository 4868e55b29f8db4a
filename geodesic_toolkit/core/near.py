"""Sparse rows of distances: from each of several source sets, those of the vertices near it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["NearRows"]


class NearRows(NamedTuple):
    """K rows, each with the vertices up to a limit and their distances.

    Attributes
    ----------
    begins : ndarray of shape (K + 1,), int64
        Index of the first entry of each row, and the number of entries at the end.
    vertices : ndarray of shape (nnz,), int64
        Ascending in each row.
    distances : ndarray of shape (nnz,), float64

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.core.near import NearRows
    >>> NearRows.of_table(np.array([[0.0, 1.0, 2.0]]), np.array([1.0])).vertices
    array([0, 1])
    """

    begins: IntArray
    vertices: IntArray
    distances: FloatArray

    @classmethod
    def of_table(cls, distances: FloatArray, limits: FloatArray) -> "NearRows":
        """Return the entries of a table (K, N) up to the limit (K,) of each row."""
        kept = distances <= limits[:, None]
        rows, vertices = np.nonzero(kept)
        begins = np.searchsorted(rows, np.arange(len(distances) + 1))
        return cls(begins.astype(np.int64), vertices.astype(np.int64), distances[kept])

    @classmethod
    def together(cls, parts: Sequence["NearRows"]) -> "NearRows":
        """Return the rows of one part after those of the other."""
        if len(parts) == 1:
            return parts[0]
        counts = np.concatenate([np.diff(part.begins) for part in parts])
        return cls(
            np.concatenate([[0], np.cumsum(counts)]),
            np.concatenate([part.vertices for part in parts]),
            np.concatenate([part.distances for part in parts]),
        )

    @property
    def rows(self) -> IntArray:
        """The row of each entry, (nnz,)."""
        return np.repeat(np.arange(len(self.begins) - 1), np.diff(self.begins))

    def within(self, limits: FloatArray) -> "NearRows":
        """Return the entries up to the limit (K,) of each row."""
        counts = np.diff(self.begins)
        kept = self.distances <= np.repeat(limits, counts)
        if kept.all():
            return self
        ends = np.concatenate([[0], np.cumsum(kept)])[self.begins]
        return NearRows(ends, self.vertices[kept], self.distances[kept])

    def chosen(self, rows: IntArray) -> "NearRows":
        """Return some of the rows, in ascending order."""
        own = np.zeros(len(self.begins) - 1, dtype=np.bool_)
        own[rows] = True
        counts = np.diff(self.begins)
        kept = np.repeat(own, counts)
        begins = np.concatenate([[0], np.cumsum(counts[rows])])
        return NearRows(begins, self.vertices[kept], self.distances[kept])

    def replaced(self, rows: IntArray, others: "NearRows") -> "NearRows":
        """Return the rows with some of them, in ascending order, from other ones."""
        if not len(rows):
            return self
        source = np.zeros(len(self.begins) - 1, dtype=np.bool_)
        source[rows] = True
        kept = ~np.repeat(source, np.diff(self.begins))
        row = np.concatenate([self.rows[kept], rows[others.rows]])
        order = np.argsort(row, kind="stable")
        begins = np.searchsorted(row[order], np.arange(len(self.begins))).astype(np.int64)
        vertices = np.concatenate([self.vertices[kept], others.vertices])
        distances = np.concatenate([self.distances[kept], others.distances])
        return NearRows(begins, vertices[order], distances[order])

    def taken_from(self, representatives: IntArray) -> "NearRows":
        """Return rows in which each vertex reads the distance of its representative, (N,)."""
        members = np.argsort(representatives, kind="stable")
        sizes = np.bincount(representatives, minlength=len(representatives))
        firsts = np.cumsum(sizes) - sizes
        counts = sizes[self.vertices]
        row = np.repeat(self.rows, counts)
        position = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        vertices = members[np.repeat(firsts[self.vertices], counts) + position]
        order = np.lexsort((vertices, row))
        begins = np.searchsorted(row, np.arange(len(self.begins))).astype(np.int64)
        return NearRows(begins, vertices[order], np.repeat(self.distances, counts)[order])
