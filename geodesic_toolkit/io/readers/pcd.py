"""PCD, the Point Cloud Library's format: text, binary and compressed.

This reader replaces Open3D's: it keeps missing points and float64 coordinates, and does not need
Open3D's system libraries.
"""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import Domain, PointCloud, normals_of, positions_of
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.io.common import check_count, cloud, floats

__all__ = ["encode_pcd", "read_pcd"]

SIZES = {"F": {4, 8}, "I": {1, 2, 4, 8}, "U": {1, 2, 4, 8}}
LONGEST_HEADER = 1 << 16

_Layout = list[tuple[str, np.dtype[Any], int]]  # name, type and number of entries of each field


def read_pcd(path: Path) -> PointCloud:
    """Read a PCD file; points that are NaN are kept as missing points."""
    header, layout, fields = _contents(path)
    columns = {
        name: values[:, 0]
        for (name, _, count), values in zip(layout, fields, strict=True)
        if count == 1
    }
    points = _triple(columns, ("x", "y", "z"))
    if points is None:
        raise ReadError(f"the fields are {' '.join(header['FIELDS'])[:80]}, without x, y and z")
    return cloud(path, points, _triple(columns, ("normal_x", "normal_y", "normal_z")))


def encode_pcd(domain: Domain, field: FloatArray, like: Path | None) -> bytes:
    """Return a binary PCD file of points with the field ``distance``, of 8 bytes.

    Parameters
    ----------
    domain : Domain
        Its positions, and normals if there are any, are written if there is no `like`.
    field : ndarray of shape (N,)
    like : Path, optional
        A PCD file of the same points; all its fields are kept, and its organisation.

    Raises
    ------
    InvalidOptionError
        A file with another number of points.
    """
    header: dict[str, list[str]] = {}
    layout: _Layout = []
    fields: list[NDArray[Any]] = []
    if like is not None:
        header, layout, fields = _contents(like)
        check_count(like, len(fields[0]), len(field))
        old = [i for i, (name, _, _) in enumerate(layout) if name != "distance"]
        layout, fields = [layout[i] for i in old], [fields[i] for i in old]
    else:
        names, columns = ["x", "y", "z"], [*positions_of(domain).T]
        normals = normals_of(domain)
        if normals is not None:
            names += ["normal_x", "normal_y", "normal_z"]
            columns += [*normals.T]
        layout = [(name, np.dtype("<f8"), 1) for name in names]
        fields = [column[:, None] for column in columns]
    layout.append(("distance", np.dtype("<f8"), 1))
    fields.append(field[:, None])
    rows = np.empty(len(field), _row(layout))
    with np.errstate(invalid="ignore"):  # a text may have nan for integers
        for number, values in enumerate(fields):
            rows[f"field{number}"] = values
    kinds = {"f": "F", "i": "I", "u": "U"}
    lines = {
        "VERSION": ["0.7"],
        "FIELDS": [name for name, _, _ in layout],
        "SIZE": [str(kind.itemsize) for _, kind, _ in layout],
        "TYPE": [kinds[kind.kind] for _, kind, _ in layout],
        "COUNT": [str(count) for _, _, count in layout],
        "WIDTH": header.get("WIDTH", [str(len(field))]),
        "HEIGHT": header.get("HEIGHT", ["1"]),
        "VIEWPOINT": header.get("VIEWPOINT", ["0", "0", "0", "1", "0", "0", "0"]),
        "POINTS": [str(len(field))],
        "DATA": ["binary"],
    }
    text = "".join(f"{keyword} {' '.join(words)}\n" for keyword, words in lines.items())
    return f"# .PCD v0.7 - geodesic distance\n{text}".encode("latin-1") + rows.tobytes()


def _contents(path: Path) -> tuple[dict[str, list[str]], _Layout, list[NDArray[Any]]]:
    """Return the header of a file, the layout of its fields, and their values, (N, count) each."""
    data = path.read_bytes()
    header, form, start = _header(data)
    n_points = _n_points(header)
    layout = _layout(header)
    take = {"ascii": _text, "binary": _rows, "binary_compressed": _compressed}[form]
    return header, layout, take(data[start:], layout, n_points)


def _triple(columns: dict[str, Any], names: tuple[str, str, str]) -> FloatArray | None:
    if not columns.keys() >= set(names):
        return None
    return np.column_stack([columns[name] for name in names]).astype(np.float64)


def _header(data: bytes) -> tuple[dict[str, list[str]], str, int]:
    """Return the header lines by keyword, the form of the data, and the start of the data."""
    header: dict[str, list[str]] = {}
    at = 0
    while 0 <= (end := data.find(b"\n", at)) < LONGEST_HEADER:
        keyword, *words = data[at:end].decode("latin-1").split() or ["#"]
        at = end + 1
        if keyword.startswith("#"):
            continue
        header[keyword.upper()] = words
        if keyword.upper() == "DATA":
            form = " ".join(words).lower()
            if form not in {"ascii", "binary", "binary_compressed"}:
                raise ReadError(f"unknown form of PCD data: {form[:40]!r}")
            header["FIELDS"] = header.get("FIELDS", header.get("COLUMNS", []))
            return header, form, at
    raise ReadError("not a PCD file: its header has no DATA line")


def _n_points(header: dict[str, list[str]]) -> int:
    try:
        if "POINTS" in header:
            (n_points,) = map(int, header["POINTS"])
        else:
            n_points = int(header["WIDTH"][0]) * int(header.get("HEIGHT", ["1"])[0])
    except (ValueError, LookupError) as error:
        raise ReadError("the header has no valid number of points") from error
    if not 0 < n_points < 2**48:
        raise ReadError(f"the header announces {n_points} points")
    return n_points


def _layout(header: dict[str, list[str]]) -> _Layout:
    """Return the name, type and number of entries of each field."""
    names = header["FIELDS"]
    counts = header.get("COUNT", ["1"] * len(names))
    sizes, kinds = header.get("SIZE", []), header.get("TYPE", [])
    if not names or not len(names) == len(sizes) == len(kinds) == len(counts):
        raise ReadError("FIELDS, SIZE, TYPE and COUNT of the header do not match")
    layout = []
    for name, size, kind, count in zip(names, sizes, kinds, counts, strict=True):
        if not (size.isdecimal() and int(size) in SIZES.get(kind.upper(), ())):
            raise ReadError(f"field {name[:40]!r} has type {kind[:8]!r} of size {size[:8]!r}")
        if not (count.isdecimal() and int(count) < 2**20):
            raise ReadError(f"field {name[:40]!r} has count {count[:8]!r}")
        layout.append((name, np.dtype(f"<{kind.lower()}{size}"), int(count)))
    return layout


def _text(text: bytes, layout: _Layout, n_points: int) -> list[NDArray[Any]]:
    width = sum(count for _, _, count in layout)
    tokens = text.split()
    if len(tokens) < n_points * width:
        raise ReadError(f"the file ends before the last of its {n_points} points")
    table = floats(tokens[: n_points * width], "the fields").reshape(n_points, width)
    ends = np.cumsum([count for _, _, count in layout])[:-1]
    return list(np.split(table, ends, axis=1))


def _row(layout: _Layout) -> np.dtype[Any]:
    return np.dtype([(f"field{i}", kind, (count,)) for i, (_, kind, count) in enumerate(layout)])


def _rows(data: bytes, layout: _Layout, n_points: int) -> list[NDArray[Any]]:
    """Read the fields from data that hold one point after the other."""
    row = _row(layout)
    if n_points * row.itemsize > len(data):
        raise ReadError(f"the file ends before the last of its {n_points} points")
    table = np.frombuffer(data, row, n_points)
    return [table[f"field{i}"] for i in range(len(layout))]


def _compressed(data: bytes, layout: _Layout, n_points: int) -> list[NDArray[Any]]:
    """Read the fields from compressed data, which hold one field after the other."""
    packed = int.from_bytes(data[:4], "little")
    size = int.from_bytes(data[4:8], "little")
    if len(data) < 8 + packed:
        raise ReadError("the file ends before the last of its compressed points")
    if size != n_points * sum(kind.itemsize * count for _, kind, count in layout):
        raise ReadError(
            f"the compressed data announce {size} bytes, which are not {n_points} points"
        )
    unpacked = _unpack(data[8 : 8 + packed], size)
    fields, at = [], 0
    for _, kind, count in layout:
        values = np.frombuffer(unpacked, kind, n_points * count, at)
        fields.append(values.reshape(n_points, count))
        at += values.nbytes
    return fields


def _unpack(packed: bytes, size: int) -> bytes:
    """Decompress liblzf data: literal bytes, and repetitions of earlier bytes."""
    out = bytearray()
    at, end = 0, len(packed)
    try:
        while at < end and len(out) <= size:
            control = packed[at]
            at += 1
            if control < 32:
                out += packed[at : at + control + 1]
                at += control + 1
                continue
            length = control >> 5
            if length == 7:
                length += packed[at]
                at += 1
            back = ((control & 31) << 8) + packed[at] + 1
            at += 1
            length += 2
            start = len(out) - back
            if start < 0:
                raise ReadError(
                    "the compressed points are damaged: they refer to bytes before their start"
                )
            if back >= length:
                out += out[start : start + length]
            else:  # the repetition overlaps its own output
                out += (out[start:] * (length // back + 1))[:length]
    except IndexError as error:
        raise ReadError(
            "the compressed points are damaged: they end within a repetition"
        ) from error
    if len(out) != size:
        raise ReadError(f"the compressed points are damaged: {len(out)} bytes, not {size}")
    return bytes(out)
