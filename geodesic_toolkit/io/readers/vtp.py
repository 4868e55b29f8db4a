"""Surfaces in VTK's XML format (.vtp), by our own reader: VTK's crashes on some damaged files.

Arrays are stored as text, as base64, or in one block at the end of the file, which is base64 or
raw; all forms but text may be compressed in blocks.
"""

import base64
import lzma
import re
import xml.etree.ElementTree as ET  # entities are refused before parsing
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains import Domain, TriangleMesh
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.geometry.polygons import strip_triangles
from geodesic_toolkit.io.common import cloud, floats, triangulate, whole_numbers

__all__ = ["read_vtp", "read_vtp_lines"]

TYPES = {
    "Int8": "i1", "UInt8": "u1", "Int16": "i2", "UInt16": "u2", "Int32": "i4", "UInt32": "u4",
    "Int64": "i8", "UInt64": "u8", "Float32": "f4", "Float64": "f8",
}  # fmt: skip
ORDERS = {"LittleEndian": "<", "BigEndian": ">"}
APPENDED = re.compile(rb"<AppendedData[^>]*>\s*_")


def read_vtp(path: Path) -> Domain:
    """Read a surface: polygons and triangle strips, or only points."""
    file = _File.of(path.read_bytes())
    points: list[FloatArray] = []
    normals: list[FloatArray | None] = []
    cells: dict[str, list[tuple[IntArray, IntArray]]] = {"Polys": [], "Strips": [], "Lines": []}
    offset = 0
    for piece in file.root.iterfind("PolyData/Piece"):
        positions = _positions(file, piece)
        for section, found in cells.items():
            sizes, corners = _cells(file, piece.find(section), len(positions))
            found.append((sizes, corners + offset))
        points.append(positions.astype(np.float64))
        normals.append(_normals(file, piece))
        offset += len(positions)
    if not offset:
        raise ReadError("the file has no points")
    return _domain(path, np.concatenate(points), normals, cells)


def read_vtp_lines(path: Path) -> list[FloatArray]:
    """Return the polylines of a surface file, each of shape (P, 3)."""
    file = _File.of(path.read_bytes())
    lines: list[FloatArray] = []
    for piece in file.root.iterfind("PolyData/Piece"):
        positions = _positions(file, piece).astype(np.float64)
        sizes, points = _cells(file, piece.find("Lines"), len(positions))
        lines += np.split(positions[points], np.cumsum(sizes)[:-1]) if len(sizes) else []
    return lines


def _positions(file: "_File", piece: ET.Element) -> NDArray[Any]:
    return file.array(piece.find("Points/DataArray"), "points").reshape(-1, 3)


def _domain(
    path: Path,
    points: FloatArray,
    normals: list[FloatArray | None],
    cells: dict[str, list[tuple[IntArray, IntArray]]],
) -> Domain:
    joined = {
        section: [np.concatenate(parts) for parts in zip(*found, strict=True)]
        for section, found in cells.items()
    }
    faces = []
    if len(joined["Polys"][0]):
        faces.append(triangulate(path, points, *joined["Polys"]))
    if len(joined["Strips"][0]):
        faces.append(strip_triangles(*joined["Strips"]))
    if faces:
        return TriangleMesh(points, np.concatenate(faces))
    if len(joined["Lines"][0]):
        raise ReadError("no faces, only lines")
    known = [each for each in normals if each is not None]
    return cloud(path, points, np.concatenate(known) if len(known) == len(normals) else None)


def _cells(file: "_File", section: ET.Element | None, n_vertices: int) -> tuple[IntArray, IntArray]:
    """Return the sizes of cells and their corners."""
    if section is None:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    arrays = {array.get("Name"): array for array in section.iterfind("DataArray")}
    corners, ends = (
        whole_numbers(file.array(arrays.get(name), name), name)
        for name in ("connectivity", "offsets")
    )
    sizes = np.diff(ends, prepend=0)
    if (sizes < 0).any() or int(sizes.sum()) != len(corners):
        raise ReadError("the offsets of cells do not match their corners")
    outside = (corners < 0) | (corners >= n_vertices)
    if outside.any():
        raise ReadError(f"a cell refers to vertex {corners[outside][0]}; there are {n_vertices}")
    return sizes, corners


def _normals(file: "_File", piece: ET.Element) -> FloatArray | None:
    data = piece.find("PointData")
    name = None if data is None else data.get("Normals")
    if data is None or name is None:
        return None
    for array in data.iterfind("DataArray"):
        if array.get("Name") == name:
            return file.array(array, "normals").reshape(-1, 3).astype(np.float64)
    return None


@dataclass(frozen=True)
class _File:
    """The XML tree of a file, and the encoding of its arrays."""

    root: ET.Element
    order: str
    header: np.dtype[Any]
    decompress: Callable[[bytes], bytes] | None
    appended: bytes
    raw: bool

    @classmethod
    def of(cls, data: bytes) -> "_File":
        appended, raw = b"", False
        if start := APPENDED.search(data):
            end = data.rfind(b"</AppendedData>")
            appended = data[start.end() : end if end > 0 else len(data)]
            raw = b'encoding="raw"' in start.group()
            data = data[: start.start()] + b"</VTKFile>"
        if b"<!ENTITY" in data:
            raise ReadError("not a VTP file: it declares entities")
        root = ET.fromstring(data)  # noqa: S314 - without entities it cannot expand
        if root.tag != "VTKFile" or root.get("type") != "PolyData":
            raise ReadError(f"not a VTP file: its root is {root.tag} of type {root.get('type')}")
        order = ORDERS.get(root.get("byte_order", "LittleEndian"))
        header = TYPES.get(root.get("header_type", "UInt32"))
        if order is None or header not in {"u4", "u8"}:
            raise ReadError("unknown byte order or type of headers")
        kind = root.get("compressor", "")
        if kind not in DECOMPRESS:
            raise ReadError(f"unknown compressor {kind}; save it with zlib, or uncompressed")
        return cls(root, order, np.dtype(order + header), DECOMPRESS[kind], appended, raw)

    def array(self, element: ET.Element | None, what: str) -> NDArray[Any]:
        """Return the numbers of an array."""
        kind = TYPES.get("" if element is None else element.get("type", ""))
        if element is None or kind is None:
            raise ReadError(f"the {what} are missing, or of an unknown type")
        form, text = element.get("format", "ascii"), (element.text or "").encode()
        if form == "ascii":
            return floats(text.split(), what)
        if form == "binary":
            data = self._payload(b"".join(text.split()), encoded=True)
        elif form == "appended":
            start = int(element.get("offset", "-1"))
            if not 0 <= start <= len(self.appended):
                raise ReadError(f"the {what} are outside the file")
            data = self._payload(self.appended[start:], encoded=not self.raw)
        else:
            raise ReadError(f"unknown format of the {what}: {form[:40]!r}")
        return np.frombuffer(data, self.order + kind)

    def _payload(self, stored: bytes, *, encoded: bool) -> bytes:
        """Return the bytes of an array from its beginning."""
        head = _Bytes(stored, encoded=encoded)
        if self.decompress is None:
            size = int(head.numbers(self.header, 1)[0])
            return head.take(size, self.header.itemsize)
        n_blocks = int(head.numbers(self.header, 1)[0])
        sizes = head.numbers(self.header, 3 + n_blocks)[3:].astype(np.int64)
        body = head.after(self.header.itemsize * (3 + n_blocks))
        ends = np.cumsum(sizes)
        packed = body.take(int(ends[-1]) if n_blocks else 0, 0)
        return b"".join(
            self.decompress(packed[end - size : end])
            for end, size in zip(ends.tolist(), sizes.tolist(), strict=True)
        )


@dataclass(frozen=True)
class _Bytes:
    """Bytes as they are, or in base64; base64 may be followed by other data."""

    stored: bytes
    encoded: bool

    def take(self, size: int, start: int) -> bytes:
        """Return `size` bytes from `start` on."""
        end = start + size
        data = self.stored[:end]
        if self.encoded:
            data = base64.b64decode(self.stored[: 4 * -(-end // 3)])
        if len(data) < end or size < 0:
            raise ReadError(f"the file ends before the last of {size} announced bytes")
        return data[start:end]

    def numbers(self, kind: np.dtype[Any], count: int) -> NDArray[Any]:
        """Return the first `count` numbers of a kind."""
        return np.frombuffer(self.take(count * kind.itemsize, 0), kind)

    def after(self, size: int) -> "_Bytes":
        """Return the rest after `size` bytes, which were encoded separately."""
        return _Bytes(self.stored[4 * -(-size // 3) if self.encoded else size :], self.encoded)


DECOMPRESS: dict[str, Callable[[bytes], bytes] | None] = {
    "": None,
    "vtkZLibDataCompressor": zlib.decompress,
    "vtkLZMADataCompressor": lzma.decompress,
}
"""Functions that decompress, by VTK's names of compressors."""
