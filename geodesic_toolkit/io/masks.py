"""`read_mask`: the vertices that no path may cross, from a table."""

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit._typing import BoolArray
from geodesic_toolkit.errors import InvalidOptionError, ReadError
from geodesic_toolkit.io.common import array_of, floats, lines_of, tokens_of, whole_numbers
from geodesic_toolkit.io.reading import check_file, named_errors

__all__ = ["MASK_SUFFIXES", "read_mask"]

MASK_SUFFIXES = (".npy", ".txt", ".csv")

WORDS = {b"true": True, b"false": False}
"""What programs write for booleans beside 1 and 0, in lower case."""


def read_mask(path: str | os.PathLike[str], n_vertices: int) -> BoolArray:
    r"""Read a mask of vertices from a file: a boolean for each, or the indices of the masked ones.

    Parameters
    ----------
    path : str or path-like
        An .npy array with one dimension, or a .txt or .csv of values separated by blanks, commas
        or line ends. Booleans, or more than two numbers that are all 0 or 1, say for each vertex
        whether it is masked; other numbers are the indices, from 0, of those that are.
    n_vertices : int
        Number N of vertices of the shape.

    Returns
    -------
    ndarray of shape (N,), bool
        True at the masked vertices.

    Raises
    ------
    ReadError
        No such file, another suffix, or contents that are not whole numbers; the message names the
        file and what is wrong.
    NotEnoughMemoryError
        The file announces more than fits.
    InvalidOptionError
        Booleans that are not one for each vertex, or an index of no vertex.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from geodesic_toolkit.io import read_mask
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "wall.txt")
    ...     _ = file.write_text("0 3\n4\n")
    ...     read_mask(file, 5)
    array([ True, False, False,  True,  True])
    """
    file = Path(path)
    check_file(file)
    suffix = file.suffix.lower()
    if suffix not in MASK_SUFFIXES:
        raise ReadError(f"{file}: a mask is read from {', '.join(MASK_SUFFIXES)}")
    with named_errors(file, "the mask"):
        values = _array(file) if suffix == ".npy" else _text(file)
    if values.dtype.kind == "b" or _no_indices(values, n_vertices):
        if len(values) != n_vertices:
            raise InvalidOptionError(
                f"{file}: {len(values)} booleans, where the shape has {n_vertices} vertices"
            )
        return np.array(values, dtype=np.bool_)
    outside = values[(values < 0) | (values >= n_vertices)]
    if len(outside):
        raise InvalidOptionError(
            f"{file}: the shape has {n_vertices} vertices, counted from 0, and none is {outside[0]}"
        )
    mask = np.zeros(n_vertices, dtype=np.bool_)
    mask[values] = True
    return mask


def _no_indices(values: NDArray[Any], n_vertices: int) -> bool:
    """Return whether whole numbers are booleans: a list of two indices would name each once."""
    return bool(np.isin(values, (0, 1)).all() and (len(values) > 2 or len(values) == n_vertices))


def _array(file: Path) -> NDArray[Any]:
    table = array_of(file)
    if table.ndim != 1 or table.dtype.kind not in "biuf":
        raise ReadError(
            "a mask is an array of booleans or of vertex indices with one dimension, not "
            f"{table.dtype} of shape {table.shape}"
        )
    return table if table.dtype.kind == "b" else whole_numbers(table, "vertex indices")


def _text(file: Path) -> NDArray[Any]:
    tokens = tokens_of(lines_of(file))
    words = [WORDS.get(token.lower()) for token in tokens]
    if None not in words:
        return np.array(words, dtype=np.bool_)
    return whole_numbers(floats(tokens, "booleans or vertex indices"), "vertex indices")
