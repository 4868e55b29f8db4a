"""Errors for objects that are not a shape, with advice on what to pass instead."""

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from geodesic_toolkit.errors import UnsupportedDomainError

__all__ = ["OF_GRIDS", "described", "refusal", "several"]

GRID_ATTRIBUTES = ("dimensions", "n_cells", "extract_surface")
"""Attributes of PyVista's structured grids that its other shapes lack."""

OF_GRIDS = (
    "give its surface, grid.extract_surface().triangulate(), or for distances through the inside a "
    "graph of the points: "
    "sklearn.feature_extraction.image.grid_to_graph(*grid.dimensions[::-1]), whose edges are 1 "
    "long (of an array of voxels: grid_to_graph(*mask.shape, mask=mask)); times the spacing they "
    "are in its unit"
)
"""Advice for objects that are grids."""

TABLE_ATTRIBUTES = ("obs", "obsm", "obsp")
"""Attributes of AnnData that shapes lack."""

OF_TABLES = (
    'give the graph of its neighbours, adata.obsp["distances"] (scanpy.pp.neighbors makes it), or '
    'its positions in space, adata.obsm["spatial"] with three columns'
)
"""Advice for tables of observations."""

MAX_LISTED_NAMES = 5
"""Number of names listed in a message."""


def described(obj: Any) -> str:
    """Return the description of an object for messages."""
    if isinstance(obj, type):
        return f"the class {obj.__name__}"
    if isinstance(obj, np.ndarray):
        return f"an array of shape {obj.shape} and dtype {obj.dtype}"
    return f"{type(obj).__module__}.{type(obj).__qualname__}".removeprefix("builtins.")


def refusal(obj: Any, taken: str) -> str:
    """Return why an object is not a shape, and the remedy for common kinds of object.

    Parameters
    ----------
    obj : object
    taken : str
        Description of the objects that are shapes.
    """
    got = described(obj)
    if obj is None:
        why = "None is not a shape; did a function return nothing?"
    elif isinstance(obj, str | bytes | os.PathLike):
        why = f"{str(obj)[:80]!r} is not a shape (to read a file: geodesic_toolkit.read)"
    elif isinstance(obj, Mapping):
        why = f"{got} is not a shape; give its vertices and faces as a pair, {_by_keys(obj)}"
    elif _has(obj, GRID_ATTRIBUTES):
        why = f"{got}: a structured grid is not a surface; {OF_GRIDS}"
    elif _has(obj, TABLE_ATTRIBUTES):
        why = f"{got}: a table of observations is not a shape; {OF_TABLES}"
    elif (table := _table(obj)) is not None:
        why = _of_table(table)
    elif isinstance(obj, list | tuple) and obj:
        why = f"{got} of {len(obj)}, the first {described(obj[0])}, is not a shape; give one shape"
        why += f": {taken}"
    else:
        why = f"{got} is not a shape; give {taken}"
    return why


def _has(obj: Any, names: tuple[str, ...]) -> bool:
    return not isinstance(obj, type) and all(hasattr(obj, name) for name in names)


def _by_keys(obj: Mapping[Any, Any]) -> str:
    if "vertices" in obj and "faces" in obj:
        return '(d["vertices"], d["faces"])'
    return f"(its keys are {_listed([repr(key) for key in obj])})"


def _table(obj: Any) -> np.ndarray[Any, Any] | None:
    """Return a table of numbers, or None if the object is not one."""
    if not isinstance(obj, list | tuple) and not hasattr(obj, "__array__"):
        return None
    try:
        table = np.asarray(obj)
    except ValueError:
        return None
    return table if table.ndim == 2 and table.dtype.kind in "iufb" and table.size else None


def _of_table(table: np.ndarray[Any, Any]) -> str:
    """Return the message for a table that does not have three columns."""
    rows, columns = table.shape
    if rows == columns:
        cure = (
            "if its entries are lengths of edges, and 0 without an edge, give "
            "scipy.sparse.csr_array(table)"
        )
    elif columns == 2:
        cure = "add a third column to points in the plane: numpy.column_stack([xy, 0 * xy[:, 0]])"
    elif columns > 3:
        cure = (
            f"for points in {columns} dimensions give the graph of their neighbours: "
            'sklearn.neighbors.kneighbors_graph(table, 10, mode="distance")'
        )
    else:
        cure = f"it has {columns} column{'s' * (columns != 1)} of {table.dtype}"
    return f"a table of size {rows} x {columns} is not a shape; {cure}"


def several(
    obj: Any, codes: Sequence[str], all_at_once: str | None = None
) -> UnsupportedDomainError:
    """Return the error for an object that holds several shapes, or no shape.

    Parameters
    ----------
    obj : object
    codes : sequence of str
        Code that returns each shape that it holds.
    all_at_once : str, optional
        Code that returns all as one shape.
    """
    if not codes:
        return UnsupportedDomainError(f"{described(obj)} is not a shape: it is empty")
    joined = f"; or all as one shape: {all_at_once}" if all_at_once else ""
    return UnsupportedDomainError(
        f"{described(obj)} holds {len(codes)} shapes; give one: {_listed(codes)}{joined}"
    )


def _listed(names: Sequence[str]) -> str:
    more = ", ..." if len(names) > MAX_LISTED_NAMES else ""
    return ", ".join(names[:MAX_LISTED_NAMES]) + more
