"""Polygon meshes."""

from collections.abc import Iterable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidDomainError, InvalidOptionError
from geodesic_toolkit.geometry.polygons import triangles_inside
from geodesic_toolkit_polygon.fans import Fans, fans_of

__all__ = ["PolygonMesh"]

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]


@final
class PolygonMesh(gt.Domain):
    """A mesh of polygons in space, which need be neither flat nor convex.

    Its surface is made of triangles: a polygon of more than three corners is the fan about a vertex
    inside it, where the squares of the areas of the triangles have the least sum. A polygon that no
    such place sees all of is split without one. Distances are those at the corners.

    Parameters
    ----------
    vertices : array-like of shape (N, 3)
        Positions, in any unit. Those that no face refers to may be anything, and are infinitely
        far.
    faces : sequence of sequences of int, or array-like of shape (F, k)
        The corners of each face in their order, counted from 0. A corner that directly follows
        itself counts once, and faces of the same corners count once.

    Attributes
    ----------
    sizes : ndarray of shape (F,), int64, read-only
        Corners of each face.
    corners : ndarray of shape (sizes.sum(),), int64, read-only
        Their vertex indices, face by face.

    Raises
    ------
    InvalidDomainError
        No vertices, no faces, an index out of range, a vertex that is not finite, a face with fewer
        than three different corners, one that comes back to a corner, or crosses itself. The
        message names the first.
    MissingDependencyError
        A polygon of more than four corners is not convex, and manifold3d is not installed.

    References
    ----------
    A. Bunge, P. Herholz, M. Kazhdan, M. Botsch, *Polygon Laplacian Made Simple*, Computer Graphics
    Forum 39, 2020, https://doi.org/10.1111/cgf.13931

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit_polygon import PolygonMesh
    >>> corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 2, 0]]
    >>> house = PolygonMesh(corners, [[0, 1, 2, 3], [3, 2, 4]])
    >>> house
    PolygonMesh(5 vertices, 2 faces of 3 to 4 corners)
    >>> gt.geodesic_distance(house, 0).round(3)
    array([0.   , 1.   , 1.414, 1.   , 2.062])
    """

    sizes: IntArray
    corners: IntArray
    _points: FloatArray
    _triangles: IntArray

    def __init__(
        self, vertices: ArrayLike, faces: Sequence[Sequence[int]] | Iterable[Any] | ArrayLike
    ) -> None:
        self._set_up(vertices, *_corners_of(faces))

    @classmethod
    def of_corners(cls, vertices: ArrayLike, sizes: ArrayLike, corners: ArrayLike) -> "PolygonMesh":
        """Return the mesh of faces that are given as one row of corners.

        Parameters
        ----------
        vertices : array-like of shape (N, 3)
        sizes : array-like of shape (F,)
            Corners of each face.
        corners : array-like of shape (sizes.sum(),)
            Their vertex indices, face by face.

        Returns
        -------
        PolygonMesh

        Raises
        ------
        InvalidDomainError
            As for the class.
        """
        mesh = cls.__new__(cls)
        mesh._set_up(  # noqa: SLF001 - of its own class
            vertices, _whole(sizes, "sizes"), _whole(corners, "corners")
        )
        return mesh

    @classmethod
    def of(cls, obj: Any) -> "PolygonMesh":
        """Return the mesh of an object of another library, with its polygons.

        Parameters
        ----------
        obj : object
            A TriangleMesh, a pair (vertices, faces), a PolyData of PyVista, a Mesh of meshio.

        Returns
        -------
        PolygonMesh
            In the unit of `obj`, its vertices in their order.

        Raises
        ------
        UnsupportedDomainError
            Something else, or a mesh with cells that are not polygons.
        InvalidDomainError
            As for the class.
        """
        from geodesic_toolkit_polygon.conversion import polygons_of

        return cls.of_corners(*polygons_of(obj))

    @classmethod
    def from_file(cls, path: Path) -> "PolygonMesh":
        """Return the mesh of an OBJ, OFF or PLY file, with its polygons."""
        return cls.of_corners(*gt.read_polygons(path))

    def _set_up(self, vertices: ArrayLike, sizes: IntArray, corners: IntArray) -> None:
        points = _points(vertices)
        if not len(points):
            raise InvalidDomainError("the mesh has no vertices")
        if not len(sizes):
            raise InvalidDomainError("the mesh has no faces; for points alone use PointCloud")
        if sizes.min() < 0 or sizes.sum() != len(corners):
            raise InvalidDomainError(
                f"sizes, from {sizes.min()} on, have the sum {sizes.sum()}; there are "
                f"{len(corners)} corners"
            )
        _check_indices(points, sizes, corners)
        sizes, corners = _without_stutter(sizes, corners)
        _check_corners(sizes, corners)
        triangles, crossing = triangles_inside(points, sizes, corners)
        if crossing:
            raise InvalidDomainError(
                f"face {crossing[0]} crosses itself, {len(crossing)} in all; give its corners in "
                "the order in which its edges run around it"
            )
        self._set(_points=points, sizes=sizes, corners=corners, _triangles=triangles)

    @property
    def n_vertices(self) -> int:
        """Number of vertices, the unreferenced ones among them."""
        return len(self._points)

    @property
    def n_faces(self) -> int:
        """Number of faces."""
        return len(self.sizes)

    @property
    def faces(self) -> list[IntArray]:
        """The corners of each face."""
        return np.split(self.corners, np.cumsum(self.sizes)[:-1])

    @property
    def positions(self) -> FloatArray:
        """The vertices, (N, 3)."""
        return self._points

    @property
    def polygons(self) -> tuple[IntArray, IntArray]:
        """The corners of each face, (F,), and their vertices, face by face."""
        return self.sizes, self.corners

    @property
    def triangles(self) -> IntArray:
        """The faces, split into triangles without further vertices, of shape (T, 3)."""
        return self._triangles

    def as_graph(self) -> gt.Graph:
        """Return the edges of faces that have some length, each once.

        Returns
        -------
        Graph
        """
        ends = np.column_stack([self.corners, _next_corners(self.sizes, self.corners)])
        edges = np.unique(np.sort(ends, axis=1), axis=0)
        steps = np.diff(self._points[edges], axis=1)[:, 0]
        lengths = np.linalg.norm(steps, axis=1)
        return gt.Graph(self.n_vertices, edges[lengths > 0], lengths[lengths > 0])

    def without(self, mask: BoolArray) -> "PolygonMesh":
        """Return the mesh without the faces that have a masked vertex, its vertices as they are.

        Parameters
        ----------
        mask : ndarray of shape (N,), bool

        Returns
        -------
        PolygonMesh

        Raises
        ------
        InvalidOptionError
            The mask leaves no face.
        """
        begins = np.cumsum(self.sizes) - self.sizes
        stays = ~np.logical_or.reduceat(mask[self.corners], begins)
        if not stays.any():
            raise InvalidOptionError("the mask leaves no face of the mesh")
        corners = self.corners[np.repeat(stays, self.sizes)]
        return PolygonMesh.of_corners(self._points, self.sizes[stays], corners)

    @property
    def surface(self) -> gt.TriangleMesh:
        """The surface as triangles: the vertices, and behind them those inside of faces.

        Exact distances of the vertices, and straight paths, are those of this mesh.
        """
        return self._surface

    @property
    def weights(self) -> csr_array:
        """The vertices inside of faces as convex combinations of the corners, (V, N)."""
        return self._fans.weights

    @cached_property
    def _fans(self) -> Fans:
        sizes, corners, split = self.sizes, self.corners, self._triangles
        once = _first_of_kind(sizes, corners)
        if not once.all():
            split = split[np.repeat(once, sizes - 2)]
            sizes, corners = sizes[once], corners[np.repeat(once, sizes)]
        return fans_of(self._points, sizes, corners, split)

    @cached_property
    def _surface(self) -> gt.TriangleMesh:
        known = np.where(np.isfinite(self._points), self._points, 0.0)  # of no face, weight 0
        further = self._fans.weights @ known
        return gt.TriangleMesh(np.concatenate([self._points, further]), self._fans.triangles)

    @classmethod
    def samples(cls) -> Any:
        """Return planes of quadrangles and of hexagons and spheres of quadrangles."""
        from geodesic_toolkit_polygon.samples import polygon_samples

        return polygon_samples()

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what derives from the rest."""
        derived = {"_fans", "_surface"}
        return {name: value for name, value in self.__dict__.items() if name not in derived}

    def __repr__(self) -> str:
        least, most = self.sizes.min(), self.sizes.max()
        corners = f"{least}" if least == most else f"{least} to {most}"
        plural = "face" if self.n_faces == 1 else "faces"
        return (
            f"PolygonMesh({self.n_vertices} vertices, {self.n_faces} {plural} of {corners} corners)"
        )


def _points(vertices: ArrayLike) -> FloatArray:
    try:
        points = np.array(vertices, dtype=np.float64, order="C")
    except (ValueError, TypeError) as error:
        raise InvalidDomainError(f"vertices cannot be read as an array: {error}") from error
    if points.ndim != 2 or points.shape[1] != 3:
        raise InvalidDomainError(f"vertices must have shape (N, 3), not {points.shape}")
    return points


def _corners_of(faces: Any) -> tuple[IntArray, IntArray]:
    """Return sizes and corners of faces, which are rows of one length or of several."""
    if isinstance(faces, np.ndarray) and faces.dtype != object:
        if faces.ndim != 2:
            raise InvalidDomainError(f"an array of faces must have shape (F, k), not {faces.shape}")
        return np.full(len(faces), faces.shape[1], dtype=np.int64), _whole(faces.ravel(), "faces")
    try:
        rows = [np.asarray(face) for face in faces]
    except (ValueError, TypeError) as error:
        raise InvalidDomainError(f"faces cannot be read as rows of indices: {error}") from error
    for number, row in enumerate(rows):
        if row.ndim != 1:
            raise InvalidDomainError(f"face {number} must be a row of indices, not {row.tolist()}")
    sizes = np.array([len(row) for row in rows], dtype=np.int64)
    return sizes, _whole(np.concatenate([np.zeros(0, dtype=np.int64), *rows]), "faces")


def _whole(values: ArrayLike, name: str) -> IntArray:
    try:
        array = np.asarray(values)
    except (ValueError, TypeError) as error:
        raise InvalidDomainError(f"{name} cannot be read as an array: {error}") from error
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iuf"):
        raise InvalidDomainError(
            f"{name} must be one row of integers, not {array.dtype} of shape {array.shape}"
        )
    if array.dtype.kind == "f":
        good = (array == np.floor(array)) & (np.abs(array) < 2.0**53)
        if not good.all():
            raise InvalidDomainError(
                f"{name} must be whole numbers; entry {good.argmin()} is {array[good.argmin()]}"
            )
    return np.array(array, dtype=np.int64)


def _owners(sizes: IntArray) -> IntArray:
    return np.repeat(np.arange(len(sizes)), sizes)


def _next_corners(sizes: IntArray, corners: IntArray) -> IntArray:
    """Return the corner that follows each in its face."""
    ends = np.cumsum(sizes)
    following = np.append(corners[1:], 0)
    following[ends[sizes > 0] - 1] = corners[(ends - sizes)[sizes > 0]]
    return following


def _check_indices(points: FloatArray, sizes: IntArray, corners: IntArray) -> None:
    outside = np.flatnonzero((corners < 0) | (corners >= len(points)))
    if len(outside):
        raise InvalidDomainError(
            f"face {_owners(sizes)[outside[0]]} refers to vertex {corners[outside[0]]}; there are "
            f"{len(points)}, numbered from 0"
        )
    lost = np.flatnonzero(~np.isfinite(points[corners]).all(axis=1))
    if len(lost):
        vertex = corners[lost[0]]
        raise InvalidDomainError(
            f"vertex {vertex} of face {_owners(sizes)[lost[0]]} is not finite: "
            f"{points[vertex].tolist()}; leave out its faces"
        )


def _without_stutter(sizes: IntArray, corners: IntArray) -> tuple[IntArray, IntArray]:
    """Return the faces without corners that directly follow themselves."""
    new = corners != _next_corners(sizes, corners)
    if new.all():
        return sizes, corners
    return np.bincount(_owners(sizes)[new], minlength=len(sizes)), corners[new]


def _check_corners(sizes: IntArray, corners: IntArray) -> None:
    """Raise for the first face of fewer than three corners, or that comes back to one."""
    few = np.flatnonzero(sizes < 3)
    if len(few):
        raise InvalidDomainError(
            f"face {few[0]} has {sizes[few[0]]} different corners; a face needs three, leave it out"
        )
    owners = _owners(sizes)
    order = np.lexsort((corners, owners))
    again = (np.diff(corners[order]) == 0) & (np.diff(owners[order]) == 0)
    if again.any():
        place = order[int(again.argmax())]
        raise InvalidDomainError(
            f"face {owners[place]} comes back to vertex {corners[place]}; make two faces of it, "
            "each with all of its corners once"
        )


def _first_of_kind(sizes: IntArray, corners: IntArray) -> BoolArray:
    """Return which faces have corners that no face before has: others are its back or a copy."""
    first = np.ones(len(sizes), dtype=np.bool_)
    begins = np.cumsum(sizes) - sizes
    for size in np.unique(sizes).tolist():
        own = np.flatnonzero(sizes == size)
        rings = np.sort(corners[begins[own, None] + np.arange(size)], axis=1)
        _, leaders = np.unique(rings, axis=0, return_index=True)
        first[own] = False
        first[own[leaders]] = True
    return first
