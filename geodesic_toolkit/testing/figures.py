"""Measures of difference that several laws use."""

import numpy as np
from scipy.sparse import csr_array

from geodesic_toolkit.core.types import FloatArray

__all__ = ["ALGEBRA", "largest", "relative"]

ALGEBRA = 1e-9
"""Tolerance of identities between products of sparse matrices."""


def largest(matrix: csr_array) -> float:
    """Return the largest absolute entry, or 0 if there is none."""
    return float(np.abs(matrix.data).max(initial=0.0))


def relative(got: FloatArray, expected: FloatArray, floor: float = 0.0) -> float:
    """Return the largest difference, relative to the largest expected value or `floor`."""
    scale = max(float(np.abs(expected).max(initial=0.0)), floor)
    difference = float(np.abs(got - expected).max(initial=0.0))
    return difference / scale if scale else difference
