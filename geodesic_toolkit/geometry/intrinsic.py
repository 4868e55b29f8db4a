"""Intrinsic triangulations, and Voronoi areas by libigl.

Everything that the core needs of libigl for triangulations is here, imported on first use. Edges
are flipped by our own kernel: libigl's flips take longer than all other steps of the heat method.
"""

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.geometry.components import connected_by_edges

__all__ = [
    "MOST_SIDES",
    "coherently_oriented",
    "cut_disagreeing",
    "delaunay_triangles",
    "voronoi_areas",
]

MAX_ROUNDING_OF_LENGTHS = 1e-9
"""Relative difference of the lengths of an edge in two faces that is rounding."""

MOST_SIDES = np.iinfo(np.int32).max
"""Maximum number of half-edges that our kernels can pair."""


def delaunay_triangles(
    faces: IntArray,
    lengths: FloatArray,
    sides: _native.HalfEdges | None = None,
    *,
    edges_agree: bool = True,
) -> tuple[IntArray, FloatArray, IntArray]:
    """Return the intrinsic Delaunay triangulation of any triangles.

    Parameters
    ----------
    faces : ndarray of shape (F, 3), int64
        With any orientation; edges of more than two faces stay.
    lengths : ndarray of shape (F, 3), float64
        The edge opposite corner i in column i, with every triangle inequality strict.
    sides : _native.HalfEdges, optional
        The half-edges of the faces, if they have been sorted already.
    edges_agree : bool
        False if two faces may disagree about the length of their edge, which then stays.

    Returns
    -------
    faces : ndarray of shape (F, 3), int64
        With the same vertices.
    lengths : ndarray of shape (F, 3), float64
    twin : ndarray of shape (3 F,), int64
        The half-edge that each half-edge ``3 f + c``, opposite corner c of face f, is glued to;
        -1 at a rim, and at edges where flips had to cut the surface.
    """
    count = int(faces.max()) + 1
    twin, coherent = (sides or _native.sorted_half_edges(faces, count)).twins()
    if coherent:
        if not edges_agree:
            cut_disagreeing(twin, lengths)
        return _flipped(faces, lengths, twin, count)
    cut, cut_lengths, origin = coherently_oriented(faces, lengths)
    twin, _ = _native.sorted_half_edges(cut, len(origin)).twins()
    if not edges_agree:
        cut_disagreeing(twin, cut_lengths)
    flipped, flipped_lengths, twin = _flipped(cut, cut_lengths, twin, len(origin))
    return origin[flipped], flipped_lengths, twin


def cut_disagreeing(twin: IntArray, lengths: FloatArray) -> BoolArray:
    """Cut half-edges from their twins in place where these have another length.

    Two faces in which the metric differs are not isometric to a flat quadrangle, so that the edge
    between them has no other diagonal.

    Parameters
    ----------
    twin : ndarray of shape (3 F,), int64
    lengths : ndarray of shape (F, 3), float64

    Returns
    -------
    ndarray of shape (3 F,), bool
        True at the half-edges that have been cut.
    """
    flat = lengths.ravel()
    other = flat[np.where(twin < 0, np.arange(len(twin)), twin)]
    cut = np.abs(flat - other) > MAX_ROUNDING_OF_LENGTHS * flat
    twin[cut] = -1
    return np.asarray(cut)


def _flipped(
    faces: IntArray, lengths: FloatArray, twin: IntArray, n_vertices: int
) -> tuple[IntArray, FloatArray, IntArray]:
    """Return the triangles and their twins after all flips; the given twins are overwritten."""
    faces, lengths = faces.copy(), lengths.copy()
    _native.flip_edges(faces, lengths, twin, np.zeros(n_vertices, dtype=np.bool_))
    return faces, lengths, twin


def coherently_oriented(
    faces: IntArray, lengths: FloatArray
) -> tuple[IntArray, FloatArray, IntArray]:
    """Return the same triangles with consistent orientation, cut where that is impossible.

    It is impossible at an edge of more than two faces, and along a line of a one-sided surface.
    Edge flips need this: libigl's flips crash or distort the surface without it, and do not flip
    the edges of a cut, as these are boundary edges.

    Parameters
    ----------
    faces : ndarray of shape (F, 3), int64
    lengths : ndarray of shape (F, 3), float64
        The edge opposite corner i in column i.

    Returns
    -------
    faces : ndarray of shape (F, 3), int64
        With new vertices: a cut splits a vertex into several.
    lengths : ndarray of shape (F, 3), float64
    origin : ndarray of int64
        The original vertex of each new one.
    """
    if _coherent(faces):
        return faces, lengths, np.arange(faces.max() + 1)
    import igl  # heavy: 0.3 s

    turned, _ = igl.bfs_orient(faces)
    reversed_rows = (turned != faces).any(axis=1, keepdims=True)
    cut, origin = _cut_apart(turned)
    return cut, np.where(reversed_rows, lengths[:, ::-1], lengths), origin


def _coherent(faces: IntArray) -> bool:
    """Return True if two faces never run along an edge in the same direction."""
    half_edges = np.sort(faces.ravel() * (faces.max() + 1) + faces[:, [1, 2, 0]].ravel())
    return bool((half_edges[1:] != half_edges[:-1]).all())  # np.unique hashes, 20 times slower here


def _cut_apart(faces: IntArray) -> tuple[IntArray, IntArray]:
    """Return the faces glued only along edges of two faces with opposite directions."""
    corners = np.arange(faces.size).reshape(faces.shape)
    tail, head = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    ends = np.sort(np.column_stack([tail, head]), axis=1)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    new = np.ones(len(order) + 1, dtype=np.bool_)
    new[1:-1] = (ends[order][1:] != ends[order][:-1]).any(axis=1)
    first = np.flatnonzero(new[:-1] & ~new[1:])  # edges of two half-edges or more
    first = first[new[first + 2]]  # edges of exactly two
    one, other = order[first], order[first + 1]
    against = tail[one] == head[other]
    one, other = one[against], other[against]
    to = corners[:, [1, 2, 0]].ravel()
    glue = np.column_stack([np.concatenate([one, to[one]]), np.concatenate([to[other], other])])
    vertex = connected_by_edges(glue, faces.size)
    origin = np.empty(vertex.max() + 1, dtype=np.int64)
    origin[vertex] = tail
    return vertex.reshape(faces.shape), origin


def voronoi_areas(faces: IntArray, lengths: FloatArray, n_vertices: int) -> FloatArray:
    """Return the (N,) mixed Voronoi areas of the vertices of a triangulation.

    References
    ----------
    M. Meyer, M. Desbrun, P. Schröder, A. H. Barr, *Discrete Differential-Geometry Operators for
    Triangulated 2-Manifolds*, 2003, https://doi.org/10.1007/978-3-662-05105-4_2
    """
    import igl  # heavy: 0.3 s

    kind = igl.MassMatrixType.MASSMATRIX_TYPE_VORONOI
    areas = np.zeros(n_vertices)
    diagonal = igl.massmatrix_intrinsic(lengths, faces, kind).diagonal()
    areas[: len(diagonal)] = diagonal  # libigl stops at the last used vertex
    return areas
