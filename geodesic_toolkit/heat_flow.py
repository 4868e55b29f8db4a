"""Step 1 of the heat method: a short diffusion, kept as the logarithm of the heat."""

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from scipy.sparse import csr_array, diags_array

from geodesic_toolkit._typing import BoolArray, FloatArray
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
        parts = [system.factor.solve(system.load(block)) for system in self.systems()]
        return np.asarray(np.mean(parts, axis=0), dtype=np.float64)

    def log_heat(self, block: Sequence[SourcePoints]) -> tuple[FloatArray, list[HeatReport]]:
        """Return log u, (N, K), over an unlimited range, and a report on each column.

        Vertices whose heat is not positive take it from their neighbours.
        """
        parts, stages = [], 1
        for system in self.systems():
            if self.solver.componentwise:
                part, needed = log_solve(system.matrix, system.factor, system.load(block))
                stages = max(stages, needed)
            else:  # restarts rest on every entry being right: take what the solver gives
                solution = system.factor.solve(system.load(block))
                part = np.log(solution, out=np.full_like(solution, -np.inf), where=solution > 0)
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

    def load(self, block: Sequence[SourcePoints]) -> FloatArray:
        """Return the right-hand sides δ, (N, K): the weights of each set's points, summed."""
        delta = np.column_stack([points.weights.sum(axis=0) for points in block])
        spikes = np.where(self.held[:, None], delta, 0.0) / self.diagonal[:, None]
        if not spikes.any():
            return np.where(self.held[:, None], 0.0, delta)
        felt = np.where(self.held[:, None], 0.0, delta - self.free @ spikes)
        return felt + spikes * self.diagonal[:, None]
