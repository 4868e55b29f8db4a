"""Names that values of vertices cannot have on the object of another library."""

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np

from geodesic_toolkit.errors import InvalidOptionError

__all__ = ["OPEN3D", "POINT_DATA", "TABLE", "TRIMESH", "TRIMESH_CLOUD", "check_name"]

OPEN3D = {
    "positions": "positions",
    "normals": "normals",
    "colors": "colours",
    "texture_uvs": "texture coordinates",
    "indices": "corners of the triangles",
    **dict.fromkeys(("opacity", "scale", "rot", "f_dc", "f_rest"), "Gaussian splats"),
    **dict.fromkeys(("x", "y", "z"), "coordinates in files"),
    **dict.fromkeys(("nx", "ny", "nz"), "normals in files"),
    **dict.fromkeys(("red", "green", "blue"), "colours in files"),
}
"""Names with a meaning in Open3D: its methods fail if the values are others, and its files mix
two columns of one name up."""

TRIMESH = {
    "vertex": "positions in files",
    **dict.fromkeys(("x", "y", "z"), "coordinates in files"),
    **dict.fromkeys(("s", "t"), "texture coordinates in files"),
}
"""Names of the columns of PLY that trimesh writes; a second column of one name makes the file
unreadable."""

TRIMESH_CLOUD = dict.fromkeys(("name", "node", "units", "file_name", "file_path"), "a text")
"""Metadata of clouds that trimesh reads itself."""

POINT_DATA = {
    "Normals": "normals",
    "vtkGhostType": "hidden points",
    "gmsh:dim_tags": "pairs of tags in files of Gmsh",
}
"""Names of point data with a meaning in VTK, and in meshio's writers."""

TABLE = {"_index": "the index in files"}
"""Names of observations that AnnData cannot write."""


def check_name(name: str, fixed: Mapping[str, str], held: Mapping[str, Any]) -> None:
    """Raise if values of vertices cannot have a name without harm to the object.

    Parameters
    ----------
    name : str
    fixed : mapping of str to str
        Names that the library uses itself, and for what.
    held : mapping
        The data of the object by their names. A column of numbers is replaced; other data, such as
        texture coordinates or categories, would be lost.

    Raises
    ------
    InvalidOptionError
    """
    if name in fixed:
        what = fixed[name]
    elif name in held and (others := _other_than_numbers(held[name])):
        what = f"other data of the object, {others}, which would be lost"
    else:
        return
    numbered = (f"distance_{number}" for number in itertools.count(2))
    unused = (other for other in itertools.chain(["distance"], numbered) if other not in held)
    raise InvalidOptionError(
        f"name {name!r} is that of {what}; give another one, such as {next(unused)!r}"
    )


def _other_than_numbers(data: Any) -> str:
    """Return a description of data that are not a column of numbers; empty for a column."""
    array = np.asarray(data.cpu().numpy() if hasattr(data, "cpu") else data)
    if array.dtype.kind not in "biuf":
        return f"such as {array.flat[0]!r}" if array.size else f"of {array.dtype}"
    if array.ndim == 1 or (array.ndim == 2 and array.shape[1] == 1):
        return ""
    return f"of shape {array.shape}"
