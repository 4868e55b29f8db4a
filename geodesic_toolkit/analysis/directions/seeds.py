"""Where fronts begin, and the directions in which sources see the vertices there."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains import Domain, TriangleMesh
from geodesic_toolkit.geometry.frames import ComplexArray, Frames
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["Surroundings", "surroundings"]

MOST_CROSSINGS = 8
"""Edges that a source is unfolded across at most, one after the other."""

REACH = 2.0
"""How far away vertices are told of a source, in lengths to the farthest corner of its face."""


@dataclass(frozen=True, eq=False)
class Surroundings:
    """P sources with their tangent frames, and the vertices around them that fronts begin at.

    Attributes
    ----------
    points : SourcePoints
        The sources. About one that lies between vertices there are more than those of its face:
        opposite the edge that it lies on, and beyond edges that are to be flipped, which hide it
        from the corners of its face.
    axes : ndarray of shape (P, 2, 3), float64
        Two unit vectors at right angles for each source: those of the vertex, or else the first of
        them leads along the first edge of the face.
    angles : ndarray of shape (nnz,), float64
        The direction in which a source sees each vertex around it; 0 where it is that vertex.
    arrivals : ndarray of shape (nnz,), float64
        The direction that leads away from the source, in the frame of the vertex; 0 there.
    """

    points: SourcePoints
    axes: FloatArray
    angles: FloatArray
    arrivals: FloatArray

    def to_frames(self, vectors: FloatArray) -> ComplexArray:
        """Return vectors in space, (P, 3), as complex numbers in the frames, (P,)."""
        along = np.einsum("pad,pd->pa", self.axes, vectors)
        return np.asarray(along[:, 0] + 1j * along[:, 1])


def surroundings(domain: Domain, frames: Frames, points: SourcePoints) -> Surroundings:
    """Return the surroundings of sources.

    Parameters
    ----------
    domain : TriangleMesh or PointCloud
    frames : Frames
        Of its vertices.
    points : SourcePoints
        No curve.
    """
    first = points.vertices[points.begins[:-1]]
    axes = np.stack([frames.x_axes[first], frames.y_axes[first]], axis=1)
    none = np.zeros(len(points.vertices))
    if len(first) == len(points.vertices):
        return Surroundings(points, axes, none, none)
    assert isinstance(domain, TriangleMesh)  # sources between the points of a cloud there are none
    parts = []
    for point in range(points.count):
        own = slice(points.begins[point], points.begins[point + 1])
        ends, shares = points.vertices[own], points.shares[own]
        if len(ends) == 1:
            parts.append((ends, shares, points.distances[own], np.zeros(1), np.zeros(1)))
            continue
        place = shares @ domain.vertices[ends]
        steps = domain.vertices[ends] - place
        axes[point] = _axes_between(steps, frames.normals[ends])
        flat = dict(zip(ends.tolist(), steps @ axes[point].T @ [1, 1j], strict=True))
        flat.update(_Unfolding(domain, place, axes[point]).beyond(flat))
        around, where = np.array(list(flat)), np.array(list(flat.values()))
        lengths = np.append(points.distances[own], np.abs(where[len(ends) :]))
        arrivals = np.angle(frames.to_frames(domain.vertices[around] - place, around))
        more = np.zeros(len(around) - len(ends))
        parts.append((around, np.append(shares, more), lengths, np.angle(where), arrivals))
    vertices, weights, distances, angles, arrivals = (
        np.concatenate(columns) for columns in zip(*parts, strict=True)
    )
    begins = np.append(0, np.cumsum([len(part[0]) for part in parts]))
    seen = SourcePoints(vertices, weights, begins, points.n_vertices, distances, points.starts)
    return Surroundings(seen, axes, angles, arrivals)


def _axes_between(steps: FloatArray, normals: FloatArray) -> FloatArray:
    """Return two axes in the plane of a triangle, or in that of an edge and a mean normal."""
    along = _unit(steps[1] - steps[0])
    up = normals.sum(axis=0)
    if len(steps) == 3:
        own = np.cross(along, steps[2] - steps[0])
        up = own if own @ up >= 0 else -own
    return np.stack([along, _unit(np.cross(up, along))])


def _unit(vector: FloatArray) -> FloatArray:
    size = float(np.linalg.norm(vector))
    return vector / size if size > 0 else vector


@dataclass(frozen=True, eq=False)
class _Unfolding:
    """The faces about a point of a mesh, laid into the plane of its frame, with it at 0."""

    mesh: TriangleMesh
    place: FloatArray
    axes: FloatArray

    def beyond(self, flat: dict[int, complex]) -> dict[int, complex]:
        """Return vertices in sight besides those, two or three, whose edge or face it lies in."""
        found: dict[int, complex] = {}
        ends = list(flat)
        for third in self._opposite(*ends[:2]):
            if len(ends) == 3 and third != ends[2]:
                continue
            corners = dict(flat)
            if len(ends) == 2:
                side = self._direction(third).imag < 0
                corners[third] = found[third] = self._apex(flat, ends[0], ends[1], third, side)
            if not self._is_flipped(list(corners)):
                continue
            for face in _edges(list(corners)):
                if set(face[:2]) != set(ends):
                    cone = _sorted(corners[face[0]], corners[face[1]])
                    found.update(self._across(corners, face, cone, MOST_CROSSINGS))
        reach = REACH * max(map(abs, flat.values()))
        return {vertex: at for vertex, at in found.items() if len(ends) == 2 or abs(at) < reach}

    def _is_flipped(self, corners: list[int]) -> bool:
        """Whether an edge of a face, or of a neighbour, has obtuse angles opposite."""
        for one, other, inner in _edges(corners):
            for apex in self._opposite(one, other):
                if apex == inner:
                    continue
                if self._is_obtuse(one, other, inner, apex):
                    return True
                for face in ((one, apex, other), (other, apex, one)):
                    for further in self._opposite(*face[:2]):
                        if further != face[2] and self._is_obtuse(*face, further):
                            return True
        return False

    def _across(
        self,
        flat: dict[int, complex],
        face: tuple[int, int, int],
        cone: tuple[complex, complex],
        left: int,
    ) -> Iterator[tuple[int, complex]]:
        """Yield what is in sight beyond the edge of the first two corners of a face."""
        one, other, inner = face
        beyond = [vertex for vertex in self._opposite(one, other) if vertex != inner]
        if left == 0 or len(beyond) != 1:
            return
        apex = beyond[0]
        side = _cross(flat[other] - flat[one], flat[inner] - flat[one]) > 0
        where = self._apex(flat, one, other, apex, side)
        low, high = cone
        if _cross(low, where) > 0 and _cross(where, high) > 0:
            yield apex, where
        corners = {**flat, apex: where}
        for end, inside in ((one, other), (other, one)):
            first, second = _sorted(flat[end], where)
            low_here = first if _cross(low, first) > 0 else low
            high_here = second if _cross(second, high) > 0 else high
            if _cross(low_here, high_here) > 0:
                narrow = (low_here, high_here)
                yield from self._across(corners, (end, apex, inside), narrow, left - 1)

    def _apex(
        self, flat: dict[int, complex], one: int, other: int, apex: int, right: bool
    ) -> complex:
        """Return where a third corner comes to lie, right or left of the way between two."""
        edge = flat[other] - flat[one]
        length, to_one = abs(edge), self._length(one, apex)
        x = (length**2 + to_one**2 - self._length(other, apex) ** 2) / (2 * length)
        y = np.sqrt(max(to_one**2 - x**2, 0.0))
        return complex(flat[one] + (x - 1j * y if right else x + 1j * y) * edge / length)

    def _opposite(self, one: int, other: int) -> list[int]:
        faces = self._around(one)
        beside = faces[(faces == other).any(axis=1)]
        return [int(v) for v in np.unique(beside[(beside != one) & (beside != other)])]

    def _around(self, vertex: int) -> IntArray:
        return np.asarray(self.mesh.faces[(self.mesh.faces == vertex).any(axis=1)])

    def _direction(self, vertex: int) -> complex:
        along = self.axes @ (self.mesh.vertices[vertex] - self.place)
        return complex(along[0], along[1])

    def _length(self, one: int, other: int) -> float:
        return float(np.linalg.norm(self.mesh.vertices[one] - self.mesh.vertices[other]))

    def _is_obtuse(self, one: int, other: int, first: int, second: int) -> bool:
        """Whether the angles opposite an edge are more than π together."""
        total = 0.0
        for apex in (first, second):
            u, v = (self.mesh.vertices[end] - self.mesh.vertices[apex] for end in (one, other))
            total += float(np.arctan2(np.linalg.norm(np.cross(u, v)), u @ v))
        return total > np.pi


def _edges(corners: list[int]) -> list[tuple[int, int, int]]:
    """Return the edges of a triangle, each with the corner opposite."""
    a, b, c = corners
    return [(a, b, c), (b, c, a), (c, a, b)]


def _cross(one: complex, other: complex) -> float:
    return one.real * other.imag - one.imag * other.real


def _sorted(one: complex, other: complex) -> tuple[complex, complex]:
    """Return two places counterclockwise as seen from 0."""
    return (one, other) if _cross(one, other) > 0 else (other, one)
