"""The exponential map: the ends of straightest lines from a point."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, cast, final

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit import _native
from geodesic_toolkit.analysis.paths.path import GeodesicPath
from geodesic_toolkit.core.checks import real_numbers
from geodesic_toolkit.core.frozen import FrozenArrays, freeze
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    UnsupportedDomainError,
)
from geodesic_toolkit.geometry.frames import Fans, fans_of
from geodesic_toolkit.geometry.triangles import (
    lengths_from_inverse,
    measured_triangles,
    proper_faces,
)
from geodesic_toolkit.solver.solver import GeodesicSolver, check_solver
from geodesic_toolkit.sources.points import SourcePoints
from geodesic_toolkit.sources.surface_point import SurfacePoint

__all__ = ["ExpMap", "exp_map"]

LONGEST = 1e6
"""Largest length of a line in mean edge lengths; longer vectors are in another unit."""

MOST = 10_000_000
"""Largest number of edges that a line crosses, for triangles much smaller than most."""

ASIDE = 1e-9
"""Angle, in radians, by which a direction may lie outside the surface and go along its boundary."""


@final
@dataclass(frozen=True, eq=False)
class ExpMap(FrozenArrays):
    """Straightest lines from a point: their ends, and the lines themselves.

    Attributes
    ----------
    mesh : TriangleMesh
    faces : ndarray of shape (Q,), int64
        The faces in which they end.
    barycentric : ndarray of shape (Q, 3), float64
        The barycentric coordinates of the ends in these faces.
    positions : ndarray of shape (Q, 3), float64
        The positions of the ends in space.
    arrival : ndarray of shape (Q, 3), float64
        The directions in which they arrive, of length 1; 0 for a line of no length.
    missing : ndarray of shape (Q,), float64
        The rest of the lengths of lines that end at a boundary, or at an edge of more than
        two faces; 0 for the others.
    """

    mesh: TriangleMesh
    faces: IntArray
    barycentric: FloatArray
    positions: FloatArray
    arrival: FloatArray
    missing: FloatArray
    _begins: IntArray
    _line_faces: IntArray
    _line_weights: FloatArray

    def __post_init__(self) -> None:
        for value in self.__dict__.values():
            if isinstance(value, np.ndarray):
                freeze(value)

    @cached_property
    def points(self) -> tuple[SurfacePoint, ...]:
        """The ends as points of the surface, which may be sources."""
        return _surface_points(self.faces, self.barycentric)

    def path(self, i: int) -> GeodesicPath:
        """Return line i, as a polyline that runs straight through one face after the other.

        Parameters
        ----------
        i : int
            The number of the line, from 0.

        Returns
        -------
        GeodesicPath

        Raises
        ------
        InvalidOptionError
            A number that is not that of a line.
        """
        if not 0 <= i < len(self.faces):
            raise InvalidOptionError(f"line {i} does not exist; there are {len(self.faces)}")
        own = slice(self._begins[i], self._begins[i + 1])
        return GeodesicPath(
            self.mesh, _surface_points(self._line_faces[own], self._line_weights[own])
        )

    def __repr__(self) -> str:
        return f"ExpMap({len(self.faces)} lines, {np.count_nonzero(self.missing)} cut short)"


def exp_map(solver: GeodesicSolver, source: Any, vectors: ArrayLike) -> ExpMap:
    """Return the ends of straightest lines that leave one place along tangent vectors.

    A line goes straight on across edges, and is as long as its vector. Directions at a vertex are
    those of the tangent frames, in which the angles around it are scaled to 2π, so that this map is
    the inverse of an exact logarithmic map. A line through a vertex passes it on one side.

    Parameters
    ----------
    solver : GeodesicSolver
        Of a mesh; nothing is factorised. Lines do not enter faces of masked vertices.
    source : int, array-like of float, or SurfacePoint
        One place, as :meth:`GeodesicSolver.distance` takes it.
    vectors : array-like of shape (Q, 3) or (3,), float64
        In space, in the unit of the mesh; only their parts in the tangent plane count.

    Returns
    -------
    ExpMap

    Raises
    ------
    InvalidOptionError
        An argument that is not a solver; vectors that are not finite, not of that shape, or
        more than a million mean edges long.
    UnsupportedDomainError
        A domain that is not a mesh; a surface with one side.
    InvalidSourceError
        Not exactly one place, or a vertex without faces.

    References
    ----------
    K. Polthier, M. Schmies, *Straightest Geodesics on Polyhedral Surfaces*, 1998,
    https://doi.org/10.1145/1185657.1185664

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> solver = gt.GeodesicSolver(gt.testing.shapes.grid(5))
    >>> lines = gt.exp_map(solver, 0, [[0.5, 0.25, 0.0], [0.0, 3.0, 0.0]])
    >>> lines.positions[0].round(6), lines.missing.round(6)
    (array([0.5 , 0.25, 0.  ]), array([0., 2.]))
    """
    check_solver(solver, "exp_map")
    mesh = solver.passable
    if not isinstance(mesh, TriangleMesh):
        raise UnsupportedDomainError(
            f"exp_map follows lines over the faces of a mesh, not over {a_kind_of(mesh)}"
        )
    place = solver.locate(source, "source")
    if place.count != 1 or place.front_curvatures is not None:
        raise InvalidSourceError(f"source: lines leave one place, not {place.count}")
    table = _vectors(vectors, solver.method.metric.spacing)
    ground = _Ground.of(mesh)
    starts = (ground.at_vertex if len(place.vertices) == 1 else ground.in_face)(place, table)
    begins, faces, weights, missing = _native.straight_lines(
        ground.fans.lengths, ground.fans.twin, *starts.lines, MOST
    )
    faces, weights = ground.as_given(faces, weights)
    positions = np.einsum("pc,pcd->pd", weights, mesh.vertices[mesh.faces[faces]])
    if solver.mask is not None:
        faces = _kept(solver)[faces]
    last = begins[1:] - 1
    return ExpMap(
        mesh=cast("TriangleMesh", solver.domain),  # what is left of it is one
        faces=faces[last],
        barycentric=weights[last],
        positions=positions[last],
        arrival=_unit(positions[last] - positions[np.maximum(last - 1, begins[:-1])]),
        missing=missing + starts.outside,
        _begins=begins,
        _line_faces=faces,
        _line_weights=weights,
    )


def _kept(solver: GeodesicSolver) -> IntArray:
    """Return the faces of the mesh that touch no masked vertex."""
    assert isinstance(solver.domain, TriangleMesh)  # for the type checker
    return np.flatnonzero(~np.asarray(solver.mask)[solver.domain.faces].any(axis=1))


class _Starts(NamedTuple):
    """Places where lines begin, their directions, and their lengths."""

    faces: IntArray
    weights: FloatArray
    angles: FloatArray  # to the first half-edge of each face
    lengths: FloatArray
    outside: FloatArray  # the lengths of those that do not begin on the surface

    @property
    def lines(self) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
        """The arguments of the kernel: places, directions, lengths on the surface."""
        return self.faces, self.weights, self.angles, self.lengths - self.outside


@dataclass(frozen=True, eq=False)
class _Ground:
    """The faces of a mesh that have an area, with directions about their vertices."""

    vertices: FloatArray
    proper: IntArray  # which faces of the mesh they are
    normals: FloatArray
    axes: FloatArray
    fans: Fans

    @classmethod
    def of(cls, mesh: TriangleMesh) -> "_Ground":
        """Return the faces of a mesh with an area."""
        faces, inverse, _, _ = measured_triangles(mesh.vertices, mesh.faces)
        proper = np.flatnonzero(proper_faces(mesh.faces))
        normals, axes, (fans,) = fans_of(mesh.vertices, [(faces, lengths_from_inverse(inverse))])
        return cls(mesh.vertices, proper, normals, axes, fans)

    def as_given(self, faces: IntArray, weights: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return places in the faces of the mesh, as those were given."""
        turned = self.fans.turned[faces][:, None]
        return self.proper[faces], np.where(turned, weights[:, ::-1], weights)

    def at_vertex(self, place: SourcePoints, vectors: FloatArray) -> _Starts:
        """Return the corners of a vertex through which lines leave it."""
        fans, vertex = self.fans, int(place.vertices[0])
        corners = np.flatnonzero(fans.origin[fans.faces].ravel() == vertex)
        if not len(corners):
            raise InvalidSourceError(f"source: vertex {vertex} belongs to no face")
        x, y = self.axes[vertex], np.cross(self.normals[vertex], self.axes[vertex])
        along = vectors @ x + 1j * (vectors @ y)
        angles = _angles(fans.lengths)
        halves = _leaving(corners)  # with their corners on the left
        scales, inside = fans.scales[halves], angles.ravel()[corners]
        off = (np.angle(along)[:, None] - fans.angles[halves]) * np.sign(scales) % (2 * np.pi)
        off = np.where(off > 2 * np.pi - ASIDE, 0.0, off) / np.abs(scales)
        chosen = np.maximum(off - inside, 0.0).argmin(axis=1)
        rows = np.arange(len(vectors))
        off, inside = off[rows, chosen], inside[chosen]
        faces, corner = np.divmod(corners[chosen], 3)
        weights = np.zeros((len(vectors), 3))
        weights[rows, corner] = 1.0
        half = _leaving(corners[chosen]) % 3
        sides = np.column_stack([0 * rows, np.pi - angles[faces, 2], np.pi + angles[faces, 1]])
        lengths = np.abs(along)
        outside = np.where(off > inside + ASIDE, lengths, 0.0)
        return _Starts(
            faces, weights, sides[rows, half] + np.minimum(off, inside), lengths, outside
        )

    def in_face(self, place: SourcePoints, vectors: FloatArray) -> _Starts:
        """Return the beginnings of lines from a point inside a face."""
        faces = self.fans.origin[self.fans.faces]
        has = np.all([(faces == vertex).any(axis=1) for vertex in place.vertices], axis=0)
        face = int(has.argmax())
        weights = np.array([place.shares[place.vertices == v].sum() for v in faces[face]])
        apex, tail, head = self.vertices[faces[face]]
        x = _unit(head - tail)
        y = _unit(apex - tail - ((apex - tail) @ x) * x)
        along = vectors @ x + 1j * (vectors @ y)
        count = len(vectors)
        return _Starts(
            np.full(count, face),
            np.tile(weights, (count, 1)),
            np.angle(along),
            np.abs(along),
            np.zeros(count),
        )


def _vectors(values: ArrayLike, spacing: float) -> FloatArray:
    """Return tangent vectors as an array of shape (Q, 3), checked."""
    table = np.atleast_2d(real_numbers(values, "vectors"))
    if table.ndim != 2 or table.shape[1] != 3:
        raise InvalidOptionError(f"vectors must have shape (Q, 3) or (3,), not {table.shape}")
    sizes = np.linalg.norm(table, axis=1)
    sound = sizes <= LONGEST * spacing  # neither is NaN
    if not sound.all():
        bad = int(sound.argmin())
        raise InvalidOptionError(
            f"vector {bad} is {table[bad].tolist()}: not finite, or longer than {LONGEST:.0e} mean "
            "edges; is it in the unit of the mesh?"
        )
    return table


def _leaving(corners: IntArray) -> IntArray:
    """Return the half-edges that leave corners of faces, and have these on their left."""
    return np.asarray(corners - corners % 3 + (corners + 2) % 3)


def _angles(lengths: FloatArray) -> FloatArray:
    """Return the angles (F, 3) of triangles by the edges opposite."""
    b, c = lengths[:, [1, 2, 0]], lengths[:, [2, 0, 1]]
    return np.asarray(np.arccos(np.clip((b**2 + c**2 - lengths**2) / (2 * b * c), -1, 1)))


def _unit(vectors: FloatArray) -> FloatArray:
    sizes = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(np.divide(vectors, sizes, out=np.zeros_like(vectors), where=sizes > 0))


def _surface_points(faces: IntArray, weights: FloatArray) -> tuple[SurfacePoint, ...]:
    return tuple(
        SurfacePoint(face, (a, b, c))
        for face, (a, b, c) in zip(faces.tolist(), weights.tolist(), strict=True)
    )
