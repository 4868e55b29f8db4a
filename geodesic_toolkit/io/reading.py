"""`read`: read a file as a domain, in the format of its suffix."""

import gzip
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from geodesic_toolkit.core.atomic import as_path
from geodesic_toolkit.domains import Domain
from geodesic_toolkit.errors import (
    GeodesicError,
    InvalidDomainError,
    InvalidOptionError,
    NotEnoughMemoryError,
    ReadError,
    UnknownPluginError,
)
from geodesic_toolkit.io.readers.freesurfer import is_surface, read_surface
from geodesic_toolkit.registry.catalog import readers

__all__ = ["check_file", "named_errors", "one_line", "read", "unpacked"]

LONGEST_REASON = 300
"""Number of characters of a foreign error's text in a message."""


def read(path: str | os.PathLike[str], *, kinds: Iterable[type[Domain]] = ()) -> Domain:
    """Read a mesh, point cloud or graph from a file.

    The suffix chooses the reader among those registered in ``gt.readers``, to which other
    distributions may add theirs (entry points of the group ``geodesic_toolkit.readers``: functions
    from a path to a domain). For a suffix that the core reads as well, the other reader is asked
    first, and returns None for a file that it leaves to the core. Vertex indices are those of the
    file: vertices are not merged or dropped, except as listed here.

    ============================ ======================================================
    off, obj, ply, stl, vtp,     a :class:`TriangleMesh`; without faces all but stl are a
    glb, gltf                    :class:`PointCloud`. An STL has corners only:
                                 equal ones are one vertex, in the order of first use,
                                 and at open edges those that differ by rounding
    mesh, msh, vtk, vtu          a :class:`TriangleMesh`, for a solid its surface (meshio)
    gii; pial, white, inflated,  a :class:`TriangleMesh` (nibabel); surfaces of FreeSurfer are
    sphere, orig and so on       recognised by their names, or by their first bytes
    pcd, pts, las, laz           a :class:`PointCloud`, missing points (NaN) kept (laspy
                                 for the last two)
    xyz, txt, asc, csv           a :class:`PointCloud`: rows ``x y z``, optionally normals,
                                 after a line with their number or names of columns; if
                                 named, x, y and z are used. Separated by blanks, commas
                                 or semicolons; decimal commas only if that is unambiguous
    mtx, npz, edges, edgelist    a :class:`Graph`: entries of a sparse matrix, or rows
                                 ``i j length`` counted from 0, are edge lengths; an npz
                                 may also hold ``vertices`` and ``faces``, or ``points``
                                 and ``normals``
    gz                           any of these, compressed
    ============================ ======================================================

    Parameters
    ----------
    path : str or path-like
    kinds : iterable of types, optional
        Kinds of domain that are wanted, such as the `domains` of an operator. The first that reads
        files itself (:meth:`Domain.from_file`) does so; without any the suffix's reader does, and
        of several readers the first that returns a wanted kind.

    Returns
    -------
    Domain
        With positions and lengths in the unit of the file.

    Raises
    ------
    InvalidOptionError
        A path or kinds that are none.
    ReadError
        The file does not exist, its suffix has no reader, or its contents are not a shape: the
        message names the file and the defect.
    MissingDependencyError
        The format needs a package that is not installed.
    NotEnoughMemoryError
        The shape does not fit into memory.
    PluginLoadError, PluginConflictError
        The reader is a plugin that does not load, or two distributions register one.

    Warns
    -----
    ReadWarning
        Polygons were split into triangles inside them (convex ones into the fan of their first
        corner), or intersect themselves; unusable normals were omitted; a surface is cut because
        the format repeats vertices.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import geodesic_toolkit as gt
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "triangle.off")
    ...     _ = path.write_text("OFF 3 1 0   0 0 0   1 0 0   0 1 0   3 0 1 2")
    ...     gt.read(path)
    TriangleMesh(3 vertices, 1 face)
    """
    file = as_path(path)
    check_file(file)
    if isinstance(kinds, str | type) or not isinstance(kinds, Iterable):
        raise InvalidOptionError(
            f"kinds must be a list of kinds of domain, as [TriangleMesh], not {kinds!r:.60}"
        )
    wanted = tuple(kinds)
    for kind in wanted:
        if not (isinstance(kind, type) and issubclass(kind, Domain)):
            raise InvalidOptionError(f"kinds holds {kind!r:.60}, which is not a kind of domain")
    with unpacked(file) as plain:
        suffix = plain.suffix[1:].lower()
        own = [kind.from_file for kind in wanted if kind.has("from_file")]
        candidates = own[:1] or _readers(file, plain)
        with named_errors(file, "the shape"):
            domain = _first(wanted or (object,), (reader(plain) for reader in candidates))
    if not isinstance(domain, Domain):
        raise ReadError(
            f"{file}: the reader of .{suffix} returned {type(domain).__name__}, not a domain"
        )
    return domain


def _first(wanted: tuple[type, ...], answers: Iterable[Any]) -> Any:
    """Return the first answer of a wanted type, else the first that is not None, else None."""
    other = None
    for answer in answers:
        if answer is not None and isinstance(answer, wanted):
            return answer
        other = answer if other is None else other
    return other


def _readers(file: Path, plain: Path) -> list[Any]:
    """Return the readers of a file that has been unpacked to `plain`, the preferred one first."""
    suffix = plain.suffix[1:].lower()
    try:
        return readers.candidates(suffix)
    except UnknownPluginError as error:
        if is_surface(plain):
            return [read_surface]
        known = sorted({name.rpartition(":")[2] for name in readers})
        unknown = f"there is no reader for .{suffix}" if suffix else "it has no suffix"
        raise ReadError(
            f"{file}: {unknown}; can be read: {', '.join(known)}, and surfaces of FreeSurfer by "
            "any name; each may be compressed (.gz)"
        ) from error


@contextmanager
def unpacked(file: Path) -> Iterator[Path]:
    """Yield a path to the contents of a .gz file, named without that suffix; or `file` itself."""
    if file.suffix.lower() != ".gz":
        yield file
        return
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder, file.stem)
        with named_errors(file, "the file"), gzip.open(file) as packed, plain.open("wb") as out:
            shutil.copyfileobj(packed, out)
        yield plain


@contextmanager
def named_errors(file: Path, what: str) -> Iterator[None]:
    """Turn errors while reading a file into typed errors that name the file, on one line."""
    try:
        # Damaged float32 values may be signalling NaNs, which warn when they are widened; the
        # users of the numbers check in any case that they are finite.
        with np.errstate(invalid="ignore", over="ignore"):
            yield
    except (ReadError, InvalidDomainError) as error:
        raise ReadError(f"{file}: {one_line(error)}") from error
    except GeodesicError:
        raise
    except MemoryError as error:
        raise NotEnoughMemoryError(f"{file}: {what} does not fit into memory") from error
    except Exception as error:  # parsers raise arbitrary exceptions on damaged files
        name, reason = type(error).__name__, one_line(error)
        raise ReadError(
            f"{file}: damaged, or not a {file.suffix.lower()} file ({name}: {reason})"
        ) from error


def check_file(file: Path) -> None:
    """Raise if there is no file to open; devices and pipes might never end."""
    try:
        if file.is_dir():
            raise ReadError(f"{file} is a directory, not a file")
        if not file.exists():
            raise ReadError(f"{file} does not exist")
        if not file.is_file():
            raise ReadError(f"{file} is not a regular file")
        if file.stat().st_size == 0:
            raise ReadError(f"{file} is empty")
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path, or a ReadError
        if isinstance(error, ReadError):
            raise
        raise ReadError(f"{str(file)!r} cannot be opened: {one_line(error)}") from error


def one_line(error: BaseException) -> str:
    """Return the text of an error on one line, truncated to `LONGEST_REASON`."""
    text = " ".join(str(error).split())
    return text if len(text) <= LONGEST_REASON else text[:LONGEST_REASON] + " ..."
