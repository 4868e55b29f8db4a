"""Geodesics in closed form, or integrated to many digits."""

import numpy as np
from scipy.spatial import Delaunay

import geodesic_toolkit as gt


def log_on_sphere(points, source):
    """Return the logarithms (N, 3) of points of the unit sphere about one of them."""
    p = points[source] if np.ndim(source) == 0 else np.asarray(source)
    away = points - (points @ p)[:, None] * p
    sine = np.linalg.norm(away, axis=1)
    distance = np.arctan2(sine, points @ p)
    return (
        np.divide(away, sine[:, None], out=np.zeros_like(away), where=sine[:, None] > 0)
        * (distance[:, None])
    )


def irregular_cylinder(n=1200, height=3.0, seed=0):
    """A cylinder of radius 1 with shaken vertices, and where these lie when it is unrolled."""
    step = np.sqrt(2 * np.pi * height / n)
    around, up = round(2 * np.pi / step), round(height / step)
    angle, z = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.linspace(0, height, up))
    flat = np.column_stack([angle.ravel(), z.ravel()])
    inside = (flat[:, 1] > 0) & (flat[:, 1] < height)
    flat[inside] += np.random.default_rng(seed).uniform(-0.35, 0.35, (inside.sum(), 2)) * step
    turns = 2 * np.pi * np.array([[-1.0, 0], [0, 0], [1, 0]])
    copies = (flat + turns[:, None]).reshape(-1, 2)
    faces = Delaunay(copies).simplices.astype(np.int64)
    a, b, c = (copies[faces[:, i]] for i in range(3))
    areas = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    faces = np.where(areas[:, None] < 0, faces[:, ::-1], faces)
    middle = copies[faces].mean(axis=1)[:, 0]
    kept = (middle >= 0) & (middle < 2 * np.pi) & (np.abs(areas) > 1e-9 * step**2)
    points = np.column_stack([np.cos(flat[:, 0]), np.sin(flat[:, 0]), flat[:, 1]])
    return gt.TriangleMesh(points, faces[kept] % len(flat)), flat


def shoot_on_ellipsoid(axes, point, vectors, steps=400):
    """Return where geodesics of an ellipsoid end that leave a point along tangent vectors.

    Runge and Kutta's fourth order, for x'' = -(x'ᵀ H x' / |g|²) g with g = H x.
    """
    scale = 1 / np.asarray(axes) ** 2

    def rate(x, v):
        g = x * scale
        return v, -(np.einsum("nd,nd->n", v, v * scale) / np.einsum("nd,nd->n", g, g))[:, None] * g

    x, v, h = np.tile(point, (len(vectors), 1)), np.array(vectors), 1 / steps
    for _ in range(steps):
        x1, v1 = rate(x, v)
        x2, v2 = rate(x + h / 2 * x1, v + h / 2 * v1)
        x3, v3 = rate(x + h / 2 * x2, v + h / 2 * v2)
        x4, v4 = rate(x + h * x3, v + h * v3)
        x = x + h / 6 * (x1 + 2 * x2 + 2 * x3 + x4)
        v = v + h / 6 * (v1 + 2 * v2 + 2 * v3 + v4)
    return x
