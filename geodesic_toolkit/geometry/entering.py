"""Distances inside triangles from one or two known corners, by unfolding into the plane."""

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["entered"]


def entered(
    positions: FloatArray, values: FloatArray, faces: IntArray, points: FloatArray
) -> FloatArray:
    """Return the distance at points in triangles, from the corners that have a distance.

    Between two such corners the front is that of a virtual source behind their edge, at the given
    distances from both; otherwise the path leads through a corner.

    Parameters
    ----------
    positions : ndarray of shape (N, 3)
    values : ndarray of shape (N,)
        Infinite at corners without a distance.
    faces : ndarray of shape (Q, 3), int64
    points : ndarray of shape (Q, 3)
        One in each face.

    Returns
    -------
    ndarray of shape (Q,)
        Infinite if all three corners are.

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.geometry.entering import entered
    >>> positions = np.array([[3.0, 0, 0], [3, 4, 0], [4, 2, 0]])
    >>> values = np.array([3.0, 5.0, np.inf])  # from the origin
    >>> entered(positions, values, np.array([[0, 1, 2]]), positions[2:]).round(6)
    array([4.472136])
    """
    known = values[faces]
    steps = np.linalg.norm(positions[faces] - points[:, None], axis=2)
    least = np.asarray((known + steps).min(axis=1))
    two = np.flatnonzero(np.isfinite(known).sum(axis=1) == 2)
    order = np.argsort(known[two], axis=1)[:, :2]
    ends = np.take_along_axis(faces[two], order, axis=1)
    tail, head = positions[ends[:, 0]], positions[ends[:, 1]]
    one, other = values[ends].T
    length = np.linalg.norm(head - tail, axis=1)
    # In the plane: the edge from 0 to `length`, the point at (along, up), the virtual source below.
    safe = np.where(length > 0, length, 1.0)
    along = np.einsum("qd,qd->q", points[two] - tail, (head - tail) / safe[:, None])
    up = np.sqrt(np.maximum(steps[two, order[:, 0]] ** 2 - along**2, 0.0))
    aside = (length + (one - other) * (one + other) / safe) / 2
    down = np.sqrt(np.maximum(one**2 - aside**2, 0.0))
    crossing = aside + (along - aside) * down / np.where(down + up > 0, down + up, 1.0)
    straight = np.hypot(along - aside, up + down)
    crosses = (crossing >= 0) & (crossing <= length) & (down > 0)
    least[two[crosses]] = np.minimum(least[two[crosses]], straight[crosses])
    return least
