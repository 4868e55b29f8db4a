"""Marks as meshes: points as balls, and lines as tubes, half of which a surface covers."""

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["balls", "tube"]

N_SIDES = 16
"""Number of sides of a tube, and of a ball around its axis."""


def balls(centres: FloatArray, radius: float) -> tuple[FloatArray, IntArray]:
    """Return one mesh of balls around the (Q, 3) centres: points (P, 3), faces (F, 3)."""
    heights = np.linspace(0, np.pi, N_SIDES // 2 + 1)
    around = 2 * np.pi * np.arange(N_SIDES) / N_SIDES
    ring = np.stack([np.cos(around), np.sin(around), np.ones(N_SIDES)], axis=1)
    widths = np.stack([np.sin(heights), np.sin(heights), np.cos(heights)], axis=1)
    ball = (widths[:, None] * ring).reshape(-1, 3)
    points = (centres[:, None] + radius * ball).reshape(-1, 3)
    faces = _strips(len(heights))[:, ::-1]  # the axis runs down
    shifted = faces + len(ball) * np.arange(len(centres))[:, None, None]
    return points, shifted.reshape(-1, 3)


def _strips(n_rings: int) -> IntArray:
    """Return the triangles between rings of points, one after the other."""
    ring = np.arange(N_SIDES)
    after = np.roll(ring, -1)
    quads = np.stack([ring, after, after + N_SIDES, ring + N_SIDES], axis=1)
    quads = (quads + N_SIDES * np.arange(n_rings - 1)[:, None, None]).reshape(-1, 4)
    return np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def tube(line: FloatArray, radius: float) -> tuple[FloatArray, IntArray]:
    """Return the surface around a polyline: points of shape (P, 3), faces of shape (F, 3).

    Parameters
    ----------
    line : ndarray of shape (Q, 3)
        Points in order; repeated ones count once.
    radius : float

    Examples
    --------
    >>> points, faces = tube(np.array([[0.0, 0, 0], [1, 0, 0]]), 0.1)
    >>> points.shape, faces.shape
    ((32, 3), (32, 3))
    """
    moved = np.linalg.norm(np.diff(line, axis=0), axis=1) > 1e-6 * radius
    line = line[np.concatenate([[True], moved])[: len(line)]]
    if len(line) < 2:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    pieces = np.diff(line, axis=0)
    pieces /= np.linalg.norm(pieces, axis=1, keepdims=True)
    ahead = np.vstack([pieces[:1], pieces[:-1] + pieces[1:], pieces[-1:]])
    lengths = np.linalg.norm(ahead, axis=1, keepdims=True)
    turning_back = lengths[:, 0] < 1e-9
    ahead[turning_back] = np.vstack([pieces, pieces[-1:]])[turning_back]
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    side = np.cross(ahead[0], np.eye(3)[np.argmin(np.abs(ahead[0]))])
    sides = np.empty_like(line)
    for index, direction in enumerate(ahead):  # carried along, so that the tube does not twist
        carried = side - (side @ direction) * direction
        length = np.linalg.norm(carried)
        if length < 1e-6:  # the line turns back on itself
            carried = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
            length = np.linalg.norm(carried)
        sides[index] = side = carried / length
    angles = 2 * np.pi * np.arange(N_SIDES) / N_SIDES
    circle = (
        np.cos(angles)[:, None] * sides[:, None]
        + np.sin(angles)[:, None] * np.cross(ahead, sides)[:, None]
    )
    points = (line[:, None] + radius * circle).reshape(-1, 3)
    return points, _strips(len(line))
