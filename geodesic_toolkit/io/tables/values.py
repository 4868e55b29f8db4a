"""`read_values`: one number for each vertex or face, from a table."""

import os

import numpy as np

from geodesic_toolkit.core.atomic import as_path
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.io.common import array_of, floats
from geodesic_toolkit.io.reading import check_file, named_errors, unpacked
from geodesic_toolkit.io.tables.rows import read_table

__all__ = ["read_values"]

SUFFIXES = (".npy", ".txt", ".csv")


def read_values(path: str | os.PathLike[str], name: str = "value") -> FloatArray:
    r"""Read one number for each vertex or face from a file, such as the costs of faces.

    Parameters
    ----------
    path : str or path-like
        An .npy array with one dimension, or a .txt or .csv of numbers separated by blanks, commas,
        semicolons or line ends. It may be compressed (.gz).
    name : str
        The column of a table with several named columns.

    Returns
    -------
    ndarray of shape (K,), float64
        In the order of the file.

    Raises
    ------
    ReadError
        The file does not exist, has another suffix, or its contents are not numbers; the message
        names the file and the defect.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from geodesic_toolkit.io import read_values
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "costs.csv")
    ...     _ = file.write_text("face,cost\n0,1.5\n1,2\n")
    ...     read_values(file, "cost")
    array([1.5, 2. ])
    """
    file = as_path(path)
    check_file(file)
    with unpacked(file) as plain:
        if plain.suffix.lower() not in SUFFIXES:
            raise ReadError(f"{file}: values are read from {', '.join(SUFFIXES)}")
        with named_errors(file, "the list of values"):
            if plain.suffix.lower() != ".npy":
                return floats(read_table(plain).values(name), "numbers")
            table = array_of(plain)
            if table.ndim != 1 or table.dtype.kind not in "iuf":
                raise ReadError(
                    "values are an array of numbers with one dimension, not "
                    f"{table.dtype} of shape {table.shape}"
                )
            return np.asarray(table, dtype=np.float64)
