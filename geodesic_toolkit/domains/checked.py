"""Checked capabilities of a domain: kernels trust the indices and shapes of arrays."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains.base import Domain
from geodesic_toolkit.domains.graph import Graph
from geodesic_toolkit.errors import UnsupportedDomainError

__all__ = ["graph_of", "normals_of", "polygons_of", "positions_of", "triangles_of"]


def positions_of(domain: Domain) -> FloatArray:
    """Return the positions of the vertices, (N, 3); NaN at vertices without one.

    Raises
    ------
    UnsupportedDomainError
        Positions are missing, or their number is not that of the vertices.
    """
    _check(domain, "positions", domain.positions, np.float64, domain.n_vertices)
    return domain.positions


def normals_of(domain: Domain) -> FloatArray | None:
    """Return the normals at the vertices, (N, 3), or None.

    Raises
    ------
    UnsupportedDomainError
        The number of normals is not that of the vertices.
    """
    if domain.normals is not None:
        _check(domain, "normals", domain.normals, np.float64, domain.n_vertices)
    return domain.normals


def triangles_of(domain: Domain) -> IntArray:
    """Return the triangles, (F, 3).

    Raises
    ------
    UnsupportedDomainError
        Triangles are missing, or one refers to a vertex that does not exist.
    """
    triangles = domain.triangles
    _check(domain, "triangles", triangles, np.int64, None)
    if triangles.size and not (triangles.min() >= 0 and triangles.max() < domain.n_vertices):
        outside = ((triangles < 0) | (triangles >= domain.n_vertices)).any(axis=1)
        bad = int(outside.argmax())
        raise UnsupportedDomainError(
            f"row {bad} of {type(domain).__name__}.triangles is {triangles[bad].tolist()}; there "
            f"are {domain.n_vertices} vertices, numbered from 0"
        )
    return triangles


def polygons_of(domain: Domain) -> tuple[IntArray, IntArray] | None:
    """Return the faces that files keep as sizes, (F,), and corners, face by face; None without any.

    Raises
    ------
    UnsupportedDomainError
        Sizes that do not add up to the corners, or a vertex that is not there.
    """
    if not domain.has("polygons"):
        if not domain.has("triangles"):
            return None
        triangles = triangles_of(domain)
        return np.full(len(triangles), 3, dtype=np.int64), triangles.ravel()
    sizes, corners = domain.polygons
    whole = all(
        isinstance(array, np.ndarray) and array.dtype == np.int64 and array.ndim == 1
        for array in (sizes, corners)
    )
    if not (whole and sizes.min(initial=1) > 0 and sizes.sum() == len(corners)):
        raise UnsupportedDomainError(
            f"{type(domain).__name__}.polygons must be two rows of int64: positive sizes, and as "
            "many corners as they add up to"
        )
    if len(corners) and not (corners.min() >= 0 and corners.max() < domain.n_vertices):
        bad = int(((corners < 0) | (corners >= domain.n_vertices)).argmax())
        raise UnsupportedDomainError(
            f"corner {bad} of {type(domain).__name__}.polygons is vertex {corners[bad]}; there are "
            f"{domain.n_vertices}, numbered from 0"
        )
    return sizes, corners


def graph_of(domain: Domain) -> Graph:
    """Return the edges with their lengths.

    Raises
    ------
    UnsupportedDomainError
        Edges are missing, or the result is not a graph with the same vertices.
    """
    graph = domain.as_graph()
    if not isinstance(graph, Graph) or graph.n_vertices != domain.n_vertices:
        raise UnsupportedDomainError(
            f"{type(domain).__name__}.as_graph() must return a Graph of {domain.n_vertices} "
            f"vertices, not {graph!r}"
        )
    return graph


def _check(domain: Domain, name: str, array: Any, dtype: type, rows: int | None) -> None:
    """Raise unless an array has the given type and shape (rows, 3)."""
    good = isinstance(array, np.ndarray) and array.dtype == dtype and array.ndim == 2
    if good and array.shape[1] == 3 and rows in (None, len(array)):
        return
    wanted = f"({'F' if rows is None else rows}, 3)"
    raise UnsupportedDomainError(
        f"{type(domain).__name__}.{name} must be {np.dtype(dtype)} of shape {wanted}, not "
        f"{_described(array)}"
    )


def _described(array: NDArray[Any] | object) -> str:
    if isinstance(array, np.ndarray):
        return f"{array.dtype} of shape {array.shape}"
    return f"{a_kind_of(array)}"
