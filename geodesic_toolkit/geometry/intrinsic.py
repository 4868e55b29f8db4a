"""Intrinsic triangulations and Voronoi areas, by libigl.

All that the core needs of libigl's triangulation side is here, imported on first use. Its edge
flips take longer than all the rest of the heat method; where kernels are worth it, ours do them.
"""

from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from geodesic_toolkit._kernels import worthwhile
from geodesic_toolkit._typing import FloatArray, IntArray

if TYPE_CHECKING:
    from geodesic_toolkit._sides import Sides  # imports Numba

__all__ = [
    "MOST_SIDES",
    "coherently_oriented",
    "delaunay_triangles",
    "intrinsic_delaunay",
    "voronoi_areas",
]

MOST_SIDES = np.iinfo(np.int32).max
"""Half-edges up to which our kernels pair them."""


def delaunay_triangles(
    faces: IntArray, lengths: FloatArray, sides: "Sides | None" = None
) -> tuple[IntArray, FloatArray]:
    """Return the intrinsic Delaunay triangulation of any triangles.

    Parameters
    ----------
    faces : ndarray of shape (F, 3), int64
        Turned in any way; edges of more than two faces stay.
    lengths : ndarray of shape (F, 3), float64
        The edge opposite corner i in column i, with every triangle inequality strict.
    sides : Sides, optional
        The half-edges of the faces, where they have been sorted already.

    Returns
    -------
    faces : ndarray of shape (F, 3), int64
        In the same vertices.
    lengths : ndarray of shape (F, 3), float64
    """
    count = int(faces.max()) + 1
    if not worthwhile(count) or faces.size > MOST_SIDES:
        cut, cut_lengths, origin = coherently_oriented(faces, lengths)
        flipped, flipped_lengths = intrinsic_delaunay(cut, cut_lengths)
        return origin[flipped], flipped_lengths
    from geodesic_toolkit._flipping import flip_edges, twins
    from geodesic_toolkit._sides import sorted_sides

    twin, coherent = twins(sorted_sides(faces, count) if sides is None else sides)
    if coherent:
        faces, lengths = faces.copy(), lengths.copy()
        flip_edges(faces, lengths, twin, np.zeros(count, dtype=np.bool_))
        return faces, lengths
    cut, cut_lengths, origin = coherently_oriented(faces, lengths)
    twin, _ = twins(sorted_sides(cut, len(origin)))
    cut, cut_lengths = cut.copy(), cut_lengths.copy()
    flip_edges(cut, cut_lengths, twin, np.zeros(len(origin), dtype=np.bool_))
    return origin[cut], cut_lengths


def coherently_oriented(
    faces: IntArray, lengths: FloatArray
) -> tuple[IntArray, FloatArray, IntArray]:
    """Return the same triangles turned so that neighbours agree, cut apart where they cannot.

    They cannot along an edge of more than two faces, and somewhere on a one-sided surface. Flipping
    edges needs this: libigl's flips crash or bend the surface without it, and leave the edges of a
    cut alone as those of a boundary.

    Parameters
    ----------
    faces : ndarray of shape (F, 3), int64
    lengths : ndarray of shape (F, 3), float64
        The edge opposite corner i in column i.

    Returns
    -------
    faces : ndarray of shape (F, 3), int64
        In vertices of their own, of which a cut makes several out of one.
    lengths : ndarray of shape (F, 3), float64
    origin : ndarray of int64
        The vertex that each of these was.
    """
    if _coherent(faces):
        return faces, lengths, np.arange(faces.max() + 1)
    import igl  # heavy: 0.3 s

    turned, _ = igl.bfs_orient(faces)
    reversed_rows = (turned != faces).any(axis=1, keepdims=True)
    cut, origin = _cut_apart(turned)
    return cut, np.where(reversed_rows, lengths[:, ::-1], lengths), origin


def _coherent(faces: IntArray) -> bool:
    """Return whether no two faces run along an edge in the same direction."""
    half_edges = np.sort(faces.ravel() * (faces.max() + 1) + faces[:, [1, 2, 0]].ravel())
    return bool((half_edges[1:] != half_edges[:-1]).all())  # np.unique hashes, 20 times slower here


def _cut_apart(faces: IntArray) -> tuple[IntArray, IntArray]:
    """Return the faces glued along those edges only where two meet that run against each other."""
    corners = np.arange(faces.size).reshape(faces.shape)
    tail, head = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    ends = np.sort(np.column_stack([tail, head]), axis=1)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    new = np.ones(len(order) + 1, dtype=np.bool_)
    new[1:-1] = (ends[order][1:] != ends[order][:-1]).any(axis=1)
    first = np.flatnonzero(new[:-1] & ~new[1:])  # edges of two half-edges or more
    first = first[new[first + 2]]  # of exactly two
    one, other = order[first], order[first + 1]
    against = tail[one] == head[other]
    one, other = one[against], other[against]
    to = corners[:, [1, 2, 0]].ravel()
    pairs = (np.concatenate([one, to[one]]), np.concatenate([to[other], other]))
    glue = coo_array((np.ones(len(pairs[0])), pairs), shape=(faces.size, faces.size))
    _, vertex = connected_components(csr_array(glue), directed=False)
    origin = np.empty(vertex.max() + 1, dtype=np.int64)
    origin[vertex] = tail
    return vertex.reshape(faces.shape).astype(np.int64), origin


def intrinsic_delaunay(faces: IntArray, lengths: FloatArray) -> tuple[IntArray, FloatArray]:
    """Flip edges until the triangulation is intrinsically Delaunay.

    The vertices and the metric of the surface stay; the cotangent weights of all inner edges
    become non-negative. Faces may come to touch themselves (two corners at the same vertex), which
    is right intrinsically.

    Parameters
    ----------
    faces : ndarray of shape (F, 3), int64
    lengths : ndarray of shape (F, 3), float64
        The edge opposite corner i in column i, with every triangle inequality strict; both as
        :func:`coherently_oriented` returns them.

    Returns
    -------
    faces : ndarray of shape (F, 3), int64
    lengths : ndarray of shape (F, 3), float64

    References
    ----------
    M. Fisher, B. Springborn, P. Schröder, A. I. Bobenko, *An algorithm for the construction of
    intrinsic Delaunay triangulations with applications to digital geometry processing*,
    Computing 81, 2007, https://doi.org/10.1007/s00607-007-0249-8
    """
    import igl  # heavy: 0.3 s

    flipped_lengths, flipped_faces, *_ = igl.intrinsic_delaunay_triangulation(lengths, faces)
    return flipped_faces, flipped_lengths


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
    areas[: len(diagonal)] = diagonal  # libigl stops at the last vertex that a face refers to
    return areas
