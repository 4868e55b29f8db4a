"""The point of a surface or cloud that is closest to a point in space."""

import numpy as np

from geodesic_toolkit._typing import FloatArray, IntArray

__all__ = ["closest_on_triangles", "closest_points"]


def closest_on_triangles(
    points: FloatArray, vertices: FloatArray, faces: IntArray
) -> tuple[IntArray, FloatArray]:
    """Return the face closest to each point and the barycentric coordinates of the foot there.

    Parameters
    ----------
    points : ndarray of shape (Q, 3)
    vertices : ndarray of shape (N, 3)
    faces : ndarray of shape (F, 3)

    Returns
    -------
    face : ndarray of shape (Q,), int64
    barycentric : ndarray of shape (Q, 3), float64
        Not negative, each row with sum 1.
    """
    import igl  # heavy: 0.3 s

    _, face, foot = igl.point_mesh_squared_distance(points, vertices, faces)
    a, b, c = (np.ascontiguousarray(vertices[faces[face, corner]]) for corner in range(3))
    barycentric = np.maximum(igl.barycentric_coordinates(foot, a, b, c), 0.0)
    nearest = np.argmin([np.linalg.norm(foot - corner, axis=1) for corner in (a, b, c)], axis=0)
    flat = ~np.isfinite(barycentric).all(axis=1)  # zero-area faces: their nearest corner
    barycentric[flat] = np.eye(3)[nearest[flat]]
    return face, barycentric / barycentric.sum(axis=1, keepdims=True)


def closest_points(queries: FloatArray, points: FloatArray) -> IntArray:
    """Return the index of the point closest to each query."""
    from scipy.spatial import cKDTree

    _, nearest = cKDTree(points).query(queries)
    return np.asarray(nearest, dtype=np.int64)
