"""Vertices around sources, at which fronts begin, and their directions from the sources."""

from collections.abc import Iterator
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.domains import Domain, TriangleMesh
from geodesic_toolkit.geometry.frames import ComplexArray, Frames
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["Surroundings", "surroundings"]

MOST_CROSSINGS = 8
"""Largest number of edges in succession across which faces are unfolded."""

_HIDDEN: WeakKeyDictionary[TriangleMesh, BoolArray] = WeakKeyDictionary()
"""Results of :func:`_hidden` by mesh."""

RINGS = 4
"""Number of rings of faces that are unfolded around a source."""

REACH = 2.0
"""Reach of a source around it, in distances to the farthest corner of its face."""


@dataclass(frozen=True, eq=False)
class Surroundings:
    """P sources with their tangent frames, and the vertices around them that fronts begin at.

    Attributes
    ----------
    points : SourcePoints
        The sources. One that lies between vertices has more of them than those of its face: the
        ones opposite the edge on which it lies, and those beyond edges to be flipped, which hide it
        from the corners of its face.
    axes : ndarray of shape (P, 2, 3), float64
        Two unit vectors at right angles for each source: those of the vertex, or else the first of
        them leads along the first edge of the face.
    angles : ndarray of shape (nnz,), float64
        The direction from a source to each vertex around it; 0 if it is that vertex.
    arrivals : ndarray of shape (nnz,), float64
        The direction away from the source in the frame of the vertex; 0 at the source.
    """

    points: SourcePoints
    axes: FloatArray
    angles: FloatArray
    arrivals: FloatArray

    def to_frames(self, vectors: FloatArray) -> ComplexArray:
        """Return vectors in space, (P, 3), as complex numbers in the frames, (P,)."""
        along = np.einsum("pad,pd->pa", self.axes, vectors)
        return np.asarray(along[:, 0] + 1j * along[:, 1])


def surroundings(
    domain: Domain, frames: Frames, points: SourcePoints, *, unfold: bool = True
) -> Surroundings:
    """Return the surroundings of sources.

    Parameters
    ----------
    domain : TriangleMesh or PointCloud
    frames : Frames
        Of its vertices.
    points : SourcePoints
        No curve.
    unfold : bool
        True to look for more vertices in sight of a point; False if there are many points.
    """
    first, rows = points.vertices[points.begins[:-1]], points.rows
    axes = np.stack([frames.x_axes[first], frames.y_axes[first]], axis=1)
    none = np.zeros(len(points.vertices))
    if len(first) == len(points.vertices):
        return Surroundings(points, axes, none, none)
    assert isinstance(domain, TriangleMesh)  # sources between the points of a cloud there are none
    corners, sizes = domain.vertices[points.vertices], np.diff(points.begins)
    places = np.add.reduceat(points.shares[:, None] * corners, points.begins[:-1])
    steps = corners - places[rows]
    for size in (2, 3):
        own = np.flatnonzero(sizes == size)
        entries = points.begins[own][:, None] + np.arange(size)
        axes[own] = _axes_between(steps[entries], frames.normals[points.vertices[entries]])
    flat = np.einsum("kd,kad->ka", steps, axes[rows]) @ [1, 1j]
    between = sizes[rows] > 1
    angles = np.where(between, np.angle(flat), 0.0)
    arrivals = np.where(between, np.angle(frames.to_frames(steps, points.vertices)), 0.0)
    hidden = np.logical_or.reduceat(_hidden(domain)[points.vertices], points.begins[:-1])
    odd = np.flatnonzero((sizes == 2) | ((sizes > 1) & hidden)) if unfold else sizes[:0]
    if not len(odd):
        return Surroundings(points, axes, angles, arrivals)
    beside = _thirds(_near(domain.faces, points.vertices[np.isin(rows, odd)], domain.n_vertices))
    more: list[tuple[int, int, complex]] = []
    for point in odd.tolist():
        entry = slice(points.begins[point], points.begins[point + 1])
        known = dict(zip(points.vertices[entry].tolist(), flat[entry].tolist(), strict=True))
        unfolding = _Unfolding(domain.vertices, beside, places[point], axes[point])
        more += [(point, vertex, at) for vertex, at in unfolding.beyond(known).items()]
    new_rows, around = (np.array([item[i] for item in more], dtype=np.int64) for i in (0, 1))
    where = np.array([item[2] for item in more], dtype=np.complex128)
    order = np.argsort(np.append(rows, new_rows), kind="stable")
    away = domain.vertices[around] - places[new_rows]
    seen = SourcePoints(
        np.append(points.vertices, around)[order],
        np.append(points.shares, np.zeros(len(around)))[order],
        np.append(0, np.cumsum(sizes + np.bincount(new_rows, minlength=points.count))),
        points.n_vertices,
        np.append(points.distances, np.abs(where))[order],
        points.starts,
    )
    return Surroundings(
        seen,
        axes,
        np.append(angles, np.angle(where))[order],
        np.append(arrivals, np.angle(frames.to_frames(away, around)))[order],
    )


def _axes_between(steps: FloatArray, normals: FloatArray) -> FloatArray:
    """Return two axes (P, 2, 3) in planes of triangles, or in those of edges and mean normals."""
    along = _unit(steps[:, 1] - steps[:, 0])
    up = normals.sum(axis=1)
    if steps.shape[1] == 3:
        own = np.cross(along, steps[:, 2] - steps[:, 0])
        up = np.where((np.einsum("pd,pd->p", own, up) < 0)[:, None], -own, own)
    return np.stack([along, _unit(np.cross(up, along))], axis=1)


def _hidden(mesh: TriangleMesh) -> BoolArray:
    """Return the (N,) vertices of faces that have an edge to be flipped, or a neighbour has."""
    if mesh not in _HIDDEN:
        faces = np.ascontiguousarray(mesh.faces)
        twin, _ = _native.sorted_half_edges(faces, mesh.n_vertices).twins()
        corners = mesh.vertices[faces]
        angles = np.empty(faces.shape)
        for c in range(3):
            u, v = (corners[:, (c + k) % 3] - corners[:, c] for k in (1, 2))
            across = np.linalg.norm(np.cross(u, v), axis=1)
            angles[:, c] = np.arctan2(across, np.einsum("fd,fd->f", u, v))
        opposite = np.where(twin >= 0, angles.ravel()[twin], 0.0).reshape(-1, 3)
        obtuse = np.asarray((angles + opposite > np.pi).any(axis=1))
        beside = ((twin >= 0) & obtuse[twin // 3]).reshape(-1, 3)
        found = np.zeros(mesh.n_vertices, dtype=np.bool_)
        found[faces[obtuse | beside.any(axis=1)]] = True
        _HIDDEN[mesh] = found
    return _HIDDEN[mesh]


def _unit(vectors: FloatArray) -> FloatArray:
    sizes = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(np.divide(vectors, sizes, out=np.zeros_like(vectors), where=sizes > 0))


@dataclass(frozen=True, eq=False)
class _Unfolding:
    """The faces about a point of a mesh, laid into the plane of its frame, with it at 0."""

    vertices: FloatArray
    thirds: dict[tuple[int, int], list[int]]
    place: FloatArray
    axes: FloatArray

    def beyond(self, flat: dict[int, complex]) -> dict[int, complex]:
        """Return vertices in sight besides the two or three of the edge or face of the point."""
        found: dict[int, complex] = {}
        ends = list(flat)
        for third in self._opposite(*ends[:2]):
            if len(ends) == 3 and third != ends[2]:
                continue
            corners = dict(flat)
            if len(ends) == 2:
                side = self._direction(third).imag < 0
                corners[third] = found[third] = self._apex(flat, ends[0], ends[1], third, side)
            for face in _edges(list(corners)):
                if set(face[:2]) != set(ends):
                    cone = _sorted(corners[face[0]], corners[face[1]])
                    found.update(self._across(corners, face, cone, MOST_CROSSINGS))
        reach = REACH * max(map(abs, flat.values()))
        return {vertex: at for vertex, at in found.items() if len(ends) == 2 or abs(at) < reach}

    def _across(
        self,
        flat: dict[int, complex],
        face: tuple[int, int, int],
        cone: tuple[complex, complex],
        left: int,
    ) -> Iterator[tuple[int, complex]]:
        """Yield the vertices in sight beyond the edge of the first two corners of a face."""
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
        """Return the place of a third corner, right or left of the edge from `one` to `other`."""
        edge = flat[other] - flat[one]
        length, to_one = abs(edge), self._length(one, apex)
        x = (length**2 + to_one**2 - self._length(other, apex) ** 2) / (2 * length)
        y = np.sqrt(max(to_one**2 - x**2, 0.0))
        return complex(flat[one] + (x - 1j * y if right else x + 1j * y) * edge / length)

    def _opposite(self, one: int, other: int) -> list[int]:
        return self.thirds.get((min(one, other), max(one, other)), [])

    def _direction(self, vertex: int) -> complex:
        along = self.axes @ (self.vertices[vertex] - self.place)
        return complex(along[0], along[1])

    def _length(self, one: int, other: int) -> float:
        return float(np.linalg.norm(self.vertices[one] - self.vertices[other]))


def _near(faces: IntArray, vertices: IntArray, count: int) -> IntArray:
    """Return the faces within a few rings of some vertices."""
    near = np.zeros(count, dtype=np.bool_)
    near[vertices] = True
    for _ in range(RINGS):
        touched = near[faces].any(axis=1)
        near[faces[touched]] = True
    return np.asarray(faces[touched])


def _thirds(faces: IntArray) -> dict[tuple[int, int], list[int]]:
    """Return the third corners of the faces at each edge, lower end first."""
    thirds: dict[tuple[int, int], list[int]] = {}
    for face in faces.tolist():
        for one, other, third in _edges(face):
            opposite = thirds.setdefault((min(one, other), max(one, other)), [])
            if third not in opposite and third not in (one, other):
                opposite.append(third)
    return thirds


def _edges(corners: list[int]) -> list[tuple[int, int, int]]:
    """Return the edges of a triangle, each with the corner opposite."""
    a, b, c = corners
    return [(a, b, c), (b, c, a), (c, a, b)]


def _cross(one: complex, other: complex) -> float:
    return one.real * other.imag - one.imag * other.real


def _sorted(one: complex, other: complex) -> tuple[complex, complex]:
    """Return two places counterclockwise as seen from 0."""
    return (one, other) if _cross(one, other) > 0 else (other, one)
