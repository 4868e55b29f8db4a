"""Insertion of points as vertices: the faces around them are split, the surface does not change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["Insertion", "insert_points"]

SNAP_WEIGHT = 1e-8
"""Barycentric weight below which a point is on the opposite edge, or at a vertex."""


@dataclass(frozen=True, eq=False)
class Insertion:
    """A mesh whose vertices include some points of its surface.

    Attributes
    ----------
    vertices : ndarray of shape (N + A, 3), float64
        The old vertices first.
    faces : ndarray of shape (G, 3), int64
    parents : ndarray of shape (G,), int64
        The old face that contains each.
    vertex_of_point : ndarray of shape (P,), int64
        The vertex of each point.
    added : list of mapping of vertex to weight
        The A new vertices as combinations of old vertices.
    """

    vertices: FloatArray
    faces: IntArray
    parents: IntArray
    vertex_of_point: IntArray
    added: list[dict[int, float]]

    def weights_on(self, face: IntArray, vertex: int) -> FloatArray:
        """Return the weights of a vertex on the corners of the old face that contains it."""
        old = len(self.vertices) - len(self.added)
        point = self.added[vertex - old] if vertex >= old else {vertex: 1.0}
        return np.array([point.get(corner, 0.0) for corner in face.tolist()])


def insert_points(vertices: FloatArray, faces: IntArray, weights: csr_array) -> Insertion:
    """Return the mesh with points as vertices: a face is split in three, faces at an edge in two.

    Parameters
    ----------
    vertices : ndarray of shape (N, 3), float64
    faces : ndarray of shape (F, 3), int64
        Each has three different vertices.
    weights : csr_array of shape (P, N)
        One row per point: its barycentric weights on one, two or three vertices of a face.

    Returns
    -------
    Insertion

    Examples
    --------
    >>> import numpy as np
    >>> from scipy.sparse import csr_array
    >>> from geodesic_toolkit.analysis.paths.insertion import insert_points
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    >>> split = insert_points(corners, np.array([[0, 1, 2]]), csr_array([[0.5, 0.25, 0.25]]))
    >>> split.faces.tolist(), split.vertex_of_point.tolist()
    ([[0, 1, 3], [1, 2, 3], [2, 0, 3]], [3])
    """
    splitter = _Splitter(faces, len(vertices))
    vertex_of_point = []
    for row in range(weights.shape[0]):
        entries = slice(weights.indptr[row], weights.indptr[row + 1])
        pairs = zip(weights.indices[entries].tolist(), weights.data[entries].tolist(), strict=True)
        vertex_of_point.append(splitter.insert(dict(pairs)))
    added = [
        sum((share * vertices[vertex] for vertex, share in point.items()), np.zeros(3))
        for point in splitter.points
    ]
    parts, parents = splitter.result()
    return Insertion(
        np.vstack([vertices, *added]),
        parts,
        parents,
        np.array(vertex_of_point, dtype=np.int64),
        splitter.points,
    )


class _Splitter:
    """Faces that are being split; a point is a mapping from old vertices to its weights on them."""

    def __init__(self, faces: IntArray, n_vertices: int) -> None:
        self.points: list[dict[int, float]] = []
        self._original = faces
        self._n_vertices = n_vertices
        self._made: list[tuple[int, list[int]]] = []  # (old face, corners), numbered after those
        self._parts: dict[int, list[int]] = {}  # current parts of each split face

    def result(self) -> tuple[IntArray, IntArray]:
        """Return the faces and the old face of each."""
        is_whole = np.ones(len(self._original), dtype=np.bool_)
        is_whole[list(self._parts)] = False
        whole = np.flatnonzero(is_whole)
        pieces = [self._piece(part) for parts in self._parts.values() for part in parts]
        faces = [self._original[whole], np.array([f for _, f in pieces]).reshape(-1, 3)]
        parents = [whole, np.array([old for old, _ in pieces])]
        return np.vstack(faces).astype(np.int64), np.concatenate(parents).astype(np.int64)

    def _piece(self, part: int) -> tuple[int, list[int]]:
        """Return the old face that contains a part, and the corners of the part."""
        count = len(self._original)
        return self._made[part - count] if part >= count else (part, self._original[part].tolist())

    def insert(self, point: dict[int, float]) -> int:
        """Return the vertex at a point, which may exist already."""
        kept = {vertex: share for vertex, share in point.items() if share > SNAP_WEIGHT}
        total = sum(kept.values())
        kept = {vertex: share / total for vertex, share in kept.items()}
        if len(kept) == 1:
            return next(iter(kept))
        inside = np.isin(self._original, list(kept)).sum(axis=1) == len(kept)
        parts = [part for old in np.flatnonzero(inside).tolist() for part in self._parts_of(old)]
        if not parts:  # on an omitted face: not connected
            return self._new_vertex(kept)
        part, local = self._containing(parts, kept)
        _, face = self._piece(part)
        support = [face[corner] for corner in range(3) if local[corner] > SNAP_WEIGHT]
        if len(support) == 1:
            return support[0]
        vertex = self._new_vertex(kept)
        if len(support) == 3:
            self._split(part, vertex, face)
        else:
            for other in parts:
                _, corners = self._piece(other)
                if set(support) <= set(corners):
                    self._split(other, vertex, corners, edge=support)
        return vertex

    def _containing(self, parts: list[int], point: dict[int, float]) -> tuple[int, FloatArray]:
        """Return the part that contains a point, and its barycentric weights there."""
        best, found = parts[0], np.full(3, -np.inf)
        for part in parts:
            parent, face = self._piece(part)
            old = self._original[parent]
            corners = np.array([self._weights_on(old, corner) for corner in face])
            local = np.linalg.solve(corners.T, [point.get(int(vertex), 0.0) for vertex in old])
            if local.min() > found.min():
                best, found = part, local
        return best, found

    def _weights_on(self, old: IntArray, vertex: int) -> list[float]:
        if vertex < self._n_vertices:
            return [float(vertex == corner) for corner in old]
        point = self.points[vertex - self._n_vertices]
        return [point.get(int(corner), 0.0) for corner in old]

    def _parts_of(self, old: int) -> list[int]:
        return self._parts.get(old, [old])

    def _new_vertex(self, point: dict[int, float]) -> int:
        self.points.append(point)
        return self._n_vertices + len(self.points) - 1

    def _split(
        self, part: int, vertex: int, face: list[int], *, edge: list[int] | None = None
    ) -> None:
        """Replace a part by triangles around a new vertex, inside it or on its `edge`."""
        old, _ = self._piece(part)
        parts = [other for other in self._parts_of(old) if other != part]
        for corner in range(3):
            tail, head = face[corner], face[(corner + 1) % 3]
            if edge is not None and {tail, head} == set(edge):
                continue
            parts.append(len(self._original) + len(self._made))
            self._made.append((old, [tail, head, vertex]))
        self._parts[old] = parts
