"""An operator for geodesic-toolkit: the Gaussian-kernel Laplacian of a point cloud."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np
from scipy.spatial import KDTree

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError

__all__ = ["KernelLaplacian"]


@final
@dataclass(frozen=True, kw_only=True)
class KernelLaplacian(gt.LaplaceOperator):
    """Graph Laplacian of the nearest neighbours of a point cloud, weighted by a Gaussian kernel.

    ``L = D - W`` (that is -Δ, positive semidefinite) with ``w = exp(-ℓ² / 2σ²)`` on an edge of
    length ℓ, and ``m_i = Σ_j w_ij ℓ_ij² / (2 dim)``, for which |∇u| is a slope.

    Parameters
    ----------
    k : int
        Neighbours of a point; all the others where there are fewer.
    width : float
        Width σ of the kernel, in mean edge lengths.
    dim : int
        Dimension of what the points sample: 2 for a surface.

    Raises
    ------
    InvalidOptionError
        An option that is not positive.

    References
    ----------
    M. Belkin, P. Niyogi, *Laplacian Eigenmaps for Dimensionality Reduction and Data
    Representation*, 2003, https://doi.org/10.1162/089976603321780317
    """

    k: int = 12
    width: float = 0.7
    dim: int = 2

    domains: ClassVar[tuple[type[gt.Domain], ...]] = (gt.PointCloud,)
    references: ClassVar[tuple[str, ...]] = ("10.1162/089976603321780317",)

    def __post_init__(self) -> None:
        for option in ("k", "width", "dim"):
            if not getattr(self, option) > 0:
                raise InvalidOptionError(
                    f"{option} must be positive, not {getattr(self, option)!r}"
                )

    def assemble(self, domain: gt.Domain) -> gt.Discretization:
        """Return the discretization of -Δ (positive semidefinite) on a point cloud.

        Missing points are connected to nothing; a duplicate hangs on the point that it repeats.
        """
        self.check_domain(domain)
        assert isinstance(domain, gt.PointCloud)  # for the type checker; check_domain has raised
        present = np.flatnonzero(domain.present)
        places, first, place = np.unique(
            domain.points[present], axis=0, return_index=True, return_inverse=True
        )
        if len(places) < 2:
            raise UnsupportedDomainError("all points of the cloud are one place: it has no edges")

        nearest = KDTree(places).query(places, min(self.k + 1, len(places)))
        distances, neighbours = map(np.asarray, nearest)
        here = np.repeat(np.arange(len(places)), neighbours.shape[1] - 1)
        pairs = np.sort(np.column_stack([here, neighbours[:, 1:].ravel()]), axis=1)
        pairs, index = np.unique(pairs, axis=0, return_index=True)
        lengths = distances[:, 1:].ravel()[index]
        spacing = float(lengths.mean())

        original = present[first[place.ravel()]]
        repeats = original != present
        edges = np.concatenate(
            [present[first[pairs]], np.column_stack([original, present])[repeats]]
        )
        lengths = np.append(lengths, np.zeros(repeats.sum()))
        weights = np.exp(-((lengths / (self.width * spacing)) ** 2) / 2)
        shares = np.repeat(weights * lengths**2, 2)
        mass = np.bincount(edges.ravel(), shares, domain.n_vertices) / (2 * self.dim)

        gradient = gt.EdgeGradient(edges, weights, mass)
        return gt.Discretization(
            mass=mass,
            stiffness=gradient.stiffness(),
            gradient=gradient,
            spacing=spacing,
            boundary=np.zeros(domain.n_vertices, dtype=np.bool_),
        )
