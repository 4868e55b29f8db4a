"""Laplace operators on solids: linear elements on tetrahedra, finite volumes on voxels."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np
from numpy.typing import NDArray

import geodesic_toolkit as gt
from geodesic_toolkit.errors import UnsupportedDomainError
from geodesic_toolkit.geometry.frames import Frames
from geodesic_toolkit_volume.checks import check_sizes
from geodesic_toolkit_volume.marching import Integers
from geodesic_toolkit_volume.tet_fronts import TetFronts
from geodesic_toolkit_volume.tet_mesh import TetMesh
from geodesic_toolkit_volume.voxel_fronts import VoxelFronts
from geodesic_toolkit_volume.voxel_image import VoxelImage

__all__ = ["TetLaplacian", "VoxelLaplacian"]

WITHOUT_FRAMES = (
    "a solid has no tangent planes: directions, log maps and transport are for surfaces, such as "
    "gt.TriangleMesh(solid.vertices, solid.triangles)"
)


@final
@dataclass(frozen=True, kw_only=True)
class TetLaplacian(gt.LaplaceOperator):
    """Linear finite elements on tetrahedra; L is -Δ, positive semidefinite, the mass lumped.

    Distances come from fronts that cross the cells (:class:`TetFronts`), and from heat with
    ``refine=False``. Costs are a metric: lengths count ``cost`` times. Cells without volume are
    left out.

    References
    ----------
    M. Botsch et al., *Polygon Mesh Processing*, 2010, and for fronts R. Kimmel, J. A. Sethian,
    *Computing geodesic paths on manifolds*, 1998, https://doi.org/10.1073/pnas.95.15.8431
    """

    domains: ClassVar[tuple[type[gt.Domain], ...]] = (TetMesh,)
    references: ClassVar[tuple[str, ...]] = ("10.1073/pnas.95.15.8431",)

    def assemble(self, domain: gt.Domain) -> gt.Discretization:
        """Return the discretization of -Δ (positive semidefinite) on a solid.

        Raises
        ------
        UnsupportedDomainError
            Another kind of domain, a solid without volume, or one whose width, in lengths or in
            costs, has powers out of the range of floats.
        """
        self.check_domain(domain)
        assert isinstance(domain, TetMesh)  # for the type checker; check_domain has raised
        check_sizes(domain.vertices[np.unique(domain.cells)], domain.costs)
        solid = domain.is_solid
        if not solid.any():
            raise UnsupportedDomainError(f"none of the {len(solid)} cells has a volume")
        cells, costs = domain.cells[solid], domain.costs[solid]
        corners = domain.vertices[cells]
        edges = corners[:, 1:] - corners[:, :1]
        volumes = np.abs(np.linalg.det(edges)) / 6 * costs**3
        rest = np.linalg.inv(edges) / costs[:, None, None]
        coefficients = np.concatenate([-rest.sum(axis=2, keepdims=True), rest], axis=2)
        gradient = gt.ElementGradient(cells, coefficients, volumes, domain.n_vertices, copy=False)
        boundary = np.zeros(domain.n_vertices, dtype=np.bool_)
        boundary[domain.triangles] = True
        shares = np.repeat(volumes / 4, 4)
        mass = np.bincount(cells.ravel(), shares, domain.n_vertices).astype(np.float64)
        used = TetMesh(domain.vertices, cells, costs)
        return gt.Discretization(
            mass=mass,
            stiffness=gradient.stiffness(),
            gradient=gradient,
            spacing=float(used.as_graph().lengths.mean()),
            boundary=boundary,
            fronts=TetFronts(used.vertices, used.cells, used.costs),
            notes={"flat_cells": int((~solid).sum())},
        )

    def frames(self, domain: gt.Domain, metric: gt.Discretization) -> Frames:  # noqa: ARG002
        """Raise an `UnsupportedDomainError`: tangent planes belong to surfaces."""
        raise UnsupportedDomainError(WITHOUT_FRAMES)


@final
@dataclass(frozen=True, kw_only=True)
class VoxelLaplacian(gt.LaplaceOperator):
    """Finite volumes on voxels, of seven points; L is -Δ, positive semidefinite.

    Distances come from fronts that cross the voxels (:class:`VoxelFronts`), and from heat with
    ``refine=False``. Costs are a metric: lengths count ``cost`` times.

    References
    ----------
    J. A. Sethian, *A fast marching level set method for monotonically advancing fronts*, 1996,
    https://doi.org/10.1073/pnas.93.4.1591
    """

    domains: ClassVar[tuple[type[gt.Domain], ...]] = (VoxelImage,)
    references: ClassVar[tuple[str, ...]] = ("10.1073/pnas.93.4.1591",)

    def assemble(self, domain: gt.Domain) -> gt.Discretization:
        """Return the discretization of -Δ (positive semidefinite) on an image.

        Raises
        ------
        UnsupportedDomainError
            Another kind of domain, an image in which no voxels are neighbours, or voxels whose
            sides, in lengths or in costs, have powers out of the range of floats.
        """
        self.check_domain(domain)
        assert isinstance(domain, VoxelImage)  # for the type checker; check_domain has raised
        own = np.ones(1) if domain.costs is None else domain.costs[domain.mask]
        check_sizes(np.diag(domain.spacing), own)
        edges, axes = domain.edges
        if not len(edges):
            raise UnsupportedDomainError("no two voxels of the body are neighbours along an axis")
        count, costs = domain.n_vertices, domain.edge_costs(edges)
        dim = len(np.unique(axes))
        steps, volume = np.array(domain.spacing), float(np.prod(domain.spacing))
        if dim < 3:  # of a sheet or a line its area or length
            volume = float(np.prod(steps[np.unique(axes)]))
        lengths = steps[axes] * costs
        weights = costs**dim * volume / lengths**2
        sums = np.bincount(edges.ravel(), np.repeat(weights * lengths**2, 2), count)
        neighbours = np.bincount(edges.ravel(), minlength=count)
        mass = sums / (2 * dim)  # for which |∇u| is a slope, at the rim as well
        gradient = gt.EdgeGradient(edges, weights, mass.copy(), copy=False)
        return gt.Discretization(
            mass=mass,
            stiffness=gradient.stiffness(),
            gradient=gradient,
            spacing=float(lengths.mean()),
            boundary=_rim(neighbours, dim),
            fronts=VoxelFronts(domain.mask, domain.spacing, domain.costs),
            copy=False,
        )

    def frames(self, domain: gt.Domain, metric: gt.Discretization) -> Frames:  # noqa: ARG002
        """Raise an `UnsupportedDomainError`: tangent planes belong to surfaces."""
        raise UnsupportedDomainError(WITHOUT_FRAMES)


def _rim(neighbours: Integers, dim: int) -> NDArray[np.bool_]:
    """Return a mask of voxels that lack a neighbour along an axis."""
    return (neighbours > 0) & (neighbours < 2 * dim)
