"""`read_curves`: read curves on a shape from files of lines, points or vertices."""

import os
from pathlib import Path
from typing import Any

import numpy as np

from geodesic_toolkit.core.atomic import as_path
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import positions_of
from geodesic_toolkit.errors import InvalidSourceError, ReadError
from geodesic_toolkit.interop.conversion import as_domain
from geodesic_toolkit.io.common import array_of
from geodesic_toolkit.io.readers.obj import read_obj_lines
from geodesic_toolkit.io.readers.ply import read_ply_lines
from geodesic_toolkit.io.readers.vtp import read_vtp_lines
from geodesic_toolkit.io.reading import check_file, named_errors, unpacked
from geodesic_toolkit.io.tables.rows import read_table
from geodesic_toolkit.io.tables.vertices import read_vertices
from geodesic_toolkit.sources.kinds import Curve
from geodesic_toolkit.sources.points import as_vertices

__all__ = ["read_curves"]

READERS = {".obj": read_obj_lines, ".ply": read_ply_lines, ".vtp": read_vtp_lines}


def read_curves(path: str | os.PathLike[str], domain: Any) -> list[Curve]:
    """Read curves from a file, such as one that :func:`write_curves` wrote.

    A curve whose last point is its first one is closed.

    Parameters
    ----------
    path : str or path-like
        Polylines in an .obj, .ply or .vtp file; a .csv with columns x, y and z, and a column
        ``curve`` if there are several; an .npy array of shape (P, 3); or one curve as a list of
        vertices, in any format of :func:`read_vertices`.
    domain : Domain or object
        The shape whose vertices a list refers to, or an object that :func:`as_domain` converts.

    Returns
    -------
    list of Curve
        One or more, with points in space.

    Raises
    ------
    ReadError
        The file does not exist, or has no curves; the message names the file and the defect.
    InvalidSourceError
        A curve of less than two points, or a vertex that the shape does not have.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import geodesic_toolkit as gt
    >>> square = gt.testing.shapes.grid(3)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "side.csv")
    ...     gt.write_curves(file, square, gt.Curve([[0, 0, 0], [1, 0, 0], [1, 1, 0]], closed=True))
    ...     curve, = gt.read_curves(file, square)
    >>> curve.closed, len(curve.points)
    (True, 3)
    """
    file = as_path(path)
    check_file(file)
    with unpacked(file) as plain, named_errors(file, "the curves"):
        lines = _lines(plain)
    if lines is None:
        shape = as_domain(domain)
        vertices = as_vertices(read_vertices(file), shape.n_vertices)
        lines = [positions_of(shape)[vertices]]
    if not lines:
        raise ReadError(f"{file}: there are no lines in the file")
    return [_curve(line, f"{file}: curve {number}") for number, line in enumerate(lines)]


def _lines(file: Path) -> list[FloatArray] | None:
    """Return the polylines of a file, each of shape (P, 3); None if it lists vertices."""
    suffix = file.suffix.lower()
    if suffix in READERS:
        return READERS[suffix](file)
    if suffix == ".npy":
        table = array_of(file)
        if table.ndim != 2:
            return None
        if table.shape[1] != 3 or table.dtype.kind not in "iuf":
            raise ReadError(f"points have shape (P, 3), not {table.shape} of {table.dtype}")
        return [table.astype(np.float64)]
    if suffix in {".csv", ".txt"}:
        names = read_table(file).names
        if {"x", "y", "z"} <= set(names):
            return _lines_of_table(file, names)
    return None


def _lines_of_table(file: Path, names: list[str]) -> list[FloatArray]:
    numbered = "curve" in names
    columns = [names.index(name) for name in ("x", "y", "z", *(["curve"] if numbered else []))]
    rows = read_table(file).numbers(columns)
    if not numbered:
        return [rows]
    return np.split(rows[:, :3], np.flatnonzero(np.diff(rows[:, 3])) + 1)


def _curve(line: FloatArray, name: str) -> Curve:
    if not np.isfinite(line).all():
        bad = int(np.isfinite(line).all(axis=1).argmin())
        raise ReadError(f"{name}: point {bad} is not finite: {line[bad].tolist()}")
    closed = len(line) > 2 and bool((line[0] == line[-1]).all())
    own = line[:-1] if closed else line
    if len(own) < 2:
        raise InvalidSourceError(f"{name} needs two points or more, not {len(own)}")
    return Curve(own, closed=closed)
