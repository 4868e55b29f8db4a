"""`read_vertices` and `read_mask`: read vertices from a table or a file of neuroimaging."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit.core.atomic import as_path
from geodesic_toolkit.core.types import BoolArray, IntArray
from geodesic_toolkit.errors import InvalidOptionError, ReadError
from geodesic_toolkit.io.common import array_of, floats, whole_numbers
from geodesic_toolkit.io.reading import check_file, named_errors, unpacked
from geodesic_toolkit.io.tables.regions import REGION_SUFFIXES, check_no_region, read_region
from geodesic_toolkit.io.tables.rows import read_table

__all__ = ["read_mask", "read_vertices"]

SUFFIXES = (".npy", ".txt", ".csv", *REGION_SUFFIXES)

WORDS = {b"true": True, b"false": False}
"""Booleans as programs write them besides 1 and 0, in lower case."""


def read_vertices(path: str | os.PathLike[str], *, region: str | None = None) -> IntArray:
    r"""Read a list of vertex indices from a file.

    Parameters
    ----------
    path : str or path-like
        An .npy array with one dimension, or a .txt or .csv of whole numbers separated by blanks,
        commas, semicolons or line ends. The first line may hold names, and ``#`` begins a comment;
        of several named columns, ``vertex`` is read. Or a file of neuroimaging that marks
        vertices: a FreeSurfer .label; an .annot or GIFTI .label.gii with a `region`; a GIFTI .gii
        of zeros and ones. Each may be compressed (.gz).
    region : str, optional
        The name of the region of an .annot or .label.gii.

    Returns
    -------
    ndarray of shape (K,), int64
        In the order of the file. They are not checked against a shape.

    Raises
    ------
    ReadError
        The file does not exist, has another suffix, or its contents are not whole numbers; the
        message names the file and the defect.
    InvalidOptionError
        The region does not exist, or one must be chosen.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from geodesic_toolkit.io import read_vertices
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "landmarks.csv")
    ...     _ = file.write_text("vertex\n500\n2000\n")
    ...     read_vertices(file)
    array([ 500, 2000])
    """
    with _opened(as_path(path), "vertices are", "the list of vertices") as plain:
        if plain.suffix.lower() in REGION_SUFFIXES:
            return read_region(plain, region)[0]
        check_no_region(plain, region)
        if plain.suffix.lower() == ".npy":
            return whole_numbers(_array(plain, "iuf", "vertices are an array of"), "vertex indices")
        numbers = floats(read_table(plain).values("vertex"), "vertex indices")
        return whole_numbers(numbers, "vertex indices")


def read_mask(
    path: str | os.PathLike[str], n_vertices: int, *, region: str | None = None
) -> BoolArray:
    r"""Read a mask of vertices from a file: a boolean for each, or the indices of the masked ones.

    Parameters
    ----------
    path : str or path-like
        An .npy array with one dimension, or a .txt or .csv of values separated by blanks, commas,
        semicolons or line ends. Booleans, or more than two numbers that are all 0 or 1, state for
        each vertex whether it is masked; other numbers are the indices of masked vertices, from 0.
        Or a file of neuroimaging that marks vertices: a FreeSurfer .label; an .annot or GIFTI
        .label.gii, of which `region` is masked; a GIFTI .gii of zeros and ones. Each may be
        compressed (.gz).
    n_vertices : int
        Number N of vertices of the shape.
    region : str, optional
        The name of the region of an .annot or .label.gii.

    Returns
    -------
    ndarray of shape (N,), bool
        True at the masked vertices.

    Raises
    ------
    ReadError
        The file does not exist, has another suffix, or its contents are not whole numbers; the
        message names the file and the defect.
    NotEnoughMemoryError
        The file announces more data than fit into memory.
    InvalidOptionError
        The number of booleans or regions is not that of the vertices, an index is out of range, or
        the region does not exist.

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
    file = as_path(path)
    what = "booleans"
    with _opened(file, "a mask is", "the mask") as plain:
        if plain.suffix.lower() in REGION_SUFFIXES:
            what = "regions"
            values, expected = read_region(plain, region)
        else:
            check_no_region(plain, region)
            values = _flags_or_indices(plain)
            flags = values.dtype.kind == "b" or _no_indices(values, n_vertices)
            expected = len(values) if flags else None
            values = np.flatnonzero(values) if flags else values
    if expected not in {None, n_vertices}:
        raise InvalidOptionError(
            f"{file}: {expected} {what}, but the shape has {n_vertices} vertices"
        )
    outside = values[(values < 0) | (values >= n_vertices)]
    if len(outside):
        raise InvalidOptionError(
            f"{file}: there is no vertex {outside[0]}: they are 0 to {n_vertices - 1}"
        )
    mask = np.zeros(n_vertices, dtype=np.bool_)
    mask[values] = True
    return mask


@contextmanager
def _opened(file: Path, are: str, what: str) -> Iterator[Path]:
    """Yield the path of a file, unpacked, with errors that name the file."""
    check_file(file)
    with unpacked(file) as plain:
        if plain.suffix.lower() not in SUFFIXES:
            raise ReadError(f"{file}: {are} read from {', '.join(SUFFIXES)}")
        with named_errors(file, what):
            yield plain


def _flags_or_indices(file: Path) -> NDArray[Any]:
    if file.suffix.lower() == ".npy":
        table = _array(file, "biuf", "a mask is an array of booleans or of vertex")
        return table if table.dtype.kind == "b" else whole_numbers(table, "vertex indices")
    tokens = read_table(file).values("vertex")
    words = [WORDS.get(token.lower()) for token in tokens]
    if None not in words:
        return np.array(words, dtype=np.bool_)
    return whole_numbers(floats(tokens, "booleans or vertex indices"), "vertex indices")


def _no_indices(values: NDArray[Any], n_vertices: int) -> bool:
    """Return whether whole numbers are booleans: a list of two indices would have each once."""
    return bool(np.isin(values, (0, 1)).all() and (len(values) > 2 or len(values) == n_vertices))


def _array(file: Path, kinds: str, expected: str) -> NDArray[Any]:
    table = array_of(file)
    if table.ndim != 1 or table.dtype.kind not in kinds or not (len(table) or "b" in kinds):
        raise ReadError(
            f"{expected} indices with one dimension, not {table.dtype} of shape {table.shape}"
        )
    return table
