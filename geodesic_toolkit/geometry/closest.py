"""The point of a surface that is closest to a point in space."""

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["TriangleTree"]


MIN_POINTS_TO_SORT = 1000
"""Number of points above which sorting them saves time."""


class TriangleTree:
    """Triangles in a tree of boxes, by libigl: built once, then used for many points.

    Parameters
    ----------
    vertices : ndarray of shape (N, 3), float64
        Unused vertices may have any value.
    faces : ndarray of shape (F, 3), int64
        One or more. A face with its last two vertices equal is a segment.
    """

    def __init__(self, vertices: FloatArray, faces: IntArray) -> None:
        import igl  # heavy: 0.3 s

        self._faces = faces
        corners = vertices[faces]
        self._middle = (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1))) / 2
        # libigl squares lengths, which must not overflow or underflow in any unit.
        self._scale = float(np.abs(corners - self._middle).max()) or 1.0
        usable = np.where(np.isfinite(vertices), vertices, self._middle)  # unused vertices
        self._vertices = (usable - self._middle) / self._scale
        self._tree = igl.AABB()
        self._tree.init(self._vertices, faces)

    def closest(self, points: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the face closest to each point, and the barycentric coordinates of its foot.

        Parameters
        ----------
        points : ndarray of shape (Q, 3)

        Returns
        -------
        face : ndarray of shape (Q,), int64
        barycentric : ndarray of shape (Q, 3), float64
            Not negative, each row with sum 1.
        """
        import igl

        scaled = np.clip((points - self._middle) / self._scale, -1e9, 1e9)
        # Points sorted by position find their boxes in the processor's cache: on 800,000
        # triangles, 100,000 scattered points took 0.9 s of CPU when sorted, and 4.8 s otherwise.
        order = (
            _spatial_order(scaled) if len(scaled) >= MIN_POINTS_TO_SORT else np.arange(len(scaled))
        )
        _, found, feet = self._tree.squared_distance(self._vertices, self._faces, scaled[order])
        face, foot = np.empty_like(found), np.empty_like(feet)
        face[order], foot[order] = found, feet
        corners = self._vertices[self._faces[face]]
        a, b, c = (np.ascontiguousarray(corners[:, corner]) for corner in range(3))
        with np.errstate(invalid="ignore"):
            barycentric = np.maximum(igl.barycentric_coordinates(foot, a, b, c), 0.0)
            barycentric /= barycentric.sum(axis=1, keepdims=True)
            missed = np.linalg.norm(np.einsum("qc,qcd->qd", barycentric, corners) - foot, axis=1)
        longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        flat = ~(missed <= 1e-6 * longest)  # the height is almost 0, and the result NaN or wrong
        barycentric[flat] = _along_longest_edge(foot[flat], corners[flat])
        return face, barycentric


def _spatial_order(points: FloatArray) -> IntArray:
    """Return an order in which points near each other are close together."""
    from scipy.spatial import cKDTree

    order: IntArray = cKDTree(points).indices
    return order


def _along_longest_edge(feet: FloatArray, corners: FloatArray) -> FloatArray:
    """Return the barycentric coordinates of points on triangles that are segments."""
    rows = np.arange(len(feet))
    start = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).argmax(axis=1)
    end = (start + 1) % 3
    along = corners[rows, end] - corners[rows, start]
    squared = np.einsum("qd,qd->q", along, along)
    share = np.einsum("qd,qd->q", feet - corners[rows, start], along)
    share = np.clip(share / np.where(squared > 0, squared, 1.0), 0.0, 1.0)
    barycentric = np.zeros((len(feet), 3))
    barycentric[rows, start] = 1 - share
    barycentric[rows, end] = share
    return barycentric
