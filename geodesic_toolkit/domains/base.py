"""The base of all domains, and the coercion of arrays that they share."""

import abc
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.arrays import copied
from geodesic_toolkit.core.checks import check_nothing_masked
from geodesic_toolkit.core.frozen import FrozenArrays
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.errors import InvalidDomainError

__all__ = ["Domain", "as_floats", "as_indices", "check_corners", "check_indices", "first_bad_row"]


class Domain(FrozenArrays, abc.ABC):
    """A shape that distances are measured on: immutable, validated once, with read-only arrays.

    Third parties may subclass it for a kind of shape that the core does not have; an operator
    says in :attr:`LaplaceOperator.domains` which kinds it discretizes.
    """

    @property
    @abc.abstractmethod
    def n_vertices(self) -> int:
        """Number of vertices: the length of every distance field on this domain."""


def _as_array(values: ArrayLike, name: str) -> np.ndarray[Any, Any]:
    cure = "leave those rows out; positions are missing after {}.filled(numpy.nan)"
    check_nothing_masked(values, name, InvalidDomainError, cure)
    try:
        array = np.asarray(values)
    except (ValueError, TypeError) as error:  # ragged lists, objects that refuse conversion
        reason = _raggedness(values) or str(error)
        raise InvalidDomainError(f"{name} cannot be read as an array: {reason}") from error
    if array.dtype.kind not in "iuf":
        raise InvalidDomainError(
            f"{name} must hold real numbers, not dtype {array.dtype}; convert them first"
        )
    return array


def _raggedness(values: Any) -> str | None:
    """Return which row has another number of entries than the first, or None."""
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

    ``None`` stands for any length. Overflow of wider floats to infinity, and NaN that signal, are
    left to the caller's check of finiteness.
    """
    array = _as_array(values, name)
    _check_shape(array, name, shape)
    with np.errstate(over="ignore", invalid="ignore"):
        return copied(array, np.float64)


def as_indices(values: ArrayLike, name: str, row: str, shape: tuple[int | None, ...]) -> IntArray:
    """Return a fresh C-ordered int64 copy of `values`; floats must be whole numbers.

    `row` names one row of the array in messages: "face", "edge".
    """
    array = _as_array(values, name)
    if array.size == 0 and array.ndim < len(shape):  # [] says "no rows" as well as (0, 3) does
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
        They have four columns.
    """
    try:
        shape = np.shape(faces)
    except (ValueError, TypeError):  # rows of different lengths, say, which `as_indices` names
        return
    if len(shape) == 2 and shape[1] == 4 and shape[0]:
        raise InvalidDomainError(
            f"faces must have shape (n, 3), not {shape}. Split quadrangles that are convex: "
            "numpy.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]]); others, or tetrahedra: "
            'meshio.Mesh(vertices, [("quad", faces)]), or "tetra"; of PyVista\'s rows, which begin '
            "with 3, give faces[:, 1:]"
        )


def check_indices(indices: IntArray, n_vertices: int, row: str) -> None:
    """Raise for the first row of `indices` that refers to a vertex that is not there."""
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
    """Return the index of the first row in which `good` is not true throughout, or None."""
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
