"""Numbers in columns: point clouds (xyz, pts) and edge lists."""

import io
import re
import warnings
from pathlib import Path

import numpy as np

from geodesic_toolkit._typing import FloatArray
from geodesic_toolkit.domains import Graph, PointCloud
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.io.common import cloud, text_of, warn, whole_numbers

__all__ = ["number_table", "read_edges", "read_pts", "read_xyz"]

COMMENT = re.compile(r"(#|//|%)[^\n]*")

UNIT = 0.05
"""How far from 1 the length of a normal may be to be told from a colour."""

SPARSEST = 1000
"""Vertices an edge, beyond a million, from which vertex numbers are taken for identifiers."""


def read_xyz(path: Path) -> PointCloud:
    """Read rows ``x y z [nx ny nz] [...]``; a first line with their number or names may precede."""
    rows = _points(path)
    if rows.shape[1] < 6:
        return PointCloud(rows[:, :3])
    normals = rows[:, 3:6]
    length = np.linalg.norm(normals, axis=1)
    if not (np.abs(length[np.isfinite(rows[:, :3]).all(axis=1)] - 1) <= UNIT).all():
        warn(path, "columns 4 to 6 are not unit normals and were left out")
        return PointCloud(rows[:, :3])
    return cloud(path, rows[:, :3], normals)


def read_pts(path: Path) -> PointCloud:
    """Read rows ``x y z [intensity] [r g b]`` after a first line with their number."""
    return PointCloud(_points(path)[:, :3])


def read_edges(path: Path) -> Graph:
    """Read rows ``i j [length]``, vertices counted from 0."""
    rows = number_table(_lines(path))
    if rows.shape[1] not in {2, 3}:
        raise ReadError(f"an edge list has columns i j [length], not {rows.shape[1]} of them")
    edges = whole_numbers(rows[:, :2], "vertex numbers")
    n_vertices = int(edges.max()) + 1
    if n_vertices > SPARSEST * len(edges) + 1_000_000:
        raise ReadError(
            f"vertex {n_vertices - 1} in a list of {len(edges)} edges: vertices must be numbered "
            "from 0 without large gaps"
        )
    return Graph(n_vertices, edges, rows[:, 2] if rows.shape[1] == 3 else None)


def _points(path: Path) -> FloatArray:
    lines = _lines(path)
    head = lines[0].split()
    announced = None
    if len(head) == 1 and len(lines) > 1:
        announced = int(head[0]) if head[0].isdecimal() else None
        if announced is None:
            raise ReadError(f"the first line is no number of points: {head[0][:40]!r}")
        lines = lines[1:]
    elif len(lines) > 1 and len(head) == len(lines[1].split()) and not _is_number(head[0]):
        lines = lines[1:]  # the names of the columns
    if announced is not None and len(lines) != announced:
        raise ReadError(f"the first line announces {announced} points, {len(lines)} follow")
    rows = number_table(lines)
    if rows.shape[1] < 3:
        raise ReadError(f"points have at least three columns, not {rows.shape[1]}")
    return rows


def _lines(path: Path) -> list[str]:
    """Return the lines that hold anything, columns separated by blanks."""
    text = COMMENT.sub("", text_of(path).decode("latin-1")).replace(",", " ").replace(";", " ")
    lines = [line for line in text.splitlines() if line.strip()]
    if not lines:
        raise ReadError("there are no numbers in the file")
    return lines


def number_table(lines: list[str]) -> FloatArray:
    """Return numbers separated by blanks, a row a line.

    Raises
    ------
    ReadError
        They are no table of numbers.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            table: FloatArray = np.loadtxt(io.StringIO("\n".join(lines)), ndmin=2, comments=None)
    except (ValueError, UserWarning) as error:
        reason = str(error).partition(";")[0]
        raise ReadError(f"the file is not a table of numbers: {reason}") from error
    return table


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
