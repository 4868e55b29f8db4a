"""A kind of domain that the core does not have, as a plugin would bring it: tetrahedra."""

from dataclasses import dataclass
from itertools import permutations
from typing import ClassVar, final

import numpy as np

import geodesic_toolkit as gt
from geodesic_toolkit.core.frozen import freeze
from geodesic_toolkit.domains.base import as_floats, as_indices, check_indices
from geodesic_toolkit.errors import InvalidOptionError
from geodesic_toolkit.geometry.closest import TriangleTree

__all__ = ["Bare", "BareLaplacian", "Solid", "SolidLaplacian", "cube"]

FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])
"""Corners of a tetrahedron, face by face."""

INSIDE = -1e-12
"""Barycentric weight down to which a place is in a tetrahedron."""


@final
class Solid(gt.Domain):
    """Tetrahedra in space, with everything that a kind of domain may bring."""

    vertex_name: ClassVar[str] = "corner"

    def __init__(self, vertices, cells):
        self._vertices = freeze(as_floats(vertices, "vertices", (None, 3)))
        self.cells = freeze(as_indices(cells, "cells", "cell", (None, 4)))
        check_indices(self.cells, len(self._vertices), "cell")

    @property
    def n_vertices(self):
        return len(self._vertices)

    @property
    def positions(self):
        return self._vertices

    @property
    def triangles(self):
        """The faces that one tetrahedron has."""
        faces = self.cells[:, FACES].reshape(-1, 3)
        _, first, count = np.unique(
            np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
        )
        return freeze(faces[first[count == 1]])

    def as_graph(self):
        pairs = self.cells[:, [0, 1, 0, 2, 0, 3, 1, 2, 1, 3, 2, 3]].reshape(-1, 2)
        edges = np.unique(np.sort(pairs, axis=1), axis=0)
        steps = self.positions[edges[:, 1]] - self.positions[edges[:, 0]]
        return gt.Graph(self.n_vertices, edges, np.linalg.norm(steps, axis=1))

    def without(self, mask):
        cells = self.cells[~mask[self.cells].any(axis=1)]
        if not len(cells):
            raise InvalidOptionError("the mask leaves no tetrahedron")
        return Solid(self._vertices, cells)

    def closest(self, points):
        corners = self.positions[self.cells]
        across = np.linalg.inv((corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1))
        three = np.einsum("tij,qtj->qti", across, points[:, None] - corners[:, 0])
        weights = np.concatenate([1 - three.sum(axis=2, keepdims=True), three], axis=2)
        cell = weights.min(axis=2).argmax(axis=1)
        found = weights[np.arange(len(points)), cell]
        vertices = self.cells[cell]
        outside = found.min(axis=1) < INSIDE
        if outside.any():
            faces = self.triangles
            face, on = TriangleTree(self.positions, faces).closest(points[outside])
            vertices[outside] = np.column_stack([faces[face], faces[face][:, 0]])
            found[outside] = np.column_stack([on, np.zeros(len(on))])
        found = np.maximum(found, 0.0)
        return gt.Located(vertices, found / found.sum(axis=1, keepdims=True))

    @classmethod
    def samples(cls):
        return gt.testing.DomainSamples(
            kind=Solid,
            families=([_cube_sample(n) for n in (5, 9)],),
            generic=_lumpy(),
            permuted=lambda s, order: Solid(s.positions[order], np.argsort(order)[s.cells]),
            united=_united,
            isolated=lambda s: Solid(np.vstack([s.positions, [[0.1, 0.2, 0.3]]]), s.cells),
            moved=lambda s, rotation, shift: Solid(s.positions @ rotation.T + shift, s.cells),
            scaled=lambda s, factor: Solid(factor * s.positions, s.cells),
            degenerate=(Solid(np.vstack([np.zeros(3), np.eye(3)]), [[0, 1, 2, 3]]),),
        )

    def __repr__(self):
        return f"Solid({self.n_vertices} corners, {len(self.cells)} tetrahedra)"


@final
@dataclass(frozen=True, kw_only=True)
class SolidLaplacian(gt.LaplaceOperator):
    """Linear finite elements on tetrahedra: L = -Δ, positive semidefinite."""

    domains: ClassVar = (Solid,)
    references: ClassVar = ("10.1145/2516971.2516977",)

    def assemble(self, domain):
        self.check_domain(domain)
        corners = domain.positions[domain.cells]
        steps = corners[:, 1:] - corners[:, :1]
        three = np.linalg.inv(steps)
        coefficients = np.concatenate([-three.sum(axis=2, keepdims=True), three], axis=2)
        volume = np.abs(np.linalg.det(steps)) / 6
        gradient = gt.ElementGradient(domain.cells, coefficients, volume, domain.n_vertices)
        on_boundary = np.zeros(domain.n_vertices, dtype=bool)
        on_boundary[domain.triangles] = True
        shares = np.repeat(volume / 4, 4)
        return gt.Discretization(
            mass=np.bincount(domain.cells.ravel(), shares, domain.n_vertices),
            stiffness=gradient.stiffness(),
            gradient=gradient,
            spacing=float(domain.as_graph().lengths.mean()),
            boundary=on_boundary,
        )


@final
class Bare(gt.Domain):
    """Vertices along a line, and not one of the things that a kind of domain may bring."""

    def __init__(self, count=12):
        self._count = count

    @property
    def n_vertices(self):
        return self._count


@final
@dataclass(frozen=True, kw_only=True)
class BareLaplacian(gt.LaplaceOperator):
    """The Laplacian of a path whose edges have the length 1."""

    domains: ClassVar = (Bare,)

    def assemble(self, domain):
        self.check_domain(domain)
        steps = np.arange(domain.n_vertices)
        edges = np.column_stack([steps[:-1], steps[1:]])
        return gt.UniformLaplacian(dim=1).assemble(gt.Graph(domain.n_vertices, edges))


def cube(n):
    """Return the unit cube, n vertices a side, six tetrahedra around a diagonal of each cell."""
    index = np.arange(n**3).reshape(n, n, n)
    low = index[:-1, :-1, :-1].ravel()
    strides = (n * n, n, 1)
    cells = [
        np.column_stack([low, low + a, low + a + b, low + a + b + c])
        for a, b, c in permutations(strides)
    ]
    side = np.linspace(0, 1, n)
    vertices = np.stack(np.meshgrid(side, side, side, indexing="ij"), axis=-1).reshape(-1, 3)
    return Solid(vertices, np.concatenate(cells))


def _cube_sample(n):
    solid = cube(n)
    positions = solid.positions
    source = int(np.abs(positions - 0.5).sum(axis=1).argmin())
    return gt.testing.Sample(
        name=f"cube, {n} a side",
        domain=solid,
        dim=3,
        positions=positions,
        source=source,
        distance=np.linalg.norm(positions - positions[source], axis=1),
        spacing=float(solid.as_graph().lengths.mean()),
        measure=1.0,
        error=0.12,
        inner=np.abs(positions - 0.5).max(axis=1) < 0.3,
    )


def _lumpy():
    solid = cube(5)
    x, y, z = solid.positions.T
    bent = [x + 0.1 * np.sin(2 * y + z), 0.9 * y + 0.1 * z * x, 0.8 * z + 0.05 * np.cos(3 * x + y)]
    return Solid(np.column_stack(bent), solid.cells)


def _united(first, second):
    beside = second.positions + np.array([10.0, 0.0, 0.0])
    cells = np.concatenate([first.cells, second.cells + first.n_vertices])
    return Solid(np.concatenate([first.positions, beside]), cells)
