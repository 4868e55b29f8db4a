"""Tests of whether a graph consists of lines, and its width."""

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.geometry.along_edges import AlongEdges
from geodesic_toolkit.geometry.components import connected_by_edges

__all__ = [
    "FEW_LENGTHS",
    "LENGTH_TOLERANCE",
    "NEARLY_EVERYWHERE",
    "is_network",
    "share_of_meshes",
    "widest_level",
]

NEARLY_EVERYWHERE = 0.05
"""Share of the vertices that may lie in meshes of a graph of lines. Trees, chains and streets with
a bend each have none; square grids with every tenth edge missing have 0.8, three by three 0.11.
"""


LENGTH_TOLERANCE = 1e-6
"""Relative difference up to which two lengths are the same."""


def share_of_meshes(n_vertices: int, edges: IntArray) -> float:
    """Return the share of vertices that lie in meshes, instead of on lines.

    Dead ends are taken off first, so that a tree has no junctions. What is left of a graph of lines
    are junctions with chains of vertices between them; a vertex of a grid, or of a neighbour graph,
    is a junction with three neighbours at least that are junctions.

    Parameters
    ----------
    n_vertices : int
    edges : ndarray of shape (E, 2), int64
        Each once, without loops.

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.geometry.lines import share_of_meshes
    >>> square = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])
    >>> share_of_meshes(4, square), share_of_meshes(4, square[:4])
    (1.0, 0.0)
    """
    inner = edges[~_dead_ends(n_vertices, edges)[edges].any(axis=1)]
    junction = np.bincount(inner.ravel(), minlength=n_vertices) >= 3
    between = inner[junction[inner].all(axis=1)]
    return float(np.mean(np.bincount(between.ravel(), minlength=n_vertices) >= 3))


FEW_LENGTHS = 16
"""Lengths that the edges of a lattice may have: those around a voxel have 13."""

SMALLER_JUNCTIONS = 0.05
"""Least share of vertices with fewer than four neighbours in a network of streets. A closed mesh of
quadrangles has next to none, and a raster of 80 x 80 places has so many at its margin."""

MAX_SHARE_OF_TRIANGLES = 0.1
"""Share of edges that may be sides of triangles in a network of streets. Plans have 1 to 5 %, and
meshes and neighbour graphs nearly 100."""


def is_network(n_vertices: int, edges: IntArray, lengths: FloatArray) -> bool:
    """Return whether a graph of junctions looks like a street network rather than like samples.

    Its edges have all kinds of lengths, other than those of a lattice; hardly two neighbours of a
    vertex are neighbours, other than among samples; and there are at most four of them, often
    fewer. A raster of heights, with edges to four sides, looks alike where it is small.

    Parameters
    ----------
    n_vertices : int
    edges : ndarray of shape (E, 2), int64
        Each once, without loops.
    lengths : ndarray of shape (E,), float64
        Positive.

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.geometry.lines import is_network
    >>> steps = np.arange(400)
    >>> right, up = steps[steps % 20 < 19], steps[steps < 380]
    >>> grid = np.concatenate([np.column_stack([right, right + 1]), np.column_stack([up, up + 20])])
    >>> lengths = np.random.default_rng(0).uniform(80, 120, len(grid))
    >>> is_network(400, grid, lengths), is_network(400, grid, np.full(len(grid), 100.0))
    (True, False)
    """
    degree = np.bincount(edges.ravel(), minlength=n_vertices)
    known = degree[degree > 0]
    if known.mean() > 4 or np.mean(known < 4) < SMALLER_JUNCTIONS:
        return False
    if len(np.unique(np.round(np.log(lengths) / LENGTH_TOLERANCE))) <= FEW_LENGTHS:
        return False
    adjacency = AlongEdges(n_vertices, edges, np.ones(len(edges))).matrix
    in_triangles = (adjacency @ adjacency).multiply(adjacency)
    return bool(in_triangles.nnz <= MAX_SHARE_OF_TRIANGLES * adjacency.nnz)


def _dead_ends(n_vertices: int, edges: IntArray) -> BoolArray:
    """Return which (N,) vertices go when those with one neighbour are taken off time and again.

    The exclusive or of the neighbours that are left is, where there is but one, that one.
    """
    degree = np.bincount(edges.ravel(), minlength=n_vertices)
    neighbours = np.zeros(n_vertices, dtype=np.int64)
    for one, other in ((0, 1), (1, 0)):
        np.bitwise_xor.at(neighbours, edges[:, one], edges[:, other])
    gone = degree == 0
    ends = np.flatnonzero(degree == 1)
    while len(ends):
        gone[ends] = True
        last = neighbours[ends]
        np.bitwise_xor.at(neighbours, last, ends)
        np.subtract.at(degree, last, 1)
        ends = np.unique(last[(degree[last] == 1) & ~gone[last]])
    return np.asarray(gone)


def widest_level(n_vertices: int, edges: IntArray) -> int:
    """Return how many vertices the largest level of a breadth-first search has.

    Of the searches from both ends of the largest part the narrower one counts. Every level parts a
    graph in two, so that a factor need not be wider; that of a square grid is its diagonal, that
    of samples in many dimensions a good part of all vertices.

    Parameters
    ----------
    n_vertices : int
    edges : ndarray of shape (E, 2), int64
    """
    from scipy.sparse.csgraph import dijkstra

    adjacency = AlongEdges(n_vertices, edges, np.ones(len(edges))).matrix
    labels = connected_by_edges(edges, n_vertices)
    start = int(np.argmax(labels == np.bincount(labels).argmax()))
    widths = []
    for _ in range(3):
        hops = dijkstra(adjacency, indices=[start], unweighted=True)[0]
        reached = np.where(np.isfinite(hops), hops, -1)
        widths.append(int(np.bincount(reached[reached >= 0].astype(np.int64)).max()))
        start = int(reached.argmax())
    return min(widths)
