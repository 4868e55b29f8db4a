"""Lengths of polylines over faces that have lengths of their own."""

from __future__ import annotations

import numpy as np

from geodesic_toolkit.analysis.paths.metric.faces import segment_length
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains.measured import MeasuredFaces
from geodesic_toolkit.errors import InvalidSourceError

__all__ = ["steps_over"]

OUTSIDE = 1e-9
"""Weight of other vertices with which a point is outside a face."""


def steps_over(
    mesh: MeasuredFaces, faces: IntArray, weights: FloatArray, *, closed: bool
) -> FloatArray:
    """Return the lengths of the segments of a polyline, each in the cheaper face that has it.

    Parameters
    ----------
    mesh : MeasuredFaces
    faces : ndarray of shape (P,), int64
        A face of each point.
    weights : ndarray of shape (P, 3), float64
        Barycentric coordinates there.
    closed : bool
        With a segment from the last point to the first.

    Returns
    -------
    ndarray of shape (P - 1,) or (P,), float64

    Raises
    ------
    InvalidSourceError
        Two points in a row of which neither is in the face of the other.
    """
    here = np.arange(len(faces) if closed else len(faces) - 1)
    there = (here + 1) % len(faces)
    steps = np.minimum(
        _steps_in(mesh, faces[here], weights[here], faces[there], weights[there]),
        _steps_in(mesh, faces[there], weights[there], faces[here], weights[here]),
    )
    if not np.isfinite(steps).all():
        bad = int(np.isinf(steps).argmax())
        raise InvalidSourceError(
            f"points {bad} and {int(there[bad])} of the path are in the faces {faces[bad]} and "
            f"{faces[there[bad]]}, and neither is in the face of the other; a segment of a path "
            "has a length where it runs through one face"
        )
    return steps


def _steps_in(
    mesh: MeasuredFaces,
    faces: IntArray,
    weights: FloatArray,
    others: IntArray,
    other_weights: FloatArray,
) -> FloatArray:
    """Return the lengths from points to others in the faces of the former; inf to those outside."""
    same = mesh.faces[faces][:, :, None] == mesh.faces[others][:, None, :]
    moved = np.einsum("pcd,pd->pc", same, other_weights)
    lengths = segment_length(mesh.lengths[faces], moved - weights)
    return np.where(np.abs(moved.sum(axis=1) - 1) <= OUTSIDE, lengths, np.inf)
