"""Gradients along the edges of a graph."""

from __future__ import annotations

from dataclasses import InitVar, dataclass, field
from typing import TYPE_CHECKING, final

import numpy as np

from geodesic_toolkit.core.checks import check_finite, check_range, coerce
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.discretization.gradient import MIN_RELATIVE_SLOPE, Gradient, as_columns
from geodesic_toolkit.discretization.graph_laplacian import graph_laplacian
from geodesic_toolkit.errors import InvalidDiscretizationError

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["EdgeGradient"]


@final
@dataclass(frozen=True, eq=False, repr=False)
class EdgeGradient(Gradient):
    """Gradients that are differences along edges, for graphs and any Laplacian of weights >= 0.

    ``(Gu)_e = u_j - u_i`` for the edge e = (i, j), and ``L = Gᵀ W G`` is the graph Laplacian
    ``D - W``. The length of a gradient is averaged at the vertices, by the carré du champ ``|∇u|²_i
    = (1 / 2 m_i) Σ_j w_ij (u_j - u_i)²``, and a difference along an edge is divided by the mean at
    its two ends: to normalise each edge by itself would give the taxicab distance.

    Parameters
    ----------
    edges : ndarray of shape (E, 2), int64
    edge_weights : ndarray of shape (E,), float64
        Non-negative. Together with `measure` they set the scale of distance.
    measure : ndarray of shape (N,), float64
        The mass of every vertex, non-negative.
    copy : bool
        False transfers the arrays: they become read-only instead of being copied.

    Raises
    ------
    InvalidDiscretizationError
        Shapes that do not fit, indices out of range, values that are not finite or negative.

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.discretization.edge_gradient import EdgeGradient
    >>> path = EdgeGradient(np.array([[0, 1], [1, 2]]), np.ones(2), np.array([0.5, 1.0, 0.5]))
    >>> path.unit(np.array([0.0, -1.0, -2.0]))
    array([-1., -1.])
    """

    edges: IntArray
    edge_weights: FloatArray
    measure: FloatArray
    copy: InitVar[bool] = field(default=True, kw_only=True)

    def __post_init__(self, copy: bool) -> None:
        coerce(self, copy=copy, edges=np.int64, edge_weights=np.float64, measure=np.float64)
        if self.edges.ndim != 2 or self.edges.shape != (len(self.edge_weights), 2):
            raise InvalidDiscretizationError(
                f"edges {self.edges.shape} and weights {self.edge_weights.shape} "
                "must be (E, 2) and (E,)"
            )
        check_range(self.edges, self.n_vertices, "edge")
        for values, name in ((self.edge_weights, "edge weight"), (self.measure, "measure")):
            check_finite(values, name)
            if values.size and values.min() < 0:
                bad = int(values.argmin())
                raise InvalidDiscretizationError(
                    f"{name} {bad} is {values[bad]}: an EdgeGradient needs non-negative values; "
                    "a Laplacian with negative weights needs elements (ElementGradient)"
                )

    @property
    def n_vertices(self) -> int:
        """Number N of vertices."""
        return len(self.measure)

    def unit(self, log_heat: FloatArray) -> FloatArray:
        """Return ``∇log u/|∇log u|`` along every edge, of shape (E,) or (E, K).

        The logarithm has the same direction in the smooth limit and is far more accurate across an
        edge, over which u itself falls by a factor of about e. The result is zero on an edge with
        an end without heat.
        """
        start, end = self.edges.T
        with np.errstate(invalid="ignore"):
            slope = log_heat[end] - log_heat[start]
        slope[~np.isfinite(slope) | (np.abs(slope) < MIN_RELATIVE_SLOPE)] = 0.0
        length = self._length(slope)
        pooled = (length[start] + length[end]) / 2
        direction: FloatArray = np.zeros_like(slope)
        np.divide(slope, pooled, out=direction, where=pooled > 0)
        return direction

    def _length(self, slope: FloatArray) -> FloatArray:
        """Return ``|∇u|`` at the vertices by the carré du champ."""
        columns = as_columns(slope, 1)
        squared = np.empty((self.n_vertices, columns.shape[1]))
        for k in range(columns.shape[1]):
            energy = self.edge_weights * columns[:, k] ** 2
            for end in range(2):
                share = np.bincount(self.edges[:, end], energy, minlength=self.n_vertices)
                squared[:, k] = share if end == 0 else squared[:, k] + share
        mass = 2 * self.measure[:, None]
        np.divide(squared, mass, out=squared, where=mass > 0)
        length: FloatArray = np.sqrt(squared).reshape(self.n_vertices, *slope.shape[1:])
        return length

    def adjoint(self, field: FloatArray) -> FloatArray:
        """Return ``Gᵀ W x`` of a field of shape (E,) or (E, K)."""
        columns = as_columns(field, 1)
        result = np.empty((self.n_vertices, columns.shape[1]))
        for k in range(columns.shape[1]):
            flux = self.edge_weights * columns[:, k]
            result[:, k] = np.bincount(self.edges[:, 1], flux, minlength=self.n_vertices)
            result[:, k] -= np.bincount(self.edges[:, 0], flux, minlength=self.n_vertices)
        return result.reshape(self.n_vertices, *field.shape[1:])

    @property
    def matrix(self) -> csr_array:
        """G of shape (E, N): -1 at the start of an edge and +1 at its end."""
        from scipy.sparse import coo_array, csr_array

        count = len(self.edges)
        rows = np.repeat(np.arange(count), 2)
        signs = np.tile([-1.0, 1.0], count)
        return csr_array(
            coo_array((signs, (rows, self.edges.ravel())), shape=(count, self.n_vertices))
        )

    @property
    def weights(self) -> FloatArray:
        """The edge weights."""
        return self.edge_weights

    def stiffness(self) -> csr_array:
        """Return the graph Laplacian ``L = D - W``."""
        start, end = self.edges.T
        return graph_laplacian(self.edge_weights, start, end, self.n_vertices)

    def __repr__(self) -> str:
        return f"EdgeGradient({len(self.edges)} edges)"
