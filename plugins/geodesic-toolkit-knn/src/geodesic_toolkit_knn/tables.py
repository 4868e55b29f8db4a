"""Tables of samples, checked."""

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodesic_toolkit.domains.base import as_table_of_floats
from geodesic_toolkit.errors import InvalidDomainError

__all__ = ["FloatArray", "IntArray", "as_table"]

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]

SIZES = (1e-60, 1e60)
"""Extents of samples whose shortest steps have fourth powers, and inverse ones, in float64."""


def as_table(points: ArrayLike) -> FloatArray:
    """Return samples as a new table (N, D) in which a sample is finite or entirely NaN.

    Raises
    ------
    InvalidDomainError
        Not a table of real numbers, no sample that is not missing, a value that is not finite, or
        samples too close together or too far apart for floats.
    """
    if hasattr(points, "tocsr"):
        raise InvalidDomainError(
            "points are a sparse matrix; give points.toarray(), or fewer columns, as by "
            "sklearn.decomposition.TruncatedSVD (neighbours in thousands of columns are nearly "
            "arbitrary)"
        )
    table = as_table_of_floats(points, "points")
    if 0 in table.shape:
        raise InvalidDomainError(
            f"points must have shape (N, D), not {table.shape}: there are no "
            f"{'coordinates' if len(table) else 'samples'}"
        )
    missing = np.isnan(table).all(axis=1)
    if missing.all():
        raise InvalidDomainError("all samples are missing: every coordinate is NaN")
    sound = np.isfinite(table).all(axis=1) | missing
    if not sound.all():
        bad = int(sound.argmin())
        raise InvalidDomainError(
            f"sample {bad} has a coordinate that is not finite; fill it, or set all its "
            "coordinates to NaN to leave it out"
        )
    chosen = table[~missing]
    extent = float((chosen.max(axis=0) / 2 - chosen.min(axis=0) / 2).max())
    if extent > 0 and not SIZES[0] < extent < SIZES[1]:
        raise InvalidDomainError(
            f"samples extend over {extent:.1e}, whose powers floats do not have; rescale them"
        )
    return table
