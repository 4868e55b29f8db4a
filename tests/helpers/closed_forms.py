"""Closed-form distances of the generated shapes, and how errors are measured."""

import numpy as np

import geodesic_toolkit as gt


def mean_relative_error(distance, exact):
    away = exact > 0
    return float((np.abs(distance - exact)[away] / exact[away]).mean())


def on_plane(mesh, source):
    return np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)


def on_sphere(mesh, source, radius=1.0):
    chord = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1) / radius
    return 2 * radius * np.arcsin(np.clip(chord / 2, 0, 1))


def on_tube(rings, around, edge=1.0, source=0):
    """Distances on ``shapes.tube``: those of the unrolled plane, the shorter direction around."""
    ring = np.repeat(np.arange(rings), around)
    angle = np.tile(np.arange(around), rings) + 0.5 * ring
    across = (angle - angle[source]) % around
    return edge * np.hypot(
        np.minimum(across, around - across), (ring - ring[source]) * np.sqrt(3) / 2
    )


def around_torus_ring(m, minor):
    """Distances from vertex 0 to the others of its ring on ``shapes.torus``."""
    step = np.arange(m)
    return minor * 2 * np.pi * np.minimum(step, m - step) / m


def bent_path(n, spacing=1.0):
    """A path graph and the distances from its first vertex."""
    steps = np.arange(n)
    edges = np.column_stack([steps[:-1], steps[1:]])
    return gt.Graph(n, edges, np.full(n - 1, spacing)), steps * spacing
