"""OFF, the Object File Format, in its text variants."""

import re
from pathlib import Path

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains import Domain
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.io.common import floats, integers, surface, text_of

__all__ = ["off_polygons", "read_off"]

# The counts may follow the keyword directly ("OFF3485 6966 0" is common); it may be missing.
HEADER = re.compile(rb"(ST)?(C)?(N)?(4)?(n)?OFF(\s+BINARY\b)?", re.IGNORECASE)


def read_off(path: Path) -> Domain:
    """Read an OFF file: triangles and polygons, with or without colours and normals."""
    return surface(path, *off_polygons(path))


def off_polygons(path: Path) -> tuple[FloatArray, IntArray, IntArray]:
    """Return the vertices of an OFF file, and sizes and corners of its polygons."""
    text = re.sub(rb"#[^\r\n]*", b"", text_of(path)).lstrip()
    columns = 3
    if header := HEADER.match(text):
        texture, colour, normal, four, many, binary = header.groups()
        if four or many or binary:
            raise ReadError("OFF files in four or more dimensions or in binary are not supported")
        columns += (2 if texture else 0) + (4 if colour else 0) + (3 if normal else 0)
        text = text[header.end() :]
    counts = text.split(maxsplit=3)[:2]
    if len(counts) < 2:
        raise ReadError("not an OFF file: the numbers of vertices and faces are missing")
    n_vertices, n_faces = integers(counts, "the numbers of vertices and faces").tolist()
    if n_vertices < 0 or n_faces < 0:
        raise ReadError(f"{n_vertices} vertices and {n_faces} faces are announced")
    lines = _lines_after_counts(text)
    columns = _columns(lines, columns)
    tokens = b"\n".join(lines).split()
    end = n_vertices * columns
    if len(tokens) < end + n_faces:
        raise ReadError(f"the file ends within its {n_vertices} vertices and {n_faces} faces")
    vertices = floats(tokens[:end], "vertex coordinates").reshape(n_vertices, columns)[:, :3]
    sizes, corners = _faces(tokens[end:], lines, n_faces)
    return vertices, sizes, corners


def _lines_after_counts(text: bytes) -> list[bytes]:
    """Return the lines that are not empty, without the three counts (the third may be missing)."""
    head, *rest = (line for line in text.splitlines() if line.strip())
    counts = head.split()
    while len(counts) < 2:
        counts += rest.pop(0).split()
    return ([b" ".join(counts[3:])] if len(counts) > 3 else []) + rest


def _columns(lines: list[bytes], announced: int) -> int:
    """Return the number of columns per vertex.

    Colours may have an alpha or not, and the header may not announce them, so the first line is
    decisive; if the lines do not look like vertices, the header is.
    """
    first = len(lines[0].split()) if lines else 0
    return first if 3 <= first <= 12 and len(lines) > 1 else announced


def _faces(tokens: list[bytes], lines: list[bytes], n_faces: int) -> tuple[IntArray, IntArray]:
    """Return the sizes of the faces and their corners.

    A face may span several lines, or end in colours. If reading one face after the other does not
    consume the whole file, each line is a face.
    """
    quick = _triangles(tokens, n_faces)
    if quick is not None:
        return quick
    sizes, corners, position = [], [], 0
    for _ in range(n_faces):
        size = _size(tokens, position)
        if size is None:
            break
        sizes.append(size)
        corners.extend(tokens[position + 1 : position + 1 + size])
        position += 1 + size
    if len(sizes) == n_faces and position == len(tokens):
        return np.array(sizes, dtype=np.int64), integers(corners, "the corners of faces")
    return _faces_by_line(lines, n_faces)


def _triangles(tokens: list[bytes], n_faces: int) -> tuple[IntArray, IntArray] | None:
    """Return the faces if all are triangles and nothing else follows."""
    if len(tokens) != 4 * n_faces or any(size != b"3" for size in tokens[::4]):
        return None
    rows = integers(tokens, "the corners of faces").reshape(n_faces, 4)
    return rows[:, 0], rows[:, 1:].ravel()


def _faces_by_line(lines: list[bytes], n_faces: int) -> tuple[IntArray, IntArray]:
    sizes, corners = [], []
    # Lines after the faces are ignored; lines before them are vertices.
    rows = [line.split() for line in lines]
    first = len(rows) - n_faces
    for number, row in enumerate(rows[first:] if first >= 0 else []):
        size = _size(row, 0)
        if size is None:
            raise ReadError(
                f"face {number} is not a number of corners followed by that many vertices"
            )
        sizes.append(size)
        corners.extend(row[1 : 1 + size])
    if len(sizes) != n_faces:
        raise ReadError(f"the file ends within its {n_faces} faces, or does not end with them")
    return np.array(sizes, dtype=np.int64), integers(corners, "the corners of faces")


def _size(tokens: list[bytes], position: int) -> int | None:
    """Return the number of corners of the face at `position`, or None if some are missing."""
    if position >= len(tokens):
        return None
    size = int(integers(tokens[position : position + 1], "the sizes of faces")[0])
    return size if 0 <= size < len(tokens) - position else None
