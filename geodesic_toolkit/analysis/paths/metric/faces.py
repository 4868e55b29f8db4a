"""Faces of measured lengths around vertices, and strips of them."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["FacesAround", "segment_length"]

MIN_GAIN_OF_RETURNS = 1e-9
"""Share by which an edge must be cheaper in the next face for a strip to go there and back."""


def segment_length(lengths: FloatArray, steps: FloatArray) -> FloatArray:
    """Return the lengths of steps within faces, (...,).

    Parameters
    ----------
    lengths : ndarray of shape (..., 3), float64
        Of the edges opposite the corners of each face.
    steps : ndarray of shape (..., 3), float64
        Differences of barycentric coordinates, with sum 0.
    """
    u, v, w = np.moveaxis(steps, -1, 0)
    a, b, c = np.moveaxis(lengths**2, -1, 0)
    return np.asarray(np.sqrt(np.maximum(-(v * w * a + w * u * b + u * v * c), 0.0)))


@dataclass(frozen=True, eq=False)
class FacesAround:
    """Faces with lengths of their own, and those around each vertex.

    Attributes
    ----------
    faces : ndarray of shape (F, 3), int64
    lengths : ndarray of shape (F, 3), float64
        Of the edges opposite the corners.
    """

    faces: IntArray
    lengths: FloatArray

    def frames(self, faces: IntArray) -> FloatArray:
        """Return the corners of faces (S,) in their planes, (S, 3, 2)."""
        a, b, c = self.lengths[faces].T
        x = np.divide(b**2 + c**2 - a**2, 2 * c, out=b.copy(), where=c > 0)
        frames = np.zeros((len(faces), 3, 2))
        frames[:, 1, 0], frames[:, 2, 0] = c, x
        frames[:, 2, 1] = np.sqrt(np.maximum(b**2 - x**2, 0.0))
        return frames

    @cached_property
    def _rows(self) -> tuple[IntArray, IntArray]:
        """Begins of the faces of each vertex, and these faces."""
        corners = self.faces.ravel()
        begins = np.concatenate([[0], np.cumsum(np.bincount(corners))])
        return begins, np.argsort(corners, kind="stable") // 3

    def around(self, vertex: int) -> list[int]:
        """Return the faces of a vertex."""
        begins, faces = self._rows
        found: list[int] = faces[begins[vertex] : begins[vertex + 1]].tolist()
        return found

    def with_corners(self, *vertices: int) -> list[int]:
        """Return the faces that have all of some vertices."""
        first, *others = vertices
        return [face for face in self.around(first) if set(others) <= set(self.corners(face))]

    def corners(self, face: int) -> list[int]:
        """Return the three vertices of a face."""
        found: list[int] = self.faces[face].tolist()
        return found

    def edge_length(self, face: int, tail: int, head: int) -> float:
        """Return the length of an edge in one of its faces."""
        other = next(i for i, v in enumerate(self.corners(face)) if v not in (tail, head))
        return float(self.lengths[face, other])

    def common_edges(self, strip: IntArray) -> IntArray:
        """Return the edge between each face of a strip (S,) and the next, (S - 1, 2)."""
        corners = self.faces[strip]
        shared = (corners[:-1, :, None] == corners[1:, None, :]).any(axis=2)
        first = shared.argmax(axis=1)
        last = 2 - shared[:, ::-1].argmax(axis=1)
        rows = np.arange(len(first))
        return np.column_stack([corners[rows, first], corners[rows, last]])

    def chain(self, first: int, last: int, vertex: int) -> list[int]:
        """Return the fewest faces around a vertex from one to another; empty if none lead there."""
        return self._chain(first, last, vertex, frozenset(), directly=True)

    def other_side(self, run: list[int], vertex: int) -> list[int]:
        """Return the faces on the other side of a vertex, from the first of a run to its last.

        Empty where the vertex has no other side.
        """
        return self._chain(run[0], run[-1], vertex, frozenset(run[1:-1]), directly=len(run) > 2)

    def _chain(
        self, first: int, last: int, vertex: int, without: frozenset[int], *, directly: bool
    ) -> list[int]:
        corners = {face: set(self.corners(face)) for face in self.around(vertex)}
        before = {first: first}
        queue = deque([first])
        while queue and last not in before:
            here = queue.popleft()
            for face, own in corners.items():
                if face in before or face in without or len(own & corners[here]) < 2:
                    continue
                if directly or here != first or face != last:
                    before[face] = here
                    queue.append(face)
        if last not in before:
            return []
        found = [last]
        while found[-1] != first:
            found.append(before[found[-1]])
        return found[::-1]

    def cheaper_beside(self, face: int) -> list[int]:
        """Return the faces beside a face in which the edge between them is shorter."""
        corners = self.corners(face)
        found = []
        for corner in range(3):
            edge = [corners[corner - 1], corners[corner - 2]]
            found += [
                other
                for other in self.with_corners(*edge)
                if other != face and self._gains(face, other)
            ]
        return found

    def without_returns(self, strip: list[int]) -> list[int]:
        """Return a strip without repeated faces, and without there-and-back that gains nothing."""
        kept: list[int] = []
        for face in strip:
            if kept and kept[-1] == face:
                continue
            if len(kept) > 1 and kept[-2] == face and not self._gains(face, kept[-1]):
                kept.pop()
            else:
                kept.append(face)
        return kept

    def _gains(self, face: int, beyond: int) -> bool:
        """Return True if the edge between two faces is shorter in the second."""
        edge = self.common_edges(np.array([face, beyond]))[0].tolist()
        here, there = self.edge_length(face, *edge), self.edge_length(beyond, *edge)
        return there < here * (1 - MIN_GAIN_OF_RETURNS)
