"""Triangles by their edge lengths: areas, angles, hat-function gradients, edges.

A triangle is measured in its own plane, in the frame that puts its corners at (0, 0), (l, 0) and
(a, b): the three numbers ``(l, a, b)`` determine its metric, whatever their origin (corner
positions, edge lengths of an intrinsic triangulation, a tangent plane).
"""

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.rows import CompressedRows
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.geometry.components import connected_by_faces

__all__ = [
    "edges_and_lengths",
    "edges_of_faces",
    "face_areas",
    "face_edge_lengths",
    "frames_from_lengths",
    "frames_from_positions",
    "hat_gradients",
    "hat_gradients_from_inverse",
    "inverse_frames",
    "lengths_from_inverse",
    "mean_edge_length",
    "mean_squared_edges",
    "measured_by_lengths",
    "measured_triangles",
    "mollified_lengths",
    "proper_faces",
]


MIN_SLACK_OF_TRIANGLE_INEQUALITY = 1e-5
"""Minimum slack of a triangle inequality, in edge lengths, for accurate angles."""


def proper_faces(faces: IntArray) -> BoolArray:
    """Return a mask of the faces that have three different vertices and do not repeat a face.

    Surfaces are often given twice, front and back: an edge would then have four faces, and areas
    would be doubled. Copies with their own vertices are another sheet.

    Parameters
    ----------
    faces : ndarray of shape (F, 3), int64

    Returns
    -------
    ndarray of shape (F,), bool

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.geometry.triangles import proper_faces
    >>> proper_faces(np.array([[0, 1, 2], [2, 1, 0], [0, 1, 3], [3, 3, 0]]))
    array([ True, False,  True, False])
    """
    return _native.proper_faces(np.ascontiguousarray(faces), int(faces.max(initial=-1)) + 1)


def face_edge_lengths(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Return the (F, 3) edge lengths; column i is the edge opposite corner i."""
    corners = vertices[faces]
    opposite = corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]]
    lengths: FloatArray = np.sqrt(np.einsum("fcd,fcd->fc", opposite, opposite))
    return lengths


def measured_triangles(
    vertices: FloatArray, faces: IntArray
) -> tuple[IntArray, FloatArray, FloatArray, float]:
    """Return the :func:`proper_faces`, measured.

    If a face has an area of almost 0, every edge of its component is made longer by one constant,
    as in :func:`mollified_lengths`.

    Returns
    -------
    faces : ndarray of shape (F, 3), int64
        The proper faces; empty if the corners of every face are at one position.
    inverse : ndarray of shape (F, 3), float64
        As :func:`inverse_frames` returns them.
    areas : ndarray of shape (F,), float64
    added : float
        The largest length that was added to an edge.
    """
    proper = proper_faces(faces)
    if not proper.all():
        faces = faces[proper]
    inverse, areas, total, slack = _native.measure_triangles(vertices, faces)
    if total == 0:
        return faces[:0], inverse[:0], areas[:0], 0.0
    if slack < MIN_SLACK_OF_TRIANGLE_INEQUALITY:
        return faces, *_mollified(vertices, faces, face_edge_lengths(vertices, faces))
    return faces, inverse, areas, 0.0


def measured_by_lengths(lengths: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the inverse frames (F, 3) and the areas (F,) of triangles with given edge lengths."""
    return _native.measure_lengths(np.ascontiguousarray(lengths))


def _mollified(
    vertices: FloatArray, faces: IntArray, lengths: FloatArray
) -> tuple[FloatArray, FloatArray, float]:
    """Return inverse frames and areas, in components with changed lengths from these lengths."""
    frames = frames_from_positions(vertices, faces)
    part = connected_by_faces(faces, len(vertices))[faces[:, 0]]
    longer, added = mollified_lengths(lengths, part)
    changed = added > 0
    frames[changed] = frames_from_lengths(longer[changed])
    return inverse_frames(frames), face_areas(frames), float(added.max())


def frames_from_positions(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Return the (F, 3) planar frames ``(l, a, b)`` of triangles in space.

    They are more accurate than frames from edge lengths: the height b comes from a cross product
    and keeps its relative accuracy in slivers.
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
    opposite_0, opposite_1, length = np.ascontiguousarray(lengths.T)
    along = (length**2 + (opposite_1 - opposite_0) * (opposite_1 + opposite_0)) / (2 * length)
    shorter, longer = np.minimum(opposite_0, opposite_1), np.maximum(opposite_0, opposite_1)
    a, c = np.maximum(longer, length), np.minimum(shorter, length)
    b = np.maximum(shorter, np.minimum(longer, length))
    product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    double_area = np.sqrt(np.maximum(product, 0.0)) / 2
    return np.column_stack([length, along, double_area / length])


def face_areas(frames: FloatArray) -> FloatArray:
    """Return the (F,) areas of triangles in their planar frames."""
    areas: FloatArray = frames[:, 0] * frames[:, 2] / 2
    return areas


def hat_gradients(frames: FloatArray) -> FloatArray:
    """Return the (F, 2, 3) gradients of the three hat functions of each triangle, in its frame."""
    return hat_gradients_from_inverse(inverse_frames(frames))


def inverse_frames(frames: FloatArray) -> FloatArray:
    """Return ``(p, q, r)``, (F, 3), with ``[[p, 0], [q, r]]`` the inverse of ``[[l, 0], [a, b]]``.

    The rows of the latter are the edges from the first corner, so the inverse takes the differences
    of a linear function along them to its gradient.
    """
    length, along, height = frames.T
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.column_stack([1 / length, -along / (length * height), 1 / height])


def lengths_from_inverse(inverse: FloatArray) -> FloatArray:
    """Return the (F, 3) edge lengths, opposite each corner, of triangles by inverse frames."""
    return _native.edge_lengths(np.ascontiguousarray(inverse))


def hat_gradients_from_inverse(inverse: FloatArray) -> FloatArray:
    """Return the (F, 2, 3) gradients of the hat functions of triangles given by inverse frames."""
    gradients = np.zeros((len(inverse), 2, 3))
    gradients[:, 0, 1], gradients[:, 1, 1], gradients[:, 1, 2] = inverse.T
    gradients[:, :, 0] = -(gradients[:, :, 1] + gradients[:, :, 2])
    return gradients


def edges_of_faces(faces: IntArray, n_vertices: int) -> tuple[IntArray, IntArray]:
    """Return the undirected edges (E, 2), smaller vertex first, and their numbers of faces."""
    from scipy.sparse import coo_array, csr_array

    tails = faces.ravel()
    heads = faces[:, [1, 2, 0]].ravel()
    rows, columns = np.minimum(tails, heads), np.maximum(tails, heads)
    ones = np.ones(len(rows), dtype=np.int64)
    shape = (n_vertices, n_vertices)
    counted = coo_array(csr_array(coo_array((ones, (rows, columns)), shape=shape)))
    return np.column_stack(counted.coords).astype(np.int64), counted.data


def edges_and_lengths(vertices: FloatArray, faces: IntArray) -> tuple[IntArray, FloatArray]:
    """Return the edges (E, 2) of proper faces, smaller vertex first, and their lengths (E,)."""
    edges, _ = edges_of_faces(faces[proper_faces(faces)], len(vertices))
    return edges, np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)


def mean_edge_length(vertices: FloatArray, edges: CompressedRows) -> float:
    """Return the mean length of the edges in the pattern of a symmetric matrix of shape (N, N).

    Parameters
    ----------
    vertices : ndarray of shape (N, 3)
    edges : CompressedRows of shape (N, N)
    """
    return _native.mean_edge_length(vertices, edges.indptr, edges.indices)


def mean_squared_edges(lengths: FloatArray) -> FloatArray:
    """Return the (F,) mean squared edge lengths of triangles with edge lengths (F, 3)."""
    return np.asarray(np.einsum("fc,fc->f", lengths, lengths) / 3)


def mollified_lengths(
    lengths: FloatArray,
    part: IntArray | None = None,
    *,
    slack: float = MIN_SLACK_OF_TRIANGLE_INEQUALITY,
) -> tuple[FloatArray, FloatArray]:
    """Return edge lengths that form proper triangles, and the length added to those of each face.

    One constant is added to all edges of a component, the smallest that leaves every triangle
    inequality a slack of `slack` times the mean edge length of the component, or the longest edge
    of the face if that is shorter; it is 0 if they have this slack already. Zero-area faces thus
    become thin triangles that still connect their vertices (Sharp and Crane, *A Laplacian for
    Nonmanifold Triangle Meshes*, 2020, section 4.5, https://doi.org/10.1111/cgf.14069), while
    proper triangles do not change, even if they are much smaller than others.

    Parameters
    ----------
    lengths : ndarray of shape (F, 3), float64
        The edge opposite corner i in column i.
    part : ndarray of shape (F,), int64, optional
        The component of each face; a single one unless given.

    Returns
    -------
    lengths : ndarray of shape (F, 3), float64
    added : ndarray of shape (F,), float64
    """
    part = np.zeros(len(lengths), dtype=np.int64) if part is None else part
    total, longest = lengths.sum(axis=1), lengths.max(axis=1)
    count = np.bincount(part)
    mean = (np.bincount(part, total) / np.maximum(3 * count, 1))[part]
    mean = np.where(mean > 0, mean, total.mean() / 3)  # a component at one position
    scale = np.where(longest > 0, np.minimum(longest, mean), mean)
    worst = np.zeros(len(count))
    np.maximum.at(worst, part, slack * scale - (total - 2 * longest))
    added = worst[part]
    return lengths + added[:, None], added
