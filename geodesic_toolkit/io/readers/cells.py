"""Finite-element meshes through meshio: mesh (Medit), msh (Gmsh), vtu and vtk grids."""

import contextlib
import io
import threading
from pathlib import Path

import numpy as np

from geodesic_toolkit.domains import Domain, PointCloud, TriangleMesh
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.geometry.cells import surface_polygons
from geodesic_toolkit.io.common import optional_package, triangulate, warn
from geodesic_toolkit.io.readers.gmsh import check_node_numbers

__all__ = ["read_cells", "read_medit", "read_msh", "read_vtu"]

STDERR_LOCK = threading.Lock()
"""Lock for standard error, which the whole process shares, while meshio's messages are captured."""


def read_medit(path: Path) -> Domain:
    """Read a Medit .mesh file."""
    return read_cells(path, "medit")


def read_msh(path: Path) -> Domain:
    """Read a Gmsh .msh file."""
    check_node_numbers(path.read_bytes())
    return read_cells(path, "gmsh")


def read_vtu(path: Path) -> Domain:
    """Read a VTK XML file of an unstructured grid."""
    return read_cells(path, "vtu")


def read_cells(path: Path, form: str) -> Domain:
    """Read the surface of a mesh if it has one, or else the surface of its solid cells.

    `form` is the name of meshio's module for the format.
    """
    # The format's own module: meshio.read ends the process if a file has another format.
    module = optional_package(f"meshio.{form}", path.suffix[1:].lower())
    messages = io.StringIO()
    with STDERR_LOCK, contextlib.redirect_stderr(messages):
        mesh = module.read(str(path))
    if remarks := " ".join(messages.getvalue().split()):
        warn(path, f"meshio says: {remarks[:300]}")
    points = np.asarray(mesh.points, dtype=np.float64)
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    blocks = [(str(block.type), block.data) for block in mesh.cells]
    sizes, corners = surface_polygons(blocks)
    if len(sizes):
        return TriangleMesh(points, triangulate(path, points, sizes, corners))
    kinds = sorted({kind for kind, _ in blocks})
    if kinds == ["vertex"]:
        return PointCloud(points)
    raise ReadError(
        f"no surface and no solid cells: the cells are {', '.join(kinds) or 'of no known kind'}"
    )
