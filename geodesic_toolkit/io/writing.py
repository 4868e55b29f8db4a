"""Distances to files: PLY to look at, NPY and CSV to go on with."""

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodesic_toolkit._atomic import check_output, replacing
from geodesic_toolkit._typing import FloatArray
from geodesic_toolkit.domains import Domain, PointCloud, TriangleMesh, known_positions
from geodesic_toolkit.errors import InvalidOptionError
from geodesic_toolkit.io.ply import encode_ply

__all__ = ["DISTANCE_SUFFIXES", "write_distances"]

DISTANCE_SUFFIXES = (".ply", ".npy", ".csv")

GREY = (160, 160, 160)
"""Colour of what no source reaches."""

NAMED_SOURCES = 20
"""Sources that a PLY's comment lists."""


def write_distances(
    path: str | os.PathLike[str], domain: Domain, distances: ArrayLike, *, sources: Any = None
) -> None:
    """Write one distance field, in the format that the suffix names.

    ====== ==============================================================================
    .ply   binary: vertices and faces, or points with their normals, with a vertex
           property ``distance`` (``inf`` where no source reaches) and colours (viridis,
           where matplotlib is installed; grey where no source reaches)
    .npy   the distances alone, float64
    .csv   ``vertex,x,y,z,distance``, or ``vertex,distance`` of a graph, with all digits
    ====== ==============================================================================

    Parameters
    ----------
    path : str or path-like
        Replaced as a whole at the very end; an interrupted run leaves it as it was.
    domain : Domain
    distances : array-like of shape (N,)
        One a vertex, in the unit of the domain.
    sources : array-like of int, optional
        Vertex indices of the sources, noted in the comment of a PLY.

    Raises
    ------
    InvalidOptionError
        An unknown suffix, a PLY of a graph, distances of another shape.
    WriteError
        The file cannot be written.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit.io import write_distances
    >>> path = gt.Graph(3, [[0, 1], [1, 2]])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "d.csv")
    ...     write_distances(file, path, [0.0, 1.0, 2.0])
    ...     print(file.read_text())
    vertex,distance
    0,0.0
    1,1.0
    2,2.0
    <BLANKLINE>
    """
    file = check_output(path, DISTANCE_SUFFIXES)
    field = _checked(distances, domain)
    positions = known_positions(domain)
    suffix = file.suffix.lower()
    if suffix == ".ply" and positions is None:
        raise InvalidOptionError(
            f"a {type(domain).__name__} has no positions to write to a PLY; write .npy or .csv"
        )
    with replacing(file) as temporary:
        if suffix == ".npy":
            with temporary.open("wb") as handle:  # to a path np.save might add a suffix
                np.save(handle, field, allow_pickle=False)
        elif suffix == ".csv":
            _write_csv(temporary, positions, field)
        else:
            temporary.write_bytes(_ply(domain, field, sources))


def _checked(distances: ArrayLike, domain: Domain) -> FloatArray:
    field = np.asarray(distances)
    if field.shape != (domain.n_vertices,) or field.dtype.kind not in "iuf":
        raise InvalidOptionError(
            f"distances must be real numbers of shape ({domain.n_vertices},), "
            f"not {field.dtype} of shape {field.shape}"
        )
    return field.astype(np.float64)


def _write_csv(path: Path, positions: FloatArray | None, field: FloatArray) -> None:
    names = ["distance"] if positions is None else ["x", "y", "z", "distance"]
    columns = field[:, None] if positions is None else np.column_stack([positions, field])
    with path.open("w", encoding="ascii", newline="\n") as file:
        file.write(",".join(["vertex", *names]) + "\n")
        for vertex, row in enumerate(columns.tolist()):
            file.write(f"{vertex},{','.join(map(repr, row))}\n")


def _ply(domain: Domain, field: FloatArray, sources: Any) -> bytes:
    positions = known_positions(domain)
    assert positions is not None
    vertices: dict[str, NDArray[Any]] = dict(zip("xyz", positions.T, strict=True))
    if isinstance(domain, PointCloud) and domain.normals is not None:
        vertices.update(zip(("nx", "ny", "nz"), domain.normals.T, strict=True))
    vertices["distance"] = field
    colours = _colours(field)
    if colours is not None:
        vertices.update(zip(("red", "green", "blue"), colours.T, strict=True))
    faces = domain.faces if isinstance(domain, TriangleMesh) else None
    return encode_ply(vertices, faces, ["geodesic distance" + _from(sources)])


def _from(sources: Any) -> str:
    """Return words for vertex sources; others are not noted."""
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
    largest = field[reached].max(initial=0.0)
    share = np.clip(np.where(reached, field, 0.0) / (largest if largest > 0 else 1.0), 0.0, 1.0)
    colours: NDArray[np.uint8] = np.round(255 * colormaps["viridis"](share)[:, :3]).astype(np.uint8)
    colours[~reached] = GREY
    return colours
