"""Normals of points connected by edges, and their orientation."""

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.geometry.components import connected_by_edges

__all__ = ["normals_from_edges", "oriented_normals"]


def normals_from_edges(
    points: FloatArray, edges: IntArray, weights: FloatArray | None = None
) -> FloatArray:
    """Return the direction in which the neighbours of each point extend least, of shape (N, 3).

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
        Finite.
    edges : ndarray of shape (E, 2), int64
    weights : ndarray of shape (E,), float64, optional
        Weight of each edge; equal unless given.

    Returns
    -------
    ndarray of shape (N, 3), float64
        Unit vectors of any sign.
    """
    steps = points[edges[:, 1]] - points[edges[:, 0]]
    lengths = np.linalg.norm(steps, axis=1, keepdims=True)
    np.divide(steps, lengths, out=steps, where=lengths > 0)
    if weights is not None:
        steps *= np.sqrt(weights)[:, None]
    spread = np.empty((len(points), 3, 3))
    for row in range(3):
        for column in range(3):
            product = np.repeat(steps[:, row] * steps[:, column], 2)
            spread[:, row, column] = np.bincount(edges.ravel(), product, len(points))
    normals: FloatArray = np.ascontiguousarray(np.linalg.eigh(spread)[1][:, :, 0])
    return normals


def oriented_normals(points: FloatArray, normals: FloatArray, edges: IntArray) -> FloatArray:
    """Return normals with consistent signs along a minimum spanning tree of the edges.

    The tree prefers neighbours with similar normals. The normal at the highest point of each
    component points up, so that the normals of closed surfaces point outwards.

    Parameters
    ----------
    points, normals : ndarray of shape (N, 3), float64
    edges : ndarray of shape (E, 2), int64

    Returns
    -------
    ndarray of shape (N, 3), float64

    References
    ----------
    H. Hoppe, T. DeRose, T. Duchamp, J. McDonald, W. Stuetzle, *Surface Reconstruction from
    Unorganized Points*, 1992, https://doi.org/10.1145/133994.134011

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.geometry.normals import oriented_normals
    >>> points = np.array([[0.0, 0, 0], [1, 0, 0]])
    >>> oriented_normals(points, np.array([[0.0, 0, -1], [0, 0, 1]]), np.array([[0, 1]]))[:, 2]
    array([1., 1.])
    """
    from scipy.sparse import coo_array, csr_array
    from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

    count, part = len(points), connected_by_edges(edges, len(points))
    by_height = np.lexsort((points[:, 2], part))
    part = part[by_height]
    tops = by_height[np.append(part[1:] != part[:-1], True)]
    key = np.unique(edges.min(axis=1) * count + edges.max(axis=1))
    tails, heads = np.divmod(key, count)
    # Differences lie between 1 and 2, because an entry of 0 is not an edge.
    unlike = 2 - np.abs(np.einsum("ed,ed->e", normals[tails], normals[heads]))
    # One more vertex, above the others, joins all components in one tree.
    rows, columns = np.append(tails, tops), np.append(heads, np.full(len(tops), count))
    weights = np.append(unlike, np.ones(len(tops)))
    graph = csr_array(coo_array((weights, (rows, columns)), shape=(count + 1, count + 1)))
    _, before = breadth_first_order(minimum_spanning_tree(graph), count, directed=False)
    before[count] = count
    upward = np.concatenate([normals, [[0.0, 0.0, 1.0]]])
    agree = np.where(np.einsum("nd,nd->n", upward, upward[before]) < 0, -1.0, 1.0)
    while (before != count).any():  # each round doubles the height over which signs are multiplied
        agree, before = agree * agree[before], before[before]
    return np.asarray(normals * agree[:count, None])
