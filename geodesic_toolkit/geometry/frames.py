"""Tangent frames at vertices, and the turns between them and the planes of elements.

A tangent vector at a vertex is a complex number in the frame of that vertex: its real part along
the x axis, its imaginary part along the y axis, which is normal × x axis. The turn of a corner, a
complex number of length 1, takes it into the frame of the element, in which gradients are given.

N. Sharp, Y. Soliman, K. Crane, *The Vector Heat Method*, ACM Transactions on Graphics 38, 2019,
https://doi.org/10.1145/3243651
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit import _native
from geodesic_toolkit.core.frozen import FrozenArrays, freeze
from geodesic_toolkit.core.types import BoolArray, FloatArray, IndexArray, IntArray
from geodesic_toolkit.errors import UnsupportedDomainError
from geodesic_toolkit.geometry.components import connected_by_faces
from geodesic_toolkit.geometry.intrinsic import coherently_oriented
from geodesic_toolkit.geometry.threads import threads_for

__all__ = [
    "ComplexArray",
    "Fans",
    "Frames",
    "fans_of",
    "frames_in_space",
    "normals_of_faces",
    "unit_vectors",
]

ComplexArray: TypeAlias = NDArray[np.complex128]

MIN_COSINE_SUM_OF_NORMALS = 1e-9
"""Minimum of one plus the cosine of the angle between two normals with a unique least rotation."""


@dataclass(frozen=True, eq=False)
class Frames(FrozenArrays):
    """Tangent frames at vertices, and the turns from them into the frames of elements.

    Parameters
    ----------
    normals : ndarray of shape (N, 3), float64
        Unit vectors.
    x_axes : ndarray of shape (N, 3), float64
        Unit vectors, at a right angle to the normals.
    turns : ndarray of shape (E, m), complex128
        For each corner of the elements of a gradient, a number of length 1 that takes a tangent
        vector of the vertex into the frame of the element.
    mirrored : ndarray of shape (E,), bool
        Elements that are clockwise, seen from outside, where the normals point: the turn takes
        vectors into the mirror image of their frame, in which the second component has the opposite
        sign.
    surface_turns, surface_mirrored : ndarray of shape (F, 3) and (F,)
        Turns and mirrored triangles of the surface; those of the elements unless given.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> operator, square = gt.CotanLaplacian(), gt.testing.shapes.grid(3)
    >>> frames = operator.frames(square, operator.assemble(square))
    >>> frames.normals[0], frames.turns.shape
    (array([0., 0., 1.]), (8, 3))
    """

    normals: FloatArray
    x_axes: FloatArray
    turns: ComplexArray
    mirrored: BoolArray
    surface_turns: ComplexArray | None = None
    surface_mirrored: BoolArray | None = None

    def __post_init__(self) -> None:
        for name in ("surface_turns", "surface_mirrored"):
            if getattr(self, name) is None:
                object.__setattr__(self, name, getattr(self, name.removeprefix("surface_")))
        for value in self.__dict__.values():
            freeze(value)

    @cached_property
    def y_axes(self) -> FloatArray:
        """The second axes, normal × x axis, of shape (N, 3)."""
        return freeze(np.cross(self.normals, self.x_axes))

    def to_space(
        self, vectors: ComplexArray, vertices: IntArray | slice = slice(None)
    ) -> FloatArray:
        """Return tangent vectors (P,) at vertices, by default all, as vectors in space, (P, 3)."""
        pairs = np.ascontiguousarray(vectors).view(np.float64).reshape(-1, 2)
        axes = (np.ascontiguousarray(each[vertices]) for each in (self.x_axes, self.y_axes))
        return _native.to_space(pairs, *axes)

    def to_frames(
        self, vectors: FloatArray, vertices: IndexArray | IntArray | slice = slice(None)
    ) -> ComplexArray:
        """Return vectors in space, (P, 3), projected to the tangent planes of vertices."""
        x = np.einsum("pd,pd->p", vectors, self.x_axes[vertices])
        return np.asarray(x + 1j * np.einsum("pd,pd->p", vectors, self.y_axes[vertices]))

    def least_turns(self, tails: IndexArray, heads: IndexArray) -> ComplexArray:
        """Return the turns from frames at `tails` to those at `heads`, by least rotations."""
        before, after, axis = self.normals[tails], self.normals[heads], self.x_axes[tails]
        aligned = np.maximum(1 + np.einsum("ed,ed->e", before, after), MIN_COSINE_SUM_OF_NORMALS)
        share = np.einsum("ed,ed->e", after, axis) / aligned
        turned = self.to_frames(axis - share[:, None] * (before + after), heads)
        sizes = np.abs(turned)
        return np.divide(turned, sizes, out=np.ones_like(turned), where=sizes > 0)

    def __getstate__(self) -> dict[str, NDArray[np.generic]]:
        return {name: value for name, value in self.__dict__.items() if name != "y_axes"}


def unit_vectors(angles: FloatArray) -> ComplexArray:
    """Return complex numbers of length 1 at angles (N,) of up to 1e5."""
    pairs = _native.unit_vectors(np.ascontiguousarray(angles, dtype=np.float64))
    return _complex(pairs)[:, 0]


def _complex(pairs: FloatArray) -> ComplexArray:
    return pairs.view(np.complex128)


@dataclass(frozen=True, eq=False)
class Fans:
    """Triangles with the directions of their half-edges, which frames and flips need.

    Attributes
    ----------
    faces : ndarray of shape (F, 3), int64
        Consistently oriented faces; with new vertices, if cuts were needed.
    lengths : ndarray of shape (F, 3), float64
        The edge opposite corner i in column i.
    twin : ndarray of shape (3 F,), int64
        The half-edge to which each half-edge ``3 f + c``, opposite corner c of face f, is glued, or
        -1.
    origin : ndarray of int64
        The vertex of the mesh for each vertex of the faces.
    turned : ndarray of shape (F,), bool
        Faces that were given in the opposite orientation: their columns are reversed.
    mirrored : ndarray of shape (F,), bool
        Faces that are clockwise, seen from outside, where the normals point.
    angles, scales : ndarray of shape (3 F,), float64
        The direction of each half-edge in the frame of its tail, corner c + 1, and the factor of
        angles between half-edges there; negative in mirrored faces.
    """

    faces: IntArray
    lengths: FloatArray
    twin: IntArray
    origin: IntArray
    turned: BoolArray
    mirrored: BoolArray
    angles: FloatArray
    scales: FloatArray

    @property
    def elements(self) -> IntArray:
        """The faces (F, 3) with vertices of the mesh, in the given orientation."""
        faces = self.origin[self.faces]
        return np.where(self.turned[:, None], faces[:, ::-1], faces)

    def delaunay(self) -> "Fans":
        """Return the intrinsic Delaunay triangulation, as by :func:`delaunay_triangles`."""
        return self.flipped(np.zeros(len(self.origin), dtype=np.bool_))

    def flipped(self, held: BoolArray) -> "Fans":
        """Return the triangles after all flips, except for edges of held vertices.

        Parameters
        ----------
        held : ndarray of bool
            One value for each vertex of `faces`.
        """
        faces, lengths, twin = self.faces.copy(), self.lengths.copy(), self.twin.copy()
        angles, scales = self.angles.copy(), self.scales.copy()
        _native.flip_edges_with_directions(faces, lengths, twin, held, angles, scales)
        return replace(
            self,
            faces=faces,
            lengths=lengths,
            twin=twin,
            turned=np.zeros(len(faces), dtype=np.bool_),
            angles=angles,
            scales=scales,
        )

    def turns(self) -> tuple[ComplexArray, BoolArray]:
        """Return the turns of the `elements`, and a mask of mirrored ones."""
        lengths, directions = (
            self.lengths,
            _native.bisectors(self.lengths, self.angles, self.scales),
        )
        mirrored = self.mirrored ^ self.turned
        if self.turned.any():
            lengths, directions = (
                np.where(self.turned[:, None], table[:, ::-1], table)
                for table in (lengths, directions)
            )
        return _complex(_native.triangle_turns(lengths, directions, mirrored)), mirrored


def fans_of(
    vertices: FloatArray, parts: Sequence[tuple[IntArray, FloatArray]]
) -> tuple[FloatArray, FloatArray, list[Fans]]:
    """Return the normals and axes of a mesh, and the fans of each of its parts.

    Parameters
    ----------
    vertices : ndarray of shape (N, 3), float64
    parts : sequence of (faces, lengths)
        Triangles (F, 3) that do not share vertices with those of other parts, and their edge
        lengths.

    Returns
    -------
    normals, x_axes : ndarray of shape (N, 3), float64
    fans : list of Fans

    Raises
    ------
    UnsupportedDomainError
        A part is one-sided, so that its tangent planes cannot be oriented consistently.
    """
    oriented = [_Oriented.of(*part) for part in parts]
    normals = _normals(vertices, oriented)
    axes = _native.tangent_axes(normals)
    return normals, axes, [part.fans(vertices, normals, axes) for part in oriented]


def normals_of_faces(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Return unit normals at the vertices of a mesh, of shape (N, 3).

    They are exact for vertices on a sphere, of third order inside smooth surfaces, and (0, 0, 1) at
    vertices without faces. On the boundary, at creases and where vertices are noisy they are
    weighted means of those of faces. Faces are oriented consistently first, by the majority of
    their orientations.

    Parameters
    ----------
    vertices : ndarray of shape (N, 3), float64
    faces : ndarray of shape (F, 3), int64

    Raises
    ------
    UnsupportedDomainError
        The surface is one-sided.

    References
    ----------
    N. Max, *Weights for Computing Vertex Normals from Facet Normals*, Journal of Graphics Tools 4,
    1999, https://doi.org/10.1080/10867651.1999.10487501

    F. Cazals, M. Pouget, *Estimating Differential Quantities Using Polynomial Fitting of Osculating
    Jets*, Computer Aided Geometric Design 22, 2005, https://doi.org/10.1016/j.cagd.2004.09.004
    """
    return _normals(vertices, [_Oriented.of(faces, np.zeros(faces.shape))])


def _normals(vertices: FloatArray, parts: Sequence["_Oriented"]) -> FloatArray:
    faces = np.concatenate([part.by_normals() for part in parts])
    n_threads = threads_for(len(vertices))
    return _native.vertex_normals(np.ascontiguousarray(vertices), faces, n_threads)


@dataclass(frozen=True, eq=False)
class _Oriented:
    """Consistently oriented triangles."""

    faces: IntArray
    lengths: FloatArray
    twin: IntArray
    origin: IntArray
    turned: BoolArray
    mirrored: BoolArray

    @classmethod
    def of(cls, given: IntArray, lengths: FloatArray) -> "_Oriented":
        """Return consistently oriented faces, which keep the majority's orientation."""
        count = int(given.max(initial=-1)) + 1
        none = np.zeros(len(given), dtype=np.bool_)
        twin, coherent = _native.sorted_half_edges(given, count).twins()
        if coherent:
            lengths = np.ascontiguousarray(lengths)
            return cls(given, lengths, twin, np.arange(count), none, none)
        faces, lengths, origin = coherently_oriented(given, lengths)
        _check_two_sided(origin[faces], count)
        twin, _ = _native.sorted_half_edges(faces, len(origin)).twins()
        turned = np.asarray((origin[faces] != given).any(axis=1))
        patch = connected_by_faces(faces, len(origin))[faces[:, 0]]
        mirrored = 2 * np.bincount(patch, turned) > np.bincount(patch)
        return cls(faces, np.ascontiguousarray(lengths), twin, origin, turned, mirrored[patch])

    def by_normals(self) -> IntArray:
        """Return the faces (F, 3) with the orientation of the majority of the given ones."""
        faces = self.origin[self.faces]
        return (
            np.where(self.mirrored[:, None], faces[:, ::-1], faces)
            if self.mirrored.any()
            else faces
        )

    def fans(self, vertices: FloatArray, normals: FloatArray, axes: FloatArray) -> Fans:
        """Return the faces with the directions of their half-edges."""
        angles, scales = _native.polar_directions(
            np.ascontiguousarray(vertices),
            self.origin[self.faces],
            self.lengths,
            self.twin,
            self.mirrored,
            normals,
            axes,
        )
        return Fans(**self.__dict__, angles=angles, scales=scales)


def _check_two_sided(faces: IntArray, count: int) -> None:
    """Raise if two faces still have an edge with the same direction."""
    _, coherent = _native.sorted_half_edges(faces, count).twins()
    if coherent:
        return
    tails, heads = faces[:, [1, 2, 0]].ravel(), faces[:, [2, 0, 1]].ravel()
    key = np.minimum(tails, heads) * count + np.maximum(tails, heads)
    _, place, sides = np.unique(key, return_inverse=True, return_counts=True)
    runs = np.abs(np.bincount(place, np.where(tails < heads, 1, -1)))
    face = int(np.flatnonzero((sides[place] == 2) & (runs[place] == 2))[0]) // 3
    raise UnsupportedDomainError(
        "the surface is one-sided, like a Möbius strip, and its tangent planes cannot be oriented "
        f"consistently: the face of vertices {faces[face].tolist()} closes it; cut it open there"
    )


def frames_in_space(
    points: FloatArray, elements: IntArray, normals: FloatArray, *, stars: bool
) -> Frames:
    """Return frames of elements in space; turns are the least rotations between normals.

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
    elements : ndarray of shape (E, 2) or (E, 3), int64
        Edges or triangles; triangles with two equal vertices are segments.
    normals : ndarray of shape (N, 3), float64
        Unit vectors.
    stars : bool
        True if the plane of a triangle is the tangent plane of its first vertex instead of its own.
    """
    normals = np.ascontiguousarray(normals)
    axes = _native.tangent_axes(normals)
    turns, mirrored = _native.space_turns(
        np.ascontiguousarray(points), np.ascontiguousarray(elements), normals, axes, stars
    )
    return Frames(normals, axes, _complex(turns), mirrored)
