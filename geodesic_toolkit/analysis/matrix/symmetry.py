"""Symmetric matrices from nearly symmetric ones, one band of rows at a time.

Heat distances from i to j and from j to i differ by about a per cent, and many methods need a
matrix that is exactly symmetric.
"""

from collections.abc import Callable, Iterator
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from geodesic_toolkit.core.types import IntArray
from geodesic_toolkit.errors import InvalidOptionError

__all__ = [
    "Symmetrize",
    "check_symmetrize",
    "symmetric_bands",
    "symmetrize_in_place",
    "symmetrized_entries",
    "unknown_rows",
    "widened",
]

Symmetrize: TypeAlias = Literal["mean", "min", "max"] | None
"""The rule that makes two mirrored entries equal."""

Matrix: TypeAlias = NDArray[np.floating[Any]]

BAND_BYTES = 256e6
"""Size of a band of rows in memory, and of the columns that mirror it, in bytes."""


SHARE_BEYOND_LIMIT = 0.05
"""Share by which rows are known beyond the limit of a mean. Mirrored entries that differ by more
make a few rows be measured again, farther; refined distances differ by 0.2 %, plain ones by 1 %."""

ROUNDING_OF_SUMS = 1e-6
"""Share by which the sum of two entries in single precision may be smaller than it is."""


def check_symmetrize(how: object) -> None:
    """Raise an `InvalidOptionError` if `how` is not a `Symmetrize`."""
    known = get_args(get_args(Symmetrize)[0])
    if how is not None and how not in known:
        raise InvalidOptionError(f'symmetrize must be "mean", "min", "max" or None, not {how!r}')


def symmetric_bands(
    matrix: Matrix, how: str, multiple: int = 1
) -> Iterator[tuple[int, NDArray[np.floating[Any]]]]:
    """Yield bands of rows of a square matrix made symmetric, each with the index of its first row.

    Parameters
    ----------
    matrix : ndarray of shape (N, N)
        May be a memory map: only one band of it is in memory at a time.
    how : {"mean", "min", "max"}
    multiple : int
        The number of rows of every band but the last is a multiple of this.
    """
    for start, stop in _bands(matrix, multiple):
        yield start, _merged(matrix[start:stop], matrix[:, start:stop].T, how)


def symmetrize_in_place(matrix: Matrix, how: str) -> None:
    """Make a square matrix in memory symmetric."""
    for start, stop in _bands(matrix, 1):
        merged = _merged(matrix[start:stop, start:], matrix[start:, start:stop].T, how)
        matrix[start:stop, start:] = merged
        matrix[start:, start:stop] = merged.T


def _bands(matrix: Matrix, multiple: int) -> Iterator[tuple[int, int]]:
    fitting = int(BAND_BYTES / (2 * matrix.itemsize * max(1, len(matrix))))
    rows = max(1, fitting // multiple) * multiple
    for start in range(0, len(matrix), rows):
        yield start, min(start + rows, len(matrix))


def _merged(there: Matrix, back: Matrix, how: str) -> Matrix:
    """Merge two mirrored matrices into one; swapping them does not change a bit."""
    if how == "mean":
        merged: Matrix = there + back
        merged *= merged.dtype.type(0.5)
        return merged
    return _pick(how)(there, back)


def _pick(how: str) -> Callable[[Matrix, Matrix], Matrix]:
    return {"min": np.minimum, "max": np.maximum}[how]


# -- sparse ----------------------------------------------------------------------------------------


def widened(limit: float, how: str | None) -> float:
    """Return the limit up to which entries are kept, so that nearly all symmetric ones are known.

    See `unknown_rows` for the others.
    """
    return (1 + SHARE_BEYOND_LIMIT) * limit if how == "mean" else limit


def unknown_rows(matrix: csr_array, how: str, limit: float) -> tuple[IntArray, float]:
    """Return the rows that must be known farther, and how far, for the symmetric entries.

    The mean of an entry and of the one that mirrors it may be up to the limit although the latter
    is not stored: the mean of 0 and of twice the limit is.

    Parameters
    ----------
    matrix : csr_array of shape (N, N)
        Entries that are not stored are above ``widened(limit, how)``.
    how : {"mean", "min", "max"}
    limit : float

    Returns
    -------
    rows : ndarray of int64
        Ascending.
    limit : float
    """
    most = 2 * limit * (1 + ROUNDING_OF_SUMS)
    rows = np.repeat(np.arange(matrix.shape[0], dtype=np.int64), np.diff(matrix.indptr))
    columns, size = matrix.indices.astype(np.int64), matrix.shape[0]
    near = np.flatnonzero(matrix.data + widened(limit, how) < most) if how == "mean" else rows[:0]
    stored = np.sort(rows * size + columns)
    mirrored = columns[near] * size + rows[near]
    place = np.minimum(np.searchsorted(stored, mirrored), len(stored) - 1)
    alone = near[stored[place] != mirrored]
    if not len(alone):
        return alone, limit
    return np.unique(columns[alone]), most - float(matrix.data[alone].min())


def symmetrized_entries(matrix: csr_array, how: str, limit: float) -> csr_array:
    """Return the entries up to `limit` of a matrix made symmetric, including zeros.

    Parameters
    ----------
    matrix : csr_array of shape (N, N)
        Entries that are not stored are above the limit, and those whose mean with a stored one is
        not are stored.
    how : {"mean", "min", "max"}
    limit : float
    """
    size = matrix.shape[0]
    rows = np.repeat(np.arange(size, dtype=np.int64), np.diff(matrix.indptr))
    columns = matrix.indices.astype(np.int64)
    keys = np.concatenate([rows * size + columns, columns * size + rows])
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    values = np.concatenate([matrix.data, matrix.data])[order]
    first = np.flatnonzero(np.diff(keys, prepend=-1))
    alone = np.diff(first, append=len(keys)) == 1
    there = values[first]
    back = values[np.minimum(first + 1, len(values) - 1)] if len(values) else values
    merged = np.where(alone, there, _merged(there, back, how))
    # The partner of a lone entry is above the limit: only the minimum of the two is known.
    kept = (merged <= np.float64(limit)) & (~alone | (how == "min"))
    keys, merged = keys[first][kept], merged[kept]
    starts = np.searchsorted(keys, np.arange(size + 1, dtype=np.int64) * size)
    return csr_array((merged, keys % size, starts), shape=matrix.shape)
