"""LAS and LAZ, the formats of airborne laser scans, through laspy."""

import logging
import os
import struct
from pathlib import Path
from typing import Any, BinaryIO

from geodesic_toolkit.domains import PointCloud
from geodesic_toolkit.errors import MissingDependencyError, ReadError
from geodesic_toolkit.io.common import optional_package

__all__ = ["read_las"]

RECORD = 54
"""Bytes of a variable-length record without its contents."""

COMPRESSED = 128
"""Added to the number of the point format."""

ITEMS = {6: 20, 7: 8, 8: 6, 9: 29, 10: 30, 11: 6, 12: 8, 13: 29}
"""Bytes of the compressed fields of a point by their kinds; others are as long as they say."""

DENSEST = 1000
"""Compressed points that a byte can hold at most, generously."""


def read_las(path: Path) -> PointCloud:
    """Read the positions of a LAS file, or of a LAZ file."""
    laspy = optional_package("laspy", path.suffix[1:].lower())
    log = logging.getLogger("laspy")
    if not log.handlers:  # else what laspy logs beside raising it is printed to standard error
        log.addHandler(logging.NullHandler())
    _check_header(path)
    # One chunk after the other: many at a time, as is laspy's default, end the process where the
    # table of chunks is damaged.
    one_by_one = [laspy.LazBackend.Lazrs, laspy.LazBackend.Laszip]
    available = [backend for backend in one_by_one if backend.is_available()]
    try:
        with laspy.open(str(path), laz_backend=available) as reader:
            _check_points(reader.header, path.stat().st_size)
            if reader.header.are_points_compressed and not available:
                raise MissingDependencyError(
                    'reading .laz files needs lazrs: pip install "geodesic-toolkit[io]"'
                )
            return PointCloud(reader.read().xyz)
    except BaseException as error:  # lazrs's panics are no Exception; all else goes on
        if type(error).__name__ != "PanicException":
            raise
        raise ReadError(f"the compressed points are damaged ({error})") from error


def _check_points(header: Any, size: int) -> None:
    """Raise where points cannot be what the header says, which lazrs takes on trust."""
    width = header.point_format.size
    most = size * DENSEST if header.are_points_compressed else size // width
    if header.point_count > most:
        raise ReadError(f"the file ends before its {header.point_count} points do")
    for record in header.vlrs.get("LasZipVlr") if header.are_points_compressed else []:
        data = record.record_data
        (n_items,) = struct.unpack_from("<H", data, 32)
        items = [struct.unpack_from("<HH", data, 34 + 6 * number) for number in range(n_items)]
        if sum(item[1] for item in items) != width or any(
            item[1] != ITEMS.get(item[0], item[1]) for item in items
        ):
            raise ReadError("a damaged header: the compressed fields do not make up a point")


def _check_header(path: Path) -> None:
    """Raise where the header announces more records, or chunks of points, than fit.

    laspy would read on for hours, and its decompressor would end the process.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(247)
        chunks = _n_chunks(file, head) if len(head) >= 227 and head[104] >= COMPRESSED else 0
    if head[:4] != b"LASF" or len(head) < 227:
        raise ReadError('not a LAS file: it does not begin with "LASF" and a header')
    length, start, records = struct.unpack_from("<HII", head, 94)
    extended = struct.unpack_from("<I", head, 243)[0] if head[25] >= 4 and len(head) == 247 else 0
    if length + records * RECORD > min(start, size) or extended * RECORD > size:
        raise ReadError(f"a damaged header: it announces {records + extended} records")
    if chunks > size:
        raise ReadError("damaged, or cut off: its table of compressed chunks is broken")


def _n_chunks(file: BinaryIO, head: bytes) -> int:
    """Return how many chunks of compressed points a table at the end of the file announces."""
    file.seek(struct.unpack_from("<I", head, 96)[0])
    place = int.from_bytes(file.read(8), "little", signed=True)
    if place == -1:  # written by what could not go back: the place follows the table
        file.seek(-8, os.SEEK_END)
        place = int.from_bytes(file.read(8), "little", signed=True)
    if not 0 <= place < 2**62:
        raise ReadError("damaged: its table of compressed chunks has no place")
    file.seek(place + 4)
    return int.from_bytes(file.read(4), "little")
