"""Step 3 of the heat method: the potential of a field of directions, and its constants."""

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
"""Pinned vertices up to which the existing factor is used once for each of them.

For more, the matrix without them is factorised, which takes as long as 12 to 16 solves on meshes of
35,000 to 557,000 vertices, and a solve of a block takes half of one alone.
"""


class PoissonStep:
    """``L φ = Gᵀ W X`` with L = -Δ positive semidefinite, factorised once.

    The solution has a free constant in each connected component. With one source, the constant
    makes the distance at the source 0, as in the paper. With several, their mean would be a poor
    choice, as they disagree by the error of the heat method. So φ is fixed at each of them: among
    the potentials that are exact there, it is the closest to the field.

    Parameters
    ----------
    metric : Discretization
    diffusion : Discretization
        Discretization in which the heat flowed; distances are ``inf`` at vertices not reached.
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
        """Return the factor of L with one vertex per component fixed at 0.

        Adding ``L_gg`` to the diagonal at one vertex g of each component does that exactly: the
        right-hand side sums to zero over a component, so the sum of its equations is ``L_gg φ_g =
        0``. It is independent of scale and keeps the pattern, whereas a shift of all of L would
        distort distances.
        """
        with self._lock:
            if self._factor is None:
                self._factor = self._analysis.factorize(
                    plus_diagonal(self.metric.rows, self._ground)
                )
            return self._factor

    @cached_property
    def _ground(self) -> FloatArray:
        """Return the terms for the diagonal of L, (N,), that ground a vertex per component."""
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
            if points.count == 1 and self._is_connected:
                _subtract_reading(distances[k], points.readings(distances[k]))
            else:
                self._anchor(distances[k], heat.values[:, k], points)

    def _anchor(self, row: FloatArray, heat: FloatArray, points: SourcePoints) -> None:
        """Choose the constants of a potential (N,) in place, and pin it at several sources."""
        components = self.metric.components
        component = points.components(self.metric)
        parts = distinct(component)
        crowded = np.bincount(component) > 1
        for part in parts[~crowded[parts]].tolist():
            inside = components == part
            values = row[inside]
            _subtract_reading(values, points.readings(row)[component == part])
            row[inside] = values
        if crowded.any():
            self._pin(row, heat, points, crowded)
        if not self._is_connected:
            heated = np.isin(self.diffusion.components, points.components(self.diffusion))
            row[~(heated & np.isin(components, parts))] = np.inf

    @cached_property
    def _is_connected(self) -> bool:
        """True if the domain is connected."""
        return not (self.metric.components.any() or self.diffusion.components.any())

    # -- several sources in a component --------------------------------------------------------

    def _pin(
        self, row: FloatArray, heat: FloatArray, points: SourcePoints, crowded: BoolArray
    ) -> None:
        """Fix a potential (N,) at the sources of components that have several, in place.

        The correction is harmonic outside of them: ``L_ff w_f = -L_fs w_s``, f the free vertices.
        """
        components, component = self.metric.components, points.components(self.metric)
        crowded_points = crowded[component]
        late = (
            crowded_points & self._overtaken(points, heat)
            if points.delayed
            else np.zeros_like(crowded_points)
        )
        vertices, known = _around(points, crowded_points & ~late)
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
            floor[part] = points.starts[component == part].min()
        np.maximum(row, floor[components], out=row)

    def _harmonic(self, held: BoolArray, gap: FloatArray) -> FloatArray:
        """Return w, (N,), with ``L w = 0`` at free vertices, and the `gap` at held ones.

        It is 0 in components without held vertices.
        """
        rows, rim = self.metric.rows, np.flatnonzero(held)
        # The inside of a held region has no effect beyond its rim.
        if len(rim) > MAX_PINNED_BY_SCHUR_COMPLEMENT:
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
        coupling = np.where(apart, -rows.data * gap[rows.indices], 0.0)
        load = np.asarray(np.bincount(rows.row_of_entry, coupling, len(gap)), dtype=np.float64)
        return np.asarray(factor.solve(np.where(held, diagonal * gap, load)))

    def _touched(self, held: BoolArray) -> BoolArray:
        """Return a mask (N,) of the vertices of components with a held vertex."""
        return np.isin(self.metric.components, self.metric.components[held])

    def _by_schur_complement(self, rim: IntArray, gap: FloatArray) -> FloatArray:
        """Return w as the potential of point loads λ on the rim with sum 0 per component.

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
        """Return a mask (P,) of the points that a front from elsewhere passes before they start.

        There the heat does not have a peak: it is greater at a neighbour that is not a source. A
        source is also overtaken by a neighbour that starts earlier by more than a mean edge length.
        """
        rows, scales = self.metric.rows, self.metric.scales
        nearest = points.nearest_vertices
        start = np.full(len(heat), np.inf)  # it stays infinite at vertices that are not sources
        np.minimum.at(start, points.vertices, (points.distances + points.starts[points.rows]))
        source = np.isfinite(start)
        chosen = np.zeros_like(source)
        chosen[nearest] = True
        chosen_entries = np.flatnonzero(chosen[rows.row_of_entry] & (rows.data != 0))
        one, other = rows.row_of_entry[chosen_entries], rows.indices[chosen_entries]
        warmer = ~source[other] & (heat[other] > heat[one])
        earlier = start[other] + scales[one] < start[one]
        passed = np.zeros_like(source)
        passed[one[warmer | earlier]] = True
        return np.asarray(passed[nearest] & ~points.first_to_start(points.components(self.metric)))


def _around(points: SourcePoints, chosen: BoolArray) -> tuple[IntArray, FloatArray]:
    """Return the vertices of chosen points, each once, and their distances."""
    rows = points.rows
    chosen_entries = chosen[rows]
    vertices, place = np.unique(points.vertices[chosen_entries], return_inverse=True)
    known = np.full(len(vertices), np.inf)
    np.minimum.at(known, place, (points.distances + points.starts[rows])[chosen_entries])
    return vertices, known


def _subtract_reading(values: FloatArray, reading: FloatArray) -> None:
    """Subtract the value at the only source in place, and clamp values at 0."""
    values -= reading
    np.maximum(values, 0.0, out=values)
