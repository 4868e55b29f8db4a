"""Step 1 of the heat method: a short diffusion, kept as the logarithm of the heat."""

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from scipy.sparse import csr_array, diags_array

from geodesic_toolkit._typing import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization import Discretization
from geodesic_toolkit.linear.base import Factor, LinearSolver
from geodesic_toolkit.linear.log_solve import fill_from_neighbours, log_solve
from geodesic_toolkit.source_points import SourcePoints

__all__ = ["Boundary", "HeatFlow", "HeatReport"]

Boundary: TypeAlias = Literal["neumann", "dirichlet", "average"]

HARMFUL_SHARE = 0.01
"""Share of reached vertices with non-positive heat from which on it does harm."""


@dataclass(frozen=True)
class HeatReport:
    """What the heat of one source set was like.

    Attributes
    ----------
    reached : int
        Vertices connected to a source.
    non_positive : int
        Those among them where the heat came out zero or negative.
    stages : int
        Solves that its range took: 1 up to some 450 edges from the source.
    """

    reached: int
    non_positive: int
    stages: int

    @property
    def harmful(self) -> bool:
        """Whether there are so many of them that distances suffer: over a hundredth."""
        return self.non_positive > HARMFUL_SHARE * self.reached


class HeatFlow:
    """``(M + t L) u = δ`` with L = -Δ positive semidefinite, factorised once.

    Parameters
    ----------
    diffusion : Discretization
    time : float
        Time step t, in squared length.
    boundary : {"neumann", "dirichlet", "average"}
    solver : LinearSolver
    """

    def __init__(
        self, diffusion: Discretization, time: float, boundary: Boundary, solver: LinearSolver
    ) -> None:
        self.diffusion = diffusion
        self.time = time
        self.boundary = boundary
        self.solver = solver
        self._lock = threading.Lock()
        self._systems: list[_HeatSystem] | None = None

    def heat(self, block: Sequence[SourcePoints]) -> FloatArray:
        """Return u, (N, K), as the solver gives it: with underflow, zeros and negative values."""
        loads, log_scales, owners = self._loads(block)
        parts = [system.factor.solve(system.load(loads)) for system in self.systems()]
        scaled = np.mean(parts, axis=0) * np.exp(log_scales)
        return np.column_stack([scaled[:, owners == k].sum(axis=1) for k in range(len(block))])

    def log_heat(self, block: Sequence[SourcePoints]) -> tuple[FloatArray, list[HeatReport]]:
        """Return log u, (N, K), over an unlimited range, and a report on each column.

        Vertices whose heat is not positive take it from their neighbours.
        """
        parts, stages = [], 1
        loads, log_scales, owners = self._loads(block)
        for system in self.systems():
            if self.solver.componentwise:
                part, needed = log_solve(system.matrix, system.factor, system.load(loads))
                stages = max(stages, needed)
            else:  # restarts rest on every entry being right: take what the solver gives
                solution = system.factor.solve(system.load(loads))
                part = np.log(solution, out=np.full_like(solution, -np.inf), where=solution > 0)
            if len(owners) > len(block):
                columns = [np.flatnonzero(owners == k) for k in range(len(block))]
                part = np.column_stack(
                    [np.logaddexp.reduce((part + log_scales)[:, own], axis=1) for own in columns]
                )
            parts.append(part)
        log_heat = parts[0] if len(parts) == 1 else np.logaddexp(*parts) - np.log(2)
        reports = []
        for k, points in enumerate(block):
            reached = self.reached(points)
            missing = reached & (log_heat[:, k] == -np.inf)
            count = int(missing.sum())
            if count and self.solver.componentwise:
                matrix = self.systems()[0].matrix
                log_heat[:, k] = fill_from_neighbours(matrix, log_heat[:, k], missing)
            reports.append(HeatReport(int(reached.sum()), count, stages))
        return log_heat, reports

    def _loads(self, block: Sequence[SourcePoints]) -> tuple[FloatArray, FloatArray, IntArray]:
        """Return right-hand sides (N, K'), the logarithms of their scales, and whose they are."""
        # exp(-d / √t) in the smooth limit; by steps of h the heat equation has this solution.
        spacing = self.diffusion.spacing
        decay = float(np.arccosh(1 + spacing**2 / (2 * self.time))) / spacing
        loads = [points.loads(points.components(self.diffusion), decay) for points in block]
        flat = [load for own in loads for load in own]
        owners = np.repeat(np.arange(len(block)), [len(own) for own in loads])
        return np.column_stack([load for load, _ in flat]), np.array([x for _, x in flat]), owners

    def reached(self, points: SourcePoints) -> BoolArray:
        """Return where heat from a source set should come, of shape (N,)."""
        reached = np.isin(self.diffusion.components, points.components(self.diffusion))
        if self.boundary == "dirichlet":
            reached &= ~self.diffusion.boundary
        return reached

    def systems(self) -> list["_HeatSystem"]:
        """Return the systems that the boundary condition asks for, factorised once."""
        with self._lock:
            if self._systems is None:
                conditions = {"average": [False, True]}.get(
                    self.boundary, [self.boundary == "dirichlet"]
                )
                self._systems = [self._heat_system(held) for held in conditions]
            return self._systems

    def _heat_system(self, dirichlet: bool) -> "_HeatSystem":
        mass, stiffness = self.diffusion.mass, self.diffusion.stiffness
        free = csr_array(diags_array(mass) + self.time * stiffness)
        diagonal = free.diagonal()
        lonely = np.where(diagonal > 0, 0.0, 1.0)  # vertices of no element: any pivot will do
        free = csr_array(free + diags_array(lonely))
        diagonal = diagonal + lonely
        held = self.diffusion.boundary if dirichlet else np.zeros_like(self.diffusion.boundary)
        if not held.any():
            return _HeatSystem(free, free, held, diagonal, self.solver.factorize(free))
        inside = diags_array((~held).astype(np.float64))
        pinned = csr_array(inside @ free @ inside + diags_array(np.where(held, diagonal, 0.0)))
        return _HeatSystem(pinned, free, held, diagonal, self.solver.factorize(pinned))

    @property
    def nbytes(self) -> int:
        """Bytes of the factors made so far."""
        return sum(system.factor.nbytes for system in self._systems or [])


@dataclass(frozen=True)
class _HeatSystem:
    """``M + t L`` under one boundary condition: rows of `held` vertices say ``u = 0``.

    A source that is itself held is a spike of its own: its value is fixed at what a lone vertex
    would have, and its neighbours feel it through the free system's rows.
    """

    matrix: csr_array
    free: csr_array
    held: BoolArray
    diagonal: FloatArray
    factor: Factor

    def load(self, delta: FloatArray) -> FloatArray:
        """Return the right-hand sides that put the heat δ, (N, K), where the condition allows."""
        spikes = np.where(self.held[:, None], delta, 0.0) / self.diagonal[:, None]
        if not spikes.any():
            return np.where(self.held[:, None], 0.0, delta)
        felt = np.where(self.held[:, None], 0.0, delta - self.free @ spikes)
        return felt + spikes * self.diagonal[:, None]
