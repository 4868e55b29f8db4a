"""Curves to files: lines for viewers, tables for programs."""

import os
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from geodesic_toolkit.core.atomic import check_output, replacing
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.interop.conversion import as_domain
from geodesic_toolkit.sources.polylines import polylines

__all__ = ["check_curve_output", "write_curves"]

SUFFIXES = (".obj", ".ply", ".vtp", ".csv")


def check_curve_output(path: str | os.PathLike[str]) -> Path:
    """Return the path of a file for curves, checked before any work.

    Raises
    ------
    InvalidOptionError
        Another suffix.
    WriteError
        A folder that does not exist or is not writable.
    """
    return check_output(path, SUFFIXES)


def write_curves(path: str | os.PathLike[str], domain: Any, curves: Any) -> None:
    """Write curves as polylines in space, in the format that the suffix names.

    ===== ==========================================================================
    .obj  ``v`` lines, and an ``l`` line for each curve
    .ply  ASCII: vertices, and edges between them
    .vtp  ASCII: polylines, for ParaView
    .csv  ``curve,x,y,z`` with all digits; of a closed curve the first point comes again
          at the end
    ===== ==========================================================================

    Parameters
    ----------
    path : str or path-like
        Replaced as a whole at the end; an interrupted run does not change it.
    domain : Domain or object
        The shape of the curves, or an object that :func:`as_domain` converts.
    curves : Curve, GeodesicPath, CloudPath, or sequence of them

    Raises
    ------
    InvalidOptionError
        An unknown suffix.
    InvalidSourceError
        An object that is not a curve of the domain.
    WriteError
        The file cannot be written.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import geodesic_toolkit as gt
    >>> square = gt.testing.shapes.grid(3)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "side.obj")
    ...     gt.write_curves(file, square, gt.Curve([[0, 0, 0], [1, 0, 0]]))
    ...     print(file.read_text())
    v 0.0 0.0 0.0
    v 1.0 0.0 0.0
    l 1 2
    <BLANKLINE>
    """
    file = check_curve_output(path)
    lines = polylines(as_domain(domain), curves)
    encode = {".obj": _obj, ".ply": _ply, ".vtp": _vtp, ".csv": _csv}[file.suffix.lower()]
    with replacing(file) as temporary:
        temporary.write_text(encode(lines), encoding="ascii", newline="\n")


def _rows(lines: list[FloatArray], before: str = "", between: str = " ") -> list[str]:
    points = [point for line in lines for point in line.tolist()]
    return [before + between.join(map(repr, point)) for point in points]


def _numbers(lines: list[FloatArray]) -> list[list[int]]:
    """Return the numbers of the points of each line, which continue from line to line."""
    starts = np.cumsum([0, *map(len, lines)]).tolist()
    return [list(range(*pair)) for pair in pairwise(starts)]


def _joined(rows: list[str]) -> str:
    return "".join(f"{row}\n" for row in rows)


def _obj(lines: list[FloatArray]) -> str:
    chains = [" ".join(["l", *(str(1 + n) for n in own)]) for own in _numbers(lines)]
    return _joined([*_rows(lines, "v "), *chains])


def _ply(lines: list[FloatArray]) -> str:
    points = _rows(lines)
    edges = [f"{n} {n + 1}" for own in _numbers(lines) for n in own[:-1]]
    header = [
        "ply",
        "format ascii 1.0",
        f"element vertex {len(points)}",
        *(f"property double {axis}" for axis in "xyz"),
        f"element edge {len(edges)}",
        "property int vertex1",
        "property int vertex2",
        "end_header",
    ]
    return _joined([*header, *points, *edges])


def _vtp(lines: list[FloatArray]) -> str:
    points, own = _rows(lines), _numbers(lines)
    ends = np.cumsum([len(numbers) for numbers in own]).tolist()
    return _joined(
        [
            '<?xml version="1.0"?>',
            '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian">',
            "<PolyData>",
            f'<Piece NumberOfPoints="{len(points)}" NumberOfLines="{len(own)}">',
            '<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">',
            *points,
            "</DataArray></Points>",
            '<Lines><DataArray type="Int64" Name="connectivity" format="ascii">',
            *(" ".join(map(str, numbers)) for numbers in own),
            '</DataArray><DataArray type="Int64" Name="offsets" format="ascii">',
            " ".join(map(str, ends)),
            "</DataArray></Lines>",
            "</Piece>",
            "</PolyData>",
            "</VTKFile>",
        ]
    )


def _csv(lines: list[FloatArray]) -> str:
    rows = [
        row for number, line in enumerate(lines) for row in _rows([line], f"{number},", between=",")
    ]
    return _joined(["curve,x,y,z", *rows])
