"""Which faces meet at a vertex or at an edge, and how to walk around a vertex."""

import cmath
import math
from collections import deque
from functools import cached_property

import numpy as np

from geodesic_toolkit._typing import FloatArray, IntArray

__all__ = ["Fans"]


class Fans:
    """The faces around every vertex of a triangle mesh.

    Parameters
    ----------
    vertices : ndarray of shape (N, 3), float64
    faces : ndarray of shape (F, 3), int64
        Each with three different vertices.
    """

    def __init__(self, vertices: FloatArray, faces: IntArray) -> None:
        self.vertices = vertices
        self.faces = faces
        self._shapes: dict[tuple[int, int, int], complex] = {}

    @cached_property
    def _lists(self) -> tuple[IntArray, IntArray]:
        order = np.argsort(self.faces.ravel(), kind="stable")
        counts = np.bincount(self.faces.ravel(), minlength=len(self.vertices))
        return np.concatenate([[0], np.cumsum(counts)]), order // 3

    def around(self, vertex: int) -> list[int]:
        """Return the faces at a vertex."""
        starts, faces = self._lists
        found: list[int] = faces[starts[vertex] : starts[vertex + 1]].tolist()
        return found

    def at_edge(self, a: int, b: int) -> list[int]:
        """Return the faces at an edge."""
        others = set(self.around(b))
        return [face for face in self.around(a) if face in others]

    def third(self, face: int, a: int, b: int) -> int:
        """Return the corner of a face beside two others."""
        corner: int = next(c for c in self.faces[face].tolist() if c not in (a, b))
        return corner

    def others(self, face: int, vertex: int) -> tuple[int, int]:
        """Return the two corners of a face beside one."""
        a, b = (corner for corner in self.faces[face].tolist() if corner != vertex)
        return a, b

    def shape(self, a: int, b: int, c: int) -> complex:
        """Return where c lies, on the left, in the plane in which a is at 0 and b at 1."""
        key = (a, b, c)
        if key not in self._shapes:
            origin, along, across = self.vertices[[a, b, c]].tolist()
            p = [x - y for x, y in zip(along, origin, strict=True)]
            q = [x - y for x, y in zip(across, origin, strict=True)]
            squared = math.hypot(*p) ** 2 or 1.0
            normal = math.hypot(
                p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]
            )
            inner = p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
            self._shapes[key] = complex(inner, normal) / squared
        return self._shapes[key]

    def angle(self, face: int, vertex: int) -> float:
        """Return the angle of a face at a vertex."""
        return cmath.phase(self.shape(vertex, *self.others(face, vertex)))

    def total_angle(self, vertex: int) -> float:
        """Return the angle of all faces at a vertex together."""
        return sum(self.angle(face, vertex) for face in self.around(vertex))

    def chain(self, first: int, last: int, vertex: int) -> list[int] | None:
        """Return faces around a vertex from one to another, each sharing an edge with the next.

        None where they do not hang together there.
        """
        came: dict[int, int] = {first: first}
        queue = deque([first])
        while queue and last not in came:
            face = queue.popleft()
            for corner in self.others(face, vertex):
                for beside in self.at_edge(vertex, corner):
                    if beside not in came:
                        came[beside] = face
                        queue.append(beside)
        if last not in came:
            return None
        path = [last]
        while path[-1] != first:
            path.append(came[path[-1]])
        return path[::-1]

    def cycle(self, vertex: int, first: int) -> list[int] | None:
        """Return the faces around a vertex in order, or None where they make no single ring."""
        count = len(self.around(vertex))
        ring, edge = [first], self.others(first, vertex)[1]
        while True:
            beside = [face for face in self.at_edge(vertex, edge) if face != ring[-1]]
            if len(beside) != 1:
                return None
            if beside[0] == first:
                return ring if len(ring) == count else None
            if len(ring) == count:
                return None
            ring.append(beside[0])
            edge = self.third(beside[0], vertex, edge)
