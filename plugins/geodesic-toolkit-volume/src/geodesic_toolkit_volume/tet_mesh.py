"""Tetrahedral meshes as a kind of domain."""

from __future__ import annotations

from functools import cached_property
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

import geodesic_toolkit as gt
from geodesic_toolkit.domains.base import as_floats, as_indices, check_indices, first_bad_row
from geodesic_toolkit.errors import InvalidDomainError, InvalidOptionError
from geodesic_toolkit.sources.ground import Ground
from geodesic_toolkit_volume.checks import costs_of
from geodesic_toolkit_volume.marching import Floats, Integers

__all__ = ["TetMesh"]

EDGES = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])
"""The edges of a cell, by its corners."""

FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])
"""Its faces, opposite to each corner, from outside if its volume is positive."""

INSIDE = 1e-9
"""Smallest barycentric coordinate of a point that counts as inside, below 0 for rounding."""

CELLS_BY_CENTRES = 16
"""Cells by the distance of their centres that may contain a point, before all cells are asked."""


@final
class TetMesh(gt.Domain):
    """A solid made of tetrahedra.

    Parameters
    ----------
    vertices : array-like of shape (N, 3)
        Positions. Vertices without cells may be NaN or infinite.
    cells : array-like of shape (C, 4)
        Four vertex indices a tetrahedron, from 0, in any orientation.
    costs : array-like of shape (C,), optional
        The cost of a unit of length in each cell (its slowness), positive; 1 by default. Distances
        are then the least cost: ``|∇φ| = cost``.

    Attributes
    ----------
    vertices : ndarray of shape (N, 3), float64, read-only
    cells : ndarray of shape (C, 4), int64, read-only
    costs : ndarray of shape (C,), float64, read-only

    Raises
    ------
    InvalidDomainError
        Wrong shapes, a cell that refers to a vertex that is not there or is not finite, costs that
        are not positive and finite. The message names the first offender.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit_volume import TetMesh
    >>> corner = TetMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3]])
    >>> gt.GeodesicSolver(corner).distance(0)
    array([0., 1., 1., 1.])
    """

    vertices: Floats
    cells: Integers
    costs: Floats

    def __init__(
        self, vertices: ArrayLike, cells: ArrayLike, costs: ArrayLike | None = None
    ) -> None:
        places = as_floats(vertices, "vertices", (None, 3))
        corners = as_indices(cells, "cells", "cell", (None, 4))
        if not len(places):
            raise InvalidDomainError("there are no vertices")
        check_indices(corners, len(places), "cell")
        cell = first_bad_row(np.isfinite(places[corners]))
        if cell is not None:
            bad = next(vertex for vertex in corners[cell] if not np.isfinite(places[vertex]).all())
            raise InvalidDomainError(
                f"vertex {bad} is not finite: {places[bad].tolist()}; cell {cell} refers to it. "
                "Remove such cells: cells[numpy.isfinite(vertices[cells]).all(axis=(1, 2))]"
            )
        self._set(vertices=places, cells=corners, costs=costs_of(costs, (len(corners),), "cell"))

    @property
    def n_vertices(self) -> int:
        """Number of vertices, those of no cell among them."""
        return len(self.vertices)

    @property
    def positions(self) -> Floats:
        """Positions of the vertices, of shape (N, 3)."""
        return self.vertices

    @property
    def measured_in_space(self) -> bool:
        """True without costs: distances are lengths."""
        return bool((self.costs == 1).all())

    @cached_property
    def triangles(self) -> Integers:
        """The surface of the solid, (F, 3): faces of one cell alone, seen from outside."""
        corners = self.vertices[self.cells]
        turned = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0
        cells = np.where(turned[:, None], self.cells[:, [1, 0, 2, 3]], self.cells)
        faces = cells[:, FACES].reshape(-1, 3)
        _, first, count = np.unique(
            np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
        )
        surface: Integers = faces[np.sort(first[count == 1])]
        surface.setflags(write=False)
        return surface

    def as_graph(self) -> gt.Graph:
        """Return the edges of the cells with their lengths, in the cost of the cheapest cell."""
        pairs = np.sort(self.cells[:, EDGES], axis=2).reshape(-1, 2)
        steps = np.diff(self.vertices[pairs], axis=1)[:, 0]
        lengths = np.linalg.norm(steps, axis=1) * np.repeat(self.costs, len(EDGES))
        order = np.lexsort((lengths, pairs[:, 1], pairs[:, 0]))
        pairs, lengths = pairs[order], lengths[order]
        first = np.ones(len(pairs), dtype=np.bool_)
        first[1:] = (pairs[1:] != pairs[:-1]).any(axis=1)
        first &= pairs[:, 0] != pairs[:, 1]
        return gt.Graph(self.n_vertices, pairs[first], lengths[first])

    def without(self, mask: NDArray[np.bool_]) -> TetMesh:
        """Return the solid without the cells of masked vertices."""
        free = ~mask[self.cells].any(axis=1)
        if not free.any():
            raise InvalidOptionError("the mask leaves no cell, and so no paths")
        return TetMesh(self.vertices, self.cells[free], self.costs[free])

    def closest(self, points: Floats) -> gt.Located:
        """Return the places in the solid that are closest to points (Q, 3)."""
        found, weights = np.zeros((len(points), 4), dtype=np.int64), np.zeros((len(points), 4))
        outside = np.ones(len(points), dtype=np.bool_)
        if len(self._centres):
            cells, shares = self._cells_by_centres(points)
            far = shares.min(axis=1) < -INSIDE
            for q in np.flatnonzero(far):
                cells[q], shares[q] = self._cell_by_boxes(points[q])
            found, weights = self.cells[cells], np.maximum(shares, 0)
            outside = shares.min(axis=1) < -INSIDE
        if outside.any():
            at = self._surface.closest(points[outside])
            own, count = self._on_surface[at.vertices], at.vertices.shape[1]
            found[outside] = np.column_stack([own, *[own[:, -1]] * (4 - count)])
            weights[outside] = np.pad(at.weights, [(0, 0), (0, 4 - count)])
        return gt.Located(found, weights / weights.sum(axis=1, keepdims=True))

    def _cells_by_centres(self, points: Floats) -> tuple[Integers, Floats]:
        """Return the cell that each point is deepest in, of those with the nearest centres."""
        from scipy.spatial import cKDTree

        count = min(CELLS_BY_CENTRES, len(self._centres))
        near = cKDTree(self._centres).query(points, np.arange(1, count + 1))[1]
        cells = np.flatnonzero(self.is_solid)[near]
        shares = self._shares(cells, points[:, None])
        best = shares.min(axis=2).argmax(axis=1)
        rows = np.arange(len(points))
        return cells[rows, best], shares[rows, best]

    def _cell_by_boxes(self, point: Floats) -> tuple[int, Floats]:
        """Return the cell that a point is deepest in, of those whose boxes it is in."""
        low, high, _ = self._boxes
        inside = (low <= point) & (point <= high)
        near = np.flatnonzero(inside.all(axis=1) & self.is_solid)
        if not len(near):
            return 0, np.full(4, -np.inf)
        shares = self._shares(near, point)
        best = int(shares.min(axis=1).argmax())
        return int(near[best]), shares[best]

    def _shares(self, cells: Integers, points: Floats) -> Floats:
        """Return the barycentric coordinates of points in solid cells, (..., 4)."""
        rest = np.einsum("...ij,...j->...i", self._boxes[2][cells], points - self._origins[cells])
        return np.concatenate([1 - rest.sum(axis=-1, keepdims=True), rest], axis=-1)

    def spans(self, vertices: Integers, weights: Floats) -> Floats:
        """Return the costs of straight lines from places in cells to the vertices of these, (P, C).

        See :meth:`geodesic_toolkit.Domain.spans`.
        """
        lengths = super().spans(vertices, weights)
        if self.measured_in_space:
            return lengths
        least = np.full(self.n_vertices, np.inf)  # of places on a face or an edge: an upper bound
        np.minimum.at(least, self.cells.ravel(), np.repeat(self.costs, 4))
        order = np.sort(self.cells, axis=1)
        for row, (corners, shares) in enumerate(zip(vertices, weights, strict=True)):
            own = np.unique(corners[shares > 0])
            around = np.isin(order, own).sum(axis=1) == len(own)
            lengths[row] *= self.costs[around].min() if around.any() else least[own].max()
        return lengths

    @cached_property
    def _origins(self) -> Floats:
        return self.vertices[self.cells[:, 0]]

    @cached_property
    def _boxes(self) -> tuple[Floats, Floats, Floats]:
        """The boxes of the cells, and the inverses of their edges; identities for flat cells."""
        corners = self.vertices[self.cells]
        edges = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2).copy()
        edges[~self.is_solid] = np.eye(3)
        inverse = np.linalg.inv(edges)
        return corners.min(axis=1), corners.max(axis=1), np.asarray(inverse, dtype=np.float64)

    @cached_property
    def _centres(self) -> Floats:
        """The centres of solid cells."""
        return np.asarray(self.vertices[self.cells[self.is_solid]].mean(axis=1))

    @cached_property
    def _on_surface(self) -> Integers:
        """The vertices that points outside are closest to: of cells, or all without a cell."""
        return np.unique(self.cells) if len(self.cells) else np.arange(self.n_vertices)

    @cached_property
    def _surface(self) -> Ground:
        """The surface in the vertices of the cells; these alone where doubled cells hide it."""
        own = self._on_surface
        if not len(self.triangles):
            return Ground(gt.PointCloud(self.vertices[own]))
        return Ground(gt.TriangleMesh(self.vertices[own], np.searchsorted(own, self.triangles)))

    @cached_property
    def is_solid(self) -> NDArray[np.bool_]:
        """True for cells that have a volume, of shape (C,); operators leave the others out."""
        corners = self.vertices[self.cells]
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            edges = corners[:, 1:] - corners[:, :1]
            longest = np.linalg.norm(edges, axis=2).max(axis=1, initial=0.0)
            solid = np.abs(np.linalg.det(edges / longest[:, None, None])) > MAX_VOLUME_OF_FLAT_CELLS
        solid.setflags(write=False)
        return np.asarray(solid)

    @classmethod
    def samples(cls) -> Any:
        """Return solids about which the truth is known."""
        from geodesic_toolkit_volume.samples import tet_samples

        return tet_samples()

    def __getstate__(self) -> dict[str, Any]:
        return {name: self.__dict__[name] for name in ("vertices", "cells", "costs")}

    def __repr__(self) -> str:
        return f"TetMesh({self.n_vertices} vertices, {len(self.cells)} cells)"


MAX_VOLUME_OF_FLAT_CELLS = 1e-12
"""Six times the volume of a cell, in cubes of its longest edge, up to which it is flat."""
