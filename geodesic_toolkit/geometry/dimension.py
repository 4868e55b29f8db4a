"""The dimension of what a graph samples."""

import numpy as np

from geodesic_toolkit._typing import IntArray
from geodesic_toolkit.geometry.components import connected_by_edges

__all__ = ["graph_dimension"]

SAMPLES = 24
"""Balls that are grown; the largest third decides, being farthest from where a graph ends."""

BALL = 2000
"""Vertices in a ball that are enough to tell how it grows."""


def graph_dimension(n_vertices: int, edges: IntArray) -> int:
    """Return the dimension d for which balls of r hops hold about ``c (r + 1/2)^d`` vertices.

    Exact on infinite paths, square grids and triangular lattices, where a ball has 2r + 1,
    2r² + 2r + 1 and 3r² + 3r + 1 vertices. Balls are grown about vertices spread over the largest
    component until they have some two thousand vertices or a tenth of the component.

    Parameters
    ----------
    n_vertices : int
    edges : ndarray of shape (E, 2), int64

    Returns
    -------
    int
        At least 1.
    """
    if len(edges) == 0:
        return 1
    from scipy.sparse import coo_array, csr_array
    from scipy.sparse.csgraph import dijkstra  # a tenth of a second

    entries = (np.ones(len(edges)), tuple(edges.T))
    adjacency = csr_array(coo_array(entries, shape=(n_vertices, n_vertices)))
    labels = connected_by_edges(edges, n_vertices)
    members = np.flatnonzero(labels == np.bincount(labels).argmax())
    centres = members[np.linspace(0, len(members) - 1, SAMPLES + 2).astype(np.int64)[1:-1]]
    enough = min(BALL, max(len(members) // 10, 2))
    radius = 2
    while True:
        hops = dijkstra(adjacency, directed=False, indices=centres, unweighted=True, limit=radius)
        balls = np.isfinite(hops).sum(axis=1)
        largest = np.argsort(balls)[-(SAMPLES // 3) :]
        if np.median(balls[largest]) >= enough or radius > len(members):
            break
        radius *= 2
    inner = (hops[largest] <= radius // 2).sum(axis=1)
    growth = np.log(balls[largest] / inner) / np.log((radius + 0.5) / (radius // 2 + 0.5))
    return max(1, round(float(np.median(growth))))
