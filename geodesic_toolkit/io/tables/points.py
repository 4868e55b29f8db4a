"""`read_points`: read points in space from a table or from any shape."""

import os

import numpy as np

from geodesic_toolkit.core.atomic import as_path
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains import PointCloud, positions_of
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.io.common import array_of
from geodesic_toolkit.io.reading import check_file, named_errors, read, unpacked

__all__ = ["read_points"]


def read_points(path: str | os.PathLike[str]) -> PointCloud:
    r"""Read points in space from a file.

    Parameters
    ----------
    path : str or path-like
        An .npy array of shape (N, 3), or (3,) for one point; or a file that
        :func:`geodesic_toolkit.read` accepts, such as a .csv with columns x, y and z; its vertices
        are the points.

    Returns
    -------
    PointCloud
        Without normals. Points that are not finite are kept as missing.

    Raises
    ------
    ReadError
        The file does not exist, or has no points; the message names the file and the defect.
    GeodesicError
        As for :func:`geodesic_toolkit.read`.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from geodesic_toolkit.io import read_points
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "places.csv")
    ...     _ = file.write_text("name,x,y,z\n1,0.5,0,0\n2,0.5,1,0\n")
    ...     read_points(file)
    PointCloud(2 points)
    """
    file = as_path(path)
    check_file(file)
    if file.name.lower().endswith((".npy", ".npy.gz")):
        with unpacked(file) as plain, named_errors(file, "the table of points"):
            return PointCloud(np.atleast_2d(array_of(plain)))
    domain = read(file)
    if not domain.has("positions"):
        raise ReadError(f"{file}: {a_kind_of(domain)} has no positions")
    return PointCloud(positions_of(domain))
