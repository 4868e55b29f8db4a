"""Triangles with further vertices, of a shape whose own elements are not triangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from geodesic_toolkit.core.frozen import FrozenArrays, freeze_csr
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.errors import InvalidDiscretizationError

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from geodesic_toolkit.discretization.data import Discretization

__all__ = ["Subdivision"]

ROUNDING = 1e-9
"""Largest rounding error of a sum of weights, which should be 1."""


@final
@dataclass(frozen=True, eq=False, repr=False)
class Subdivision(FrozenArrays):
    """The surface of a domain of N vertices as triangles in M >= N: the further ones come last.

    Refinement sweeps fronts over these triangles, and returns the distances of the first N
    vertices. For elements that are not triangles, such as polygons with a vertex inside each.

    Parameters
    ----------
    mesh : TriangleMesh
        Its first N vertices are those of the domain.
    metric : Discretization
        That of the mesh, on triangles.
    weights : csr_array of shape (M - N, N), float64
        The place of each further vertex as a convex combination of vertices of its element: rows
        of positive entries with sum 1.

    Raises
    ------
    InvalidDiscretizationError
        Shapes that do not fit, weights that are not convex.

    Examples
    --------
    A square as one face, with a vertex in its middle:

    >>> import scipy.sparse
    >>> import geodesic_toolkit as gt
    >>> places = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 0]]
    >>> mesh = gt.TriangleMesh(places, [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    >>> weights = scipy.sparse.csr_array([[0.25] * 4])
    >>> gt.Subdivision(mesh, gt.CotanLaplacian().assemble(mesh), weights)
    Subdivision(4 triangles, 1 vertex beside 4)
    """

    mesh: TriangleMesh
    metric: Discretization
    weights: csr_array

    def __post_init__(self) -> None:
        weights, count = freeze_csr(self.weights.copy()), self.mesh.n_vertices
        self._set(weights=weights)
        further, own = weights.shape
        if further + own != count or self.metric.n_vertices != count:
            raise InvalidDiscretizationError(
                f"a subdivision needs as many vertices, {count}, in the metric, which has "
                f"{self.metric.n_vertices}, and in the weights, {further} + {own}"
            )
        sums = weights @ np.ones(own)
        good = np.abs(sums - 1) <= ROUNDING
        if not good.all():
            bad = int(good.argmin())
            raise InvalidDiscretizationError(
                f"the weights of further vertex {bad} have the sum {sums[bad]}, not 1"
            )
        if not (weights.data > 0).all():
            row = int(np.searchsorted(weights.indptr, (weights.data > 0).argmin(), "right")) - 1
            raise InvalidDiscretizationError(
                f"the weights of further vertex {row} must be positive, and finite"
            )

    @property
    def n_vertices(self) -> int:
        """Number N of vertices of the domain itself."""
        return int(self.weights.shape[1])

    def extended(self, values: FloatArray) -> FloatArray:
        """Return values at the vertices of the domain with those at the further ones behind.

        Parameters
        ----------
        values : ndarray of shape (N,) or (N, K), float64

        Returns
        -------
        ndarray of shape (M,) or (M, K), float64
            Further ones are convex combinations; ``-inf`` where one of their values is.
        """
        return np.concatenate([values, self.weights @ values])

    def __repr__(self) -> str:
        further, own = self.weights.shape
        plural = "vertex" if further == 1 else "vertices"
        return f"Subdivision({self.mesh.n_faces} triangles, {further} {plural} beside {own})"
