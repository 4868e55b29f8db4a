"""Triangles by their edge lengths: areas, angles, hat-function gradients, edges.

A triangle is measured in its own plane, in the frame that puts its corners at (0, 0), (l, 0) and
(a, b): three numbers ``(l, a, b)`` hold all of its metric, wherever they come from (corner
positions, edge lengths of an intrinsic triangulation, a tangent plane).
"""

import numpy as np
from scipy.sparse import coo_array, csr_array

from geodesic_toolkit._typing import BoolArray, FloatArray, IntArray

__all__ = [
    "edges_of_faces",
    "face_areas",
    "face_edge_lengths",
    "frames_from_lengths",
    "frames_from_positions",
    "hat_gradients",
    "mollified_lengths",
    "proper_faces",
]


def proper_faces(faces: IntArray) -> BoolArray:
    """Return where a face has three different vertices."""
    a, b, c = faces.T
    proper: BoolArray = (a != b) & (b != c) & (c != a)
    return proper


def face_edge_lengths(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Return the (F, 3) edge lengths; column i is the edge opposite corner i."""
    corners = vertices[faces]
    opposite = corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]]
    lengths: FloatArray = np.sqrt(np.einsum("fcd,fcd->fc", opposite, opposite))
    return lengths


def frames_from_positions(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Return the (F, 3) planar frames ``(l, a, b)`` of triangles in space.

    Sharper than going through edge lengths: the height b comes from a cross product and keeps its
    relative accuracy in slivers.
    """
    origin, first, second = (vertices[faces[:, corner]] for corner in range(3))
    u, v = first - origin, second - origin
    length = np.sqrt(np.einsum("fd,fd->f", u, u))
    with np.errstate(divide="ignore", invalid="ignore"):
        along = np.einsum("fd,fd->f", u, v) / length
        cross = np.cross(u, v)
        height = np.sqrt(np.einsum("fd,fd->f", cross, cross)) / length
    return np.column_stack([length, along, height])


def frames_from_lengths(lengths: FloatArray) -> FloatArray:
    """Return the (F, 3) planar frames ``(l, a, b)`` of triangles with the given edge lengths.

    `lengths` has the edge opposite corner i in column i. The area is Heron's formula in Kahan's
    order of operations, which does not cancel for thin triangles.
    """
    opposite_0, opposite_1, length = lengths.T
    along = (length**2 + (opposite_1 - opposite_0) * (opposite_1 + opposite_0)) / (2 * length)
    c, b, a = np.sort(lengths, axis=1).T
    product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    double_area = np.sqrt(np.maximum(product, 0.0)) / 2
    return np.column_stack([length, along, double_area / length])


def face_areas(frames: FloatArray) -> FloatArray:
    """Return the (F,) areas of triangles in their planar frames."""
    areas: FloatArray = frames[:, 0] * frames[:, 2] / 2
    return areas


def hat_gradients(frames: FloatArray) -> FloatArray:
    """Return the (F, 2, 3) gradients of the three hat functions of each triangle, in its frame."""
    length, along, height = frames.T
    gradients = np.empty((len(frames), 2, 3))
    gradients[:, 0, 1] = 1 / length
    gradients[:, 1, 1] = -along / (length * height)
    gradients[:, 0, 2] = 0.0
    gradients[:, 1, 2] = 1 / height
    gradients[:, :, 0] = -(gradients[:, :, 1] + gradients[:, :, 2])
    return gradients


def edges_of_faces(faces: IntArray, n_vertices: int) -> tuple[IntArray, IntArray]:
    """Return the undirected edges (E, 2), smaller vertex first, and how many faces each has."""
    tails = faces.ravel()
    heads = faces[:, [1, 2, 0]].ravel()
    rows, columns = np.minimum(tails, heads), np.maximum(tails, heads)
    ones = np.ones(len(rows), dtype=np.int64)
    shape = (n_vertices, n_vertices)
    counted = coo_array(csr_array(coo_array((ones, (rows, columns)), shape=shape)))
    return np.column_stack(counted.coords).astype(np.int64), counted.data


def mollified_lengths(lengths: FloatArray, *, slack: float = 1e-5) -> tuple[FloatArray, float]:
    """Return edge lengths that form proper triangles, and what was added to every edge.

    One constant is added to all edges, the smallest that leaves every triangle inequality a slack
    of `slack` times the mean edge length; nothing where they have it already. Zero-area faces thus
    become thin triangles that still connect their vertices (Sharp and Crane, *A Laplacian for
    Nonmanifold Triangle Meshes*, 2020, section 4.5, https://doi.org/10.1111/cgf.14069).
    """
    total = lengths.sum(axis=1, keepdims=True)
    shortfall = (slack * lengths.mean() - (total - 2 * lengths)).max()
    added = max(0.0, float(shortfall))
    return lengths + added, added
