"""`read_points`: places to ask for, from a table or from any shape."""

import os
from pathlib import Path

import numpy as np

from geodesic_toolkit._typing import FloatArray
from geodesic_toolkit.domains import PointCloud, known_positions
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.io.columns import number_table
from geodesic_toolkit.io.common import array_of, text_of
from geodesic_toolkit.io.reading import check_file, named_errors, read

__all__ = ["read_points"]


def read_points(path: str | os.PathLike[str]) -> PointCloud:
    r"""Read points in space from a file.

    Parameters
    ----------
    path : str or path-like
        An .npy array of shape (N, 3), or (3,) for one point; a .csv with columns x, y and z, in
        this order if it has no line of names; or a file that :func:`geodesic_toolkit.read` takes,
        of which the vertices count.

    Returns
    -------
    PointCloud
        Without normals. Points that are not finite are kept as missing.

    Raises
    ------
    ReadError
        No such file, or no points in it; the message names the file and what is wrong.
    GeodesicError
        What :func:`geodesic_toolkit.read` raises.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from geodesic_toolkit.io import read_points
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "places.csv")
    ...     _ = file.write_text("name,x,y,z\n1,0.5,0,0\n2,0.5,1,0\n")
    ...     read_points(file)
    PointCloud(2 points)
    """
    file = Path(path)
    tables = {".npy": _array, ".csv": _columns}
    if file.suffix.lower() not in tables:
        return _vertices(file)
    check_file(file)
    with named_errors(file, "the table of points"):
        return PointCloud(tables[file.suffix.lower()](file))


def _vertices(file: Path) -> PointCloud:
    domain = read(file)
    positions = known_positions(domain)
    if positions is None:
        raise ReadError(f"{file}: a {type(domain).__name__} has no positions")
    return PointCloud(positions)


def _array(file: Path) -> FloatArray:
    return np.atleast_2d(array_of(file))


def _columns(file: Path) -> FloatArray:
    lines = [line for line in text_of(file).decode("latin-1").splitlines() if line.strip()]
    if not lines:
        raise ReadError("there are no numbers in the file")
    names = [name.strip().strip('"').lower() for name in lines[0].split(",")]
    chosen = [0, 1, 2]
    if {"x", "y", "z"} <= set(names):
        chosen = [names.index(name) for name in "xyz"]
        lines = lines[1:]
    rows = [line.split(",") for line in lines]
    short = next((number for number, row in enumerate(rows) if len(row) <= max(chosen)), None)
    if short is not None or not rows:
        raise ReadError(f"row {short or 0} of the points has no columns x, y and z")
    return number_table([" ".join(row[column] for column in chosen) for row in rows])
