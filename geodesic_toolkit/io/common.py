"""Helpers of the readers: numbers from text, triangles from polygons, optional packages."""

import codecs
import warnings
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodesic_toolkit.core import warning as _warning
from geodesic_toolkit.core.optional import require
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains import Domain, PointCloud, TriangleMesh
from geodesic_toolkit.errors import (
    InvalidDomainError,
    InvalidOptionError,
    ReadError,
    ReadWarning,
)
from geodesic_toolkit.geometry.polygons import split_polygons

__all__ = [
    "array_of",
    "check_count",
    "cloud",
    "floats",
    "integers",
    "lines_of",
    "optional_package",
    "surface",
    "text_of",
    "triangulate",
    "warn",
    "whole_numbers",
]

BYTE_ORDER_MARK = b"\xef\xbb\xbf"


def text_of(path: Path) -> bytes:
    """Return the contents of a text file as bytes: only UTF-16 needs decoding.

    Raises
    ------
    ReadError
        The file is binary.
    """
    text = path.read_bytes()
    if text.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):  # Excel's "Unicode text"
        try:
            return text.decode("utf-16").encode()
        except UnicodeDecodeError as error:
            raise ReadError(f"it begins as UTF-16, but is not: {error}") from error
    if b"\0" in text:
        raise ReadError("the file is binary, but text is expected")
    return text.removeprefix(BYTE_ORDER_MARK)


def lines_of(path: Path) -> list[bytes]:
    """Return the lines of a text file without comments, which begin with ``#``, and empty lines.

    Raises
    ------
    ReadError
        The file is binary.
    """
    lines = [line.partition(b"#")[0] for line in text_of(path).splitlines()]
    return [line for line in lines if line.strip()]


def array_of(path: Path) -> NDArray[Any]:
    """Return the array of an .npy file.

    Raises
    ------
    ReadError
        The file is an archive of several arrays.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # NumPy and Python warn about old and damaged headers
        table = np.load(path, allow_pickle=False)
    if not isinstance(table, np.ndarray):
        raise ReadError("the file is an archive, but an .npy array is expected")
    return table


def floats(tokens: Sequence[bytes], what: str) -> FloatArray:
    """Return the tokens as an array of float64; `what` names them in the message."""
    try:
        return np.fromiter(map(float, tokens), np.float64, len(tokens))
    except ValueError as error:
        raise ReadError(f"{what} must be numbers ({_first_bad(tokens, float)})") from error


def integers(tokens: Sequence[bytes], what: str) -> IntArray:
    """Return the tokens as an array of int64; `what` names them in the message."""
    try:
        return np.fromiter(map(int, tokens), np.int64, len(tokens))
    except (ValueError, OverflowError) as error:
        raise ReadError(f"{what} must be integers ({_first_bad(tokens, int)})") from error


def _first_bad(tokens: Iterable[bytes], convert: Any) -> str:
    for token in tokens:
        try:
            np.int64(convert(token)) if convert is int else convert(token)
        except (ValueError, OverflowError):
            return f"found {token[:40].decode('ascii', 'backslashreplace')!r}"
    return "found something else"  # pragma: no cover - a token was bad a moment ago


def whole_numbers(values: NDArray[Any], what: str) -> IntArray:
    """Return an array of numbers as int64.

    Raises
    ------
    ReadError
        The numbers are not whole, or too large.
    """
    if values.dtype.kind == "f":
        good = (np.abs(values) < 2.0**53) & (values == np.floor(values))
        if not good.all():
            raise ReadError(f"{what} must be whole numbers (found {values[~good].flat[0]})")
    elif values.dtype.kind == "u" and values.size and values.max() > np.iinfo(np.int64).max:
        raise ReadError(f"{what} must be smaller (found {values.max()})")
    return values.astype(np.int64)


def triangulate(path: Path, vertices: ArrayLike, sizes: IntArray, corners: IntArray) -> IntArray:
    """Split polygons into triangles inside them, with a warning if there are any polygons.

    Parameters
    ----------
    path : Path
        The file, for the warning.
    vertices : array-like of shape (N, 3)
    sizes, corners : ndarray of int64
        Corners of each polygon, and their vertex indices, polygon by polygon.

    Returns
    -------
    ndarray of shape (F, 3), int64
        The triangles of one polygon are consecutive.
    """
    points = np.asarray(vertices, dtype=np.float64)
    faces, remarks = split_polygons(points, sizes, corners)
    for remark in remarks:
        warn(path, remark)
    return faces


def surface(path: Path, vertices: ArrayLike, sizes: IntArray, corners: IntArray) -> Domain:
    """Return the mesh of some polygons, or the cloud if there are none."""
    if len(sizes) == 0:
        return PointCloud(vertices)
    return TriangleMesh(vertices, triangulate(path, vertices, sizes, corners))


def cloud(path: Path, points: ArrayLike, normals: ArrayLike | None) -> PointCloud:
    """Return a point cloud; unusable normals are omitted with a warning."""
    points_alone = PointCloud(points)
    if normals is None:
        return points_alone
    try:
        return PointCloud(points, normals)
    except InvalidDomainError as error:
        warn(path, f"the normals of the file were omitted: {str(error).partition(';')[0]}")
        return points_alone


def warn(path: Path, text: str) -> None:
    """Issue a ReadWarning that names the file, and the line outside this package that reads it."""
    _warning.warn(f"{path.name}: {text}", ReadWarning)


def check_count(path: Path, count: int, expected: int) -> None:
    """Raise an `InvalidOptionError` unless the file `like` has the expected number of points."""
    if count != expected:
        raise InvalidOptionError(
            f"{path} has {count} points, not {expected}, so its attributes cannot be kept"
        )


def optional_package(name: str, suffix: str, doing: str = "reading") -> Any:
    """Import a package, or a module of one, of the extra ``io``; see `require`."""
    return require(name, "io", f"{doing} .{suffix} files needs")
