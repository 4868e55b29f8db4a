"""Sources as convex combinations of vertices: what the heat method starts from."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array

from geodesic_toolkit._typing import FloatArray, IntArray
from geodesic_toolkit.discretization import Discretization
from geodesic_toolkit.errors import InvalidSourceError

__all__ = ["SourcePoints", "as_vertices"]


@dataclass(frozen=True)
class SourcePoints:
    """A set of sources as convex combinations of vertices.

    Attributes
    ----------
    weights : csr_array of shape (P, N)
        One row a point: its barycentric weights on the vertices around it.
    distances : ndarray of shape (nnz,), float64
        How far the point is from each of those vertices, in the order of ``weights.data``; 0 for a
        point at a vertex.
    """

    weights: csr_array
    distances: FloatArray

    @classmethod
    def at_vertices(cls, vertices: IntArray, n_vertices: int) -> "SourcePoints":
        """Return sources at vertices."""
        count = len(vertices)
        entries = (np.ones(count), (np.arange(count), vertices))
        weights = csr_array(coo_array(entries, shape=(count, n_vertices)))
        return cls(weights, np.zeros(count))

    @property
    def offsets(self) -> FloatArray:
        """The (P,) distances of the points from their vertices, in the weighted mean."""
        rows = np.repeat(np.arange(self.weights.shape[0]), np.diff(self.weights.indptr))
        sums = np.bincount(rows, self.weights.data * self.distances, self.weights.shape[0])
        return np.asarray(sums, dtype=np.float64)

    def components(self, discretization: Discretization) -> IntArray:
        """Return the connected component that each point lies in, of shape (P,)."""
        first = self.weights.indices[self.weights.indptr[:-1]]
        return discretization.components[first]


def as_vertices(sources: Any, n_vertices: int, name: str = "sources") -> IntArray:
    """Return `sources` as a one-dimensional array of vertex indices, checked.

    Raises
    ------
    InvalidSourceError
        None at all, something that is not an integer, an index out of range.
    """
    try:
        array = np.atleast_1d(np.asarray(sources))
    except (ValueError, TypeError) as error:
        raise InvalidSourceError(f"{name} cannot be read as indices: {error}") from error
    if array.size == 0:
        raise InvalidSourceError(f"{name}: there are none; give at least one vertex")
    if array.dtype.kind not in "iu" or array.ndim != 1:
        raise InvalidSourceError(
            f"{name} must be vertex indices, one integer or a one-dimensional array of them, "
            f"not {array.dtype} of shape {np.shape(sources)}"
        )
    outside = (array < 0) | (array >= n_vertices)
    if outside.any():
        raise InvalidSourceError(
            f"{name}: vertex {array[outside][0]} does not exist; there are {n_vertices}, "
            "numbered from 0"
        )
    return np.asarray(array, dtype=np.int64)
