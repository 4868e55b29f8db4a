"""Checks of the data of discretizations, and of arrays that users pass."""

import sys
from typing import Any

import numpy as np

from geodesic_toolkit.core.frozen import freeze
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.errors import InvalidDiscretizationError, InvalidOptionError

__all__ = [
    "check_finite",
    "check_nothing_masked",
    "check_range",
    "coerce",
    "is_one_of",
    "real_number",
    "real_numbers",
]


def check_nothing_masked(values: Any, name: str, error: type[Exception], cure: str) -> None:
    """Raise if an array of NumPy has masked entries, which arrays here cannot have.

    Parameters
    ----------
    values : object
        Anything; only a masked array has a mask.
    name : str
        The name in the message.
    error : type
        The class of error to raise.
    cure : str
        Code for an array without a mask, in which ``{}`` stands for the name of the array.
    """
    if "numpy.ma" not in sys.modules:  # importing it takes 9 ms; without it there is no such array
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


def is_one_of(value: object, choices: tuple[object, ...]) -> bool:
    """Return whether an option is one of texts and booleans; arrays are equal to none."""
    return isinstance(value, str | bool | np.bool_) and value in choices


def real_number(value: Any, name: str) -> float:
    """Return what a user gave as one number; NaN and ``inf`` are kept.

    Raises
    ------
    InvalidOptionError
        Something else: a boolean, text, an array.
    """
    try:
        if isinstance(value, bool | np.bool_ | str | bytes) or np.ndim(value) != 0:
            raise TypeError
        return float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidOptionError(f"{name} must be a number, not {value!r:.60}") from error


def real_numbers(values: Any, name: str) -> FloatArray:
    """Return what a user gave as an array of float64; copied only if it is none.

    Text, dates and complex numbers, which NumPy would convert, are refused.

    Parameters
    ----------
    values : array-like
        Numbers or booleans, of any shape; NaN and ``inf`` are kept.
    name : str
        The name in messages.

    Raises
    ------
    InvalidOptionError
    """
    check_nothing_masked(values, name, InvalidOptionError, "{}.filled(numpy.inf)")
    try:
        array = np.asarray(values)
    except (TypeError, ValueError) as error:  # rows of different lengths
        raise InvalidOptionError(f"{name} cannot be read as an array: {error}") from error
    if array.dtype.kind not in "iufb":
        given = f"numbers of {array.dtype}" if array.dtype.kind == "c" else f"{array.dtype}"
        raise InvalidOptionError(f"{name} must hold real numbers, not {given}")
    return np.asarray(array, dtype=np.float64)


def coerce(data: object, *, copy: bool, **dtypes: type[np.generic]) -> None:
    """Make the named attributes read-only arrays of these dtypes, in C order.

    Without `copy`, arrays that already have dtype and order are used as they are.
    """
    as_array = np.array if copy else np.asarray
    for name, dtype in dtypes.items():
        try:
            array = np.atleast_1d(as_array(getattr(data, name), dtype, order="C"))
        except (TypeError, ValueError) as error:
            raise InvalidDiscretizationError(f"{name} is not an array: {error}") from error
        vars(data)[name] = freeze(array)


def check_range(indices: IntArray, n_vertices: int, name: str) -> None:
    """Raise an `InvalidDiscretizationError` if an index is not that of a vertex."""
    if indices.size and not (indices.min() >= 0 and indices.max() < n_vertices):
        outside = ((indices < 0) | (indices >= n_vertices)).any(axis=1)
        bad = int(np.flatnonzero(outside)[0])
        raise InvalidDiscretizationError(
            f"{name} {bad} refers to {indices[bad].tolist()}; there are {n_vertices} vertices"
        )


def check_finite(values: FloatArray, name: str) -> None:
    """Raise an `InvalidDiscretizationError` if a value is not finite; name the first such row."""
    if not np.isfinite(values.sum()):  # one pass, no temporary; checks rows only if it fails
        rows = np.isfinite(values).reshape(len(values), -1).all(axis=1)
        if not rows.all():
            raise InvalidDiscretizationError(
                f"{name} {int(np.flatnonzero(~rows)[0])} is not finite"
            )
