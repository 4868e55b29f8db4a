"""Arrows of tangent vectors: a spread selection of vertices, and lengths to scale."""

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.analysis.thinning import thin
from geodesic_toolkit.core.checks import real_numbers
from geodesic_toolkit.core.types import BoolArray, FloatArray
from geodesic_toolkit.domains import PointCloud
from geodesic_toolkit.errors import InvalidOptionError

__all__ = ["spread_arrows"]

SPACING_OF_ARROWS = 0.11
"""Least distance between arrows, in coordinates where the shape has radius 1."""

LONGEST_ARROW = 0.11
"""Length of the longest arrow in these coordinates."""


def spread_arrows(
    points: FloatArray, present: BoolArray, vectors: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return the positions (A, 3) and vectors (A, 3) of arrows that are far enough apart to see.

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
        In coordinates where the shape has radius 1.
    present : ndarray of shape (N,), bool
    vectors : array-like of shape (N, 3)
        Vertices with a vector that is 0 or not finite have no arrow.

    Raises
    ------
    InvalidOptionError
        Vectors of another shape.
    """
    table = real_numbers(vectors, "arrows")
    if table.shape != points.shape:
        raise InvalidOptionError(
            f"arrows must have shape {points.shape}, one vector per vertex, not {table.shape}"
        )
    lengths = np.linalg.norm(table, axis=1)
    shown = np.flatnonzero(present & np.isfinite(lengths) & (lengths > 0))
    if not len(shown):
        return np.zeros((0, 3)), np.zeros((0, 3))
    kept = shown[thin(PointCloud(points[shown]), SPACING_OF_ARROWS).index]
    return points[kept], table[kept] * (LONGEST_ARROW / lengths[kept].max())
