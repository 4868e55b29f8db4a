"""`as_domain`: convert the shapes of other libraries to domains.

By duck typing: an object is recognised by its attributes, without importing its library.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.core.warning import warn
from geodesic_toolkit.domains import Domain, Graph, PointCloud, TriangleMesh
from geodesic_toolkit.errors import InvalidDomainError, ReadWarning, UnsupportedDomainError
from geodesic_toolkit.geometry.along_edges import shortest_parallel_edges
from geodesic_toolkit.interop.members import only_member
from geodesic_toolkit.interop.refusals import OF_GRIDS, described, refusal

__all__ = ["as_domain", "check_one_shape", "graph_of_lengths"]

TAKEN = (
    "a TriangleMesh, PointCloud or Graph; (vertices, faces); an (N, 3) array of points; a mesh or "
    "cloud of trimesh, Open3D, PyVista, meshio, nilearn or a GIFTI image; a square SciPy sparse "
    "matrix of edge lengths; a networkx graph"
)

VTK_CELLS = {
    1: "vertex", 2: "vertex", 3: "line", 5: "triangle", 7: "polygon", 8: "pixel", 9: "quad",
    10: "tetra", 11: "voxel", 12: "hexahedron", 13: "wedge", 14: "pyramid",
    21: "line3", 22: "triangle6", 23: "quad8", 24: "tetra10", 25: "hexahedron20",
    26: "wedge15", 27: "pyramid13", 28: "quad9", 29: "hexahedron27", 32: "wedge18",
    34: "triangle7", 37: "pyramid19",
}  # fmt: skip
"""Names of VTK's cell types; other types keep their number and are not a surface."""


def as_domain(obj: Any) -> Domain:
    """Return `obj` as a mesh, point cloud or graph.

    Vertices keep their order and their indices: they are not merged, dropped or reordered.

    =========================== =============================================================
    given                       result
    =========================== =============================================================
    Domain                      itself
    (vertices, faces)           a :class:`TriangleMesh`; metadata may follow, as nibabel's
                                ``read_geometry`` gives them
    array of shape (N, 3)       a :class:`PointCloud`
    trimesh                     Trimesh: a mesh; PointCloud: a cloud; a Scene of one of them
    Open3D, legacy and tensor   TriangleMesh: a mesh; PointCloud: a cloud, with its normals
    PyVista                     PolyData: a mesh, or a cloud if it has no faces;
                                UnstructuredGrid: as for meshio; a MultiBlock of one of them
    meshio                      a mesh of the plane cells, or of the surface of the solid ones;
                                a cloud if all cells are vertices or there are none
    SciPy sparse                a :class:`Graph` whose lengths are the entries stored, in one
                                triangle of the matrix or in both (the shorter counts)
    networkx                    a graph of its nodes in their order; an edge's length is its
                                attribute ``length``, else ``weight``, else 1; directions
                                are ignored
    nilearn, nibabel            surface meshes (``coordinates`` and ``faces``), a PolyMesh or
                                SurfaceImage of one hemisphere, GIFTI images: a mesh
    =========================== =============================================================

    Parameters
    ----------
    obj : object
        Anything listed above, or with the same attributes.

    Returns
    -------
    Domain
        In the unit of `obj`.

    Raises
    ------
    UnsupportedDomainError
        The object is not listed above, or holds several shapes; the message suggests what to pass.
    InvalidDomainError
        The data cannot be a domain: no faces, an index out of range, a matrix that is not
        square.

    Warns
    -----
    ReadWarning
        Polygons were split into triangles, or intersect themselves.

    Examples
    --------
    >>> import scipy.sparse
    >>> import geodesic_toolkit as gt
    >>> gt.as_domain(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    TriangleMesh(3 vertices, 1 face)
    >>> gt.as_domain(scipy.sparse.csr_array([[0.0, 2.5], [2.5, 0.0]]))
    Graph(2 vertices, 1 edge)
    """
    if isinstance(obj, Domain):
        return obj
    if not isinstance(obj, type):  # classes have the attributes of their instances, without values
        for convert in CONVERTERS:
            domain = convert(obj)
            if domain is not None:
                return domain
    raise UnsupportedDomainError(refusal(obj, TAKEN))


def check_one_shape(function: str, others: tuple[Any, ...]) -> None:
    """Raise an `UnsupportedDomainError` if `function` got too many positional arguments.

    Usually these are vertices and faces, as two arguments.
    """
    if others:
        raise UnsupportedDomainError(
            f"{function} takes the shape as one argument, and options by name: give vertices and "
            f"faces as a pair, {function}((vertices, faces), ...)"
        )


def _has(obj: Any, *names: str) -> bool:
    return all(hasattr(obj, name) for name in names)


def _pair(obj: Any) -> Domain | None:
    """Convert (vertices, faces): two tables; a list of two points is one table.

    FreeSurfer's metadata and stamp may follow, as ``nibabel.freesurfer.read_geometry`` gives them.
    """
    if not isinstance(obj, tuple | list) or not 2 <= len(obj) <= 4 or not _is_table(obj[0]):
        return None
    vertices, faces, *rest = obj
    if not all(isinstance(member, Mapping | str) for member in rest):
        return None
    return TriangleMesh(vertices, faces)


def _is_table(obj: Any) -> bool:
    try:
        return np.ndim(obj) == 2
    except ValueError:  # rows of different lengths, which TriangleMesh names
        return _has_rows(obj)


def _has_rows(obj: Any) -> bool:
    """Return whether a sequence consists of rows, which may differ in length."""
    arrays = [row for row in obj if isinstance(row, np.ndarray)]
    return all(isinstance(row, list | tuple | np.ndarray) for row in obj) and all(
        row.ndim == 1 for row in arrays
    )


def _sparse(obj: Any) -> Domain | None:
    """Convert sparse arrays and matrices of SciPy."""
    return graph_of_lengths(obj) if _has(obj, "tocoo", "shape") else None


def graph_of_lengths(matrix: Any) -> Graph:
    """Return the graph whose edge lengths are the off-diagonal entries of a sparse matrix.

    One or both triangles may be stored; if they differ, the shorter length counts.

    Parameters
    ----------
    matrix : sparse array or matrix of shape (N, N)

    Raises
    ------
    InvalidDomainError
        The matrix is not square, or an entry is not a length.
    """
    if len(matrix.shape) != 2 or matrix.shape[0] != matrix.shape[1]:
        shape = " x ".join(map(str, matrix.shape))
        raise InvalidDomainError(f"a matrix of edge lengths must be square, not {shape}")
    entries = matrix.tocoo()  # including explicit zeros: coincident vertices
    if entries.data.dtype.kind not in "buif":
        raise InvalidDomainError(f"edge lengths must be real numbers, not {entries.data.dtype}")
    off = entries.row != entries.col
    ends = np.column_stack([entries.row, entries.col])[off].astype(np.int64)
    lengths = entries.data[off].astype(np.float64)
    if not np.isnan(lengths).any():  # otherwise Graph raises
        ends, lengths = shortest_parallel_edges(ends, lengths)
    return Graph(matrix.shape[0], ends, lengths)


def _network(obj: Any) -> Domain | None:
    """Convert graphs of networkx, of any class."""
    if not _has(obj, "nodes", "edges", "is_directed"):
        return None
    number = {node: position for position, node in enumerate(obj.nodes)}
    edges, lengths = [], []
    for tail, head, data in obj.edges(data=True):
        edges.append((number[tail], number[head]))
        lengths.append(data.get("length", data.get("weight", 1)))
    return Graph(len(number), edges, np.asarray(lengths) if lengths else None)


def _gifti(obj: Any) -> Domain | None:
    """Convert images of nibabel."""
    if not _has(obj, "get_arrays_from_intent"):
        return None
    points = obj.get_arrays_from_intent("NIFTI_INTENT_POINTSET")
    triangles = obj.get_arrays_from_intent("NIFTI_INTENT_TRIANGLE")
    if not points or not triangles:
        raise InvalidDomainError(
            "the GIFTI image holds no surface: it has no coordinates, or no triangles"
        )
    return TriangleMesh(points[0].data, triangles[0].data)


def _meshio(obj: Any) -> Domain | None:
    """Convert meshes of meshio."""
    if not _has(obj, "points", "cells") or not isinstance(obj.cells, list):
        return None
    points = np.asarray(obj.points)
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    return _of_cells(obj, points, [(block.type, block.data) for block in obj.cells])


def _vtk_grid(obj: Any) -> Domain | None:
    """Convert unstructured grids of PyVista."""
    if not _has(obj, "points", "celltypes", "cell_connectivity"):
        return None
    # The name changed in PyVista 0.48, and the old one warns from then on.
    offsets = obj.cell_offsets if hasattr(obj, "cell_offsets") else obj.offset
    starts, sizes = np.asarray(offsets)[:-1], np.diff(offsets)
    corners = np.asarray(obj.cell_connectivity)
    kinds = np.asarray(obj.celltypes)
    blocks: list[tuple[str, Any]] = []
    for kind in np.unique(kinds):
        cells = [
            corners[start : start + size]
            for start, size in zip(starts[kinds == kind], sizes[kinds == kind], strict=True)
        ]
        blocks.append((VTK_CELLS.get(int(kind), f"VTK cell {kind}"), cells))
    return _of_cells(obj, obj.points, blocks)


def _of_cells(obj: Any, points: Any, blocks: list[tuple[str, Any]]) -> Domain:
    from geodesic_toolkit.geometry.cells import surface_polygons

    sizes, corners = surface_polygons(blocks)
    if len(sizes):
        return TriangleMesh(points, _triangles(obj, points, sizes, corners))
    kinds = {kind for kind, _ in blocks}
    if kinds <= {"vertex"}:
        return PointCloud(points)
    if kinds & {"voxel", "pixel"}:
        raise UnsupportedDomainError(f"{described(obj)}: voxels are not a surface; {OF_GRIDS}")
    raise InvalidDomainError(
        f"{described(obj)}: no surface and no solid cells; the cells are {', '.join(sorted(kinds))}"
    )


def _triangles(obj: Any, points: Any, sizes: IntArray, corners: IntArray) -> IntArray:
    from geodesic_toolkit.geometry.polygons import split_polygons

    faces, remarks = split_polygons(np.asarray(points, dtype=np.float64), sizes, corners)
    for remark in remarks:
        warn(f"{type(obj).__name__}: {remark}", ReadWarning)
    return faces


def _vtk_surface(obj: Any) -> Domain | None:
    """Convert surfaces of PyVista."""
    if not _has(obj, "points", "faces", "strips"):
        return None
    from geodesic_toolkit.geometry.polygons import strip_triangles, unpadded_polygons

    faces = _triangles(obj, obj.points, *unpadded_polygons(np.asarray(obj.faces)))
    strips = np.asarray(obj.strips)
    if len(strips):
        faces = np.concatenate([faces, strip_triangles(*unpadded_polygons(strips))])
    if len(faces):
        return TriangleMesh(obj.points, faces)
    if len(obj.lines):
        raise InvalidDomainError(f"{described(obj)}: it has lines, but no faces")
    return PointCloud(obj.points, obj.point_data.get("Normals", None))


def _open3d(obj: Any) -> Domain | None:
    """Convert meshes and clouds of Open3D, whose arrays are vectors of its own types."""
    if _has(obj, "vertices", "triangles"):
        return TriangleMesh(np.asarray(obj.vertices), np.asarray(obj.triangles))
    if _has(obj, "points", "normals", "has_normals"):
        return PointCloud(obj.points, obj.normals if obj.has_normals() else None)
    return None


def _open3d_tensors(obj: Any) -> Domain | None:
    """Convert meshes and clouds of Open3D whose arrays are tensors, possibly on a GPU."""
    if _has(obj, "vertex", "triangle"):
        return TriangleMesh(
            _tensor(obj.vertex, "positions", np.zeros((0, 3))),
            _tensor(obj.triangle, "indices", np.zeros((0, 3))),
        )
    if _has(obj, "point") and "positions" in obj.point:
        return PointCloud(
            _tensor(obj.point, "positions", None), _tensor(obj.point, "normals", None)
        )
    return None


def _tensor(attributes: Any, name: str, default: FloatArray | None) -> Any:
    return attributes[name].cpu().numpy() if name in attributes else default


def _collection(obj: Any) -> Domain | None:
    """Convert scenes of trimesh, blocks of PyVista and hemispheres of nilearn, with one member."""
    member = only_member(obj)
    if member is None:
        return None
    if member.placement is None:
        return as_domain(member.shape)
    return as_domain(member.shape.copy().apply_transform(member.placement))


def _surface(obj: Any) -> Domain | None:
    """Convert meshes of trimesh and nilearn, and objects with the same attributes."""
    for vertices in ("vertices", "coordinates"):
        if _has(obj, vertices, "faces"):
            return TriangleMesh(getattr(obj, vertices), obj.faces)
    if _has(obj, "vertices", "colors") and not hasattr(obj, "entities"):  # those are curves
        return PointCloud(obj.vertices)
    return None


def _points(obj: Any) -> Domain | None:
    """Convert tables of three columns."""
    if not isinstance(obj, list | tuple) and not hasattr(obj, "__array__"):
        return None
    try:
        table = np.asarray(obj)
    except ValueError:  # rows of different lengths, which PointCloud names
        return PointCloud(obj) if _has_rows(obj) else None
    if table.ndim != 2 or table.shape[1] != 3 or table.dtype.kind not in "iuf":
        return None
    return PointCloud(obj)  # unconverted: PointCloud checks masked arrays


CONVERTERS: tuple[Callable[[Any], Domain | None], ...] = (
    _pair,
    _collection,
    _sparse,
    _network,
    _gifti,
    _meshio,
    _vtk_grid,
    _vtk_surface,
    _surface,
    _open3d,  # after the last: a mesh of trimesh has `triangles` of another kind
    _open3d_tensors,
    _points,
)
"""Each converts one kind of object, and returns None for others."""
