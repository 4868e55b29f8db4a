"""Matrices of graphs and of shapes, and their elimination by other means."""

import os
import subprocess
import sys
import textwrap
from itertools import pairwise

import numpy as np
from hypothesis import strategies as st
from scipy.sparse import csr_array, diags_array, eye_array, kron, random_array
from scipy.spatial import cKDTree

import geodesic_toolkit as gt
from geodesic_toolkit import _native
from geodesic_toolkit.testing import shapes

SOLVER = gt.Supernodal()


# -- matrices --------------------------------------------------------------------------------------


def graph_laplacian(n, edges, weights=None):
    """The Laplacian of a graph, with a diagonal in its pattern."""
    i, j = np.asarray(edges, dtype=np.int64).reshape(-1, 2).T
    w = np.ones(len(i)) if weights is None else weights
    rows, columns = np.r_[i, j, i, j, np.arange(n)], np.r_[j, i, i, j, np.arange(n)]
    return csr_array((np.r_[-w, -w, w, w, np.zeros(n)], (rows, columns)), shape=(n, n))


def plus(matrix, diagonal):
    return csr_array(matrix + diags_array(np.broadcast_to(diagonal, matrix.shape[0])))


def path(n):
    return graph_laplacian(n, list(pairwise(range(n))))


def star(n):
    return graph_laplacian(n, [(0, k) for k in range(1, n)])


def complete(n):
    return graph_laplacian(n, [(i, j) for i in range(n) for j in range(i)])


def grid(n, m):
    return csr_array(kron(path(n), eye_array(m)) + kron(eye_array(n), path(m)))


def neighbour_graph(n, k):
    points = np.random.default_rng(n).normal(size=(n, 3))
    near = cKDTree(points).query(points, k + 1)[1][:, 1:]
    pairs = np.stack([np.repeat(np.arange(n), k), near.ravel()], axis=1)
    return graph_laplacian(n, np.unique(np.sort(pairs, axis=1), axis=0))


def stiffness(mesh):
    return gt.CotanLaplacian().assemble(mesh).stiffness


def arrow(width, below):
    """Cliques of so many vertices each, that all hang on one clique of `below` vertices.

    There are so many of them that the one in the middle is not eliminated first.
    """
    cliques, shared = below // width + 6, np.arange(below)
    edges = [(i, j) for i in shared for j in range(i)]
    for c in range(cliques):
        own = below + c * width + np.arange(width)
        edges += [(i, j) for i in own for j in (*shared, *range(own[0], i))]
    return graph_laplacian(below + cliques * width, edges)


LAPLACIANS = {
    "icosphere": lambda: stiffness(shapes.icosphere(3)),
    "torus": lambda: stiffness(shapes.torus(40, 20)),
    "tube": lambda: stiffness(shapes.tube(60, 12)),
    "grid of squares": lambda: grid(30, 25),
    "several parts": lambda: stiffness(
        shapes.disjoint_union(shapes.icosphere(2), shapes.torus(16, 8), shapes.icosphere(1))
    ),
    "neighbours in space": lambda: neighbour_graph(400, 6),
    "narrow on little": lambda: arrow(3, 20),
    "narrow on much": lambda: arrow(3, 90),
    "wide on little": lambda: arrow(20, 20),
    "wide on much": lambda: arrow(20, 90),
    "one wide block": lambda: complete(200),
    "packed": lambda: arrow(70, 400),
    "star": lambda: star(300),
}


def random_definite(rng, kind):
    """A random symmetric positive definite matrix, of a condition that leaves ten digits."""
    n = int(rng.integers(1, 81))
    if kind == "M-matrix":
        count = int(rng.integers(0, 3 * n + 1))
        edges = rng.integers(0, n, size=(count, 2))
        edges = edges[edges[:, 0] != edges[:, 1]]
        laplacian = graph_laplacian(n, edges, rng.exponential(size=len(edges)))
        return plus(laplacian, rng.uniform(0.01, 1, n))
    root = random_array((n, n), density=min(1, 3 * rng.random() / n), rng=rng, dtype=np.float64)
    root.data -= 0.5
    return plus(csr_array(root @ root.T), 0.1)


# -- graphs for hypothesis -------------------------------------------------------------------------


@st.composite
def graphs(draw):
    """Symmetric patterns of all kinds; not all have a diagonal."""
    n = draw(st.integers(0, 40))
    vertex = st.integers(0, max(n - 1, 0))
    edges = set(draw(st.lists(st.tuples(vertex, vertex), max_size=3 * n))) if n else set()
    edges = {edge for edge in edges if edge[0] != edge[1]}
    if n > 1 and draw(st.booleans()):  # a row that is full
        hub = draw(vertex)
        edges |= {(hub, k) for k in range(n) if k != hub}
    if draw(st.booleans()):
        edges |= {(k, k) for k in range(n)}
    edges |= {(j, i) for i, j in edges}
    rows, columns = np.array(sorted(edges), dtype=np.int64).reshape(-1, 2).T
    return csr_array((np.ones(len(rows)), (rows, columns)), shape=(n, n))


def pattern_of(matrix):
    return matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32)


def elimination_of(matrix):
    return _native.minimum_degree(*pattern_of(matrix))


def analyze(matrix):
    return _native.analyze(*pattern_of(matrix))


def panels_of(factor):
    return factor._factor.panels


def in_a_process(program, *arguments, **environment):
    return subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program), *map(str, arguments)],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
