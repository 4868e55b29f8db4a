"""Isolines on a triangle mesh, computed by VTK."""

from typing import Any

import numpy as np

from geodesic_toolkit.core.optional import require
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.viz.scene import Scene, compacted

__all__ = ["contour_lines", "surface"]

MOST_LINES = 3
"""Number of isolines that a face shows, however close they are."""

LEAST_GAP = 0.01
"""Least distance of more isolines in one face, in coordinates where the shape has radius 1: about
two widths of a line. A face with closer ones, where the field jumps, would be black."""


def surface(points: FloatArray, faces: IntArray) -> tuple[Any, IntArray]:
    """Return a ``pyvista.PolyData`` of `faces`, and the indices of its points."""
    pyvista = require("pyvista", "viz", "Pictures need")
    used, own = compacted(faces)
    return pyvista.PolyData.from_regular_faces(points[used], own), used


def contour_lines(scene: Scene, levels: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the isolines of a scene's field as segments.

    Faces without a value at a corner have no isolines, nor faces in which many would overlap.

    Returns
    -------
    points : ndarray of shape (P, 3), float64
    segments : ndarray of shape (S, 2), int64
    """
    assert scene.faces is not None
    faces = scene.faces[scene.face_reached]
    nothing = np.zeros((0, 3)), np.zeros((0, 2), dtype=np.int64)
    if len(levels) == 0 or len(faces) == 0:
        return nothing
    faces = faces[_is_legible(scene, faces, levels)]
    if len(faces) == 0:
        return nothing
    mesh, used = surface(scene.points, faces)
    lines = mesh.contour(levels.tolist(), scalars=scene.values[used])
    if lines.n_lines == 0:
        return nothing
    segments = lines.lines.reshape(-1, 3)[:, 1:]
    return np.asarray(lines.points, dtype=np.float64), np.asarray(segments, dtype=np.int64)


def _is_legible(scene: Scene, faces: IntArray, levels: FloatArray) -> BoolArray:
    """Return a mask of the faces (F, 3) in which isolines do not overlap."""
    values, corners = scene.values[faces], scene.points[faces]
    crossing = np.searchsorted(levels, values.max(axis=1), side="right")
    crossing -= np.searchsorted(levels, values.min(axis=1))
    sizes = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    return np.asarray((crossing <= MOST_LINES) | (sizes >= LEAST_GAP * crossing))
