"""Shapes that several tests build: beside those of geodesic_toolkit.testing.shapes."""

import numpy as np
from scipy.spatial import ConvexHull

import geodesic_toolkit as gt


def random_sphere(count, noise=0.0, seed=0):
    """Return noisy random points of the unit sphere, and where they lie without noise."""
    rng = np.random.default_rng(seed)
    true = rng.normal(size=(count, 3))
    true /= np.linalg.norm(true, axis=1, keepdims=True)
    return true * (1 + noise * rng.normal(size=(count, 1))), true


def angles_from(points, source):
    """Return the distances of points of the unit sphere from one of them, without rounding."""
    across = np.linalg.norm(np.cross(points, points[source]), axis=1)
    return np.arctan2(across, points @ points[source])


def scrambled(mesh):
    """Return a mesh with its vertices, its faces and their corners in another order."""
    rng = np.random.default_rng(1)
    order = rng.permutation(mesh.n_vertices)
    faces = np.argsort(order)[mesh.faces][rng.permutation(mesh.n_faces)]
    return gt.TriangleMesh(mesh.vertices[order], faces[:, rng.permutation(3)])


def many_sheets(*, turned=(), alone=()):
    """Return five triangles with one edge in common, some turned round, and vertices of none."""
    turn = np.arange(5.0)
    tips = np.column_stack([0.3 * turn, np.cos(turn), np.sin(turn)])
    faces = [[1, 0, tip] if tip in turned else [0, 1, tip] for tip in range(2, 7)]
    vertices = np.vstack([[0, 0, 0], [1, 0, 0], tips, np.reshape(alone, (-1, 3))])
    return gt.TriangleMesh(vertices, faces)


def hull(points):
    """Return the convex hull as a mesh without other vertices."""
    found = ConvexHull(points)
    numbers = np.full(len(points), -1)
    numbers[found.vertices] = np.arange(len(found.vertices))
    return gt.TriangleMesh(points[found.vertices], numbers[found.simplices])


def edge_graph(mesh):
    """Return the edges of a mesh and their lengths as a graph."""
    edges = np.unique(np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    lengths = np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)
    return gt.Graph(mesh.n_vertices, edges, lengths)
