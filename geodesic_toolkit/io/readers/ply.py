"""PLY, the Stanford polygon format: text and binary, faces, polygons, triangle strips, points."""

import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains import Domain, TriangleMesh
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.geometry.polygons import strip_triangles
from geodesic_toolkit.io.common import check_count, cloud, floats, triangulate, whole_numbers

__all__ = ["encode_ply", "encode_ply_like", "ply_polygons", "read_ply", "read_ply_lines"]

TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
NAMES = {
    "i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort", "i4": "int", "u4": "uint",
    "f4": "float", "f8": "double",
}  # fmt: skip
COUNTS = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I"}  # for struct
ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}
COLOURS = ("red", "green", "blue")
LONGEST_HEADER = 1 << 20
HEADER_END = re.compile(rb"[\r\n](end_header)[ \t]*[\r\n]")


@dataclass(frozen=True)
class _Property:
    """A property: a scalar, or a list if it has a type for the count."""

    name: str
    kind: str
    count: str | None = None


@dataclass
class _Element:
    name: str
    n: int
    properties: list[_Property] = field(default_factory=list)


# An element's data by property: (n,) values of a scalar; (n,) sizes and all values of a list.
_Column = tuple[IntArray | None, NDArray[Any]]
_Table = dict[str, _Column]


class _Body(Protocol):
    def take(self, element: _Element) -> _Table: ...


def read_ply(path: Path) -> Domain:
    """Read a PLY file: a mesh if it has faces or triangle strips, else a cloud."""
    _, _, tables = _contents(path)
    vertices, sizes, corners = _polygons(tables)
    faces = []
    if len(sizes):
        faces.append(triangulate(path, vertices, sizes, corners))
    if "tristrips" in tables:
        faces.append(strip_triangles(*_indices(tables["tristrips"], "tristrips")))
    if not faces:
        return cloud(path, vertices, _triple(tables["vertex"], ("nx", "ny", "nz")))
    return TriangleMesh(vertices, np.concatenate(faces))


def read_ply_lines(path: Path) -> list[FloatArray]:
    """Return the polylines of a PLY file, each of shape (P, 3): runs of edges that follow on."""
    _, _, tables = _contents(path)
    vertices = _triple(tables.get("vertex", {}), ("x", "y", "z"))
    edges = tables.get("edge", {})
    if vertices is None or not {"vertex1", "vertex2"} <= set(edges):
        raise ReadError("the file has no vertices with edges, vertex1 and vertex2")
    tails, heads = (
        whole_numbers(edges[name][1], "vertex indices of edges") for name in ("vertex1", "vertex2")
    )
    outside = [v for v in (*tails, *heads) if not 0 <= v < len(vertices)]
    if outside:
        raise ReadError(f"an edge refers to vertex {outside[0]}; there are {len(vertices)}")
    runs = np.split(np.arange(len(tails)), np.flatnonzero(tails[1:] != heads[:-1]) + 1)
    return [vertices[[*tails[run], heads[run[-1]]]] for run in runs if len(run)]


def ply_polygons(path: Path) -> tuple[FloatArray, IntArray, IntArray]:
    """Return the vertices of a PLY file, and sizes and corners of its polygons, without strips."""
    return _polygons(_contents(path)[2])


def _polygons(tables: dict[str, _Table]) -> tuple[FloatArray, IntArray, IntArray]:
    vertices = _triple(tables.get("vertex", {}), ("x", "y", "z"))
    if vertices is None:
        raise ReadError("the file has no element vertex with properties x, y and z")
    if "face" not in tables:
        return vertices, np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    return vertices, *_indices(tables["face"], "face")


def _contents(path: Path) -> tuple[list[str], list[_Element], dict[str, _Table]]:
    """Return the remarks of a file, the declarations of its elements, and their values."""
    data = path.read_bytes()
    form, elements, start = _header(data)
    body: _Body = _Text(data[start:]) if form == "ascii" else _Binary(data, start, ORDERS[form])
    remarks = [
        line
        for line in data[:start].decode("latin-1").splitlines()
        if line.startswith(("comment", "obj_info"))
    ]
    return remarks, elements, {element.name: body.take(element) for element in elements}


def _triple(table: _Table, names: tuple[str, str, str]) -> FloatArray | None:
    if any(name not in table or table[name][0] is not None for name in names):
        return None
    return np.column_stack([table[name][1] for name in names]).astype(np.float64)


def _indices(table: _Table, element: str) -> tuple[IntArray, IntArray]:
    for name in ("vertex_indices", "vertex_index"):
        sizes, values = table.get(name, (None, None))
        if sizes is not None and values is not None:
            return sizes, whole_numbers(values, f"vertex indices of {element}")
    if all(len(column) == 0 for _, column in table.values()):
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    raise ReadError(f"the element {element} has no list vertex_indices")


# -- the header ----------------------------------------------------------------------------------


def _header(data: bytes) -> tuple[str, list[_Element], int]:
    """Return the format, the elements, and the start of the data."""
    if data[:3] != b"ply" or data[3:4] not in {b"\n", b"\r", b" "}:
        raise ReadError('not a PLY file: it does not begin with "ply"')
    found = HEADER_END.search(data, 0, LONGEST_HEADER)  # a comment may contain the word
    end = found.start(1) if found else -1
    newline = min(
        (at for at in (data.find(b"\n", end), data.find(b"\r", end)) if at >= 0), default=-1
    )
    if end < 0 or newline < 0:
        raise ReadError("the PLY header has no end_header line")
    start = newline + (2 if data[newline : newline + 2] == b"\r\n" else 1)
    form, elements = "", list[_Element]()
    for line in data[:end].decode("latin-1").splitlines()[1:]:
        match line.split():
            case ["format", name, *_]:
                form = name
            case ["element", name, number]:
                elements.append(_Element(name, _count(number, name)))
            case ["property", "list", count, kind, name] if elements:
                elements[-1].properties.append(_Property(name, _type(kind), _count_type(count)))
            case ["property", kind, name] if elements:
                elements[-1].properties.append(_Property(name, _type(kind)))
            case [] | ["comment" | "obj_info", *_]:
                pass
            case _:
                raise ReadError(f"unrecognised line in the header: {line[:60]!r}")
    if form != "ascii" and form not in ORDERS:
        raise ReadError(f"unknown format of PLY file: {form[:40]!r}")
    return form, elements, start


def _count(number: str, name: str) -> int:
    if not (number.isascii() and number.isdigit() and len(number) < 19):
        raise ReadError(f"the number of elements {name} is {number[:40]!r}")
    return int(number)


def _type(name: str) -> str:
    if name not in TYPES:
        raise ReadError(f"unknown type in the PLY header: {name[:40]!r}")
    return TYPES[name]


def _count_type(name: str) -> str:
    kind = _type(name)
    if kind[0] == "f":
        raise ReadError(f"the type {name} cannot count the entries of a list")
    return kind


def _ends_early(element: _Element) -> ReadError:
    return ReadError(f"the file ends before the last of its {element.n} elements {element.name}")


# -- the data ------------------------------------------------------------------------------------


class _Binary:
    """The data of a binary file, read element by element."""

    def __init__(self, data: bytes, start: int, order: str) -> None:
        self.data, self.at, self.order = data, start, order

    def take(self, element: _Element) -> _Table:
        least = sum(np.dtype(each.count or each.kind).itemsize for each in element.properties)
        if element.n * least > len(self.data) - self.at:
            raise _ends_early(element)
        if not element.n or not least:
            return {each.name: _nothing(each) for each in element.properties}
        try:
            return self._uniform(element) or self._walk(element)
        except struct.error as error:
            raise _ends_early(element) from error

    def _uniform(self, element: _Element) -> _Table | None:
        """Read rows that all have the lengths of the first; None if they do not."""
        lengths = [size for size, _ in self._row(element, self.at)[0]]
        fields: list[Any] = []
        for number, (each, length) in enumerate(zip(element.properties, lengths, strict=True)):
            if each.count is None:
                fields.append((f"value{number}", self.order + each.kind))
            else:
                fields.append((f"count{number}", self.order + each.count))
                fields.append((f"value{number}", self.order + each.kind, (length,)))
        layout = np.dtype(fields)
        if element.n * layout.itemsize > len(self.data) - self.at:
            return None
        rows = np.frombuffer(self.data, layout, element.n, self.at)
        table: _Table = {}
        for number, (each, length) in enumerate(zip(element.properties, lengths, strict=True)):
            values = rows[f"value{number}"]
            if each.count is None:
                table[each.name] = None, values
                continue
            if (rows[f"count{number}"] != length).any():
                return None
            table[each.name] = np.full(element.n, length, dtype=np.int64), values.ravel()
        self.at += element.n * layout.itemsize
        return table

    def _walk(self, element: _Element) -> _Table:
        sizes: list[list[int]] = [[] for _ in element.properties]
        pieces: list[list[bytes]] = [[] for _ in element.properties]
        for _ in range(element.n):
            spans, self.at = self._row(element, self.at)
            for number, (size, piece) in enumerate(spans):
                sizes[number].append(size)
                pieces[number].append(piece)
        return {
            each.name: (
                None if each.count is None else np.array(sizes[number], dtype=np.int64),
                np.frombuffer(b"".join(pieces[number]), self.order + each.kind),
            )
            for number, each in enumerate(element.properties)
        }

    def _row(self, element: _Element, at: int) -> tuple[list[tuple[int, bytes]], int]:
        """Return the length and the bytes of each property of the row at `at`, and its end."""
        spans = []
        for each in element.properties:
            size = 1
            if each.count is not None:
                (size,) = struct.unpack_from(self.order + COUNTS[each.count], self.data, at)
                at += int(each.count[1])
                if size < 0:
                    raise ReadError(f"a list {each.name} of {element.name} has {size} entries")
            end = at + size * int(each.kind[1])
            if end > len(self.data):
                raise _ends_early(element)
            spans.append((size, self.data[at:end]))
            at = end
        return spans, at


class _Text:
    """The data of a text file, read element by element."""

    def __init__(self, text: bytes) -> None:
        self.tokens, self.at = text.split(), 0

    def take(self, element: _Element) -> _Table:
        least = len(element.properties)
        if element.n * least > len(self.tokens) - self.at:
            raise _ends_early(element)
        if not element.n or not least:
            return {each.name: _nothing(each) for each in element.properties}
        return self._uniform(element) or self._walk(element)

    def _uniform(self, element: _Element) -> _Table | None:
        """Read rows that all have the lengths of the first; None if they do not."""
        lengths = [len(row) for row in self._row(element, self.at)[0]]
        width = sum(lengths) + sum(each.count is not None for each in element.properties)
        end = self.at + element.n * width
        if end > len(self.tokens):
            return None
        rows = floats(self.tokens[self.at : end], f"properties of {element.name}")
        rows = rows.reshape(element.n, width)
        table: _Table = {}
        column = 0
        for each, length in zip(element.properties, lengths, strict=True):
            sizes = None
            if each.count is not None:
                if (rows[:, column] != length).any():
                    return None
                sizes = np.full(element.n, length, dtype=np.int64)
                column += 1
            table[each.name] = sizes, rows[:, column : column + length].ravel()
            column += length
        self.at = end
        return table

    def _walk(self, element: _Element) -> _Table:
        sizes: list[list[int]] = [[] for _ in element.properties]
        values: list[list[bytes]] = [[] for _ in element.properties]
        for _ in range(element.n):
            row, self.at = self._row(element, self.at)
            for number, entries in enumerate(row):
                sizes[number].append(len(entries))
                values[number] += entries
        return {
            each.name: (
                None if each.count is None else np.array(sizes[number], dtype=np.int64),
                floats(values[number], f"properties of {element.name}"),
            )
            for number, each in enumerate(element.properties)
        }

    def _row(self, element: _Element, at: int) -> tuple[list[list[bytes]], int]:
        """Return the tokens of each property of the row at `at`, and its end."""
        row = []
        for each in element.properties:
            size = 1
            if each.count is not None:
                head = self.tokens[at : at + 1]
                if not head:
                    raise _ends_early(element)
                if not head[0].isdigit() or len(head[0]) > 18:
                    raise ReadError(f"a list {each.name} of {element.name} has {head[0]!r} entries")
                size, at = int(head[0]), at + 1
            if at + size > len(self.tokens):
                raise _ends_early(element)
            row.append(self.tokens[at : at + size])
            at += size
        return row, at


def _nothing(each: _Property) -> _Column:
    sizes = None if each.count is None else np.empty(0, dtype=np.int64)
    return sizes, np.empty(0, dtype=each.kind)


# -- writing -------------------------------------------------------------------------------------


def encode_ply(
    vertices: Mapping[str, NDArray[Any]],
    polygons: tuple[IntArray, IntArray] | None,
    comments: list[str],
) -> bytes:
    """Return a binary little-endian PLY file.

    Parameters
    ----------
    vertices : mapping from property names to arrays of shape (N,)
        uint8, float32 or float64.
    polygons : tuple of (F,) sizes and (sizes.sum(),) corners, or None
    comments : list of str
        One line each.
    """
    n = len(next(iter(vertices.values())))
    lines = ["ply", "format binary_little_endian 1.0", *(f"comment {text}" for text in comments)]
    lines.append(f"element vertex {n}")
    lines += [f"property {NAMES[array.dtype.str[1:]]} {name}" for name, array in vertices.items()]
    rows = np.empty(
        n, dtype=[(name, "<" + array.dtype.str[1:]) for name, array in vertices.items()]
    )
    for name, array in vertices.items():
        rows[name] = array
    parts = [rows.tobytes()]
    if polygons is not None:
        sizes, corners = polygons
        kind = "u1" if sizes.max(initial=0) < 256 else "i4"
        face = _Element("face", len(sizes), [_Property("vertex_indices", "i4", kind)])
        lines.append(f"element face {face.n}")
        lines.append(f"property list {NAMES[kind]} int vertex_indices")
        parts.append(_encoded(face, {"vertex_indices": (sizes, corners)}))
    return "\n".join([*lines, "end_header", ""]).encode("ascii") + b"".join(parts)


def encode_ply_like(path: Path, fields: Mapping[str, NDArray[Any]], comment: str) -> bytes:
    """Return another PLY file as a binary little-endian one with more vertex properties.

    All elements and their properties are kept, including polygons and colours, except vertex
    properties of the same names.

    Parameters
    ----------
    path : Path
        The other file.
    fields : mapping from property names to arrays of shape (N,)
        uint8, float32 or float64. Colours are omitted if the file has colours of its own.
    comment : str

    Raises
    ------
    InvalidOptionError
        A file with another number of vertices.
    """
    remarks, elements, tables = _contents(path)
    (vertex,) = (element for element in elements if element.name == "vertex")
    check_count(path, vertex.n, len(next(iter(fields.values()))))
    own = tables["vertex"].keys()
    new = {
        name: values for name, values in fields.items() if name not in COLOURS or name not in own
    }
    vertex.properties = [
        *(each for each in vertex.properties if each.name not in new),
        *(_Property(name, values.dtype.str[1:]) for name, values in new.items()),
    ]
    tables["vertex"] = {**tables["vertex"], **{name: (None, new[name]) for name in new}}
    first = comment.partition(" from ")[0]  # of a file written by this package
    lines = ["ply", "format binary_little_endian 1.0", f"comment {comment}"]
    lines += [remark for remark in remarks if not remark.startswith(f"comment {first}")]
    for element in elements:
        lines.append(f"element {element.name} {element.n}")
        for each in element.properties:
            size = "" if each.count is None else f"list {NAMES[each.count]} "
            lines.append(f"property {size}{NAMES[each.kind]} {each.name}")
    header = "\n".join([*lines, "end_header", ""]).encode("latin-1")
    return header + b"".join(_encoded(element, tables[element.name]) for element in elements)


def _encoded(element: _Element, table: _Table) -> bytes:
    """Return the rows of an element."""
    if not element.n or not element.properties:
        return b""
    sizes = [table[each.name][0] for each in element.properties]
    if any(size is not None and (size != size[0]).any() for size in sizes):
        return _encoded_row_by_row(element, table)
    fields: list[Any] = []
    for number, (each, size) in enumerate(zip(element.properties, sizes, strict=True)):
        if each.count is not None and size is not None:
            fields.append((f"count{number}", f"<{each.count}"))
        length = 1 if size is None else int(size[0])
        fields.append((f"value{number}", f"<{each.kind}", (length,)))
    rows = np.empty(element.n, fields)
    with np.errstate(invalid="ignore"):  # a text may have nan for integers
        for number, each in enumerate(element.properties):
            size, values = table[each.name]
            if size is not None:
                rows[f"count{number}"] = size
            rows[f"value{number}"] = values.reshape(element.n, -1)
    return rows.tobytes()


def _encoded_row_by_row(element: _Element, table: _Table) -> bytes:
    """Return rows whose lists have different lengths."""
    columns = []
    for each in element.properties:
        size, values = table[each.name]
        length = np.ones(element.n, dtype=np.int64) if size is None else size
        ends = (np.cumsum(length) * int(each.kind[1])).tolist()
        data = values.astype(f"<{each.kind}").tobytes()
        counts = [b""] * element.n
        if size is not None:
            width = int(str(each.count)[1])
            packed = size.astype(f"<{each.count}").tobytes()
            counts = [packed[width * row : width * (row + 1)] for row in range(element.n)]
        columns.append((counts, [0, *ends], data))
    parts = []
    for row in range(element.n):
        for counts, bounds, data in columns:
            parts += [counts[row], data[bounds[row] : bounds[row + 1]]]
    return b"".join(parts)
