"""The Laplacian of polygon meshes."""

from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias, final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array, eye_array, vstack

import geodesic_toolkit as gt
from geodesic_toolkit.discretization.graph_laplacian import graph_laplacian
from geodesic_toolkit.discretization.heat import Heat
from geodesic_toolkit_polygon.mesh import PolygonMesh

__all__ = ["PolygonGradient", "PolygonLaplacian"]

FloatArray: TypeAlias = NDArray[np.float64]


@final
class PolygonGradient(gt.Gradient):
    """Gradients on the triangles inside polygons, of functions that are given at the corners.

    The value at a vertex inside a polygon is a convex combination of those at its corners.

    Parameters
    ----------
    fine : Gradient
        On triangles of M vertices.
    weights : csr_array of shape (M - N, N), float64
        The further vertices as convex combinations of the N corners, rows of positive entries.
    """

    def __init__(self, fine: gt.Gradient, weights: csr_array) -> None:
        self.fine, self.prolongation = fine, _prolongation(weights)
        self._weights = weights

    @property
    def n_vertices(self) -> int:
        """Number N of corners."""
        return int(self._weights.shape[1])

    def unit(self, log_heat: FloatArray) -> FloatArray:
        """Return ``∇u/|∇u|`` on every triangle, of shape (E, 2) or (E, 2, K)."""
        return self.fine.unit(self._extended(log_heat))

    def adjoint(self, field: FloatArray) -> FloatArray:
        """Return ``Gᵀ W x`` of a field of shape (E, 2) or (E, 2, K)."""
        return np.asarray(self.prolongation.T @ self.fine.adjoint(field))

    def descent_load(self, heat: Heat) -> FloatArray:
        """Return ``Gᵀ W X`` with ``X = -∇u/|∇u|``; on the triangles in one pass."""
        fine = self.fine.descent_load(Heat.of_log(self._extended(heat.log())))
        return np.asarray(self.prolongation.T @ fine)

    def _extended(self, log_heat: FloatArray) -> FloatArray:
        """Return log u with that of the further vertices, where u is a mean, however small."""
        rows = self._weights
        if not rows.shape[0]:
            return log_heat
        corners = log_heat[rows.indices]
        begins = rows.indptr[:-1]
        largest = np.maximum.reduceat(corners, begins, axis=0)
        scale = np.where(largest > -np.inf, largest, 0.0)
        corners -= np.repeat(scale, np.diff(rows.indptr), axis=0)
        shares = rows.data.reshape(-1, *(1,) * (log_heat.ndim - 1))
        means = np.add.reduceat(shares * np.exp(corners), begins, axis=0)
        with np.errstate(divide="ignore"):
            return np.concatenate([log_heat, np.log(means) + scale])

    @property
    def matrix(self) -> csr_array:
        """G of shape (2 E, N)."""
        return csr_array(self.fine.matrix @ self.prolongation)

    @property
    def weights(self) -> FloatArray:
        """The area of each triangle, twice."""
        return self.fine.weights

    def stiffness(self) -> csr_array:
        """Return ``L = Gᵀ W G``, positive semidefinite (L = -Δ), with ``L 1 = 0``."""
        product = coo_array(self.prolongation.T @ self.fine.stiffness() @ self.prolongation)
        rows, columns = product.coords
        above = rows < columns
        return graph_laplacian(
            -product.data[above],
            rows[above].astype(np.int64),
            columns[above].astype(np.int64),
            self.n_vertices,
        )

    def __repr__(self) -> str:
        return f"PolygonGradient({self.fine!r}, {self._weights.shape[0]} vertices inside polygons)"


@final
@dataclass(frozen=True, kw_only=True)
class PolygonLaplacian(gt.LaplaceOperator):
    """Laplacian of a polygon mesh, by a vertex inside each polygon that follows its corners.

    ``L = Pᵀ Lₜ P`` with Lₜ the cotangent Laplacian of the fans about these vertices and P the
    values there: means of those at the corners. L is -Δ, positive semidefinite, and that of linear
    finite elements where all faces are triangles. Refined distances are those along the fans.

    References
    ----------
    A. Bunge, P. Herholz, M. Kazhdan, M. Botsch, *Polygon Laplacian Made Simple*, Computer Graphics
    Forum 39, 2020, https://doi.org/10.1111/cgf.13931

    Examples
    --------
    >>> from geodesic_toolkit_polygon import PolygonLaplacian, PolygonMesh
    >>> square = PolygonMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    >>> PolygonLaplacian().assemble(square).stiffness.toarray()
    array([[ 0.75, -0.25, -0.25, -0.25],
           [-0.25,  0.75, -0.25, -0.25],
           [-0.25, -0.25,  0.75, -0.25],
           [-0.25, -0.25, -0.25,  0.75]])
    """

    domains: ClassVar[tuple[type[gt.Domain], ...]] = (PolygonMesh,)
    references: ClassVar[tuple[str, ...]] = ("10.1111/cgf.13931",)

    def assemble(self, domain: gt.Domain) -> gt.Discretization:
        """Return the discretization of -Δ (positive semidefinite) on a polygon mesh.

        Parameters
        ----------
        domain : PolygonMesh

        Returns
        -------
        Discretization
            With the fans as its `subdivision`. Its notes hold ``split_faces``, the number of faces
            that have no vertex inside, ``dropped_faces`` and ``mollified_by`` (a length).

        Raises
        ------
        UnsupportedDomainError
            Another kind of domain, or one whose faces have no extent.
        """
        self.check_domain(domain)
        assert isinstance(domain, PolygonMesh)  # for the type checker; check_domain has raised
        fine = gt.CotanLaplacian(intrinsic_delaunay="auto").assemble(domain.surface)
        weights, count = domain.weights, domain.n_vertices
        gradient = PolygonGradient(fine.gradient, weights)
        spacing = float(domain.as_graph().lengths.mean())
        parts = np.unique(fine.components[:count], return_inverse=True)[1]
        mass = gradient.prolongation.T @ fine.mass
        return gt.Discretization(
            mass=mass,
            stiffness=gradient.stiffness(),
            gradient=gradient,
            spacing=spacing,
            boundary=fine.boundary[:count],
            scales=np.maximum(
                fine.scales[:count] * (spacing / fine.spacing),
                np.sqrt(_mean_areas(domain, mass, parts))[parts],
            ),
            subdivision=gt.Subdivision(domain.surface, fine, weights),
            known_components=parts,
            notes=self._notes(domain, fine),
            copy=False,
        )

    def _notes(self, domain: PolygonMesh, fine: gt.Discretization) -> dict[str, Any]:
        return {
            "split_faces": int((domain.sizes > 3).sum() - domain.weights.shape[0]),
            "dropped_faces": fine.notes["dropped_faces"],
            "mollified_by": fine.notes["mollified_by"],
        }


def _mean_areas(domain: PolygonMesh, mass: FloatArray, parts: NDArray[np.int64]) -> FloatArray:
    """Return the mean area of the faces of each connected part; 0 where there are none.

    Heat that falls by a factor of e along each edge is not followed across a polygon of many: its
    inside has one value. Plain heat on a square of L shapes of eight corners reads 4.3 % with the
    squared edge as the time step, with 1.4, 2, 3 and 5 times that 3.0, 2.2, 2.1 and 2.5; the area
    of these is 3 times as much, that of a hexagon 2.6 (1.5, 1.3, 1.5, 2.0 and 2.9 %) and that of a
    square once.
    """
    faces = np.bincount(
        parts[domain.corners[np.cumsum(domain.sizes) - 1]], minlength=parts.max() + 1
    )
    return np.asarray(np.bincount(parts, mass) / np.maximum(faces, 1))


def _prolongation(weights: csr_array) -> csr_array:
    """Return the values at all vertices from those at the corners, (M, N)."""
    return csr_array(vstack([eye_array(weights.shape[1], format="csr"), weights], format="csr"))
