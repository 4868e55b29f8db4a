"""Tests of whether a graph consists of lines, and its width."""

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.geometry.along_edges import AlongEdges
from geodesic_toolkit.geometry.components import connected_by_edges

__all__ = [
    "MAX_SHARE_OF_MESHES",
    "is_network",
    "share_of_meshes",
    "widest_level",
]

MAX_SHARE_OF_MESHES = 0.05
"""Maximum share of vertices in meshes, in a graph of lines. In trees, chains and streets with a
bend each it is 0; in square grids with every tenth edge missing 0.8, in a grid of three by three
0.11.
"""


LENGTH_TOLERANCE = 1e-6
"""Relative difference up to which two lengths are the same."""


def share_of_meshes(n_vertices: int, edges: IntArray) -> float:
    """Return the share of vertices that lie in meshes, instead of on lines.

    Dead ends are removed first, so that a tree does not have junctions. The rest of a graph of
    lines consists of junctions with chains of vertices between them; a vertex of a grid, or of a
    neighbour graph, is a junction with at least three neighbours that are junctions.

    Parameters
    ----------
    n_vertices : int
    edges : ndarray of shape (E, 2), int64
        Distinct, without loops.

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


MAX_LENGTHS_OF_LATTICES = 16
"""Maximum number of edge lengths in a lattice: the edges around a voxel have 13."""

MIN_SHARE_OF_SMALL_JUNCTIONS = 0.05
"""Minimum share of vertices with fewer than four neighbours in a street network. A closed mesh of
quadrangles has almost none, and a raster of 80 x 80 points has this share at its margin."""

MAX_SHARE_OF_TRIANGLES = 0.1
"""Maximum share of edges that are sides of triangles in a street network. City plans have 1 to 5 %,
and meshes and neighbour graphs nearly 100."""


def is_network(n_vertices: int, edges: IntArray, lengths: FloatArray) -> bool:
    """Return True if a graph of junctions looks like a street network rather than like samples.

    Edges of a network have many lengths, unlike those of a lattice; two neighbours of a vertex are
    rarely neighbours, unlike among samples; and a vertex has at most four neighbours, often fewer.
    A small raster of heights, with edges to four sides, looks the same.

    Parameters
    ----------
    n_vertices : int
    edges : ndarray of shape (E, 2), int64
        Distinct, without loops.
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
    if known.mean() > 4 or np.mean(known < 4) < MIN_SHARE_OF_SMALL_JUNCTIONS:
        return False
    if len(np.unique(np.round(np.log(lengths) / LENGTH_TOLERANCE))) <= MAX_LENGTHS_OF_LATTICES:
        return False
    adjacency = AlongEdges(n_vertices, edges, np.ones(len(edges))).matrix
    in_triangles = (adjacency @ adjacency).multiply(adjacency)
    return bool(in_triangles.nnz <= MAX_SHARE_OF_TRIANGLES * adjacency.nnz)


def _dead_ends(n_vertices: int, edges: IntArray) -> BoolArray:
    """Return a mask (N,) of the vertices removed by repeatedly removing those with one neighbour.

    The exclusive or of the remaining neighbours of a vertex is its neighbour if only one remains.
    """
    degree = np.bincount(edges.ravel(), minlength=n_vertices)
    neighbours = np.zeros(n_vertices, dtype=np.int64)
    for one, other in ((0, 1), (1, 0)):
        np.bitwise_xor.at(neighbours, edges[:, one], edges[:, other])
    removed = degree == 0
    ends = np.flatnonzero(degree == 1)
    while len(ends):
        removed[ends] = True
        last = neighbours[ends]
        np.bitwise_xor.at(neighbours, last, ends)
        np.subtract.at(degree, last, 1)
        ends = np.unique(last[(degree[last] == 1) & ~removed[last]])
    return np.asarray(removed)


def widest_level(n_vertices: int, edges: IntArray) -> int:
    """Return the number of vertices in the largest level of a breadth-first search.

    The result is the narrowest of searches from the ends of the largest component. Every level
    splits a graph in two, so that a factor need not be wider; the largest level of a square grid is
    its diagonal, that of samples in many dimensions is a large share of all vertices.

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
