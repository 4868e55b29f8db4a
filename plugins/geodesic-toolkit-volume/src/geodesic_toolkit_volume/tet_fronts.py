"""Fronts that cross tetrahedra: the distance of a vertex from those of the others.

The front through a tetrahedron is a sphere about a virtual source, which the distances of three
vertices, of two or of one determine. If the straight line from it to the fourth vertex passes
between them, its length is a candidate distance. Point sources in a body without obstacles are then
exact. Where costs jump, no point may have these distances: the front is then a plane.
"""

from collections.abc import Iterator
from functools import cached_property
from itertools import combinations
from typing import Any, final

import numpy as np

from geodesic_toolkit_volume.marching import Floats, Integers, Marching, Wave

__all__ = ["TetFronts"]

BAND_PER_EDGE = 0.75
"""Width of the band, in mean edges.

A wider one accepts more vertices at once, and more of them again. Measured on the ball, the shell
and the slab of ``benchmarks/volumes.py`` with 17,000 to 20,000 vertices: from 0.1 to 1.5 the error
of the ball grows from 0.0004 to 0.02 %, the others by less than a sixth, and the time falls to a
fifth; from 0.5 to 1 it changes by a third.
"""

MAX_ROUNDING_OF_WEIGHTS = 1e-9
"""Negative weight, as a share of the sum, with which a line still crosses a triangle."""


@final
class TetFronts(Marching):
    """Tetrahedra that fronts cross.

    Parameters
    ----------
    vertices : ndarray of shape (N, 3), float64
    cells : ndarray of shape (C, 4), int64
    costs : ndarray of shape (C,), float64
        The slowness of each cell, the cost of a unit of length.
    """

    def __init__(self, vertices: Floats, cells: Integers, costs: Floats) -> None:
        self._vertices, self._cells, self._costs = vertices, cells, costs

    @property
    def n_vertices(self) -> int:
        """Number N of vertices."""
        return len(self._vertices)

    @cached_property
    def width(self) -> float:
        """Width of the band of distances whose vertices are accepted at once."""
        a, b = self._vertices[self._cells[:, 0]], self._vertices[self._cells[:, 1]]
        return BAND_PER_EDGE * float((np.linalg.norm(a - b, axis=1) * self._costs).mean())

    @cached_property
    def _unit(self) -> float:
        """The power of two next to the width: products of lengths in it are within range."""
        return float(2.0 ** np.round(np.log2(self.width)))

    @cached_property
    def _products(self) -> Floats:
        """Inner products of the edges from each corner to the others, (4, 6, C), in cost / unit."""
        corners = self._vertices[self._cells] / self._unit
        products = np.empty((4, 6, len(self._cells)))
        for j in range(4):
            edges = corners[:, OTHERS[j]] - corners[:, j : j + 1]
            edges *= self._costs[:, None, None]
            for row, (a, b) in enumerate(PAIRS):
                products[j, row] = np.einsum("cd,cd->c", edges[:, a], edges[:, b])
        return products

    @cached_property
    def _around(self) -> tuple[Integers, Integers]:
        """The cells around each vertex, in compressed rows."""
        flat = self._cells.ravel()
        order = np.argsort(flat, kind="stable")
        counts = np.bincount(flat, minlength=self.n_vertices)
        return np.concatenate([[0], np.cumsum(counts)]), order // 4

    def updates(self, now: Integers, wave: Wave) -> Iterator[tuple[Integers, Floats, Floats]]:
        """Yield candidate distances of vertices in the cells of newly accepted vertices."""
        begins, around = self._around
        cells = np.unique(around[_ranges(begins[now], begins[now + 1])])
        corners = self._cells[cells]
        values = np.where(wave.accepted[corners], wave.values[corners], np.inf)
        for j in range(4):
            others = OTHERS[j]
            from_others = values[:, others]
            some = wave.values[corners[:, j]] > from_others.min(axis=1)
            apex, known = corners[some, j], from_others[some].T
            began = wave.began[corners[some][:, others]].T
            began = np.where(np.isfinite(known), began, np.inf).min(axis=0)
            products = self._products[j][:, cells[some]]
            for size in (3, 2, 1):
                for subset in combinations(range(3), size):
                    there = np.isfinite(known[list(subset)]).all(axis=0)
                    if there.any():
                        across = self._unit * crossed(
                            (known[list(subset)][:, there] - began[there]) / self._unit,
                            products[_rows_of(subset)][:, there],
                        )
                        yield apex[there], across + began[there], began[there]

    def __getstate__(self) -> dict[str, Any]:
        return {
            name: value
            for name, value in self.__dict__.items()
            if name not in {"_products", "_around", "_unit", "width"}
        }


OTHERS = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]
"""The other three corners of each corner."""

PAIRS = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
"""Pairs of edges in the order of their inner products."""


def _rows_of(subset: tuple[int, ...]) -> list[int]:
    return [PAIRS.index((a, b)) for i, a in enumerate(subset) for b in subset[i:]]


def _ranges(first: Integers, last: Integers) -> Integers:
    """Return all numbers from each first to each last, without it, in one array."""
    counts = last - first
    ends = np.cumsum(counts)
    return np.asarray(np.arange(ends[-1]) + np.repeat(first - (ends - counts), counts))


def crossed(known: Floats, products: Floats) -> Floats:
    """Return the straight distance to an apex from a virtual source, infinite where it misses.

    With the edges e from the apex, their products G and the squared distance q to the source S,
    ``e · S = (q + e · e - d²) / 2``; with S a combination λ of the edges that is
    ``λ = G⁻¹ (q + k) / 2`` and ``q = λᵀ G λ``, a quadratic equation for q. Without a solution the
    front is a plane, ``(φ - d)ᵀ G⁻¹ (φ - d) = 1``.

    Parameters
    ----------
    known : ndarray of shape (m, P), float64
        Distances d of m corners, 1 to 3.
    products : ndarray of shape (m (m + 1) / 2, P), float64
        The upper triangle of G, by rows.

    Returns
    -------
    ndarray of shape (P,), float64
    """
    if len(known) == 1:
        return np.asarray(known[0] + np.sqrt(products[0]))
    inverse = _inverse_of_two(products) if len(known) == 2 else _inverse_of_three(products)
    own = products[[0, 2]] if len(known) == 2 else products[[0, 3, 5]]
    k = own - known**2
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        to_one = np.stack([row.sum(axis=0) for row in inverse])
        to_k = np.stack([(row * k).sum(axis=0) for row in inverse])
        a, b, c = to_one.sum(axis=0) / 4, to_k.sum(axis=0) / 2 - 1, (k * to_k).sum(axis=0) / 4
        inner = b * b - 4 * a * c
        q = (np.sqrt(inner) - b) / (2 * a)
        weights = q * to_one + to_k
        found, plane = np.sqrt(q), inner < 0
        if plane.any():
            found[plane], weights[:, plane] = _plane(known[:, plane], inverse[..., plane])
        passes = (weights >= -MAX_ROUNDING_OF_WEIGHTS * np.abs(weights).sum(axis=0)).all(axis=0)
        # At obtuse angles a corner may be farther than the apex: it is accepted later, and the apex
        # again. Without such updates the error in a ball is 0.64 %, with them 0.002 %.
        return np.asarray(np.where(passes, found, np.inf))


def _plane(known: Floats, inverse: Floats) -> tuple[Floats, Floats]:
    """Return the distance of an apex from a plane front, (P,), and the weights of its line."""
    to_one = inverse.sum(axis=1)
    to_known = (inverse * known).sum(axis=1)
    a, b = to_one.sum(axis=0), to_known.sum(axis=0)
    inner = b * b - a * ((known * to_known).sum(axis=0) - 1)
    found = (b + np.sqrt(inner)) / a
    return found, found * to_one - to_known


def _inverse_of_two(g: Floats) -> Any:
    determinant = g[0] * g[2] - g[1] ** 2
    determinant[determinant <= MAX_DETERMINANT_OF_FLAT_EDGES * g[0] * g[2]] = np.nan
    return np.array([[g[2], -g[1]], [-g[1], g[0]]]) / determinant


def _inverse_of_three(g: Floats) -> Any:
    a, b, c, d, e, f = g
    first = [d * f - e * e, c * e - b * f, b * e - c * d]
    determinant = a * first[0] + b * first[1] + c * first[2]
    determinant[determinant <= MAX_DETERMINANT_OF_FLAT_EDGES * a * d * f] = np.nan
    mixed = b * c - a * e
    return (
        np.array(
            [
                first,
                [first[1], a * f - c * c, mixed],
                [first[2], mixed, a * d - b * b],
            ]
        )
        / determinant
    )


MAX_DETERMINANT_OF_FLAT_EDGES = 1e-12
"""Determinant, relative to the product of squared lengths, up to which edges lie in one plane."""
