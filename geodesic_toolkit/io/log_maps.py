"""Logarithmic maps to files: tables, and meshes with texture coordinates."""

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit.core.atomic import check_output, replacing
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.domains import Domain, positions_of, triangles_of
from geodesic_toolkit.errors import InvalidOptionError
from geodesic_toolkit.io.readers.ply import encode_ply

if TYPE_CHECKING:  # importing it takes SciPy, which reading a shape does not need
    from geodesic_toolkit.analysis.directions.log_map import LogMap

__all__ = ["check_log_map_output", "write_log_map"]

SUFFIXES = (".ply", ".obj", ".csv", ".npy", ".json")


def check_log_map_output(path: str | os.PathLike[str]) -> Path:
    """Return the path of a file for a logarithmic map, checked before any work.

    Raises
    ------
    InvalidOptionError
        Another suffix.
    WriteError
        A folder that does not exist or is not writable.
    """
    return check_output(path, SUFFIXES)


def write_log_map(path: str | os.PathLike[str], domain: Domain, log: "LogMap") -> None:
    """Write a logarithmic map in the format that the suffix names.

    ===== ==========================================================================
    .ply  binary: vertices with texture coordinates ``s``, ``t``, the properties
          ``distance`` and ``angle``, and faces
    .obj  a mesh with texture coordinates: ``v``, ``vt`` and ``f`` lines; faces with a
          vertex that is not connected to the source have none
    .csv  ``vertex,x,y,z,u,v,distance,angle`` with all digits
    .npy  the coordinates alone, of shape (N, 2), float64
    .json ``frame``, ``coordinates``, ``distance`` and ``angle``; null where a vertex is
          not connected to the source
    ===== ==========================================================================

    Texture coordinates are the ``coordinates`` of the map, in the unit of the shape: a repeated
    texture has tiles of length 1, and the source lies at (0, 0).

    Parameters
    ----------
    path : str or path-like
        Replaced as a whole at the end; an interrupted run does not change it.
    domain : Domain
        The mesh or point cloud of the map; an .obj needs a mesh.
    log : LogMap

    Raises
    ------
    InvalidOptionError
        An unknown suffix, a map of another number of vertices, a cloud in an .obj file.
    WriteError
        The file cannot be written.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import geodesic_toolkit as gt
    >>> square = gt.testing.shapes.grid(3)
    >>> log = gt.log_map(gt.GeodesicSolver(square), 4)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "square.csv")
    ...     gt.write_log_map(file, square, log)
    ...     file.read_text().splitlines()[0]
    'vertex,x,y,z,u,v,distance,angle'
    """
    file = check_log_map_output(path)
    if len(log.distance) != domain.n_vertices:
        raise InvalidOptionError(
            f"a map of {len(log.distance)} vertices does not fit {domain!r} of {domain.n_vertices}"
        )
    points = positions_of(domain)
    faces = triangles_of(domain) if domain.has("triangles") else None
    suffix = file.suffix.lower()
    if suffix == ".obj" and faces is None:
        raise InvalidOptionError(f"{file}: an .obj file needs a mesh; write a .ply or .csv file")
    with replacing(file) as temporary:
        if suffix == ".npy":
            with temporary.open("wb") as handle:  # np.save might add a suffix to a path
                np.save(handle, log.coordinates, allow_pickle=False)
        elif suffix == ".ply":
            temporary.write_bytes(_ply(points, faces, log))
        else:
            text = (
                _json(log)
                if suffix == ".json"
                else _csv(points, log)
                if faces is None or suffix == ".csv"
                else _obj(points, faces, log)
            )
            temporary.write_text(text, encoding="ascii", newline="\n")


def _ply(points: FloatArray, faces: IntArray | None, log: "LogMap") -> bytes:
    columns: dict[str, NDArray[np.float64]] = dict(
        zip(("x", "y", "z", "s", "t"), [*points.T, *log.coordinates.T], strict=True)
    )
    fields = {**columns, "distance": log.distance, "angle": log.angle}
    polygons = None if faces is None else (np.full(len(faces), 3), faces.ravel())
    return encode_ply(fields, polygons, ["logarithmic map: s and t in the unit of the shape"])


def _obj(points: FloatArray, faces: IntArray, log: "LogMap") -> str:
    reached: BoolArray = np.asarray(np.isfinite(log.coordinates).all(axis=1))
    number = np.cumsum(reached)
    rows = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    rows += [f"vt {u!r} {v!r}" for u, v in log.coordinates[reached].tolist()]
    whole: BoolArray = np.asarray(reached[faces].all(axis=1))
    for face, known in zip(faces.tolist(), whole, strict=True):
        corners = (f"{v + 1}/{number[v]}" if known else str(v + 1) for v in face)
        rows.append(" ".join(["f", *corners]))
    return "".join(f"{row}\n" for row in rows)


def _csv(points: FloatArray, log: "LogMap") -> str:
    table = np.column_stack([points, log.coordinates, log.distance, log.angle])
    rows = [f"{vertex},{','.join(map(repr, row))}" for vertex, row in enumerate(table.tolist())]
    return "".join(f"{row}\n" for row in ["vertex,x,y,z,u,v,distance,angle", *rows])


def _json(log: "LogMap") -> str:
    content = {
        name: np.where(np.isfinite(values), values.astype(object), np.array(None)).tolist()
        for name, values in (
            ("frame", log.frame),
            ("coordinates", log.coordinates),
            ("distance", log.distance),
            ("angle", log.angle),
        )
    }
    return json.dumps(content, allow_nan=False) + "\n"
