"""Cells of finite elements as the polygons of a surface.

Polygons are given by their sizes and by their corners, one polygon after the other. Cells have the
names of meshio, and their nodes are in the order of VTK: the corners, the nodes in the middles of
edges, those in the middles of faces.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np

from geodesic_toolkit.core.types import IntArray
from geodesic_toolkit.errors import InvalidDomainError

__all__ = ["faces_of", "surface_polygons"]

CORNERS_OF_PLANE_CELLS = {"triangle": 3, "quad": 4}
"""Corners of the plane cells."""

PARTS_OF_FACES: dict[tuple[int, int], list[tuple[int, ...]]] = {
    (3, 3): [(0, 1, 2)],
    (3, 6): [(0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)],
    (3, 7): [(0, 3, 6), (3, 1, 6), (1, 4, 6), (4, 2, 6), (2, 5, 6), (5, 0, 6)],
    (4, 4): [(0, 1, 2, 3)],
    (4, 8): [(0, 4, 7), (4, 1, 5), (5, 2, 6), (7, 6, 3), (4, 5, 6, 7)],
    (4, 9): [(0, 4, 8, 7), (4, 1, 5, 8), (8, 5, 2, 6), (7, 8, 6, 3)],
}
"""Polygons that replace a face of given numbers of corners and nodes: every node is a corner."""

FACES_OF_SOLID_CELLS: dict[str, list[tuple[int, ...]]] = {
    "tetra": [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)],
    "hexahedron": [
        (0, 3, 2, 1),
        (4, 5, 6, 7),
        (0, 1, 5, 4),
        (1, 2, 6, 5),
        (2, 3, 7, 6),
        (3, 0, 4, 7),
    ],
    "wedge": [(0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)],
    "pyramid": [(0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)],
}
"""Faces of the solid cells, seen from outside."""

EDGES_OF_SOLID_CELLS: dict[str, list[tuple[int, int]]] = {
    "tetra": [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
    "hexahedron": [
        *[(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)],
        *[(0, 4), (1, 5), (2, 6), (3, 7)],
    ],
    "wedge": [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)],
    "pyramid": [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)],
}
"""Edges of the solid cells, in the order of the nodes in their middles."""

MIDDLE_NODES_OF_FACES: dict[str, list[int]] = {
    "hexahedron27": [24, 25, 22, 21, 23, 20],
    "wedge18": [-1, -1, 15, 16, 17],
    "pyramid14": [13, -1, -1, -1, -1],
    "pyramid19": [13, 14, 15, 16, 17],
}
"""Nodes in the middles of the faces of solid cells, or -1; other cells do not have such nodes."""

CORNERS_OF_SOLID_CELLS = {"tetra": 4, "hexahedron": 8, "wedge": 6, "pyramid": 5}


def surface_polygons(blocks: Iterable[tuple[str, Any]]) -> tuple[IntArray, IntArray]:
    """Return the polygons among cells or, if there are none, the surface of the solid cells.

    Cells of second order are split, so that the nodes in the middles of their edges and faces are
    corners, too.

    Parameters
    ----------
    blocks : iterable of (kind, cells)
        Cells of a kind, by the names of meshio ("triangle", "quad8", "polygon", "tetra10"): arrays
        with a row for each cell, or sequences of rows. Other kinds are ignored.

    Returns
    -------
    sizes, corners : ndarray of int64
        Empty if there is neither surface nor solid. The surface of solids consists of the faces of
        only one cell, seen from outside.

    Raises
    ------
    InvalidDomainError
        Cells of a third order or a higher one.
    """
    cells = [(kind, data) for kind, data in blocks if len(data)]
    polygons = [part for kind, data in cells for part in _polygons(kind, data)]
    if not polygons:
        polygons = _boundary(
            [(kind, data) for kind, data in cells if _family(kind) in FACES_OF_SOLID_CELLS]
        )
    nothing = np.zeros(0, dtype=np.int64)
    return (
        np.concatenate([nothing, *(sizes for sizes, _ in polygons)]),
        np.concatenate([nothing, *(corners for _, corners in polygons)]),
    )


def _family(kind: str) -> str:
    """Return the name of a cell without its number of nodes: "triangle" for "triangle6"."""
    return kind.rstrip("0123456789")


def _polygons(kind: str, data: Any) -> list[tuple[IntArray, IntArray]]:
    if kind.startswith("polygon"):
        sizes = np.array([len(row) for row in data], dtype=np.int64)
        return [(sizes, np.concatenate([np.asarray(row, dtype=np.int64) for row in data]))]
    count = CORNERS_OF_PLANE_CELLS.get(_family(kind))
    return [] if count is None else _split(kind, np.asarray(data, dtype=np.int64), count)


def _split(kind: str, nodes: IntArray, count: int) -> list[tuple[IntArray, IntArray]]:
    """Return plane cells with `count` corners as polygons whose corners are all of their nodes.

    The polygons of a cell that have equally many corners follow each other.
    """
    parts = PARTS_OF_FACES.get((count, nodes.shape[1]))
    if parts is None:
        raise InvalidDomainError(_too_high(kind))
    sizes = sorted({len(part) for part in parts})
    return [
        _rows(nodes[:, [part for part in parts if len(part) == size]].reshape(-1, size))
        for size in sizes
    ]


def _too_high(kind: str) -> str:
    return (
        f"the cells {kind!r} have more nodes than those of second order, and distances at the "
        "additional nodes would be missing; export the mesh with cells of first or second order"
    )


def _rows(table: IntArray) -> tuple[IntArray, IntArray]:
    """Return the rows of a table as polygons."""
    return np.full(len(table), table.shape[1], dtype=np.int64), table.ravel()


def _boundary(solids: list[tuple[str, Any]]) -> list[tuple[IntArray, IntArray]]:
    """Return the faces of only one solid cell."""
    faces: dict[tuple[int, int], list[IntArray]] = {}
    for kind, data in solids:
        cells = np.asarray(data, dtype=np.int64)
        for nodes, count in faces_of(kind, cells.shape[1]):
            faces.setdefault((count, len(nodes)), []).append(cells[:, nodes])
    boundary = []
    for count in CORNERS_OF_PLANE_CELLS.values():
        alike = {size: np.concatenate(some) for (own, size), some in faces.items() if own == count}
        if not alike:
            continue
        corners = np.concatenate([rows[:, :count] for rows in alike.values()])
        _, which, times = np.unique(
            np.sort(corners, axis=1), axis=0, return_inverse=True, return_counts=True
        )
        alone = np.split(
            times[which.ravel()] == 1, np.cumsum([len(rows) for rows in alike.values()])[:-1]
        )
        for rows, own in zip(alike.values(), alone, strict=True):
            boundary += _split("", rows[own], count)
    return boundary


def faces_of(kind: str, size: int) -> list[tuple[list[int], int]]:
    """Return the nodes of each face of a solid cell, in plane-cell order, and its corners."""
    family = _family(kind)
    first, edges = CORNERS_OF_SOLID_CELLS[family], EDGES_OF_SOLID_CELLS[family]
    if size == first:
        return [(list(face), len(face)) for face in FACES_OF_SOLID_CELLS[family]]
    middles = MIDDLE_NODES_OF_FACES.get(f"{family}{size}", [-1] * len(FACES_OF_SOLID_CELLS[family]))
    if size != first + len(edges) and f"{family}{size}" not in MIDDLE_NODES_OF_FACES:
        raise InvalidDomainError(_too_high(kind))
    faces = []
    number = {frozenset(edge): first + place for place, edge in enumerate(edges)}
    for face, middle in zip(FACES_OF_SOLID_CELLS[family], middles, strict=True):
        ring = zip(face, face[1:] + face[:1], strict=True)
        nodes = [*face, *(number[frozenset(edge)] for edge in ring)]
        faces.append((nodes + [middle] * (middle >= 0), len(face)))
    return faces
