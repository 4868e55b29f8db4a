"""Readers of solids: tetrahedra through meshio and TetGen's files, images through NIfTI and VTI.

Readers of suffixes that the core has as well return None where a file has no tetrahedra: it is then
the core's.
"""

import contextlib
import io
from pathlib import Path
from typing import Any

import numpy as np

from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.io.common import optional_package
from geodesic_toolkit.io.readers.cells import STDERR_LOCK
from geodesic_toolkit_volume.marching import Floats
from geodesic_toolkit_volume.tet_mesh import TetMesh
from geodesic_toolkit_volume.voxel_image import VoxelImage

__all__ = [
    "read_medit",
    "read_msh",
    "read_nifti",
    "read_tetgen",
    "read_vti",
    "read_vtk",
    "read_vtu",
]


def read_medit(path: Path) -> TetMesh | None:
    """Read the tetrahedra of a Medit .mesh file."""
    data = path.read_bytes()
    return _cells(path, "medit") if b"Tetrahedra" in data else None


def read_msh(path: Path) -> TetMesh | None:
    """Read the tetrahedra of a Gmsh .msh file."""
    from geodesic_toolkit.io.readers.gmsh import check_node_numbers

    check_node_numbers(path.read_bytes())
    return _cells(path, "gmsh")


def read_vtk(path: Path) -> TetMesh | None:
    """Read the tetrahedra of a legacy VTK file."""
    head = path.read_bytes()[:4096].upper()
    return _cells(path, "vtk") if b"UNSTRUCTURED_GRID" in head else None


def read_vtu(path: Path) -> TetMesh | None:
    """Read the tetrahedra of a VTK XML file of an unstructured grid."""
    return _cells(path, "vtu")


def _cells(path: Path, form: str) -> TetMesh | None:
    """Read tetrahedra by meshio; None where the file has none, or meshio cannot read it."""
    module = optional_package(f"meshio.{form}", path.suffix[1:].lower())
    try:
        with STDERR_LOCK, contextlib.redirect_stderr(io.StringIO()):
            mesh = module.read(str(path))
    except Exception:  # noqa: BLE001 - the core's reader says what is wrong, or knows better
        return None
    blocks = [block.data for block in mesh.cells if str(block.type) == "tetra"]
    if not sum(map(len, blocks)):
        return None
    return TetMesh(mesh.points, np.concatenate(blocks))


def read_tetgen(path: Path) -> TetMesh:
    """Read a pair of TetGen's files, .node and .ele, by the name of either."""
    nodes = _rows(path.with_suffix(".node"), 4)
    cells = _rows(path.with_suffix(".ele"), 5)
    first = int(nodes[0, 0])
    if first not in (0, 1) or not np.array_equal(nodes[:, 0], first + np.arange(len(nodes))):
        raise ReadError(f"{path.with_suffix('.node').name}: nodes must be numbered from 0 or 1")
    return TetMesh(nodes[:, 1:4], cells[:, 1:5].astype(np.int64) - first)


def _rows(path: Path, columns: int) -> Floats:
    """Return the rows of a file that begins with their number, with these columns at least."""
    if not path.is_file():
        raise ReadError(f"{path.name} is missing beside it")
    lines = (line.partition("#")[0].split() for line in path.read_text("utf-8").splitlines())
    rows = [words for words in lines if words]
    try:
        count = int(rows[0][0])
        table = np.array([row[:columns] for row in rows[1 : count + 1]], dtype=np.float64)
    except (IndexError, ValueError) as error:
        raise ReadError(f"{path.name}: {error}") from error
    if count < 1 or table.shape != (count, columns):
        raise ReadError(f"{path.name}: {count} rows are announced, {len(table)} follow")
    return table


def read_nifti(path: Path) -> VoxelImage:
    """Read a NIfTI image: the body is where it is above 0, in millimetres or its own unit."""
    nibabel = optional_package("nibabel", "nii")
    image = nibabel.load(str(path))
    values = np.asanyarray(image.dataobj)
    values = values.reshape(values.shape[:3]) if values.shape[3:] == (1,) else values
    if values.ndim != 3:
        raise ReadError(f"an image of shape {values.shape}; it must have three axes")
    return VoxelImage(_body(values), affine=np.asarray(image.affine, dtype=np.float64))


def read_vti(path: Path) -> VoxelImage:
    """Read a VTK XML image: the body is where its scalars, of cells or points, are above 0."""
    optional_package("vtkmodules.util.numpy_support", "vti")
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLImageDataReader

    reader = vtkXMLImageDataReader()
    if not reader.CanReadFile(str(path)):
        raise ReadError("it is not a VTK XML image")
    reader.SetFileName(str(path))
    reader.Update()
    image = reader.GetOutput()
    shape, half = np.array(image.GetDimensions()), 0.0
    data = image.GetPointData()
    if image.GetCellData().GetNumberOfArrays():
        data, shape, half = image.GetCellData(), np.maximum(shape - 1, 1), 0.5
    array = data.GetScalars() or data.GetArray(0)
    if array is None or array.GetNumberOfComponents() != 1:
        raise ReadError("the image has no scalars; one number a voxel says what is in the body")
    values = vtk_to_numpy(array).reshape(shape[::-1]).transpose(2, 1, 0)
    return VoxelImage(_body(values), affine=_affine(image, half))


def _affine(image: Any, half: float) -> Floats:
    """Return the affine from the numbers of voxels to their centres."""
    from_index = image.GetIndexToPhysicalMatrix()
    affine = np.array([[from_index.GetElement(i, j) for j in range(4)] for i in range(4)])
    first = np.array(image.GetExtent()[::2]) + half
    affine[:3, 3] += affine[:3, :3] @ first
    return affine


def _body(values: Any) -> Any:
    body = np.asarray(values) > 0
    if not body.any():
        raise ReadError("nothing in the image is above 0: the body is empty")
    return body
