"""Write distances: shapes with a field for viewers, tables for other programs."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodesic_toolkit.core.atomic import as_path, replacing
from geodesic_toolkit.core.checks import real_numbers
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import Domain, normals_of, polygons_of, positions_of
from geodesic_toolkit.errors import GeodesicError, InvalidOptionError, WriteError
from geodesic_toolkit.interop.conversion import as_domain
from geodesic_toolkit.io.outputs import check_distance_output, check_domain_of_output
from geodesic_toolkit.io.readers.gifti import encode_gifti
from geodesic_toolkit.io.readers.las import write_las
from geodesic_toolkit.io.readers.pcd import encode_pcd
from geodesic_toolkit.io.readers.ply import encode_ply, encode_ply_like
from geodesic_toolkit.io.readers.vtk_library import write_vtk
from geodesic_toolkit.io.reading import check_file, named_errors, one_line

__all__ = ["write"]

FAMILIES = ((".ply",), (".pcd",), (".las", ".laz"))
"""Suffixes of formats that keep the point attributes of a file of the same family."""

GREY = (160, 160, 160)
"""Colour of vertices that no source reaches."""

NAMED_SOURCES = 20
"""Number of sources listed in the comment of a PLY."""


def write(
    path: str | os.PathLike[str],
    domain: Any,
    distances: ArrayLike,
    *,
    sources: Any = None,
    like: str | os.PathLike[str] | None = None,
) -> None:
    """Write one distance field, in the format that the suffix names.

    ================ ====================================================================
    .ply             binary: vertices and faces, or points with their normals, with a
                     vertex property ``distance`` (``inf`` if no source reaches it) and
                     colours (viridis, or red to blue if there are negative values; if
                     matplotlib is installed; grey if no source reaches the vertex)
    .pcd, .las, .laz points with a field ``distance`` (laspy)
    .vtp, .vtk, .vtu vertices and faces, or points, with the point data ``distance``, for
                     ParaView (vtk)
    .gii             the distances alone, float32, as in ``.shape.gii`` or ``.func.gii``
                     (nibabel)
    .npy             the distances alone, float64
    .csv             ``vertex,x,y,z,distance``, or ``vertex,distance`` for a graph, with all
                     digits
    .txt             the distances alone, one per line, with all digits
    ================ ====================================================================

    Plugins add formats of their kinds of domain by a :class:`Writer`: these come first for such a
    domain.

    If a .ply, .pcd, .las or .laz is written `like` the file of the shape, the result is that file
    with the distance added: all other data are kept, such as colours, intensities, classes,
    normals, polygons, the coordinate system.

    Parameters
    ----------
    path : str or path-like
        Replaced as a whole at the end; an interrupted run does not change it.
    domain : Domain or object
        A shape, or an object that :func:`as_domain` converts to one.
    distances : array-like of shape (N,)
        One per vertex, in the unit of the domain.
    sources : array-like of int, optional
        Vertex indices of the sources, noted in the comment of a PLY.
    like : path-like, optional
        A file of the same vertices, such as the one that `domain` was read from. It is used
        if its format is that of `path` (.las and .laz are one).

    Raises
    ------
    InvalidOptionError
        An unknown suffix, a format that cannot hold this kind of domain, distances of another
        shape, missing points in a .las file, or a `like` with another number of points.
    MissingDependencyError
        The format needs a package that is not installed.
    UnsupportedDomainError
        The object is not a shape.
    PluginLoadError
        The format is that of a plugin that does not load.
    ReadError
        The file `like` cannot be read.
    WriteError
        The file cannot be written.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import geodesic_toolkit as gt
    >>> path = gt.Graph(3, [[0, 1], [1, 2]])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "d.csv")
    ...     gt.write(file, path, [0.0, 1.0, 2.0])
    ...     print(file.read_text())
    vertex,distance
    0,0.0
    1,1.0
    2,2.0
    <BLANKLINE>
    """
    file = check_distance_output(path)
    domain = as_domain(domain)
    field = _checked(distances, domain)
    writer = check_domain_of_output(file, domain)
    if writer is not None:
        with replacing(file) as temporary, _named_failures(file):
            writer.write(temporary, domain, field)
        return
    positions = positions_of(domain) if domain.has("positions") else None
    suffix = file.suffix.lower()
    model = _model(file, like)
    shape = b""
    if suffix in {".ply", ".pcd"}:
        with nullcontext() if model is None else named_errors(model, "the file"):
            if suffix == ".ply":
                shape = _ply(domain, field, sources, model)
            else:
                shape = encode_pcd(domain, field, model)
    with replacing(file) as temporary:
        match suffix:
            case ".npy":
                with temporary.open("wb") as handle:  # np.save might add a suffix to a path
                    np.save(handle, field, allow_pickle=False)
            case ".csv":
                _write_csv(temporary, positions, field)
            case ".txt":
                text = "".join(f"{value!r}\n" for value in field.tolist())
                temporary.write_text(text, encoding="ascii", newline="\n")
            case ".gii":
                temporary.write_bytes(encode_gifti(field, file.name))
            case ".las" | ".laz":
                assert positions is not None  # for the type checker
                write_las(temporary, positions, field, model)
            case ".ply" | ".pcd":
                temporary.write_bytes(shape)
            case _:
                write_vtk(temporary, domain, field)


@contextmanager
def _named_failures(file: Path) -> Iterator[None]:
    """Turn errors of the writer of a plugin into a `WriteError` that names the file."""
    try:
        yield
    except (GeodesicError, MemoryError, OSError):  # `replacing` names the file in the last
        raise
    except Exception as error:  # a third party's code may raise anything
        raise WriteError(
            f"{file} cannot be written: {type(error).__name__}: {one_line(error)}"
        ) from error


def _model(file: Path, like: str | os.PathLike[str] | None) -> Path | None:
    """Return `like` if its attributes can be kept in `file`, else None."""
    if like is None:
        return None
    model = as_path(like)
    for family in FAMILIES:
        if file.suffix.lower() in family and model.suffix.lower() in family:
            check_file(model)
            return model
    return None


def _checked(distances: ArrayLike, domain: Domain) -> FloatArray:
    field = real_numbers(distances, "distances")
    if field.shape != (domain.n_vertices,):
        raise InvalidOptionError(
            f"distances must be real numbers of shape ({domain.n_vertices},), one per vertex, not "
            f"of shape {field.shape}"
        )
    return field


def _write_csv(path: Path, positions: FloatArray | None, field: FloatArray) -> None:
    names = ["distance"] if positions is None else ["x", "y", "z", "distance"]
    columns = field[:, None] if positions is None else np.column_stack([positions, field])
    with path.open("w", encoding="ascii", newline="\n") as file:
        file.write(",".join(["vertex", *names]) + "\n")
        for vertex, row in enumerate(columns.tolist()):
            file.write(f"{vertex},{','.join(map(repr, row))}\n")


def _ply(domain: Domain, field: FloatArray, sources: Any, model: Path | None) -> bytes:
    fields: dict[str, NDArray[Any]] = {"distance": field}
    colours = _colours(field)
    if colours is not None:
        fields.update(zip(("red", "green", "blue"), colours.T, strict=True))
    comment = "geodesic distance" + _from(sources)
    if model is not None:
        return encode_ply_like(model, fields, comment)
    vertices: dict[str, NDArray[Any]] = dict(zip("xyz", positions_of(domain).T, strict=True))
    normals = normals_of(domain)
    if normals is not None:
        vertices.update(zip(("nx", "ny", "nz"), normals.T, strict=True))
    return encode_ply({**vertices, **fields}, polygons_of(domain), [comment])


def _from(sources: Any) -> str:
    """Return a text that lists vertex sources; other sources are not listed."""
    indices = np.atleast_1d(np.asarray(sources)) if sources is not None else np.empty(0)
    if indices.dtype.kind not in "iu" or indices.ndim != 1 or not len(indices):
        return ""
    more = f" and {len(indices) - NAMED_SOURCES} more" if len(indices) > NAMED_SOURCES else ""
    return " from vertices " + " ".join(map(str, indices[:NAMED_SOURCES].tolist())) + more


def _colours(field: FloatArray) -> NDArray[np.uint8] | None:
    """Return the (N, 3) colours of a field, or None without matplotlib."""
    try:
        from matplotlib import colormaps
    except ImportError:
        return None
    reached = np.isfinite(field)
    share = np.where(reached, field, 0.0)
    share /= np.abs(share).max(initial=0.0) or 1.0
    signed = bool((share < 0).any())
    table = colormaps["RdBu"]((share + 1) / 2) if signed else colormaps["viridis"](share)
    colours: NDArray[np.uint8] = np.round(255 * table[:, :3]).astype(np.uint8)
    colours[~reached] = GREY
    return colours
