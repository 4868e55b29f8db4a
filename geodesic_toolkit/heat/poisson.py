"""Step 3 of the heat method: the potential of a field of directions, and where it is 0."""

import threading
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from geodesic_toolkit.core.arrays import distinct
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.heat import Heat
from geodesic_toolkit.linear.base import Analysis, Factor
from geodesic_toolkit.linear.patterns import plus_diagonal
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["PoissonStep"]

MAX_PINNED_BY_SCHUR_COMPLEMENT = 16
"""Pinned vertices up to which the factor at hand is used once for each of them.

For more, the matrix without them is factorised, which takes as long as 12 to 16 solves on meshes of
35,000 to 557,000 vertices, and a solve of a block takes half of one alone.
"""


class PoissonStep:
    """``L φ = Gᵀ W X`` with L = -Δ positive semidefinite, factorised once.

    The solution has one constant to choose in each connected component. From one source it is such
    that the source reads 0: the paper's own result. From several, their mean would be a poor
    choice, as they disagree by the error of the heat method, and so φ is held at each of them:
    the potential that comes closest to the field among those which are right there.

    Parameters
    ----------
    metric : Discretization
    diffusion : Discretization
        Where the heat flowed: what it does not reach is ``inf``.
    analysis : Analysis
        Of the pattern of L, which other systems may share.
    """

    def __init__(
        self, metric: Discretization, diffusion: Discretization, analysis: Analysis
    ) -> None:
        self.metric = metric
        self.diffusion = diffusion
        self._analysis = analysis
        self._lock = threading.Lock()
        self._factor: Factor | None = None

    def factor(self) -> Factor:
        """Return the factor of L with one vertex a component held at 0.

        Adding ``L_gg`` to the diagonal at one vertex g of each component does that exactly: the
        right-hand side sums to zero over a component, so the equation summed over it leaves
        ``L_gg φ_g = 0``. It is scale-free and keeps the pattern, unlike shifting all of L, which
        bends distances.
        """
        with self._lock:
            if self._factor is None:
                self._factor = self._analysis.factorize(
                    plus_diagonal(self.metric.rows, self._ground)
                )
            return self._factor

    @cached_property
    def _ground(self) -> FloatArray:
        """Return what to add to the (N,) diagonal of L to ground one vertex of each component."""
        grounded = np.zeros(1, dtype=np.int64)
        if self.metric.components.any():
            _, grounded = np.unique(self.metric.components, return_index=True)
        diagonal = self.metric.rows.diagonal()[grounded]
        ground = np.zeros(self.metric.n_vertices)
        ground[grounded] = np.where(diagonal > 0, diagonal, 1.0)
        return ground

    @property
    def nbytes(self) -> int:
        """Bytes of the factor, if it has been made."""
        return 0 if self._factor is None else self._factor.nbytes

    def distances(
        self, load: FloatArray, heat: Heat, block: Sequence[SourcePoints], distances: FloatArray
    ) -> None:
        """Write the potentials of loads ``Gᵀ W X``, (N, K) or (N,), as distances, (K, N)."""
        potential = self.factor().solve_over(load).reshape(self.metric.n_vertices, len(block))
        distances[:] = potential.T
        for k, points in enumerate(block):
            if points.count == 1 and self._in_one_piece:
                _lower(distances[k], points.readings(distances[k]))
            else:
                self._anchor(distances[k], heat.values[:, k], points)

    def _anchor(self, row: FloatArray, heat: FloatArray, points: SourcePoints) -> None:
        """Choose the constants of a potential (N,) in place, and pin it at several sources."""
        components = self.metric.components
        home = points.components(self.metric)
        parts = distinct(home)
        crowded = np.bincount(home) > 1
        for part in parts[~crowded[parts]].tolist():
            inside = components == part
            values = row[inside]
            _lower(values, points.readings(row)[home == part])
            row[inside] = values
        if crowded.any():
            self._pin(row, heat, points, crowded)
        if not self._in_one_piece:
            heated = np.isin(self.diffusion.components, points.components(self.diffusion))
            row[~(heated & np.isin(components, parts))] = np.inf

    @cached_property
    def _in_one_piece(self) -> bool:
        """Return whether the domain is connected."""
        return not (self.metric.components.any() or self.diffusion.components.any())

    # -- several sources in a component --------------------------------------------------------

    def _pin(
        self, row: FloatArray, heat: FloatArray, points: SourcePoints, crowded: BoolArray
    ) -> None:
        """Hold a potential (N,) at the sources of crowded components, in place.

        The correction is harmonic outside of them: ``L_ff w_f = -L_fs w_s``, f the free vertices.
        """
        components, home = self.metric.components, points.components(self.metric)
        mine = crowded[home]
        late = mine & self._overtaken(points, heat) if points.delayed else np.zeros_like(mine)
        vertices, known = _around(points, mine & ~late)
        held = np.zeros(len(row), dtype=np.bool_)
        held[vertices] = True
        gap = np.zeros(len(row))
        gap[vertices] = known - row[vertices]
        row += self._harmonic(held, gap)
        row[vertices] = known
        vertices, known = _around(points, late)
        row[vertices] = np.minimum(row[vertices], known)
        floor = np.full(int(components.max()) + 1, -np.inf)
        for part in np.flatnonzero(crowded).tolist():
            floor[part] = points.starts[home == part].min()
        np.maximum(row, floor[components], out=row)

    def _harmonic(self, held: BoolArray, gap: FloatArray) -> FloatArray:
        """Return w, (N,), with ``L w = 0`` but at held vertices, where it is their `gap`.

        It is 0 in components in which nothing is held.
        """
        rows, rim = self.metric.rows, np.flatnonzero(held)
        if (
            len(rim) > MAX_PINNED_BY_SCHUR_COMPLEMENT
        ):  # what lies within a region is cut off by its rim
            across = held[rows.row_of_entry] & ~held[rows.indices] & (rows.data != 0)
            rim = distinct(rows.row_of_entry[across])
        if len(rim) <= MAX_PINNED_BY_SCHUR_COMPLEMENT:
            return self._by_schur_complement(rim, gap)
        apart = held[rows.row_of_entry] | held[rows.indices]
        diagonal = rows.diagonal()
        diagonal = np.where(diagonal > 0, diagonal, 1.0)
        others = np.where(held, diagonal, self._ground * ~self._touched(held))
        factor = self._analysis.factorize(
            plus_diagonal(rows.with_data(np.where(apart, 0.0, rows.data)), others)
        )
        felt = np.where(apart, -rows.data * gap[rows.indices], 0.0)
        load = np.asarray(np.bincount(rows.row_of_entry, felt, len(gap)), dtype=np.float64)
        return np.asarray(factor.solve(np.where(held, diagonal * gap, load)))

    def _touched(self, held: BoolArray) -> BoolArray:
        """Return which (N,) vertices lie in a component in which one is held."""
        return np.isin(self.metric.components, self.metric.components[held])

    def _by_schur_complement(self, rim: IntArray, gap: FloatArray) -> FloatArray:
        """Return that w as the potential of point loads λ on the rim that sum to 0 in a component.

        With A the grounded L and E the columns of the identity at the rim, ``w = A⁻¹ E λ + c``,
        c one constant in each component, and ``Eᵀ w`` is the gap.
        """
        components = self.metric.components
        parts, place = np.unique(components[rim], return_inverse=True)
        n_vertices, n_rim, n_parts = len(gap), len(rim), len(parts)
        loads = np.zeros((n_vertices, n_rim))
        loads[rim, np.arange(n_rim)] = 1.0
        columns = self.factor().solve_over(loads)
        members = np.eye(n_parts)[place]
        system = np.block([[columns[rim], members], [members.T, np.zeros((n_parts, n_parts))]])
        solution = np.linalg.solve(system, np.concatenate([gap[rim], np.zeros(n_parts)]))
        constants = np.zeros(int(components.max()) + 1)
        constants[parts] = solution[n_rim:]
        return np.asarray(columns @ solution[:n_rim] + constants[components])

    def _overtaken(self, points: SourcePoints, heat: FloatArray) -> BoolArray:
        """Return which (P,) points a front from elsewhere passes before they start.

        There the heat has no peak: it is greater at a neighbour that is not a source. A source next
        to one that starts earlier, by more than a mean edge length, is overtaken by that.
        """
        rows, scales = self.metric.rows, self.metric.scales
        nearest = points.nearest_vertices
        start = np.full(len(heat), np.inf)  # where it stays infinite is no source
        np.minimum.at(start, points.vertices, (points.distances + points.starts[points.rows]))
        source = np.isfinite(start)
        chosen = np.zeros_like(source)
        chosen[nearest] = True
        mine = np.flatnonzero(chosen[rows.row_of_entry] & (rows.data != 0))
        one, other = rows.row_of_entry[mine], rows.indices[mine]
        warmer = ~source[other] & (heat[other] > heat[one])
        sooner = start[other] + scales[one] < start[one]
        passed = np.zeros_like(source)
        passed[one[warmer | sooner]] = True
        return np.asarray(passed[nearest] & ~points.first_to_start(points.components(self.metric)))


def _around(points: SourcePoints, chosen: BoolArray) -> tuple[IntArray, FloatArray]:
    """Return the vertices at and around chosen points, each once, and the distance there."""
    rows = points.rows
    mine = chosen[rows]
    vertices, place = np.unique(points.vertices[mine], return_inverse=True)
    known = np.full(len(vertices), np.inf)
    np.minimum.at(known, place, (points.distances + points.starts[rows])[mine])
    return vertices, known


def _lower(values: FloatArray, reading: FloatArray) -> None:
    """Take what the only source reads off values in place; nothing is below it."""
    values -= reading
    np.maximum(values, 0.0, out=values)
