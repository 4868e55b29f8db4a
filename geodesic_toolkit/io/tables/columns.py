"""Numbers in columns: point clouds (xyz, txt, asc, csv, pts) and edge lists."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import Graph, PointCloud
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.io.common import cloud, warn, whole_numbers
from geodesic_toolkit.io.tables.rows import Table, read_table

__all__ = ["read_edges", "read_pts", "read_xyz"]

POSITIONS = (("x", "y", "z"), ("points:0", "points:1", "points:2"))
"""Names of the coordinates in lower case: the usual ones, and ParaView's."""

NORMALS = (("nx", "ny", "nz"), ("normals:0", "normals:1", "normals:2"))

MAX_DEVIATION_OF_UNIT_LENGTH = 0.05
"""Deviation from 1 of the length of a normal, above which it is taken for a colour."""

MAX_VERTICES_PER_EDGE = 1000
"""Vertices per edge, beyond a million, above which vertex numbers are taken for identifiers."""


def read_xyz(path: Path) -> PointCloud:
    """Read rows ``x y z [nx ny nz] [...]``, optionally after their number or names of columns."""
    rows = _points(path)
    if rows.shape[1] < 6:
        return PointCloud(rows[:, :3])
    normals = rows[:, 3:6]
    length = np.linalg.norm(normals, axis=1)
    if not (
        np.abs(length[np.isfinite(rows[:, :3]).all(axis=1)] - 1) <= MAX_DEVIATION_OF_UNIT_LENGTH
    ).all():
        warn(path, "columns 4 to 6 are not unit normals and were omitted")
        return PointCloud(rows[:, :3])
    return cloud(path, rows[:, :3], normals)


def read_pts(path: Path) -> PointCloud:
    """Read rows ``x y z [intensity] [r g b]`` after a first line with their number."""
    return PointCloud(_points(path)[:, :3])


def read_edges(path: Path) -> Graph:
    """Read rows ``i j [length]``, vertices counted from 0."""
    table = read_table(path)
    if table.names:
        raise ReadError(f"an edge list cannot have names of columns: {', '.join(table.names)[:80]}")
    rows = table.numbers()
    if rows.shape[1] not in {2, 3}:
        raise ReadError(f"an edge list has 2 or 3 columns, i j [length], not {rows.shape[1]}")
    edges = whole_numbers(rows[:, :2], "vertex numbers")
    n_vertices = int(edges.max()) + 1
    if n_vertices > MAX_VERTICES_PER_EDGE * len(edges) + 1_000_000:
        raise ReadError(
            f"vertex {n_vertices - 1} in a list of {len(edges)} edges: vertices must be numbered "
            "from 0 without large gaps"
        )
    return Graph(n_vertices, edges, rows[:, 2] if rows.shape[1] == 3 else None)


def _points(path: Path) -> FloatArray:
    """Return positions and the columns after them, of shape (N, 3 or more)."""
    table = read_table(path)
    if table.names:
        return table.numbers(_columns(table.names))
    _check_no_column_numbers(table)
    head = table.fields(0)
    if len(head) == 1 and len(table.lines) > 1:
        if not head[0].isdecimal():
            raise ReadError(f"the first line is not a number of points: {head[0][:40]!r}")
        table = replace(table, lines=table.lines[1:])
        if len(table.lines) != int(head[0]):
            raise ReadError(f"{head[0]} points are announced, but {len(table.lines)} follow")
    rows = table.numbers()
    if rows.shape[1] < 3:
        raise ReadError(f"points need at least three columns, not {rows.shape[1]}")
    _check_no_colours_first(rows)
    if rows.shape[1] > 3 and len(rows) > 3 and (np.diff(np.sort(rows[:, 0])) == 1).all():
        warn(
            path,
            "the first column, which seems to number the rows, was taken for x; if it is a number, "
            "remove it, or name the columns",
        )
    return rows


def _check_no_column_numbers(table: Table) -> None:
    """Raise if the first row is 0, 1, 2, ..., as pandas numbers columns that have no names."""
    first = table.fields(0)
    numbered = len(first) > 2 and first == [str(number) for number in range(len(first))]
    if numbered and len(table.lines) > 1 and all("." in line for line in table.lines[1:]):
        raise ReadError(
            f"the first line, {table.lines[0][:40]!r}, may be a point, or number the columns; name "
            "them x, y and z, or remove it"
        )


def _check_no_colours_first(rows: FloatArray) -> None:
    """Raise if the first three columns look like colours, and the next three do not."""
    if rows.shape[1] < 6:
        return
    colours, rest = rows[:, :3], rows[:, 3:6]
    if _are_bytes(colours) and colours.max() > 1 and not _are_bytes(rest) and not _are_unit(rest):
        raise ReadError(
            "the first three columns are whole numbers from 0 to 255, like colours, and the next "
            "three are not: which are x, y and z? Name the columns in a first line, such as "
            "'r g b x y z'"
        )


def _are_bytes(values: FloatArray) -> bool:
    return bool(((values >= 0) & (values <= 255) & (values == np.floor(values))).all())


def _are_unit(vectors: FloatArray) -> bool:
    length = np.linalg.norm(vectors, axis=1)
    return bool((np.abs(length[np.isfinite(length)] - 1) <= MAX_DEVIATION_OF_UNIT_LENGTH).all())


def _columns(names: list[str]) -> list[int]:
    """Return the columns of x, y and z, and of the normals if they are named.

    Three columns of other names (easting, northing, height) are taken in their order.
    """
    if len(set(names)) < len(names) and (
        twice := [name for name in names if names.count(name) > 1 and name in "xyz"]
    ):
        raise ReadError(f"several columns are named {twice[0]!r}; give each its own name")
    for position in POSITIONS:
        if set(position) <= set(names):
            normals = next((each for each in NORMALS if set(each) <= set(names)), ())
            return [names.index(name) for name in (*position, *normals)]
    if len(names) == 3:
        return [0, 1, 2]
    raise ReadError(
        f"the columns are named {', '.join(names)[:80]}: which are x, y and z? Rename these three"
    )
