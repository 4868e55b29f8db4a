"""Checks that the data of a discretization share, and those of arrays that users give."""

import sys
from typing import Any

import numpy as np

from geodesic_toolkit.core.frozen import freeze
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.errors import InvalidDiscretizationError

__all__ = ["check_finite", "check_nothing_masked", "check_range", "coerce"]


def check_nothing_masked(values: Any, name: str, error: type[Exception], cure: str) -> None:
    """Raise for a masked array of NumPy in which something is masked: no array here is one.

    Parameters
    ----------
    values : object
        Anything; only a masked array has a mask.
    name : str
        What it is called in the message.
    error : type
        What to raise.
    cure : str
        What to give instead, in code, where ``{}`` stands for the array.
    """
    if "numpy.ma" not in sys.modules:  # to import it takes 9 ms; who has such an array has done so
        return
    if not isinstance(values, np.ma.MaskedArray):
        return
    masked = np.ma.getmaskarray(values)
    if masked.any():
        first = np.argwhere(masked)[0].tolist()
        raise error(
            f"{name} is a masked array, and entry {first} is masked, as {int(masked.sum())} of "
            f"{masked.size} are; give an array without a mask: {cure.format(name)}"
        )


def coerce(data: object, *, copy: bool, **dtypes: type[np.generic]) -> None:
    """Make the named attributes read-only arrays of these dtypes, in C order.

    Without `copy` those that have dtype and order already are taken over as they are.
    """
    as_array = np.array if copy else np.asarray
    for name, dtype in dtypes.items():
        try:
            array = np.atleast_1d(as_array(getattr(data, name), dtype, order="C"))
        except (TypeError, ValueError) as error:
            raise InvalidDiscretizationError(f"{name} is not an array: {error}") from error
        vars(data)[name] = freeze(array)


def check_range(indices: IntArray, n_vertices: int, name: str) -> None:
    """Raise an `InvalidDiscretizationError` unless indices are those of vertices."""
    if indices.size and not (indices.min() >= 0 and indices.max() < n_vertices):
        outside = ((indices < 0) | (indices >= n_vertices)).any(axis=1)
        bad = int(np.flatnonzero(outside)[0])
        raise InvalidDiscretizationError(
            f"{name} {bad} refers to {indices[bad].tolist()}; there are {n_vertices} vertices"
        )


def check_finite(values: FloatArray, name: str) -> None:
    """Raise an `InvalidDiscretizationError` unless all values are finite; name the first row."""
    if not np.isfinite(values.sum()):  # one pass without a temporary; look closer only on doubt
        rows = np.isfinite(values).reshape(len(values), -1).all(axis=1)
        if not rows.all():
            raise InvalidDiscretizationError(
                f"{name} {int(np.flatnonzero(~rows)[0])} is not finite"
            )
