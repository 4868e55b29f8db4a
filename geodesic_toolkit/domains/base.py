"""The base class of all domains, and the coercion of arrays that they share."""

from __future__ import annotations

import abc
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.arrays import copied
from geodesic_toolkit.core.checks import check_nothing_masked
from geodesic_toolkit.core.frozen import FrozenArrays
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.errors import InvalidDomainError, UnsupportedDomainError

if TYPE_CHECKING:
    from pathlib import Path

    from geodesic_toolkit.domains.graph import Graph
    from geodesic_toolkit.domains.located import Located

__all__ = [
    "Domain",
    "as_floats",
    "as_indices",
    "as_table_of_floats",
    "check_corners",
    "check_indices",
    "first_bad_row",
]


class Domain(FrozenArrays, abc.ABC):
    """A shape that distances are measured on: immutable, validated once, with read-only arrays.

    Third parties may subclass it for a kind of shape that the core does not have; the attribute
    :attr:`LaplaceOperator.domains` of an operator lists the kinds that it discretizes. Distances
    need only the number of vertices. Everything else is an optional capability; the use of a
    missing one raises an `UnsupportedDomainError` that names it.

    ============ =====================================================================
    capability   used by
    ============ =====================================================================
    positions    sources at points, queries, pictures, files with a shape
    polygons     files with faces of any number of corners
    from_file    files that the suffix's reader makes another kind of
    triangles    pictures and files with faces, :class:`SurfacePoint`, points between vertices
    closest      sources and queries at points inside elements that are not triangles
    as_graph     paths along edges, pictures of edges
    without      masks
    samples      ``geodesic-toolkit check`` of an operator on this kind
    attach       :func:`attach` for objects of another library that are this kind's own
    ============ =====================================================================

    `present`, `normals`, `measured_in_space` and `spans` have defaults that fit most kinds.

    Attributes
    ----------
    vertex_name : str
        Singular noun for a vertex in messages.
    """

    vertex_name: ClassVar[str] = "vertex"

    @property
    @abc.abstractmethod
    def n_vertices(self) -> int:
        """Number of vertices: the length of every distance field on this domain."""

    @property
    def present(self) -> BoolArray:
        """True at the vertices that are not missing, of shape (N,); all of them by default.

        A missing vertex has an index, a distance of ``inf``, and cannot be a source.
        """
        return np.broadcast_to(np.True_, (self.n_vertices,))

    @property
    def measured_in_space(self) -> bool:
        """True if places within an element are as far apart as their positions in space.

        False for a kind with a metric of its own, which then has a method ``spans``.
        """
        return True

    @property
    def normals(self) -> FloatArray | None:
        """Unit normals, of shape (N, 3), which files keep; None unless overridden."""
        return None

    @property
    def positions(self) -> FloatArray:
        """Positions of the vertices, of shape (N, 3), in the unit of the distances.

        Unused vertices may be NaN.

        Raises
        ------
        UnsupportedDomainError
            This kind of domain does not have them.
        """
        raise _without_capability(
            self, "no positions: its distances are at its vertices alone", "positions"
        )

    @property
    def triangles(self) -> IntArray:
        """Triangles of the surface as vertex indices, of shape (F, 3).

        They are the faces of a mesh, the parts of split polygons, or the boundary of a solid.

        Raises
        ------
        UnsupportedDomainError
            This kind of domain does not have them.
        """
        raise _without_capability(self, "no triangles", "triangles")

    @property
    def polygons(self) -> tuple[IntArray, IntArray]:
        """Faces of any number of corners, which files keep, where `triangles` are parts of them.

        The number of corners of each, of shape (F,), and their vertices, face by face.

        Raises
        ------
        UnsupportedDomainError
            This kind of domain has none.
        """
        raise _without_capability(self, "no polygons", "polygons")

    def as_graph(self) -> Graph:
        """Return the distinct edges between the vertices, with their lengths.

        Returns
        -------
        Graph
            With the same vertices.

        Raises
        ------
        UnsupportedDomainError
            This kind of domain does not have them.
        """
        raise _without_capability(self, "no edges", "as_graph()")

    def without(self, mask: BoolArray) -> Domain:  # noqa: ARG002 - for overriding methods
        """Return the domain without elements of masked vertices, which paths then cannot cross.

        Parameters
        ----------
        mask : ndarray of shape (N,), bool

        Returns
        -------
        Domain
            A new domain of a kind that the same operators take. All vertices keep their numbers;
            masked vertices do not belong to elements any more.

        Raises
        ------
        InvalidOptionError
            All elements have masked vertices.
        UnsupportedDomainError
            This kind of domain cannot be masked.
        """
        raise UnsupportedDomainError(
            f"vertices of {a_kind_of(self)} cannot be masked; remove them from it"
            f"{_to_write(self, 'without(mask)')}"
        )

    def closest(self, points: FloatArray) -> Located:  # noqa: ARG002 - as above
        """Return the places of the domain that are closest to points in space.

        Kinds of domain override it if their places are not those of their `triangles`. Without it,
        the closest places are found on the triangles, or else among vertices with `positions`.

        Parameters
        ----------
        points : ndarray of shape (Q, 3), float64
            Finite.

        Returns
        -------
        Located
            Q places.

        Raises
        ------
        UnsupportedDomainError
            This kind of domain leaves it to its triangles or vertices.
        """
        raise _without_capability(self, "no places of its own between vertices", "closest(points)")

    def spans(self, vertices: IntArray, weights: FloatArray) -> FloatArray:
        """Return the straight distances of places in elements from the vertices of these, (P, C).

        Parameters
        ----------
        vertices : ndarray of shape (P, C), int64
            The vertices of the element of each place.
        weights : ndarray of shape (P, C), float64
            Convex weights.

        Returns
        -------
        ndarray of shape (P, C), float64

        Raises
        ------
        UnsupportedDomainError
            This kind of domain has no positions.
        """
        corners = self.positions[vertices]
        at = np.einsum("pc,pcd->pd", weights, corners)
        return np.asarray(np.linalg.norm(corners - at[:, None], axis=2))

    @classmethod
    def from_file(cls, path: Path) -> Domain:
        """Return the shape of this kind that a file holds.

        :func:`read` calls it where this kind is asked for: on the command line, by an operator.

        Parameters
        ----------
        path : Path
            Unpacked, and not empty.

        Returns
        -------
        Domain
            Of this kind, with the vertices in the order of the file.

        Raises
        ------
        ReadError, InvalidDomainError
            What is wrong in the file; :func:`read` adds its name.
        UnsupportedDomainError
            This kind of domain leaves it to the reader of the suffix.
        """
        raise UnsupportedDomainError(f"{path}: a {cls.__name__} is not read from files")

    def attach(self, obj: Any, values: np.ndarray[Any, Any], name: str) -> Any:  # noqa: ARG002 - as above
        """Put values of the vertices on the object of another library that became this domain.

        :func:`geodesic_toolkit.attach` calls it with ``domain=``, for an object that it does not
        know.

        Parameters
        ----------
        obj : object
            Not checked.
        values : ndarray of shape (N,)
            Float64, float32, int64 or bool; a copy.
        name : str
            Name of the values; those of that name are replaced.

        Returns
        -------
        object
            The object that holds the values: `obj`, or a new one.

        Raises
        ------
        UnsupportedDomainError
            The object cannot hold values of this domain.
        """
        raise _without_capability(
            self, f"no place for values on {a_kind_of(obj)}", "attach(obj, values, name)"
        )

    @classmethod
    def samples(cls) -> Any:
        """Return shapes of this kind with known distances.

        Returns
        -------
        DomainSamples
            In the form that :func:`geodesic_toolkit.testing.laplace_operator_checks` takes.

        Raises
        ------
        UnsupportedDomainError
            This kind of domain does not provide samples.
        """
        raise UnsupportedDomainError(
            f"there are no samples of {cls.__name__}: pass samples=[DomainSamples(...)], or give "
            "the class the classmethod samples() of Domain"
        )

    @classmethod
    def has(cls, capability: str) -> bool:
        """Return True if this kind of domain provides a capability.

        Parameters
        ----------
        capability : str
            The name of the property or method.

        Returns
        -------
        bool

        Examples
        --------
        >>> import geodesic_toolkit as gt
        >>> gt.TriangleMesh.has("positions"), gt.Graph.has("positions")
        (True, False)
        """
        return _defined(cls, capability) is not _defined(Domain, capability)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.n_vertices} vertices)"


def _defined(kind: type, capability: str) -> Any:
    """Return the attribute of a class; of a classmethod its function, which is always the same."""
    found = getattr(kind, capability)
    return getattr(found, "__func__", found)


def _without_capability(domain: Domain, missing: str, name: str) -> UnsupportedDomainError:
    return UnsupportedDomainError(f"{a_kind_of(domain)} has {missing}{_to_write(domain, name)}")


def _to_write(domain: Domain, name: str) -> str:
    """Return advice for the author of a kind of domain; "" for kinds of the core."""
    kind = type(domain)
    if kind.__module__.startswith(f"{__package__}."):
        return ""
    member = "method" if name.endswith(")") else "property"
    return f". To allow it, give the class {kind.__name__} the {member} {name} of Domain"


def _as_array(values: ArrayLike, name: str) -> np.ndarray[Any, Any]:
    cure = "remove those rows; positions are missing after {}.filled(numpy.nan)"
    check_nothing_masked(values, name, InvalidDomainError, cure)
    try:
        array = np.asarray(values)
    except (ValueError, TypeError) as error:  # ragged lists, inconvertible objects
        reason = _raggedness(values) or str(error)
        raise InvalidDomainError(f"{name} cannot be read as an array: {reason}") from error
    if array.ndim == 0 and array.dtype.kind in "OUS":  # anything but an array
        raise InvalidDomainError(f"{name} must be an array of numbers, not {a_kind_of(values)}")
    if array.dtype.kind not in "iuf":
        raise InvalidDomainError(
            f"{name} must hold real numbers, not dtype {array.dtype}; convert them first"
        )
    return array


def _raggedness(values: Any) -> str | None:
    """Describe the first row with another number of entries than row 0; None without any."""
    rows = list(values) if isinstance(values, list | tuple) else []
    if not rows or not all(isinstance(row, list | tuple | np.ndarray) for row in rows):
        return None
    sizes = [0 if isinstance(row, np.ndarray) and row.ndim == 0 else len(row) for row in rows]
    other = next((number for number, size in enumerate(sizes) if size != sizes[0]), None)
    if other is None:
        return None
    return f"row {other} has {sizes[other]} entries, where row 0 has {sizes[0]}"


def as_floats(values: ArrayLike, name: str, shape: tuple[int | None, ...]) -> FloatArray:
    """Return a fresh C-ordered float64 copy of `values` after checking its `shape`.

    ``None`` in `shape` means any length. The caller checks finiteness, after overflow of wider
    floats to infinity.
    """
    array = _as_array(values, name)
    _check_shape(array, name, shape)
    with np.errstate(over="ignore", invalid="ignore"):
        return copied(array, np.float64)


def as_table_of_floats(values: ArrayLike, name: str) -> FloatArray:
    """Return a fresh float64 copy of a table (N, D) with any number of columns; see `as_floats`."""
    shape = _as_array(values, name).shape
    if len(shape) == 1 and shape[0]:
        raise InvalidDomainError(
            f"{name} must have shape (N, D), not {shape}; for one coordinate each: {name}[:, None]"
        )
    if len(shape) != 2:
        raise InvalidDomainError(f"{name} must have shape (N, D), not {shape}")
    return as_floats(values, name, shape)


def as_indices(values: ArrayLike, name: str, row: str, shape: tuple[int | None, ...]) -> IntArray:
    """Return a fresh C-ordered int64 copy of `values`; floats must be whole numbers.

    `row` names one row of the array in messages: "face", "edge".
    """
    array = _as_array(values, name)
    if array.size == 0 and array.ndim < len(shape):  # [] means "no rows" like (0, 3)
        array = array.reshape([length or 0 for length in shape])
    _check_shape(array, name, shape)
    if array.dtype.kind == "f":
        with np.errstate(over="ignore"):
            whole = array.astype(np.float64)
        bad = first_bad_row((whole == np.floor(whole)) & (np.abs(whole) < 2.0**53))
        if bad is not None:
            raise InvalidDomainError(
                f"{row} {bad} of {name} holds {_row_text(array[bad])}: not whole numbers; "
                "vertex indices must be integers"
            )
    elif array.dtype == np.uint64:
        bad = first_bad_row(array <= np.uint64(np.iinfo(np.int64).max))
        if bad is not None:
            raise InvalidDomainError(
                f"{row} {bad} of {name} holds {_row_text(array[bad])}: too large"
            )
    return copied(array, np.int64)


def check_corners(faces: Any) -> None:
    """Raise an error for faces of four corners, with what to do.

    Raises
    ------
    InvalidDomainError
        `faces` has four columns.
    """
    try:
        shape = np.shape(faces)
    except (ValueError, TypeError):  # for example ragged rows, which `as_indices` reports
        return
    if len(shape) == 2 and shape[1] == 4 and shape[0]:
        raise InvalidDomainError(
            f"faces must have shape (n, 3), not {shape}. Split quadrangles that are convex: "
            "numpy.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]]); others, or tetrahedra: "
            'meshio.Mesh(vertices, [("quad", faces)]), or "tetra"; of PyVista\'s rows, which begin '
            "with 3, pass faces[:, 1:]"
        )


def check_indices(indices: IntArray, n_vertices: int, row: str) -> None:
    """Raise for the first row of `indices` that refers to a vertex that does not exist."""
    if indices.size == 0 or (indices.min() >= 0 and indices.max() < n_vertices):
        return
    outside = (indices < 0) | (indices >= n_vertices)
    bad = int(np.flatnonzero(outside.any(axis=1))[0])
    index = int(indices[bad][outside[bad]][0])
    hint = " (are the indices one-based?)" if indices.min() >= 1 and index == n_vertices else ""
    raise InvalidDomainError(
        f"{row} {bad} refers to vertex {index}; there are {n_vertices}, numbered from 0{hint}"
    )


def first_bad_row(good: np.ndarray[Any, Any]) -> int | None:
    """Return the index of the first row in which `good` is not entirely true, or None."""
    if good.all():
        return None
    rows = good.all(axis=tuple(range(1, good.ndim))) if good.ndim > 1 else good
    return int(np.flatnonzero(~rows)[0])


def _check_shape(array: np.ndarray[Any, Any], name: str, shape: tuple[int | None, ...]) -> None:
    fits = array.ndim == len(shape) and all(
        wanted is None or wanted == length
        for wanted, length in zip(shape, array.shape, strict=True)
    )
    if not fits:
        wanted = ", ".join("n" if length is None else str(length) for length in shape)
        comma = "," if len(shape) == 1 else ""
        raise InvalidDomainError(f"{name} must have shape ({wanted}{comma}), not {array.shape}")


def _row_text(row: np.ndarray[Any, Any]) -> str:
    return "(" + ", ".join(str(value) for value in np.atleast_1d(row).tolist()) + ")"
