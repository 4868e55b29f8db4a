"""A reader for geodesic-toolkit: triangles in a small text format."""

from pathlib import Path

import geodesic_toolkit as gt
from geodesic_toolkit.errors import ReadError

__all__ = ["read_triangles"]

COLUMNS = {"v": ("three coordinates", float), "t": ("three indices of vertices", int)}


def read_triangles(path: Path) -> gt.Domain:
    """Read a mesh from lines ``v x y z``, vertices, and ``t i j k``, triangles from index 0.

    Empty lines, and those that begin with ``#``, are ignored.

    Parameters
    ----------
    path : Path

    Returns
    -------
    TriangleMesh

    Raises
    ------
    ReadError
        The file is not text, or a line is of another form: the message has its number.
    """
    rows: dict[str, list[list[float]]] = {"v": [], "t": []}
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except UnicodeDecodeError as error:
        raise ReadError(f"not a text file: byte {error.start} is not UTF-8") from error
    for number, line in enumerate(lines, start=1):
        key, *numbers = line.split() or ["#"]
        if key.startswith("#"):
            continue
        if key not in COLUMNS:
            raise ReadError(f"line {number} begins with {key!r}; known are v and t")
        meaning, kind = COLUMNS[key]
        try:
            row = [kind(text) for text in numbers]
        except ValueError as error:
            raise ReadError(f"line {number}: {error}") from error
        if len(row) != 3:
            raise ReadError(f"line {number} has {len(row)} numbers after {key}, not {meaning}")
        rows[key].append(row)
    if not rows["v"]:
        raise ReadError("there are no vertices: no line begins with v")
    return gt.TriangleMesh(rows["v"], rows["t"])
