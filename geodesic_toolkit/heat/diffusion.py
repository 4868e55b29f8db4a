"""Step 1 of the heat method: a short diffusion, kept as the logarithm of the heat."""

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np

from geodesic_toolkit.core.arrays import distinct, empty
from geodesic_toolkit.core.rows import CompressedRows
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.heat import Heat, log_of
from geodesic_toolkit.heat.log_range import fill_from_neighbours, log_solve, smallest_final_value
from geodesic_toolkit.linear.base import Analysis, Factor, LinearSolver
from geodesic_toolkit.linear.patterns import SharedAnalysis, plus_diagonal
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["Boundary", "HeatFlow", "HeatReport"]

Boundary: TypeAlias = Literal["neumann", "dirichlet", "average"]

HARMFUL_SHARE = 0.01
"""Minimum share of reached vertices with non-positive heat at which distances are wrong."""

ROWS_PER_BLOCK = 16
"""Rows of a table that are compared as one row."""


@dataclass(frozen=True)
class HeatReport:
    """A report on the heat of one source set.

    Attributes
    ----------
    reached : int
        Vertices connected to a source.
    non_positive : int
        Number of these vertices with zero or negative heat.
    stages : int
        Number of solves for its range: 1 up to some 600 edges from the source.
    """

    reached: int
    non_positive: int
    stages: int

    @property
    def harmful(self) -> bool:
        """True if distances are inaccurate: over 1 % of vertices have non-positive heat."""
        return self.non_positive > HARMFUL_SHARE * self.reached


class HeatFlow:
    """``(M + t L) u = δ`` with L = -Δ positive semidefinite, factorised once.

    Parameters
    ----------
    diffusion : Discretization
    times : float or ndarray of shape (N,)
        Time step t, in squared length; one value in each connected component.
    boundary : {"neumann", "dirichlet", "average"}
    solver : LinearSolver
    analysis : Analysis, optional
        Analysis of the solver, given if other systems share it.
    """

    def __init__(
        self,
        diffusion: Discretization,
        times: float | FloatArray,
        boundary: Boundary,
        solver: LinearSolver,
        *,
        analysis: Analysis | None = None,
    ) -> None:
        self.diffusion = diffusion
        self.times = times
        self.boundary = boundary
        self.solver = solver
        self._analysis = analysis or SharedAnalysis(solver)
        self._lock = threading.Lock()
        self._systems: list[_HeatSystem] | None = None

    def heat(self, block: Sequence[SourcePoints]) -> FloatArray:
        """Return u, (N, K), as the solver gives it: with underflow, zeros and negative values."""
        heat = self._heat(block)
        if free := self._at_held_boundary(block):
            heat[:, free] = self._free.heat([block[k] for k in free])
        return heat

    def diffuse(
        self, block: Sequence[SourcePoints], *, workspace: FloatArray | None = None
    ) -> tuple[Heat, list[HeatReport]]:
        """Return the heat of each source set, and a report on it.

        Vertices whose heat is not positive take it from their neighbours, unless there are so many
        of them that the report says harmful.

        Parameters
        ----------
        block : sequence of K SourcePoints
        workspace : ndarray of shape (N, K), float64, optional
            Workspace, which may hold the heat afterwards.
        """
        heat, reports = self._diffuse(block, workspace)
        if free := self._at_held_boundary(block):
            other, again = self._free.diffuse([block[k] for k in free])
            heat = heat.replaced(free, other)
            for k, report in zip(free, again, strict=True):
                reports[k] = report
        return heat, reports

    def log_solve(self, loads: FloatArray) -> FloatArray:
        """Return log u, (N, K), for loads >= 0 at vertices, without a boundary condition."""
        if self.boundary != "neumann":
            return self._free.log_solve(loads)
        (system,) = self.systems()
        if not self.solver.componentwise:  # restarts need every entry to be accurate
            return log_of(system.factor.solve(loads))
        log_heat, _ = log_solve(system.matrix, system.factor, loads)
        return log_heat

    def is_positive(self, load: FloatArray) -> bool:
        """Return True if heat of a load (N,) is positive at every vertex that it is connected to.

        One solve is enough where heat stays in the range of floats, or is negative within it.
        """
        system = (self if self.boundary == "neumann" else self._free).systems()[0]
        lowest = float(system.factor.solve(load).min())
        if lowest > system.smallest_final or not self.solver.componentwise:
            return True
        if lowest < -system.smallest_final:
            return False
        return not self.is_cold(self.log_solve(load[:, None]), load[:, None])

    def is_cold(self, log_heat: FloatArray, loads: FloatArray) -> bool:
        """Return True if heat (N, K) is not positive at a vertex that its load is connected to."""
        parts = self.diffusion.components
        for column in np.flatnonzero((log_heat == -np.inf).any(axis=0)):
            heated = np.zeros(parts.max() + 1, dtype=np.bool_)
            heated[parts[loads[:, column] > 0]] = True
            if (heated[parts] & (log_heat[:, column] == -np.inf)).any():
                return True
        return False

    def _at_held_boundary(self, block: Sequence[SourcePoints]) -> list[int]:
        """Return the source sets at a boundary held at zero; they are solved with a free boundary.

        A source set is there if a point is on the boundary or adjacent to it, within the reach √t =
        h of the heat: the condition turns such heat into that of a dipole, which carries little
        information on distance. On a square of 22 x 22 vertices distances from the rim were 24 %
        off with the condition, and are 1.7 % off without it.
        """
        if self.boundary != "dirichlet" or not self.diffusion.boundary.any():
            return []
        return [
            k
            for k, points in enumerate(block)
            if np.logical_and.reduceat(self._cold[points.vertices], points.begins[:-1]).any()
        ]

    @cached_property
    def _cold(self) -> BoolArray:
        """Return a mask, (N,), of vertices that are on the boundary or adjacent to it."""
        held, rows = self.diffusion.boundary, self.diffusion.rows
        cold = held.copy()
        cold[rows.row_of_entry[held[rows.indices]]] = True
        return cold

    @cached_property
    def _free(self) -> "HeatFlow":
        """Return the same diffusion without a condition at the boundary."""
        return HeatFlow(self.diffusion, self.times, "neumann", self.solver, analysis=self._analysis)

    def _heat(self, block: Sequence[SourcePoints]) -> FloatArray:
        loads, log_scales, owners = self._loads(block)
        parts = [system.factor.solve(system.load(loads)) for system in self.systems()]
        scaled = np.mean(parts, axis=0) * np.exp(log_scales)
        return np.column_stack([scaled[:, owners == k].sum(axis=1) for k in range(len(block))])

    def _diffuse(
        self, block: Sequence[SourcePoints], workspace: FloatArray | None
    ) -> tuple[Heat, list[HeatReport]]:
        loads, log_scales, owners = self._loads(block, workspace)
        (system, *more) = self.systems()
        first = system.load(loads)
        if self.solver.componentwise:
            solve = system.factor.solve if more else system.factor.solve_over  # keep loads
            solution = solve(first)
            lowest = _lowest(solution)
            far = list(range(len(owners)))
            if not more and len(owners) == len(block):
                far = self._beyond_range(solution, lowest, block)
            if not far:
                reports = [
                    self._complete_in_range(solution, k, points)
                    if lowest[k] < 0
                    else HeatReport(self._reach(points), 0, 1)
                    for k, points in enumerate(block)
                ]
                return Heat.of(solution), reports
            part = log_of(solution)
            part[:, far], stages = log_solve(
                system.matrix, system.factor, first[:, far], solution=solution[:, far]
            )
        else:  # restarts need every entry to be accurate: use the solution unchanged
            part, stages = log_of(system.factor.solve(first)), 1
        parts = [part]
        for other in more:
            if self.solver.componentwise:
                part, needed = log_solve(other.matrix, other.factor, other.load(loads))
                stages = max(stages, needed)
            else:
                part = log_of(other.factor.solve(other.load(loads)))
            parts.append(part)
        if len(owners) > len(block):
            parts = [_merged(part + log_scales, owners) for part in parts]
        log_heat = parts[0] if len(parts) == 1 else np.logaddexp(*parts) - np.log(2)
        unset = log_heat.min(axis=0, initial=np.inf) == -np.inf  # most columns are complete
        reports = [
            self._complete(log_heat[:, k], block[k], stages)
            if unset[k]
            else HeatReport(self._reach(block[k]), 0, stages)
            for k in range(len(block))
        ]
        return Heat.of_log(log_heat), reports

    def _beyond_range(
        self, solution: FloatArray, lowest: FloatArray, block: Sequence[SourcePoints]
    ) -> list[int]:
        """Return the columns whose heat falls to values near underflow, and needs more solves."""
        beyond = []
        final = self.systems()[0].smallest_final
        for k, least in enumerate(lowest.tolist()):
            if least > final:  # as in most columns
                continue
            small = np.abs(solution[:, k]) <= final
            if small.any() and (small & self.reached(block[k])).any():
                beyond.append(k)
        return beyond

    def _complete_in_range(self, solution: FloatArray, k: int, points: SourcePoints) -> HeatReport:
        """Fill column k of u in place at vertices whose heat is not positive."""
        missing = solution[:, k] < 0
        report = HeatReport(self._reach(points), int(np.count_nonzero(missing)), 1)
        if report.non_positive and not report.harmful:
            matrix = self.systems()[0].matrix
            fill_from_neighbours(matrix, solution[:, k], missing, logarithmic=False)
        return report

    def _complete(self, log_heat: FloatArray, points: SourcePoints, stages: int) -> HeatReport:
        """Fill a column of log u in place at vertices whose heat is not positive."""
        reached = self.reached(points)
        missing = reached & (log_heat == -np.inf)
        count = int(missing.sum())
        if count and self.solver.componentwise:
            matrix = self.systems()[0].matrix
            fill_from_neighbours(matrix, log_heat, missing, logarithmic=True)
        return HeatReport(int(reached.sum()), count, stages)

    def _loads(
        self, block: Sequence[SourcePoints], workspace: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray, IntArray]:
        """Return right-hand sides (N, K'), the logarithms of their scales, and their sets."""
        if not any(points.delayed for points in block):
            columns = workspace
            if columns is None:
                columns = empty((self.diffusion.n_vertices, len(block)), np.float64)
            columns.fill(0.0)
            for column, points in enumerate(block):
                np.add.at(columns[:, column], points.vertices, points.shares)
            return columns, np.zeros(len(block)), np.arange(len(block))
        loads = [
            points.delayed_loads(points.components(self.diffusion), self._decay(points))
            if points.delayed
            else [points.load()]
            for points in block
        ]
        flat = [(k, *load) for k, own in enumerate(loads) for load in own]
        columns = np.zeros((self.diffusion.n_vertices, len(flat)))
        for column, (_, vertices, strengths, _) in enumerate(flat):
            np.add.at(columns[:, column], vertices, strengths)
        owners, _, _, log_scales = zip(*flat, strict=True)
        return columns, np.array(log_scales), np.array(owners)

    def _decay(self, points: SourcePoints) -> FloatArray:
        """Return the rate of exponential decay of heat per unit of length at each point."""
        at = points.first_vertices
        scale = self.diffusion.scales[at]
        time = np.broadcast_to(self.times, self.diffusion.n_vertices)[at]
        # exp(-d / √t) in the smooth limit; the discrete equation with steps of h has this solution.
        return np.asarray(np.arccosh(1 + scale**2 / (2 * time)) / scale)

    def reached(self, points: SourcePoints) -> BoolArray:
        """Return a mask (N,) of the vertices that heat from a source set should reach."""
        reached = np.isin(self.diffusion.components, points.components(self.diffusion))
        if self.boundary == "dirichlet":
            reached &= ~self.diffusion.boundary
        return reached

    def _reach(self, points: SourcePoints) -> int:
        """Return the number of vertices that heat from a source set should reach."""
        if self.boundary == "dirichlet":
            return int(self.reached(points).sum())
        if len(self._part_sizes) == 1:
            return self.diffusion.n_vertices
        return int(self._part_sizes[distinct(points.components(self.diffusion))].sum())

    @cached_property
    def _part_sizes(self) -> IntArray:
        return np.bincount(self.diffusion.components)

    def systems(self) -> list["_HeatSystem"]:
        """Return the systems of the boundary condition, factorised once."""
        with self._lock:
            if self._systems is None:
                conditions = {"average": [False, True]}.get(
                    self.boundary, [self.boundary == "dirichlet"]
                )
                self._systems = [self._heat_system(held) for held in conditions]
            return self._systems

    def _heat_system(self, dirichlet: bool) -> "_HeatSystem":
        free = plus_diagonal(self.diffusion.rows, self.diffusion.mass, self.times)
        diagonal = free.diagonal()
        if not (diagonal > 0).all():  # vertices without elements: any pivot is accepted
            free = plus_diagonal(free, np.where(diagonal > 0, 0.0, 1.0))
            diagonal = free.diagonal()
        held = self.diffusion.boundary if dirichlet else np.zeros_like(self.diffusion.boundary)
        if not held.any():
            return _HeatSystem(free, free, held, diagonal, self._analysis.factorize(free))
        uncoupled = held[free.row_of_entry] | held[free.indices]
        pinned = plus_diagonal(
            free.with_data(np.where(uncoupled, 0.0, free.data)), np.where(held, diagonal, 0.0)
        )
        return _HeatSystem(pinned, free, held, diagonal, self._analysis.factorize(pinned))

    @property
    def nbytes(self) -> int:
        """Bytes of the factors made so far."""
        own = sum(system.factor.nbytes for system in self._systems or [])
        free: HeatFlow | None = self.__dict__.get("_free")
        return own + (free.nbytes if free is not None else 0)


@dataclass(frozen=True)
class _HeatSystem:
    """``M + t L`` under one boundary condition: rows of `held` vertices are ``u = 0``.

    A held source is a separate spike: its value is fixed at that of an isolated vertex, and it acts
    on its neighbours through the rows of the free system.
    """

    matrix: CompressedRows
    free: CompressedRows
    held: BoolArray
    diagonal: FloatArray
    factor: Factor

    @cached_property
    def smallest_final(self) -> float:
        """The smallest heat that is final after one solve."""
        return smallest_final_value(self.diagonal)

    def load(self, delta: FloatArray) -> FloatArray:
        """Return the right-hand sides of the heat δ, (N, K), under the boundary condition."""
        if self.free is self.matrix:  # not a vertex is held
            return delta
        spikes = np.where(self.held[:, None], delta, 0.0) / self.diagonal[:, None]
        if not spikes.any():
            return np.where(self.held[:, None], 0.0, delta)
        coupling = np.where(self.held[:, None], 0.0, delta - self.free.scipy @ spikes)
        return coupling + spikes * self.diagonal[:, None]


def _lowest(table: FloatArray) -> FloatArray:
    """Return the minimum of each column, of shape (K,).

    Many rows are compared at a time, because for a few columns NumPy's overhead per row dominates.
    """
    if table.shape[1] == 1 or not table.flags.c_contiguous:
        return np.asarray(table.min(axis=0))
    count, width = table.shape
    whole = count - count % ROWS_PER_BLOCK
    rows = table[:whole].reshape(-1, ROWS_PER_BLOCK * width).min(axis=0, initial=np.inf)
    rest = table[whole:].min(axis=0, initial=np.inf)
    return np.asarray(np.minimum(rows.reshape(ROWS_PER_BLOCK, width).min(axis=0), rest))


def _merged(log_heat: FloatArray, owners: IntArray) -> FloatArray:
    """Return the logarithms of the sums of the columns that each source set owns."""
    return np.column_stack(
        [
            np.logaddexp.reduce(log_heat[:, owners == k], axis=1)
            for k in range(int(owners.max()) + 1)
        ]
    )
