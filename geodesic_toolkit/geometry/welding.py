"""Equal and nearly equal positions: corners that were written more than once."""

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.geometry.triangles import proper_faces

__all__ = [
    "boundary_edges",
    "edges_and_counts",
    "merged_positions",
    "movable_by",
    "rounding_of",
    "same_positions",
]

MAX_SHARE_OF_SHORTEST_EDGE = 0.25
"""Maximum move of a vertex, relative to the shortest edge at it. Below a half, two corners of a
face are never merged, because each would have to move by half of their edge. So a quarter preserves
faces."""

MAX_ULPS_OF_COPIES = 4
"""Units in the last place, of single precision, by which two computations of one position may
differ: half a unit each by rounding, and the same again in each coordinate."""

SORTING_DIRECTION = np.array([0.61803399, 0.56984029, 0.54159265])
"""Direction in which positions are sorted: not one that is common in shapes."""


def same_positions(points: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the first point at each position, in order, and the position of each point.

    Parameters
    ----------
    points : ndarray of shape (N, 3)
        Points with a NaN are never equal to others.

    Returns
    -------
    first : ndarray of shape (P,), int64
    place : ndarray of shape (N,), int64

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.geometry.welding import same_positions
    >>> first, place = same_positions(np.array([[1.0, 0, 0], [0, 0, 0], [1, -0.0, 0]]))
    >>> first.tolist(), place.tolist()
    ([0, 1], [0, 1, 0])
    """
    order = np.lexsort(points.T)  # stable: the first of equal points stays the first
    new = np.ones(len(points), dtype=np.bool_)
    new[1:] = (points[order[1:]] != points[order[:-1]]).any(axis=1)
    owner = np.empty(len(points), dtype=np.int64)
    owner[order] = order[new][np.cumsum(new) - 1]
    first, place = np.unique(owner, return_inverse=True)
    return first, place


def merged_positions(points: FloatArray, reach: FloatArray) -> IntArray:
    """Return for each point the first point that it is merged with, of shape (N,).

    Points are processed in order: a point that is near enough to an earlier one that stays is
    merged with it. So a point never moves farther than its reach, even in a long chain of points.

    Parameters
    ----------
    points : ndarray of shape (N, 3)
        Points that are not finite stay.
    reach : ndarray of shape (N,)
        Maximum distance of a point that is merged, 0 or more; of two points the smaller reach
        applies.

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.geometry.welding import merged_positions
    >>> points = np.array([[0.0, 0, 0], [0.9, 0, 0], [1.8, 0, 0], [9, 0, 0]])
    >>> merged_positions(points, np.full(4, 1.0)).tolist()
    [0, 0, 2, 3]
    """
    first, place = same_positions(points)
    least = np.full(len(first), np.inf)
    np.minimum.at(least, place, reach)
    one, other = _near_pairs(points[first], least)
    moves = np.zeros(len(first), dtype=np.bool_)
    low, high = one, other
    while len(low):
        waits = np.zeros(len(first), dtype=np.bool_)
        waits[high] = True
        moves[high[~waits[low]]] = True  # all before `low` are decided: it stays
        undecided = ~moves[low] & ~moves[high] & waits[low]
        low, high = low[undecided], high[undecided]
    owner = np.arange(len(first))
    joins = ~moves[one]
    np.minimum.at(owner, other[joins], one[joins])
    return np.asarray(first[owner][place])


def _near_pairs(points: FloatArray, reach: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the pairs of points within the reach of each other, the earlier point first.

    SciPy's trees could do this, but their import takes longer than the distances of most meshes.
    """
    rows = np.flatnonzero(np.isfinite(points).all(axis=1))
    points, reach = points[rows] - points[rows[:1]], reach[rows]
    along = points @ (SORTING_DIRECTION / np.linalg.norm(SORTING_DIRECTION))
    order = np.argsort(along, kind="stable")
    points, reach, along, rows = points[order], reach[order], along[order], rows[order]
    rounding = 1e-15 * float(np.abs(along).max(initial=0.0))
    pairs = [np.zeros((2, 0), dtype=np.int64)]
    near, step = np.arange(len(rows)), 0
    while len(near):
        step += 1
        near = near[: np.searchsorted(near, len(rows) - step)]
        near = near[along[near + step] - along[near] <= reach[near] + rounding]
        gap = np.linalg.norm(points[near + step] - points[near], axis=1)
        met = near[gap <= np.minimum(reach[near], reach[near + step])]
        pairs.append(np.sort([rows[met], rows[met + step]], axis=0))
    one, other = np.concatenate(pairs, axis=1)
    return one, other


def rounding_of(points: FloatArray) -> float:
    """Return the largest distance between copies of one position by rounding to single precision.

    Coordinates that are numbers of single precision have been rounded themselves; others may have
    been rounded in a frame centred at the shape.
    """
    eps = float(np.finfo(np.float32).eps)
    with np.errstate(over="ignore"):
        single = bool((points == points.astype(np.float32)).all())
    extent = float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0
    return MAX_ULPS_OF_COPIES * eps * (float(np.abs(points).max(initial=0.0)) if single else extent)


def movable_by(points: FloatArray, edges: IntArray, rounding: float) -> FloatArray:
    """Return the distance that each point may move without loss of a feature of the shape, (N,).

    It is a quarter of the shortest edge at the point; edges as short as the rounding are not
    features.

    Parameters
    ----------
    points : ndarray of shape (N, 3)
    edges : ndarray of shape (E, 2), int64
        In any order; they may be repeated.
    rounding : float
    """
    length = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    length[length <= rounding] = np.inf
    shortest = np.full(len(points), np.inf)
    np.minimum.at(shortest, edges[:, 0], length)
    np.minimum.at(shortest, edges[:, 1], length)
    return MAX_SHARE_OF_SHORTEST_EDGE * shortest


def edges_and_counts(faces: IntArray) -> tuple[IntArray, IntArray]:
    """Return the edges (E, 2) of faces, smaller vertex first, and how many faces each has."""
    sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    sides = sides[np.lexsort((sides[:, 1], sides[:, 0]))]
    new = np.ones(len(sides), dtype=np.bool_)
    new[1:] = (sides[1:] != sides[:-1]).any(axis=1)
    begins = np.flatnonzero(new)
    return sides[begins], np.diff(begins, append=len(sides))


def boundary_edges(faces: IntArray) -> IntArray:
    """Return the edges (B, 2) of only one of the :func:`proper_faces`."""
    edges, counts = edges_and_counts(faces[proper_faces(faces)])
    return np.asarray(edges[counts == 1])
