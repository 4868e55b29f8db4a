"""Files of VTK, written by VTK's own library."""

import re
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains import Domain, graph_of, normals_of, polygons_of, positions_of
from geodesic_toolkit.errors import WriteError
from geodesic_toolkit.io.common import optional_package

__all__ = ["require_vtk", "write_by", "write_vtk"]

MESSAGE_LOCK = threading.Lock()
"""Lock for VTK's single output window, which is replaced while messages are captured."""

ERROR_LOCATION = re.compile(r"(ERROR|Warning): In \S+, line \d+ \S+ \(\w+\): ")
"""Pattern of the position in VTK's sources that precedes an error message."""

CELLS = {"SetVerts": 1, "SetLines": 3, "SetPolys": 5}
"""VTK's cell numbers of vertices, lines and triangles, by the setters of such cells."""

POLYGON = 7
"""VTK's cell number of faces with any number of corners."""


def require_vtk(path: Path) -> Any:
    """Import the module that converts arrays to VTK's.

    Raises
    ------
    MissingDependencyError
        VTK is not installed.
    """
    return optional_package("vtkmodules.util.numpy_support", path.suffix[1:].lower(), "writing")


def write_vtk(path: Path, domain: Domain, field: FloatArray) -> None:
    """Write a mesh or a cloud with its distances, in the format of the suffix: .vtp, .vtk or .vtu.

    The distances are the point array ``distance``.
    """
    numpy_support = require_vtk(path)
    from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkUnstructuredGrid
    from vtkmodules.vtkIOLegacy import vtkPolyDataWriter
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

    setter, sizes, corners = _elements(domain)
    kind = POLYGON if setter == "SetPolys" and (sizes != 3).any() else CELLS[setter]
    cells = _vtk_cells(numpy_support, sizes, corners)
    if path.suffix.lower() == ".vtu":
        data, writer = vtkUnstructuredGrid(), vtkXMLUnstructuredGridWriter()
        data.SetCells(kind, cells)
    else:
        data = vtkPolyData()
        writer = vtkXMLPolyDataWriter() if path.suffix.lower() == ".vtp" else vtkPolyDataWriter()
        getattr(data, setter)(cells)
    if path.suffix.lower() == ".vtk":
        writer.SetFileTypeToBinary()
        writer.SetFileVersion(42)  # programs older than 2020 cannot read the default, 5.1
    _fill(numpy_support, data, domain, field)
    writer.SetInputData(data)
    write_by(writer, path)


def write_by(writer: Any, path: Path) -> None:
    """Let a writer of VTK write to a file.

    Raises
    ------
    WriteError
        With VTK's messages.
    """
    writer.SetFileName(str(path))
    if messages := _messages_of(writer.Write):
        raise WriteError(f"{path.name} cannot be written: {messages}")


def _elements(domain: Domain) -> tuple[str, IntArray, IntArray]:
    """Return the setter of the faces, else the edges or vertices, with their sizes and corners."""
    faces = polygons_of(domain)
    if faces is not None:
        return "SetPolys", *faces
    if domain.has("as_graph"):
        edges = graph_of(domain).edges
        return "SetLines", np.full(len(edges), 2), edges.ravel()
    return "SetVerts", np.ones(domain.n_vertices, dtype=np.int64), np.arange(domain.n_vertices)


def _vtk_cells(numpy_support: Any, sizes: IntArray, corners: IntArray) -> Any:
    """Return cells with these numbers of corners."""
    from vtkmodules.vtkCommonDataModel import vtkCellArray

    cells = vtkCellArray()
    cells.SetData(
        *(
            numpy_support.numpy_to_vtkIdTypeArray(np.array(numbers, dtype=np.int64), deep=True)
            for numbers in (np.append(0, np.cumsum(sizes)), corners)
        )
    )
    return cells


def _fill(numpy_support: Any, data: Any, domain: Domain, field: FloatArray) -> None:
    """Set the points, distances and normals of the data."""
    from vtkmodules.vtkCommonCore import vtkPoints

    def array(values: FloatArray, name: str) -> Any:
        made = numpy_support.numpy_to_vtk(np.ascontiguousarray(values), deep=True)
        made.SetName(name)
        return made

    points = vtkPoints()
    points.SetData(array(positions_of(domain), "Points"))
    data.SetPoints(points)
    data.GetPointData().SetScalars(array(field, "distance"))
    normals = normals_of(domain)
    if normals is not None:
        data.GetPointData().SetNormals(array(normals, "Normals"))


def _messages_of(work: Callable[[], Any]) -> str:
    """Return the messages of VTK during `work`, which would go to stderr and to its log."""
    from vtkmodules.vtkCommonCore import vtkLogger, vtkOutputWindow, vtkStringOutputWindow

    with MESSAGE_LOCK:
        before, window = vtkOutputWindow.GetInstance(), vtkStringOutputWindow()
        verbosity = vtkLogger.GetCurrentVerbosityCutoff()
        vtkOutputWindow.SetInstance(window)
        vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
        try:
            work()
        finally:
            vtkOutputWindow.SetInstance(before)
            vtkLogger.SetStderrVerbosity(verbosity)
    messages = " ".join(str(window.GetOutput()).split())
    return ERROR_LOCATION.sub("", messages)[:300]
