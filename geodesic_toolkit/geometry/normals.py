"""Normals of points that edges connect, and their orientation."""

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
        How much each edge counts; all the same unless given.

    Returns
    -------
    ndarray of shape (N, 3), float64
        Of length 1 and of any sign.
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
    """Return normals with the signs that agree along a minimum spanning tree of the edges.

    Neighbours whose normals are alike come first. The highest point of each connected part looks
    up, so that the normals of closed surfaces point outwards.

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
    >>> oriented_normals(points, np.array([[0.0, 0, -1], [0, 0, 1]]), np.array([[0, 1]]))
    array([[0., 0., 1.],
           [0., 0., 1.]])
    """
    from scipy.sparse import coo_array, csr_array
    from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

    count, part = len(points), connected_by_edges(edges, len(points))
    by_height = np.lexsort((points[:, 2], part))
    part = part[by_height]
    tops = by_height[np.append(part[1:] != part[:-1], True)]
    key = np.unique(edges.min(axis=1) * count + edges.max(axis=1))
    tails, heads = np.divmod(key, count)
    unlike = 2 - np.abs(
        np.einsum("ed,ed->e", normals[tails], normals[heads])
    )  # an entry of 0 is not an edge
    # One more vertex, above the others, makes one tree of all parts.
    rows, columns = np.append(tails, tops), np.append(heads, np.full(len(tops), count))
    weights = np.append(unlike, np.ones(len(tops)))
    graph = csr_array(coo_array((weights, (rows, columns)), shape=(count + 1, count + 1)))
    _, before = breadth_first_order(minimum_spanning_tree(graph), count, directed=False)
    before[count] = count
    upward = np.concatenate([normals, [[0.0, 0.0, 1.0]]])
    agree = np.where(np.einsum("nd,nd->n", upward, upward[before]) < 0, -1.0, 1.0)
    while (before != count).any():  # each round doubles how far up the tree signs are multiplied
        agree, before = agree * agree[before], before[before]
    return np.asarray(normals * agree[:count, None])
