"""Files of VTK, written by its own library."""

import re
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import Domain, PointCloud, TriangleMesh, known_positions
from geodesic_toolkit.errors import WriteError
from geodesic_toolkit.io.common import optional_package

__all__ = ["require_vtk", "write_vtk"]

ALONE = threading.Lock()
"""VTK has one place for messages: one thread at a time listens there."""

WHERE = re.compile(r"(ERROR|Warning): In \S+, line \d+ \S+ \(\w+\): ")
"""Where in its sources VTK met an error."""

VERTEX, TRIANGLE = 1, 5
"""VTK's numbers of these cells."""


def require_vtk(path: Path) -> Any:
    """Import what arrays become those of VTK with.

    Raises
    ------
    MissingDependencyError
        VTK is not installed.
    """
    return optional_package("vtkmodules.util.numpy_support", path.suffix[1:].lower(), "writing")


def write_vtk(path: Path, domain: Domain, field: FloatArray) -> None:
    """Write a mesh or a cloud with its distances, as the suffix says: .vtp, .vtk or .vtu.

    They are the array ``distance`` of the points.
    """
    numpy_support = require_vtk(path)
    from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkUnstructuredGrid
    from vtkmodules.vtkIOLegacy import vtkPolyDataWriter
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

    cells = _vtk_cells(numpy_support, domain)
    if path.suffix.lower() == ".vtu":
        data, writer = vtkUnstructuredGrid(), vtkXMLUnstructuredGridWriter()
        data.SetCells(TRIANGLE if isinstance(domain, TriangleMesh) else VERTEX, cells)
    else:
        data = vtkPolyData()
        writer = vtkXMLPolyDataWriter() if path.suffix.lower() == ".vtp" else vtkPolyDataWriter()
        (data.SetPolys if isinstance(domain, TriangleMesh) else data.SetVerts)(cells)
    if path.suffix.lower() == ".vtk":
        writer.SetFileTypeToBinary()
        writer.SetFileVersion(42)  # 5.1, the default, is not known to programs older than 2020
    _fill(numpy_support, data, domain, field)
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    if said := _listened(writer.Write):
        raise WriteError(f"{path.name} cannot be written: {said}")


def _vtk_cells(numpy_support: Any, domain: Domain) -> Any:
    """Return the faces of a mesh, or a cell for each point."""
    from vtkmodules.vtkCommonDataModel import vtkCellArray

    rows = (
        domain.faces
        if isinstance(domain, TriangleMesh)
        else np.arange(domain.n_vertices, dtype=np.int64)[:, None]
    )
    cells = vtkCellArray()
    cells.SetData(
        *(
            numpy_support.numpy_to_vtkIdTypeArray(np.array(numbers, dtype=np.int64), deep=True)
            for numbers in (np.arange(len(rows) + 1) * rows.shape[1], rows.ravel())
        )
    )
    return cells


def _fill(numpy_support: Any, data: Any, domain: Domain, field: FloatArray) -> None:
    """Give the data their points, distances and normals."""
    from vtkmodules.vtkCommonCore import vtkPoints

    def array(values: FloatArray, name: str) -> Any:
        made = numpy_support.numpy_to_vtk(np.ascontiguousarray(values), deep=True)
        made.SetName(name)
        return made

    positions = known_positions(domain)
    assert positions is not None  # for the type checker; write has raised
    points = vtkPoints()
    points.SetData(array(positions, "Points"))
    data.SetPoints(points)
    data.GetPointData().SetScalars(array(field, "distance"))
    if isinstance(domain, PointCloud) and domain.normals is not None:
        data.GetPointData().SetNormals(array(domain.normals, "Normals"))


def _listened(work: Callable[[], Any]) -> str:
    """Return what VTK says while it works, which it would print, and print on its log as well."""
    from vtkmodules.vtkCommonCore import vtkLogger, vtkOutputWindow, vtkStringOutputWindow

    with ALONE:
        before, window = vtkOutputWindow.GetInstance(), vtkStringOutputWindow()
        verbosity = vtkLogger.GetCurrentVerbosityCutoff()
        vtkOutputWindow.SetInstance(window)
        vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
        try:
            work()
        finally:
            vtkOutputWindow.SetInstance(before)
            vtkLogger.SetStderrVerbosity(verbosity)
    said = " ".join(str(window.GetOutput()).split())
    return WHERE.sub("", said)[:300]
