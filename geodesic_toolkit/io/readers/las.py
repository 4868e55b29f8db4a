"""LAS and LAZ, the formats of airborne laser scans, through laspy."""

import copy
import logging
import os
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import PointCloud
from geodesic_toolkit.errors import (
    InvalidOptionError,
    MissingDependencyError,
    ReadError,
    WriteError,
)
from geodesic_toolkit.io.common import check_count, optional_package

__all__ = ["read_las", "require_las", "write_las"]

POINTS_PER_CHUNK = 1_000_000
"""Number of points copied at once."""

BYTES_OF_RECORD_HEADER = 54
"""Number of bytes of a variable-length record without its contents."""

COMPRESSED_FORMAT_FLAG = 128
"""Flag added to the number of the point format if points are compressed."""

BYTES_OF_ITEMS = {6: 20, 7: 8, 8: 6, 9: 29, 10: 30, 11: 6, 12: 8, 13: 29}
"""Bytes of the compressed fields of a point by their kinds; other fields state their length."""

MAX_POINTS_PER_BYTE = 1000
"""Generous upper bound of compressed points per byte."""


def read_las(path: Path) -> PointCloud:
    """Read the positions of a LAS or LAZ file."""
    with _opened(path) as reader:
        return PointCloud(reader.read().xyz)


def require_las(path: Path) -> None:
    """Raise a `MissingDependencyError` if a LAS or LAZ file could not be written."""
    laspy = optional_package("laspy", path.suffix[1:].lower(), "writing")
    if path.suffix.lower() == ".laz" and not laspy.LazBackend.detect_available():
        raise MissingDependencyError(
            'writing .laz files needs lazrs: pip install "geodesic-toolkit[io]"'
        )


def write_las(path: Path, positions: FloatArray, field: FloatArray, like: Path | None) -> None:
    """Write points with the extra dimension ``distance``, a double.

    Parameters
    ----------
    path : Path
        Compressed if the suffix is .laz.
    positions : ndarray of shape (N, 3)
        Written if there is no `like`.
    field : ndarray of shape (N,)
    like : Path, optional
        A LAS or LAZ file of the same points; all its attributes and records are kept.

    Raises
    ------
    InvalidOptionError
        Missing points, which LAS cannot store; a file with another number of points.
    """
    import laspy

    try:
        if like is None:
            _write_positions(path, positions, field)
        else:
            _write_like(path, field, like)
    except laspy.errors.LaspyException as error:
        raise WriteError(f"{path.suffix} cannot be written: {error}") from error


def _write_like(path: Path, field: FloatArray, like: Path) -> None:
    import laspy

    with _opened(like) as reader:
        check_count(like, reader.header.point_count, len(field))
        header = copy.deepcopy(reader.header)
        if "distance" in header.point_format.extra_dimension_names:
            header.remove_extra_dim("distance")
        header.add_extra_dim(_dimension())
        with laspy.open(str(path), mode="w", header=header) as writer:
            start = 0
            for points in reader.chunk_iterator(POINTS_PER_CHUNK):
                record = laspy.ScaleAwarePointRecord.zeros(len(points), header=header)
                record.copy_fields_from(points)
                record["distance"] = field[start : start + len(points)]
                writer.write_points(record)
                start += len(points)
            if header.version.minor >= 4 and reader.evlrs:
                writer.write_evlrs(reader.evlrs)


def _write_positions(path: Path, positions: FloatArray, field: FloatArray) -> None:
    import laspy

    missing = ~np.isfinite(positions).all(axis=1)
    if missing.any():
        raise InvalidOptionError(
            f"point {int(missing.argmax())} is missing, which LAS cannot store; write .pcd or .ply"
        )
    header = laspy.LasHeader(point_format=0, version="1.4")
    low, high = positions.min(axis=0), positions.max(axis=0)
    size = max(float((high - low).max()), float(np.finfo(np.float64).tiny) * 1e20)
    header.offsets = low
    header.scales = np.full(3, 10.0 ** np.ceil(np.log10(size / 2**30)))  # 32-bit integers
    header.add_extra_dim(_dimension())
    points = laspy.LasData(header)
    points.x, points.y, points.z = positions.T
    points["distance"] = field
    points.write(str(path))


def _dimension() -> Any:
    import laspy

    return laspy.ExtraBytesParams("distance", np.float64, "geodesic distance")


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """Open a file for reading by laspy; errors of its decompressor become a `ReadError`."""
    laspy = optional_package("laspy", path.suffix[1:].lower())
    log = logging.getLogger("laspy")
    if not log.handlers:  # otherwise laspy's log goes to stderr
        log.addHandler(logging.NullHandler())
    _check_header(path)
    # One chunk after the other: laspy's default, many at a time, ends the process if the table of
    # chunks is damaged.
    one_by_one = [laspy.LazBackend.Lazrs, laspy.LazBackend.Laszip]
    available = [backend for backend in one_by_one if backend.is_available()]
    try:
        with laspy.open(str(path), laz_backend=available) as reader:
            _check_points(reader.header, path.stat().st_size)
            if reader.header.are_points_compressed and not available:
                raise MissingDependencyError(
                    'reading .laz files needs lazrs: pip install "geodesic-toolkit[io]"'
                )
            yield reader
    except BaseException as error:  # lazrs's panics are not an Exception
        if type(error).__name__ != "PanicException":
            raise
        raise ReadError(f"the compressed points are damaged ({error})") from error


def _check_points(header: Any, size: int) -> None:
    """Raise if the points cannot be those of the header, which lazrs does not check."""
    width = header.point_format.size
    most = size * MAX_POINTS_PER_BYTE if header.are_points_compressed else size // width
    if header.point_count > most:
        raise ReadError(f"the file ends before the last of its {header.point_count} points")
    for record in header.vlrs.get("LasZipVlr") if header.are_points_compressed else []:
        data = record.record_data
        (n_items,) = struct.unpack_from("<H", data, 32)
        items = [struct.unpack_from("<HH", data, 34 + 6 * number) for number in range(n_items)]
        if sum(item[1] for item in items) != width or any(
            item[1] != BYTES_OF_ITEMS.get(item[0], item[1]) for item in items
        ):
            raise ReadError("a damaged header: the compressed fields do not make up a point")


def _check_header(path: Path) -> None:
    """Raise if the header announces more records, or chunks of points, than fit into the file.

    Otherwise laspy would read for hours, and its decompressor would end the process.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(247)
        chunks = (
            _n_chunks(file, head) if len(head) >= 227 and head[104] >= COMPRESSED_FORMAT_FLAG else 0
        )
    if head[:4] != b"LASF" or len(head) < 227:
        raise ReadError('not a LAS file: it does not begin with "LASF" and a header')
    length, start, records = struct.unpack_from("<HII", head, 94)
    extended = struct.unpack_from("<I", head, 243)[0] if head[25] >= 4 and len(head) == 247 else 0
    if (
        length + records * BYTES_OF_RECORD_HEADER > min(start, size)
        or extended * BYTES_OF_RECORD_HEADER > size
    ):
        raise ReadError(f"a damaged header: it announces {records + extended} records")
    if chunks > size:
        raise ReadError("damaged, or cut off: its table of compressed chunks is broken")


def _n_chunks(file: BinaryIO, head: bytes) -> int:
    """Return the number of chunks of compressed points, from the table at the end of the file."""
    file.seek(struct.unpack_from("<I", head, 96)[0])
    position = int.from_bytes(file.read(8), "little", signed=True)
    if position == -1:  # written as a stream: the position follows the table
        file.seek(-8, os.SEEK_END)
        position = int.from_bytes(file.read(8), "little", signed=True)
    if not 0 <= position < 2**62:
        raise ReadError("damaged: the position of its table of compressed chunks is invalid")
    file.seek(position + 4)
    return int.from_bytes(file.read(4), "little")
