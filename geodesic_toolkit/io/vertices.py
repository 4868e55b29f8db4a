"""`read_vertices`: vertex indices from a table."""

import os
from pathlib import Path

from geodesic_toolkit._typing import IntArray
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.io.common import array_of, integers, lines_of, tokens_of, whole_numbers
from geodesic_toolkit.io.reading import check_file, named_errors

__all__ = ["VERTEX_SUFFIXES", "read_vertices"]

VERTEX_SUFFIXES = (".npy", ".txt", ".csv")


def read_vertices(path: str | os.PathLike[str]) -> IntArray:
    r"""Read a list of vertex indices from a file.

    Parameters
    ----------
    path : str or path-like
        An .npy array with one dimension, or a .txt or .csv of whole numbers separated by blanks,
        commas or line ends, where a first line without any digit is one of names, and ``#`` begins
        a comment.

    Returns
    -------
    ndarray of shape (K,), int64
        As they stand there; whether a shape has such vertices is for the shape to say.

    Raises
    ------
    ReadError
        No such file, another suffix, or contents that are no whole numbers; the message names the
        file and what is wrong.

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
    file = Path(path)
    check_file(file)
    suffix = file.suffix.lower()
    if suffix not in VERTEX_SUFFIXES:
        raise ReadError(f"{file}: vertices are read from {', '.join(VERTEX_SUFFIXES)}")
    with named_errors(file, "the list of vertices"):
        return _array(file) if suffix == ".npy" else _text(file)


def _array(file: Path) -> IntArray:
    table = array_of(file)
    if table.ndim != 1 or table.dtype.kind not in "iuf" or not len(table):
        raise ReadError(
            "vertices are an array of indices with one dimension, not "
            f"{table.dtype} of shape {table.shape}"
        )
    return whole_numbers(table, "vertex indices")


def _text(file: Path) -> IntArray:
    lines = lines_of(file)
    if lines and not any(character in b"0123456789" for character in lines[0]):
        lines = lines[1:]  # names of columns
    return integers(tokens_of(lines), "vertex indices")
