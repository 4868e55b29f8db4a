"""`read_polygons`: the polygons of a file, before any split."""

import os

from geodesic_toolkit.core.atomic import as_path
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.io.readers.obj import obj_polygons
from geodesic_toolkit.io.readers.off import off_polygons
from geodesic_toolkit.io.readers.ply import ply_polygons
from geodesic_toolkit.io.reading import check_file, named_errors, unpacked

__all__ = ["read_polygons"]

PARSERS = {".obj": obj_polygons, ".off": off_polygons, ".ply": ply_polygons}


def read_polygons(path: str | os.PathLike[str]) -> tuple[FloatArray, IntArray, IntArray]:
    """Read the polygons of an OBJ, OFF or PLY file as they are, which :func:`read` splits.

    For kinds of domain of plugins, whose :meth:`Domain.from_file` makes something of them.

    Parameters
    ----------
    path : str or path-like
        May be compressed (.gz).

    Returns
    -------
    vertices : ndarray of shape (N, 3), float64
        In the unit of the file.
    sizes : ndarray of shape (F,), int64
        Corners of each polygon.
    corners : ndarray of shape (sizes.sum(),), int64
        Their vertex indices, polygon by polygon.

    Raises
    ------
    ReadError
        No such file, another format, or contents that are not polygons: the message names the file
        and what is wrong in it.
    NotEnoughMemoryError
        The shape does not fit into memory.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import geodesic_toolkit as gt
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "square.off")
    ...     _ = path.write_text("OFF 4 1 0   0 0 0   1 0 0   1 1 0   0 1 0   4 0 1 2 3")
    ...     gt.read_polygons(path)[1:]
    (array([4]), array([0, 1, 2, 3]))
    """
    file = as_path(path)
    check_file(file)
    with unpacked(file) as plain:
        parser = PARSERS.get(plain.suffix.lower())
        if parser is None:
            raise ReadError(f"{file}: polygons can be read from {', '.join(PARSERS)} files")
        with named_errors(file, "the shape"):
            return parser(plain)
