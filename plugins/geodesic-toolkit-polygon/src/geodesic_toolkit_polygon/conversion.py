"""Polygons of objects of other libraries, known by their attributes."""

import re
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidDomainError, UnsupportedDomainError
from geodesic_toolkit.geometry.polygons import unpadded_polygons

__all__ = ["polygons_of"]

IntArray: TypeAlias = NDArray[np.int64]
Polygons: TypeAlias = tuple[Any, IntArray, IntArray]

PLANE_CELLS = re.compile(r"triangle|quad|polygon\d*")
"""Names of meshio's cells that are polygons."""


def polygons_of(obj: Any) -> Polygons:
    """Return vertices, sizes and corners of the polygons of an object."""
    if isinstance(obj, gt.Domain):
        return _of_domain(obj)
    if isinstance(obj, tuple | list) and len(obj) == 2:
        from geodesic_toolkit_polygon.mesh import PolygonMesh

        mesh = PolygonMesh(*obj)
        return mesh.positions, *mesh.polygons
    if hasattr(obj, "points") and hasattr(obj, "faces") and hasattr(obj, "strips"):
        if len(obj.strips):
            raise UnsupportedDomainError(
                "the PolyData has triangle strips beside its polygons; give mesh.triangulate()"
            )
        return obj.points, *unpadded_polygons(np.asarray(obj.faces))
    if hasattr(obj, "points") and isinstance(getattr(obj, "cells", None), list):
        return _of_cells(obj)
    raise UnsupportedDomainError(
        f"a {type(obj).__name__} is not a polygon mesh; give (vertices, faces), a PolyData of "
        "PyVista or a Mesh of meshio"
    )


def _of_domain(domain: gt.Domain) -> Polygons:
    if domain.has("polygons"):
        return domain.positions, *domain.polygons
    triangles = domain.triangles
    return domain.positions, np.full(len(triangles), 3, dtype=np.int64), triangles.ravel()


def _of_cells(obj: Any) -> Polygons:
    points = np.asarray(obj.points)
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    others = [block.type for block in obj.cells if not PLANE_CELLS.fullmatch(block.type)]
    solids = [kind for kind in others if kind not in {"vertex", "line"}]
    if solids:
        raise UnsupportedDomainError(
            f"the mesh has cells of type {solids[0]}; polygons are triangle, quad and polygon"
        )
    rows = [
        np.asarray(cell, dtype=np.int64)
        for block in obj.cells
        if PLANE_CELLS.fullmatch(block.type)
        for cell in block.data
    ]
    if not rows:
        raise InvalidDomainError("the mesh has no triangles, quads or polygons")
    return points, np.array([len(row) for row in rows], dtype=np.int64), np.concatenate(rows)
