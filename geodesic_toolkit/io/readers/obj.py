"""Wavefront OBJ.

Only positions and the position indices of faces are read. A corner's texture and normal indices,
which make other readers split vertices along seams, do not cut the surface.
"""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains import Domain, TriangleMesh
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.io.common import cloud, floats, integers, text_of, triangulate

__all__ = ["obj_polygons", "read_obj", "read_obj_lines"]


def read_obj(path: Path) -> Domain:
    """Read an OBJ file: its ``v`` and ``f`` lines, and ``vn`` if it has only points."""
    vertices, sizes, corners, normals = _contents(path)
    if not len(sizes):
        paired = len(normals) == vertices.size
        return cloud(path, vertices, floats(normals, "normals").reshape(-1, 3) if paired else None)
    return TriangleMesh(vertices, triangulate(path, vertices, sizes, corners))


def obj_polygons(path: Path) -> tuple[FloatArray, IntArray, IntArray]:
    """Return the vertices of an OBJ file, and sizes and corners of its polygons."""
    return _contents(path)[:3]


def _contents(path: Path) -> tuple[FloatArray, IntArray, IntArray, list[bytes]]:
    """Return vertices, sizes and corners of polygons, and normals as they are written."""
    coordinates: list[bytes] = []
    normals: list[bytes] = []
    corners: list[bytes] = []
    sizes: list[int] = []
    seen: list[int] = []  # number of vertices before each face, for negative indices
    for keyword, *words in _rows(path):
        if keyword == b"v":
            if len(words) < 3:
                raise ReadError(
                    f"vertex {len(coordinates) // 3} has {len(words)} coordinates, not 3"
                )
            coordinates += words[:3]
        elif keyword == b"f":
            corners += words
            sizes.append(len(words))
            seen.append(len(coordinates) // 3)
        elif keyword == b"vn" and len(words) >= 3:
            normals += words[:3]
    if not coordinates:
        raise ReadError("not an OBJ file, or one without vertices")
    vertices = floats(coordinates, "vertex coordinates").reshape(-1, 3)
    numbers = integers([corner.partition(b"/")[0] for corner in corners], "the corners of faces")
    counts = np.array(sizes, dtype=np.int64)
    owner = np.repeat(np.arange(len(counts)), counts)
    indices = np.where(numbers < 0, numbers + np.array(seen, dtype=np.int64)[owner], numbers - 1)
    outside = np.flatnonzero((indices < 0) | (indices >= len(vertices)))
    if len(outside):
        raise ReadError(
            f"face {owner[outside[0]]} refers to vertex {numbers[outside[0]]}; there are "
            f"{len(vertices)}, numbered from 1, or from -1 backwards"
        )
    return vertices, counts, indices, normals


def read_obj_lines(path: Path) -> list[FloatArray]:
    """Return the polylines of an OBJ file, each of shape (P, 3): its ``l`` lines."""
    rows = [(keyword, words) for keyword, *words in _rows(path)]
    coordinates = [word for keyword, words in rows if keyword == b"v" for word in words[:3]]
    if len(coordinates) % 3:
        raise ReadError("a vertex has less than 3 coordinates")
    vertices = floats(coordinates, "vertex coordinates").reshape(-1, 3)
    lines: list[FloatArray] = []
    for keyword, words in rows:
        if keyword == b"l":
            numbers = integers([word.partition(b"/")[0] for word in words], "the points of lines")
            outside = (numbers < 1) | (numbers > len(vertices))
            if outside.any():
                raise ReadError(
                    f"line {len(lines)} refers to vertex {numbers[outside][0]}; there are "
                    f"{len(vertices)}, numbered from 1"
                )
            lines.append(vertices[numbers - 1])
    return lines


def _rows(path: Path) -> Iterator[list[bytes]]:
    """Yield the keyword and the words of each line, without comments."""
    text = re.sub(rb"\\\r?\n", b" ", text_of(path))
    for line in text.splitlines():
        yield line.partition(b"#")[0].split() or [b""]
