"""Connected components, numbered by their first vertices."""

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.rows import CompressedRows
from geodesic_toolkit.core.types import IntArray

__all__ = ["connected_by_edges", "connected_by_faces", "connected_vertices"]


def connected_vertices(matrix: CompressedRows) -> IntArray:
    """Return the connected component of every vertex, of shape (N,), numbered from 0.

    Parameters
    ----------
    matrix : CompressedRows of shape (N, N)
        Its entries, whatever their values, are the edges; entries on one side of the diagonal are
        enough.
    """
    return _native.components(matrix.indptr, matrix.indices)


def connected_by_edges(edges: IntArray, n_vertices: int) -> IntArray:
    """Return the component of every vertex, (N,), of a graph with the given edges, (E, 2).

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.geometry.components import connected_by_edges
    >>> connected_by_edges(np.array([[0, 3], [1, 2]]), 5).tolist()
    [0, 1, 1, 0, 2]
    """
    return _native.components_of_edges(np.ascontiguousarray(edges, dtype=np.int64), n_vertices)


def connected_by_faces(faces: IntArray, n_vertices: int) -> IntArray:
    """Return the component of every vertex, (N,), of a mesh with the given faces, (F, 3)."""
    return connected_by_edges(np.concatenate([faces[:, :2], faces[:, 1:]]), n_vertices)
