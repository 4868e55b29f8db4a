"""The connection Laplacian: the Laplacian of tangent vectors, from turns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.rows import MOST_ENTRIES, CompressedRows
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.edge_gradient import EdgeGradient
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.errors import InvalidDiscretizationError, NotEnoughMemoryError
from geodesic_toolkit.geometry.frames import ComplexArray, Frames

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["Connection", "connection_along_edges", "connection_laplacian"]

ALIKE = 1e-9
"""Magnitude of the sum of unit turns of an edge's elements below which it has no direction."""


@dataclass(frozen=True, eq=False)
class Connection:
    """A connection Laplacian: Hermitian, positive semidefinite, as L = -Δ is.

    Attributes
    ----------
    pattern : CompressedRows of shape (N, N)
        Where its entries are; the values are of no account.
    entries : ndarray of shape (nnz, 2), float64
        Their real and imaginary parts.
    """

    pattern: CompressedRows
    entries: FloatArray

    @property
    def scipy(self) -> csr_array[Any]:
        """The matrix as one of SciPy's, complex (N, N)."""
        from scipy.sparse import csr_array

        values = np.ascontiguousarray(self.entries).view(np.complex128)[:, 0]
        arrays = (values, self.pattern.indices, self.pattern.indptr)
        return csr_array(arrays, shape=self.pattern.shape)

    def plus_mass(self, mass: FloatArray, times: FloatArray) -> CompressedRows:
        """Return ``M + t L_c`` as a real matrix of shape (2 N, 2 N).

        Real and imaginary part of a vertex are side by side; it is symmetric, and positive definite
        where each vertex has mass.
        """
        count = self.pattern.shape[0]
        if 4 * self.pattern.nnz > MOST_ENTRIES:
            raise NotEnoughMemoryError(
                f"the vector heat of {count} vertices would have more entries than 32 bits count; "
                "simplify the shape, or work on its parts"
            )
        scale = np.ascontiguousarray(np.broadcast_to(times, (count,)))
        alone = np.maximum(mass, np.where(np.diff(self.pattern.indptr) > 1, 0.0, 1.0))
        diagonal = np.where(mass > 0, mass, alone)  # vertices of no element take any pivot
        places = self.pattern.indptr, self.pattern.indices
        return CompressedRows(*_native.real_form(*places, self.entries, scale, diagonal))


def connection_laplacian(metric: Discretization, frames: Frames) -> Connection:
    """Return ``G_cᴴ W G_c``, with G_c the gradient whose coefficients are multiplied by turns.

    Parameters
    ----------
    metric : Discretization
        Made of triangles, or of edges.
    frames : Frames
        Those of its operator.

    Raises
    ------
    InvalidDiscretizationError
        Turns that are not those of its elements.
    """
    gradient = metric.gradient
    if isinstance(gradient, EdgeGradient):
        return connection_along_edges(metric, metric, frames)
    if not (isinstance(gradient, ElementGradient) and gradient.of_planes):
        raise InvalidDiscretizationError(
            f"a connection needs triangles or edges, and this discretization has {gradient!r}"
        )
    _check_turns(frames, gradient.elements.shape)
    if metric.rows.nnz <= gradient.n_vertices + 2 * gradient.elements.size:  # that of its edges
        entries = _on(metric.rows, gradient, frames)
        if entries is not None:
            return Connection(metric.rows, entries)
    pattern = gradient.sums().stiffness()
    entries = _on(pattern, gradient, frames)
    assert entries is not None  # for the type checker; the pattern has all edges
    return Connection(pattern, entries)


def _on(pattern: CompressedRows, gradient: ElementGradient, frames: Frames) -> FloatArray | None:
    """Return the entries on a pattern, or None if it lacks some."""
    return _native.connection_laplacian(
        pattern.indptr,
        pattern.indices,
        gradient.elements,
        gradient.inverse_frames,
        gradient.measure,
        frames.turns.view(np.float64),
    )


def connection_along_edges(
    diffusion: Discretization, metric: Discretization, frames: Frames
) -> Connection:
    """Return the same along the edges of another diffusion on the same vertices.

    Vectors are turned along an edge as they are through the elements of the metric that have it,
    and by the least rotation of normals where none has. Weights of the wrong sign are left out.

    Parameters
    ----------
    diffusion : Discretization
    metric : Discretization
        Of whose elements the turns are.
    frames : Frames
    """
    gradient, rows = metric.gradient, diffusion.rows
    assert isinstance(gradient, ElementGradient | EdgeGradient)  # others have no frames
    elements = gradient.edges if isinstance(gradient, EdgeGradient) else gradient.elements
    _check_turns(frames, elements.shape)
    turns = frames.turns.view(np.float64)
    sums = _native.edge_turns(rows.indptr, rows.indices, np.ascontiguousarray(elements), turns)
    turn = sums.view(np.complex128)[:, 0]
    i, j = rows.row_of_entry, rows.indices
    missing = np.flatnonzero((np.abs(turn) < ALIKE) & (i != j))
    turn[missing] = frames.least_turns(j[missing], i[missing])
    weights = np.where(i == j, 0.0, np.maximum(-rows.data, 0.0))
    entries = -weights * _unit(turn)
    entries[i == j] = np.bincount(i, weights, rows.shape[0])[i[i == j]]
    return Connection(rows, np.ascontiguousarray(entries).view(np.float64).reshape(-1, 2))


def _check_turns(frames: Frames, shape: tuple[int, ...]) -> None:
    if frames.turns.shape != shape:
        raise InvalidDiscretizationError(
            f"turns {frames.turns.shape} must be one for each corner of the elements, {shape}"
        )


def _unit(numbers: ComplexArray) -> ComplexArray:
    sizes = np.abs(numbers)
    return np.divide(numbers, sizes, out=np.zeros_like(numbers), where=sizes > 0)
