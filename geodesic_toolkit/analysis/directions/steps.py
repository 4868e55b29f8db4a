"""Points of a mesh moved along tangent vectors, many at once."""

from dataclasses import dataclass

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.geometry.frames import Fans, fans_of
from geodesic_toolkit.geometry.triangles import (
    lengths_from_inverse,
    measured_triangles,
    proper_faces,
)
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["Stepper"]

INSIDE = 1e-3
"""Least barycentric weight of a moved point: its tangent plane is that of the face."""

MOST = 100_000
"""Largest number of edges that a step crosses."""


@dataclass(frozen=True, eq=False)
class Stepper:
    """The faces of a mesh, laid out for straight lines."""

    mesh: TriangleMesh
    proper: IntArray
    fans: Fans

    @classmethod
    def of(cls, mesh: TriangleMesh) -> "Stepper":
        """Return the stepper of a mesh.

        Raises
        ------
        UnsupportedDomainError
            The surface has one side.
        """
        faces, inverse, _, _ = measured_triangles(mesh.vertices, mesh.faces)
        _, _, (fans,) = fans_of(mesh.vertices, [(faces, lengths_from_inverse(inverse))])
        return cls(mesh, np.flatnonzero(proper_faces(mesh.faces)), fans)

    def inside(self, points: SourcePoints) -> tuple[IntArray, FloatArray]:
        """Return faces, by number here, and weights of points, moved a little into a face."""
        faces = self._faces
        weights = np.zeros((points.count, 3))
        numbers = np.zeros(points.count, dtype=np.int64)
        near = np.flatnonzero(np.isin(faces, points.vertices).any(axis=1))
        for point in range(points.count):
            own = slice(points.begins[point], points.begins[point + 1])
            held = np.isin(faces[near], points.vertices[own]).sum(axis=1)
            numbers[point] = near[held.argmax()]
            for vertex, share in zip(points.vertices[own], points.shares[own], strict=True):
                weights[point] += share * (faces[numbers[point]] == vertex)
        return numbers, _inwards(weights)

    def points(self, numbers: IntArray, weights: FloatArray) -> SourcePoints:
        """Return points in faces, by number here, as sources."""
        corners = self._faces[numbers]
        places = self.mesh.vertices[corners]
        at = np.einsum("pc,pcd->pd", weights, places)
        distances = np.linalg.norm(places - at[:, None], axis=2)
        return SourcePoints(
            vertices=corners.ravel(),
            shares=weights.ravel(),
            begins=np.arange(0, corners.size + 1, 3),
            n_vertices=self.mesh.n_vertices,
            distances=distances.ravel(),
        )

    def moved(
        self, numbers: IntArray, weights: FloatArray, vectors: FloatArray
    ) -> tuple[IntArray, FloatArray]:
        """Return the ends of straight lines from points in faces along vectors in space, (P, 3)."""
        apex, tail, head = (self.mesh.vertices[column] for column in self._faces[numbers].T)
        x = _unit(head - tail)
        up = apex - tail
        y = _unit(up - np.einsum("pd,pd->p", up, x)[:, None] * x)
        along = np.einsum("pd,pd->p", vectors, x) + 1j * np.einsum("pd,pd->p", vectors, y)
        begins, faces, ends, _ = _native.straight_lines(
            self.fans.lengths,
            self.fans.twin,
            numbers,
            np.ascontiguousarray(weights),
            np.angle(along),
            np.abs(along),
            MOST,
        )
        last = begins[1:] - 1
        return faces[last], _inwards(ends[last])

    def as_given(self, numbers: IntArray, weights: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return faces of the mesh, and weights on their corners as those were given."""
        turned = self.fans.turned[numbers][:, None]
        return self.proper[numbers], np.where(turned, weights[:, ::-1], weights)

    @property
    def _faces(self) -> IntArray:
        return self.fans.origin[self.fans.faces]


def _inwards(weights: FloatArray) -> FloatArray:
    clipped = np.maximum(weights, INSIDE)
    return np.asarray(clipped / clipped.sum(axis=1, keepdims=True))


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))
