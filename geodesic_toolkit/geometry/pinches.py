"""Vertices where sheets of a surface meet in a single point, and the surface cut apart there."""

import numpy as np

from geodesic_toolkit._typing import IntArray
from geodesic_toolkit.geometry.components import connected_by_edges

__all__ = ["cut_pinches"]


def cut_pinches(faces: IntArray, n_vertices: int) -> tuple[IntArray, IntArray]:
    """Return the faces with a vertex of its own for each fan around a vertex.

    A fan are the faces around a vertex that hang together by edges. Most vertices have one; where
    there are several, the surface is pinched to a point, and the faces of all but one of them get
    copies of the vertex.

    Parameters
    ----------
    faces : ndarray of shape (F, 3), int64
        Each with three different vertices.
    n_vertices : int

    Returns
    -------
    faces : ndarray of shape (F, 3), int64
        The old vertices keep their numbers, the copies follow them.
    origin : ndarray of shape (N + C,), int64
        The old vertex of each.

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.geometry.pinches import cut_pinches
    >>> faces, origin = cut_pinches(np.array([[0, 1, 2], [2, 3, 4]]), 5)
    >>> faces.tolist(), origin.tolist()
    ([[0, 1, 2], [5, 3, 4]], [0, 1, 2, 3, 4, 2])
    """
    fans = _fans(faces)
    vertex = faces.ravel()
    _, first = np.unique(fans, return_index=True)
    owners = vertex[first]  # the old vertex of each fan
    order = np.argsort(owners, kind="stable")
    repeated = np.concatenate([[False], owners[order][1:] == owners[order][:-1]])
    numbers = owners.copy()
    numbers[order[repeated]] = n_vertices + np.arange(repeated.sum())
    origin = np.concatenate([np.arange(n_vertices), owners[order[repeated]]])
    return numbers[fans].reshape(faces.shape), origin


def _fans(faces: IntArray) -> IntArray:
    """Return the fan that each corner belongs to, of shape (3F,), numbered from 0."""
    corners = np.arange(faces.size).reshape(faces.shape)
    tail, head = corners.ravel(), corners[:, [1, 2, 0]].ravel()
    vertex = faces.ravel()
    turned = vertex[tail] > vertex[head]
    low, high = np.where(turned, head, tail), np.where(turned, tail, head)
    order = np.lexsort((vertex[high], vertex[low]))
    low, high = low[order], high[order]
    same = (vertex[low][1:] == vertex[low][:-1]) & (vertex[high][1:] == vertex[high][:-1])
    one = np.concatenate([low[:-1][same], high[:-1][same]])
    other = np.concatenate([low[1:][same], high[1:][same]])
    return connected_by_edges(np.column_stack([one, other]), faces.size)
