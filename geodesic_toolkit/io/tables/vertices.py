"""`read_vertices`: vertex indices from a table."""

import os
from pathlib import Path

from geodesic_toolkit.core.types import IntArray
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.io.common import array_of, floats, whole_numbers
from geodesic_toolkit.io.reading import check_file, named_errors, unpacked
from geodesic_toolkit.io.tables.regions import REGION_SUFFIXES, check_no_region, read_region
from geodesic_toolkit.io.tables.rows import read_table

__all__ = ["VERTEX_SUFFIXES", "read_vertices"]

VERTEX_SUFFIXES = (".npy", ".txt", ".csv", *REGION_SUFFIXES)


def read_vertices(path: str | os.PathLike[str], *, region: str | None = None) -> IntArray:
    r"""Read a list of vertex indices from a file.

    Parameters
    ----------
    path : str or path-like
        An .npy array with one dimension, or a .txt or .csv of whole numbers separated by blanks,
        commas, semicolons or line ends, where the first line may be one of names, and ``#`` begins
        a comment; of several named columns, that of ``vertex`` is read. Or a file of neuroimaging
        that marks vertices: a FreeSurfer .label; an .annot or GIFTI .label.gii with a `region`; a
        GIFTI .gii of zeros and ones. Each may be compressed (.gz).
    region : str, optional
        The name of the region of an .annot or .label.gii.

    Returns
    -------
    ndarray of shape (K,), int64
        As they stand there; whether a shape has such vertices is for the shape to say.

    Raises
    ------
    ReadError
        No such file, another suffix, or contents that are not whole numbers; the message names the
        file and what is wrong.
    InvalidOptionError
        A region that the file has not, or none where it has several.

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
    with unpacked(file) as plain:
        suffix = plain.suffix.lower()
        if suffix not in VERTEX_SUFFIXES:
            raise ReadError(f"{file}: vertices are read from {', '.join(VERTEX_SUFFIXES)}")
        with named_errors(file, "the list of vertices"):
            if suffix in REGION_SUFFIXES:
                return read_region(plain, region)[0]
            check_no_region(plain, region)
            return _array(plain) if suffix == ".npy" else _text(plain)


def _array(file: Path) -> IntArray:
    table = array_of(file)
    if table.ndim != 1 or table.dtype.kind not in "iuf" or not len(table):
        raise ReadError(
            "vertices are an array of indices with one dimension, not "
            f"{table.dtype} of shape {table.shape}"
        )
    return whole_numbers(table, "vertex indices")


def _text(file: Path) -> IntArray:
    numbers = floats(read_table(file).values("vertex"), "vertex indices")
    return whole_numbers(numbers, "vertex indices")
