"""Irregular meshes with closed forms for directions: logarithms, parallel transport."""

import numpy as np
from scipy.spatial import ConvexHull, Delaunay

import geodesic_toolkit as gt


def irregular_sphere(n=1500, seed=0, rounds=3):
    """Random points on the unit sphere, moved apart a little, and their convex hull."""
    points = np.random.default_rng(seed).normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    for _ in range(rounds):
        hull = ConvexHull(points).simplices
        total, count = np.zeros_like(points), np.zeros(n)
        for i, j in ((0, 1), (1, 2), (2, 0)):
            for one, other in ((i, j), (j, i)):
                np.add.at(total, hull[:, one], points[hull[:, other]])
                np.add.at(count, hull[:, one], 1)
        points = total / count[:, None]
        points /= np.linalg.norm(points, axis=1)[:, None]
    faces = ConvexHull(points).simplices.astype(np.int64)
    return gt.TriangleMesh(points, outward(points, faces, points[faces[:, 0]]))


def irregular_plate(n=30, seed=0):
    """The unit square with shaken inner vertices."""
    grid = np.stack(np.meshgrid(*(np.linspace(0, 1, n),) * 2), axis=-1).reshape(-1, 2)
    inside = (grid > 0).all(axis=1) & (grid < 1).all(axis=1)
    shake = np.random.default_rng(seed).uniform(-0.35, 0.35, (inside.sum(), 2))
    grid[inside] += shake / n
    points = np.column_stack([grid, np.zeros(len(grid))])
    faces = Delaunay(grid).simplices.astype(np.int64)
    areas = np.linalg.norm(
        np.cross(*(points[faces[:, c]] - points[faces[:, 0]] for c in (1, 2))), axis=1
    )
    faces = faces[areas > 1e-9 * areas.max()]
    return gt.TriangleMesh(points, outward(points, faces, np.tile([0.0, 0, 1], (len(faces), 1))))


def outward(points, faces, directions):
    """Turn faces so that their normals go along directions."""
    normals = np.cross(*(points[faces[:, c]] - points[faces[:, 0]] for c in (1, 2)))
    inward = np.einsum("fd,fd->f", normals, directions) < 0
    return np.where(inward[:, None], faces[:, ::-1], faces)


def transported_on_sphere(points, source, vector):
    """Return a tangent vector at a vertex of the unit sphere, carried along great circles."""
    p = points[source]
    cosine = np.clip(points @ p, -1, 1)
    away = points - cosine[:, None] * p
    sine = np.linalg.norm(away, axis=1)
    out = np.divide(away, sine[:, None], out=np.zeros_like(away), where=sine[:, None] > 0)
    side = np.cross(p, out)
    arrival = -sine[:, None] * p + cosine[:, None] * out
    moved = (out @ vector)[:, None] * arrival + (side @ vector)[:, None] * side
    moved[source] = vector
    return moved


def degrees_between(one, other):
    """Return the angles between the rows of two tables of vectors."""
    sine = np.linalg.norm(np.cross(one, other), axis=-1)
    return np.degrees(np.arctan2(sine, np.einsum("...d,...d->...", one, other)))


def moebius(n=24):
    """A one-sided strip."""
    turn = np.repeat(2 * np.pi * np.arange(n) / n, 3)
    aside = np.tile([-0.3, 0.0, 0.3], n)
    radius = 1 + aside * np.cos(turn / 2)
    points = np.column_stack(
        [radius * np.cos(turn), radius * np.sin(turn), aside * np.sin(turn / 2)]
    )
    faces = []
    for k in range(n):
        here = [3 * k, 3 * k + 1, 3 * k + 2]
        there = [3 * k + 3, 3 * k + 4, 3 * k + 5] if k < n - 1 else [2, 1, 0]
        for i in range(2):
            faces += [[here[i], here[i + 1], there[i + 1]], [here[i], there[i + 1], there[i]]]
    return gt.TriangleMesh(points, np.array(faces))
