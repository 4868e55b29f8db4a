"""Robust Laplacians of triangle meshes and point clouds, by way of robust-laplacian."""

from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias, final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError

__all__ = ["RobustLaplacian"]

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]

FEWEST_POINTS = 4
"""Points that a neighbourhood needs to have an inside; with fewer the library finds no triangle."""


@final
@dataclass(frozen=True, kw_only=True)
class RobustLaplacian(gt.LaplaceOperator):
    """Intrinsic Delaunay Laplacian of the tufted cover of a mesh, or of a point cloud.

    The cover glues two copies of every face into a surface without boundary and without
    non-manifold edges, whatever the mesh was; its intrinsic Delaunay triangulation has no negative
    weight. So ``L = D - W`` (that is -Δ, positive semidefinite) with W >= 0: heat is positive on
    meshes that are non-manifold, sliver-ridden or both. That makes it a good *diffusion* of
    another metric, ``GeodesicSolver(mesh, diffusion="robust")``; as a metric of its own it knows
    edges, not triangles, and its gradient is the less accurate one of graphs.

    Parameters
    ----------
    mollify_factor : float
        Length added to the sides of triangles to keep them from degenerating, relative to their
        mean; 0 for none.
    n_neighbors : int
        Neighbours of a point of a cloud; all the others where there are fewer.

    Raises
    ------
    InvalidOptionError
        A negative or non-finite factor, fewer than three neighbours.

    References
    ----------
    N. Sharp, K. Crane, *A Laplacian for Nonmanifold Triangle Meshes*, Computer Graphics Forum 39,
    2020, https://doi.org/10.1111/cgf.14069

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit_robust import RobustLaplacian
    >>> book = gt.TriangleMesh(  # three pages on one spine
    ...     [[0, 0, 0], [0, 0, 1], [1, 0, 0], [-1, 1, 0], [-1, -1, 0]],
    ...     [[0, 1, 2], [0, 1, 3], [0, 1, 4]],
    ... )
    >>> gt.GeodesicSolver(book, diffusion=RobustLaplacian()).diagnosis.non_positive
    0
    """

    mollify_factor: float = 1e-5
    n_neighbors: int = 30

    domains: ClassVar[tuple[type[gt.Domain], ...]] = (gt.TriangleMesh, gt.PointCloud)
    references: ClassVar[tuple[str, ...]] = ("10.1111/cgf.14069",)

    def __post_init__(self) -> None:
        if not 0 <= self.mollify_factor < np.inf:
            raise InvalidOptionError(
                f"mollify_factor must be a length in mean edges, not {self.mollify_factor!r}"
            )
        if self.n_neighbors < FEWEST_POINTS - 1:
            raise InvalidOptionError(f"n_neighbors must be 3 or more, not {self.n_neighbors!r}")

    def assemble(self, domain: gt.Domain) -> gt.Discretization:
        """Return the discretization of -Δ (positive semidefinite) on a mesh or a cloud.

        Parameters
        ----------
        domain : TriangleMesh or PointCloud
            Faces that repeat a vertex are left out, as are missing points and unreferenced
            vertices, which are connected to nothing.

        Returns
        -------
        Discretization
            Its notes hold ``clipped_weight``, the largest negative weight that rounding left and
            that was set to 0, relative to the largest weight.

        Raises
        ------
        UnsupportedDomainError
            Another kind of domain, a mesh without a face of three different places, a cloud of
            fewer than four points or of points on one line.
        """
        self.check_domain(domain)
        if isinstance(domain, gt.TriangleMesh):
            return self._assemble_mesh(domain)
        assert isinstance(domain, gt.PointCloud)  # for the type checker; check_domain has raised
        return self._assemble_cloud(domain)

    def _assemble_mesh(self, mesh: gt.TriangleMesh) -> gt.Discretization:
        from robust_laplacian import mesh_laplacian

        a, b, c = mesh.faces.T
        proper = (a != b) & (b != c) & (c != a)
        # Front and back of one face are one: the edges of a surface given twice have four faces.
        _, first = np.unique(np.sort(mesh.faces, axis=1), axis=0, return_index=True)
        faces = mesh.faces[np.intersect1d(first, np.flatnonzero(proper))]
        sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        edges, face_counts = np.unique(sides, axis=0, return_counts=True)
        lengths = _lengths(mesh.vertices, edges)
        if not lengths.any():
            raise UnsupportedDomainError(
                "all corners of every face are at one position; the mesh has zero area"
            )
        # The library gives unreferenced vertices invalid weights: pass the others only.
        used, compact = np.unique(faces, return_inverse=True)
        laplacian, mass = mesh_laplacian(
            mesh.vertices[used], compact.reshape(-1, 3), mollify_factor=self.mollify_factor
        )
        boundary = np.zeros(mesh.n_vertices, dtype=np.bool_)
        boundary[edges[face_counts == 1]] = True
        return _discretization(
            laplacian,
            mass,
            mesh.vertices,
            used=used,
            boundary=boundary,
            spacing=float(lengths.mean()),
        )

    def _assemble_cloud(self, cloud: gt.PointCloud) -> gt.Discretization:
        from robust_laplacian import point_cloud_laplacian

        used = np.flatnonzero(cloud.present)
        if len(used) < FEWEST_POINTS:
            raise UnsupportedDomainError(
                f"the cloud has {len(used)} points; its triangles need {FEWEST_POINTS} at least"
            )
        points = cloud.points[used]
        # The library's local triangulations depend on where the origin lies: put it in the middle.
        points = points - points.mean(axis=0)
        try:
            laplacian, mass = point_cloud_laplacian(
                points,
                mollify_factor=self.mollify_factor,
                n_neighbors=min(self.n_neighbors, len(used) - 1),
            )
        except RuntimeError as error:
            raise UnsupportedDomainError(
                f"robust-laplacian finds no triangles about some points ({error}): points on one "
                "line, or more copies of one point than it has neighbours; remove them, or raise "
                "n_neighbors"
            ) from error
        edges, weights, _ = _edges(laplacian)
        lengths = _lengths(points, edges[weights > 0])
        boundary = np.zeros(cloud.n_vertices, dtype=np.bool_)
        return _discretization(
            laplacian,
            mass,
            cloud.points,
            used=used,
            boundary=boundary,
            spacing=float(lengths.mean()),
        )


def _discretization(
    laplacian: Any,
    mass: Any,
    points: FloatArray,
    *,
    used: IntArray,
    boundary: NDArray[np.bool_],
    spacing: float,
) -> gt.Discretization:
    """Return ``(L, M)`` of the vertices in use as the discretization of all."""
    edges, weights, clipped = _edges(laplacian)
    edges = used[edges]
    vertex_mass = np.zeros(len(boundary))
    vertex_mass[used] = mass.diagonal()
    # Slopes are pooled over Σ_j w ℓ² / 4, the area that follows from the edges at a vertex: a
    # third of its triangles differs from it where their valences do.
    energy = np.repeat(weights * _lengths(points, edges) ** 2, 2)
    pooled = np.bincount(edges.ravel(), energy, minlength=len(boundary)) / 4
    gradient = gt.EdgeGradient(edges, weights, pooled, copy=False)
    return gt.Discretization(
        mass=vertex_mass,
        stiffness=gradient.stiffness(),
        gradient=gradient,
        spacing=spacing,
        boundary=boundary,
        notes={"clipped_weight": clipped},
        copy=False,
    )


def _edges(laplacian: Any) -> tuple[IntArray, FloatArray, float]:
    """Return the edges of ``L = D - W``, their weights, and how much was clipped to make W >= 0."""
    lower = coo_array(laplacian)
    row, column = lower.coords
    below = row > column
    weights = -lower.data[below]
    if not np.isfinite(weights).all():
        raise UnsupportedDomainError(
            "robust-laplacian's weights are not finite: the shape has triangles too thin for it; "
            "raise mollify_factor"
        )
    largest = float(weights.max(initial=0.0))
    clipped = max(0.0, float(-weights.min() / largest)) if largest else 0.0
    edges = np.column_stack([column[below], row[below]]).astype(np.int64)
    return edges, np.maximum(weights, 0.0), clipped


def _lengths(points: FloatArray, edges: IntArray) -> FloatArray:
    steps = points[edges[:, 0]] - points[edges[:, 1]]
    return np.sqrt(np.einsum("ed,ed->e", steps, steps))
