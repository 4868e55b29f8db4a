"""Closed-form distances of the generated shapes, and how errors are measured."""

import numpy as np
from scipy.optimize import minimize_scalar

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


def by_snell(mesh, source, here, there):
    """Travel times in half planes x < 1/2 and x > 1/2, from a source in the first, by Fermat."""
    x, y = mesh.vertices[source, :2]
    times = np.empty(mesh.n_vertices)
    for vertex, (px, py, _) in enumerate(mesh.vertices):
        if px > 0.5 + 1e-9:
            found = minimize_scalar(
                lambda at, px=px, py=py: (
                    here * np.hypot(0.5 - x, at - y) + there * np.hypot(px - 0.5, py - at)
                ),
                bounds=(min(y, py) - 1e-9, max(y, py) + 1e-9),
                method="bounded",
                options={"xatol": 1e-10},
            )
            times[vertex] = found.fun
            continue
        times[vertex] = here * np.hypot(px - x, py - y)
        if there < here:  # the head wave, which runs along the line at its lesser cost
            aside = (0.5 - x) + (0.5 - px)
            critical = np.arcsin(there / here)
            along = abs(py - y) - aside * np.tan(critical)
            if along > 0:
                way = here * aside / np.cos(critical) + there * along
                times[vertex] = min(times[vertex], way)
    return times
