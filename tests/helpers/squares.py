"""A kind of domain whose elements are not triangles, with a vertex inside each: squares."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np
from scipy.sparse import csr_array

import geodesic_toolkit as gt
from geodesic_toolkit.core.frozen import freeze

__all__ = ["Squares", "SquaresLaplacian"]


@final
class Squares(gt.Domain):
    """The unit square as n x n squares, split along diagonals for pictures and places."""

    def __init__(self, n):
        self.n = n
        x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
        self._places = freeze(np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]))
        number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
        ring = (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
        self.corners = freeze(np.column_stack([corner.ravel() for corner in ring]))

    @property
    def n_vertices(self):
        return len(self._places)

    @property
    def positions(self):
        return self._places

    @property
    def polygons(self):
        return freeze(np.full(len(self.corners), 4)), freeze(self.corners.ravel().copy())

    @property
    def triangles(self):
        return freeze(self.corners[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3))

    @classmethod
    def from_file(cls, path):
        return cls(int(path.read_text()))


@final
@dataclass(frozen=True, kw_only=True)
class SquaresLaplacian(gt.LaplaceOperator):
    """Heat on the triangles of diagonals, fronts on fans: L = -Δ, positive semidefinite."""

    domains: ClassVar = (Squares,)

    def assemble(self, domain):
        self.check_domain(domain)
        heat = gt.CotanLaplacian().assemble(gt.TriangleMesh(domain.positions, domain.triangles))
        return gt.Discretization(
            mass=heat.mass,
            stiffness=heat.stiffness,
            gradient=heat.gradient,
            spacing=heat.spacing,
            boundary=heat.boundary,
            subdivision=self.fans(domain),
        )

    def fans(self, domain):
        count, squares = domain.n_vertices, domain.corners
        middles = np.broadcast_to(count + np.arange(len(squares))[:, None], squares.shape)
        fans = np.stack([squares, np.roll(squares, -1, axis=1), middles], axis=2).reshape(-1, 3)
        entries = np.full(squares.size, 0.25), squares.ravel(), 4 * np.arange(len(squares) + 1)
        weights = csr_array(entries, shape=(len(squares), count))
        places = np.concatenate([domain.positions, weights @ domain.positions])
        mesh = gt.TriangleMesh(places, fans)
        return gt.Subdivision(mesh, gt.CotanLaplacian().assemble(mesh), weights)
