"""Legacy VTK files: polygonal surfaces by our own reader, grids through meshio.

Surfaces are usually saved in the former format, which meshio does not support.
"""

import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit.core.types import IntArray
from geodesic_toolkit.domains import Domain, PointCloud, TriangleMesh
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.geometry.polygons import strip_triangles
from geodesic_toolkit.io.common import floats, triangulate, whole_numbers
from geodesic_toolkit.io.readers.cells import read_cells

__all__ = ["read_vtk"]

TYPES = {
    "char": "i1", "unsigned_char": "u1", "short": "i2", "unsigned_short": "u2",
    "int": "i4", "unsigned_int": "u4", "long": "i8", "unsigned_long": "u8",
    "vtkidtype": "i4", "vtktypeint64": "i8", "float": "f4", "double": "f8",
}  # fmt: skip
CELLS = {"VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS"}
DATA = re.compile(rb"\n(POINT_DATA|CELL_DATA)[ \t]+\d+[ \t\r]*\n")
ATTRIBUTES = {"POINT_DATA", "CELL_DATA", "FIELD"}


def read_vtk(path: Path) -> Domain:
    """Read a legacy VTK file: polygons and triangle strips, or only points, or a grid."""
    data = path.read_bytes()
    head = data[:2048].decode("latin-1").splitlines()[:4]
    if len(head) < 4 or not head[0].lower().startswith("# vtk datafile version"):
        raise ReadError('not a VTK file: it does not begin with "# vtk DataFile Version"')
    if head[3].upper().split() != ["DATASET", "POLYDATA"]:
        return _read_grid(path, data)
    cursor = _Cursor(data, binary=head[2].strip().upper() == "BINARY")
    for _ in range(4):
        cursor.words()
    points, faces = None, []
    while (words := cursor.words()) and words[0].upper() not in ATTRIBUTES:
        match [words[0].upper(), *words[1:]]:
            case ["POINTS", number, kind]:
                points = cursor.numbers(3 * _count(number), kind).reshape(-1, 3)
            case [section, number, size] if section in CELLS:
                sizes, corners = cursor.cells(_count(number), _count(size))
                if section == "POLYGONS" and len(sizes):
                    if points is None:  # the triangulation of a polygon needs its points
                        raise ReadError("the VTK file has polygons before its points")
                    faces.append(triangulate(path, points, sizes, corners))
                elif section == "TRIANGLE_STRIPS":
                    faces.append(strip_triangles(sizes, corners))
            case _:
                pass  # skip METADATA and its lines
    if points is None:
        raise ReadError("the VTK file has no points")
    return TriangleMesh(points, np.concatenate(faces)) if faces else PointCloud(points)


def _read_grid(path: Path, data: bytes) -> Domain:
    """Read a grid without its point and cell data, as meshio does not support all of them."""
    cells = data.rfind(b"CELL_TYPES")
    found = DATA.search(data, cells) if cells >= 0 else None
    if found is None:
        return read_cells(path, "vtk")
    with tempfile.TemporaryDirectory() as folder:
        bare = Path(folder, path.name)
        bare.write_bytes(data[: found.start() + 1])
        return read_cells(bare, "vtk")


def _count(word: str) -> int:
    if not (word.isascii() and word.isdigit() and len(word) < 19):
        raise ReadError(f"{word[:40]!r} is not a number of entries")
    return int(word)


class _Cursor:
    """A position in the file, which advances as data are read."""

    def __init__(self, data: bytes, *, binary: bool) -> None:
        self.data, self.binary, self.at = data, binary, 0

    def words(self) -> list[str]:
        """Return the words of the next line that is not empty; [] at the end of the file."""
        while self.at < len(self.data):
            end = self.data.find(b"\n", self.at)
            end = len(self.data) if end < 0 else end
            words = self.data[self.at : end].decode("latin-1").split()
            self.at = end + 1
            if words:
                return words
        return []

    def numbers(self, n: int, kind: str) -> NDArray[Any]:
        """Return the next `n` numbers of VTK's type `kind`."""
        if kind.lower() not in TYPES:
            raise ReadError(f"unknown type of numbers: {kind[:40]!r}")
        code = TYPES[kind.lower()]
        early = ReadError(f"the file ends before the last of {n} announced numbers")
        if n * (int(code[1]) if self.binary else 1) > len(self.data) - self.at:
            raise early
        if self.binary:
            values = np.frombuffer(self.data, ">" + code, n, self.at)
            self.at += values.nbytes
            return values
        tokens = self.data[self.at :].split(maxsplit=n)
        if len(tokens) < n:
            raise early
        self.at = len(self.data) - (len(tokens[n]) if len(tokens) > n else 0)
        return floats(tokens[:n], "the numbers of the file")

    def cells(self, n: int, size: int) -> tuple[IntArray, IntArray]:
        """Return the sizes of cells and their corners.

        From version 5 on they are stored as offsets and corners; earlier versions store each size
        followed by its corners.
        """
        at = self.at
        match self.words():
            case ["OFFSETS", kind]:
                offsets = whole_numbers(self.numbers(n, kind), "offsets of cells")
                words = self.words()
                if words[:1] != ["CONNECTIVITY"] or len(words) != 2:
                    raise ReadError("the corners of cells are missing after their offsets")
                corners = whole_numbers(self.numbers(size, words[1]), "corners of cells")
                sizes = np.diff(offsets)
                if (sizes < 0).any() or (len(offsets) and (offsets[0], offsets[-1]) != (0, size)):
                    raise ReadError("the offsets of cells do not match their corners")
                return sizes, corners
        self.at = at
        row = whole_numbers(self.numbers(size, "int"), "corners of cells")
        lengths, size_positions, position = [], [], 0
        for _ in range(n):
            if position >= size or not 0 <= row[position] < size - position:
                raise ReadError("the sizes of cells do not match their number")
            lengths.append(int(row[position]))
            size_positions.append(position)
            position += 1 + lengths[-1]
        return np.array(lengths, dtype=np.int64), np.delete(row[:position], size_positions)
