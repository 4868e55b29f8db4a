"""The heat method, readable beside the paper.

K. Crane, C. Weischedel, M. Wardetzky, *Geodesics in Heat: A New Approach to Computing Distance
Based on Heat Flow*, ACM Transactions on Graphics 32, 2013, https://doi.org/10.1145/2516971.2516977
"""

import os
import threading
import warnings
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_array, csr_array, diags_array

from geodesic_toolkit._typing import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization import Discretization
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    NonPositiveHeatWarning,
    UnsupportedDomainError,
)
from geodesic_toolkit.linear.base import Factor, LinearSolver
from geodesic_toolkit.linear.log_solve import fill_from_neighbours, log_solve
from geodesic_toolkit.refine import WavefrontSweeper

__all__ = ["Boundary", "HeatMethod", "HeatReport", "Progress", "SourcePoints", "as_vertices"]

Boundary: TypeAlias = Literal["neumann", "dirichlet", "average"]
Progress: TypeAlias = Callable[[int, int], None]

BLOCK = 16
"""Source sets solved at once: they share the reading of a factor, and stay in cache."""

HARMFUL_SHARE = 0.01
"""Share of reached vertices with non-positive heat above which a warning is due."""


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


@dataclass(frozen=True)
class SourcePoints:
    """A set of sources as convex combinations of vertices.

    Attributes
    ----------
    weights : csr_array of shape (P, N)
        One row a point: its barycentric weights on the vertices around it.
    distances : ndarray of shape (nnz,), float64
        How far the point is from each of those vertices, in the order of ``weights.data``; 0 for a
        point at a vertex.
    """

    weights: csr_array
    distances: FloatArray

    @classmethod
    def at_vertices(cls, vertices: IntArray, n_vertices: int) -> "SourcePoints":
        """Return sources at vertices."""
        count = len(vertices)
        entries = (np.ones(count), (np.arange(count), vertices))
        weights = csr_array(coo_array(entries, shape=(count, n_vertices)))
        return cls(weights, np.zeros(count))

    @property
    def offsets(self) -> FloatArray:
        """The (P,) distances of the points from their vertices, in the weighted mean."""
        rows = np.repeat(np.arange(self.weights.shape[0]), np.diff(self.weights.indptr))
        sums = np.bincount(rows, self.weights.data * self.distances, self.weights.shape[0])
        return np.asarray(sums, dtype=np.float64)

    def components(self, discretization: Discretization) -> IntArray:
        """Return the connected component that each point lies in, of shape (P,)."""
        first = self.weights.indices[self.weights.indptr[:-1]]
        return discretization.components[first]


class HeatMethod:
    """Geodesic distance by heat, for any discretization: it knows no domain and no Laplacian.

    1. Diffuse: ``(M + t L) u = δ`` with L = -Δ positive semidefinite, kept as ``log u`` so that u
       may be arbitrarily small.
    2. Normalise: ``X = -∇u / |∇u|``.
    3. Integrate: ``Δφ = ∇·X``, which is ``L φ = Gᵀ W X``; the right-hand side is *minus* the
       integrated divergence of X, as L is -Δ.

    Both systems are factorised once and serve every source.

    Parameters
    ----------
    metric : Discretization
        Where gradients are taken and integrated.
    diffusion : Discretization, optional
        Where heat flows, on the same vertices; the metric by default.
    time : float, optional
        Time step t, in squared length; ``time_factor * metric.spacing**2`` by default.
    time_factor : float
        Time step in units of the squared mean edge length; 1 is the paper's choice. Larger values
        smooth, smaller ones sharpen up to where the edges show through.
    boundary : {"neumann", "dirichlet", "average"}
        Condition on the heat at the boundary: insulated, held at zero, or the mean of both heats.
    heat_solver, poisson_solver : LinearSolver
        For steps 1 and 3. Step 1 needs a componentwise accurate one.
    refine : bool
        Instead of steps 2 and 3, sweep wavefronts over the triangles in the order of the heat
        (:mod:`geodesic_toolkit.refine`): several times more accurate, exact at the sources, and no
        Poisson system is factorised. For metrics made of triangles.

    Raises
    ------
    InvalidOptionError
        A time step that is not positive and finite, both `time` and a `time_factor`, an unknown
        boundary condition, a heat solver that cannot resolve small values.
    UnsupportedDomainError
        Metric and diffusion with different numbers of vertices; refinement of something else than
        triangles.
    SolverError, NotEnoughMemoryError
        A factorisation failed.

    References
    ----------
    K. Crane, C. Weischedel, M. Wardetzky, *Geodesics in Heat*, 2013,
    https://doi.org/10.1145/2516971.2516977

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> mesh = gt.testing.shapes.icosphere(3)
    >>> superlu = gt.solvers["superlu"]()
    >>> method = gt.HeatMethod(
    ...     gt.CotanLaplacian().assemble(mesh), heat_solver=superlu, poisson_solver=superlu
    ... )
    >>> round(float(method.distance(0).max()), 1)  # the antipode of the unit sphere: π
    3.1
    """

    def __init__(
        self,
        metric: Discretization,
        *,
        diffusion: Discretization | None = None,
        time: float | None = None,
        time_factor: float = 1.0,
        boundary: Boundary = "neumann",
        heat_solver: LinearSolver,
        poisson_solver: LinearSolver,
        refine: bool = False,
    ) -> None:
        self.metric = metric
        self.diffusion = metric if diffusion is None else diffusion
        if self.diffusion.n_vertices != metric.n_vertices:
            raise UnsupportedDomainError(
                f"the diffusion has {self.diffusion.n_vertices} vertices, "
                f"the metric {metric.n_vertices}"
            )
        self.time = _time_step(time, time_factor, metric.spacing)
        if boundary not in ("neumann", "dirichlet", "average"):
            raise InvalidOptionError(
                f'boundary must be "neumann", "dirichlet" or "average", not {boundary!r}'
            )
        self.boundary = boundary
        if not (heat_solver.componentwise or getattr(heat_solver, "allow_heat", False)):
            raise InvalidOptionError(
                f"{type(heat_solver).__name__} cannot resolve the small values of heat, far from "
                'the source; use it for the Poisson step only, solver={"poisson": ...}, or insist '
                "with its option allow_heat=True"
            )
        self.heat_solver = heat_solver
        self.poisson_solver = poisson_solver
        self.refine = bool(refine)
        self._sweeper = WavefrontSweeper(metric) if refine else None
        self._lock = threading.RLock()
        self._systems: list[_HeatSystem] | None = None
        self._poisson_factor: Factor | None = None

    # -- the three steps -----------------------------------------------------------------------

    def distance(self, sources: ArrayLike | SourcePoints) -> FloatArray:
        """Return the geodesic distance from one set of sources.

        Parameters
        ----------
        sources : int, array-like of int, or SourcePoints
            Vertex indices, or points between them.

        Returns
        -------
        ndarray of shape (N,), float64
            In the unit of the domain; ``inf`` where no source connects. A single source vertex
            reads exactly 0; of several, the mean in each component is 0, so that values near them
            may be slightly negative.

        Raises
        ------
        InvalidSourceError
            No source, an index out of range, something that is no index.
        """
        (distance,) = self.distances([sources])
        return np.asarray(distance)

    def distances(
        self, source_sets: Iterable[Any], *, progress: Progress | None = None
    ) -> FloatArray:
        """Return the geodesic distances from K sets of sources, solved in blocks.

        Parameters
        ----------
        source_sets : iterable of source sets
            A one-dimensional array of integers means that many single sources.
        progress : callable, optional
            Called with the number of sets done and their total after each block.

        Returns
        -------
        ndarray of shape (K, N), float64
            One row a set, as `distance` returns it.

        Raises
        ------
        InvalidSourceError
            As for `distance`; the message says which set.
        """
        points = [self._source_points(sources, k) for k, sources in enumerate(source_sets)]
        distances = np.empty((len(points), self.n_vertices))
        for start in range(0, len(points), BLOCK):
            block = points[start : start + BLOCK]
            log_heat, _ = self._diffuse(block)
            if self._sweeper is not None:
                distances[start : start + len(block)] = self._sweep(log_heat, block)
            else:
                directions = -self.metric.gradient.unit(log_heat)
                potential = self.integrate(directions)
                distances[start : start + len(block)] = self._anchor(potential, block)
            if progress is not None:
                progress(start + len(block), len(points))
        return distances

    def log_heat(self, sources: ArrayLike | SourcePoints) -> FloatArray:
        """Return the logarithm of the heat u of step 1, of shape (N,), over an unlimited range.

        ``-inf`` where no heat comes: in other components, and at a Dirichlet boundary.
        Parameters and errors are those of `distance`.
        """
        log_heat, _ = self._diffuse([self._source_points(sources)])
        return log_heat[:, 0]

    def heat(self, sources: ArrayLike | SourcePoints) -> FloatArray:
        """Return the heat u of step 1 as the solver gives it, of shape (N,).

        It underflows some 700 edges from the source, and shows what `log_heat` cures: zeros and
        negative values. Parameters and errors are those of `distance`.
        """
        points = [self._source_points(sources)]
        parts = [system.factor.solve(system.load(points))[:, 0] for system in self._heat_systems()]
        return np.asarray(np.mean(parts, axis=0), dtype=np.float64)

    def heat_report(self, sources: ArrayLike | SourcePoints) -> HeatReport:
        """Return how far the heat of one source set reaches and where it is not positive.

        Parameters and errors are those of `distance`.
        """
        _, reports = self._diffuse([self._source_points(sources)], warn=False)
        return reports[0]

    def integrate(self, field: FloatArray) -> FloatArray:
        """Return φ with ``L φ = Gᵀ W X``: step 3 for any field X, φ = 0 at one vertex a component.

        Parameters
        ----------
        field : ndarray
            In the rows of ``metric.gradient.matrix``: (E, dim) on elements, (E,) on edges, with
            one more axis for K fields at once.

        Returns
        -------
        ndarray of shape (N,) or (N, K)
        """
        return self._poisson().solve(self.metric.gradient.adjoint(field))

    # -- step 1 --------------------------------------------------------------------------------

    def _diffuse(
        self, block: Sequence[SourcePoints], *, warn: bool = True
    ) -> tuple[FloatArray, list[HeatReport]]:
        """Return log u, (N, K), and a report on each of its columns."""
        parts, stages = [], 1
        for system in self._heat_systems():
            if self.heat_solver.componentwise:
                part, needed = log_solve(system.matrix, system.factor, system.load(block))
                stages = max(stages, needed)
            else:  # restarts rest on every entry being right: take what the solver gives
                solution = system.factor.solve(system.load(block))
                part = np.log(solution, out=np.full_like(solution, -np.inf), where=solution > 0)
            parts.append(part)
        log_heat = parts[0] if len(parts) == 1 else np.logaddexp(*parts) - np.log(2)
        reports = []
        for k, points in enumerate(block):
            reached = np.isin(self.diffusion.components, points.components(self.diffusion))
            if self.boundary == "dirichlet":
                reached &= ~self.diffusion.boundary
            missing = reached & (log_heat[:, k] == -np.inf)
            count = int(missing.sum())
            if count and self.heat_solver.componentwise:
                matrix = self._heat_systems()[0].matrix
                log_heat[:, k] = fill_from_neighbours(matrix, log_heat[:, k], missing)
            reports.append(HeatReport(int(reached.sum()), count, stages))
        worst = max(reports, key=lambda report: report.non_positive)
        if warn and worst.non_positive > HARMFUL_SHARE * worst.reached:
            warnings.warn(self._complaint(worst), NonPositiveHeatWarning, stacklevel=3)
        return log_heat, reports

    def _complaint(self, report: HeatReport) -> str:
        found = (
            f"the heat is not positive at {report.non_positive} of {report.reached} vertices, and "
            "distances there are not to be trusted; "
        )
        if not self.heat_solver.componentwise:
            return found + "an iterative solver cannot resolve it, a direct one can"
        if self.boundary == "dirichlet":
            return found + 'a boundary held at zero lets none through: use boundary="average"'
        return found + (
            "the diffusion has weights of the wrong sign: on a triangle mesh use "
            "CotanLaplacian(intrinsic_delaunay=True)"
        )

    def _heat_systems(self) -> list["_HeatSystem"]:
        """Return the heat systems of the boundary condition, factorised once."""
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
            return _HeatSystem(free, free, held, diagonal, self.heat_solver.factorize(free))
        inside = diags_array((~held).astype(np.float64))
        pinned = csr_array(inside @ free @ inside + diags_array(np.where(held, diagonal, 0.0)))
        return _HeatSystem(pinned, free, held, diagonal, self.heat_solver.factorize(pinned))

    # -- step 3 --------------------------------------------------------------------------------

    def _poisson(self) -> Factor:
        """Return the factor of L with one vertex a component held at 0.

        Adding ``L_gg`` to the diagonal at one vertex g of each component does that exactly: the
        right-hand side sums to zero over a component, so the equation summed over it leaves
        ``L_gg φ_g = 0``. It is scale-free and keeps the pattern, unlike shifting all of L, which
        bends distances.
        """
        with self._lock:
            if self._poisson_factor is None:
                stiffness = self.metric.stiffness
                _, grounded = np.unique(self.metric.components, return_index=True)
                diagonal = stiffness.diagonal()[grounded]
                ground = np.zeros(self.n_vertices)
                ground[grounded] = np.where(diagonal > 0, diagonal, 1.0)
                matrix = csr_array(stiffness + diags_array(ground))
                self._poisson_factor = self.poisson_solver.factorize(matrix)
            return self._poisson_factor

    def _anchor(self, potential: FloatArray, block: Sequence[SourcePoints]) -> FloatArray:
        """Return (K, N) distances: the mean over the sources of a component is 0 there."""
        components = self.metric.components
        distances = np.full(potential.T.shape, np.inf)
        for k, points in enumerate(block):
            above = points.weights @ potential[:, k] - points.offsets
            home = points.components(self.metric)
            heated = np.isin(self.diffusion.components, points.components(self.diffusion))
            for component in np.unique(home):
                inside = heated & (components == component)
                distances[k, inside] = potential[inside, k] - above[home == component].mean()
        return distances

    # -- instead of steps 2 and 3 --------------------------------------------------------------

    def _sweep(self, log_heat: FloatArray, block: Sequence[SourcePoints]) -> FloatArray:
        """Return (K, N) refined distances; the sweeps of a block share the processors."""
        assert self._sweeper is not None
        sweeper = self._sweeper.prepare()

        def column(k: int) -> FloatArray:
            points = block[k]
            vertices = points.weights.indices.astype(np.int64)
            return sweeper.distance(log_heat[:, k], vertices, points.distances)

        if len(block) == 1:
            return column(0)[None]
        with ThreadPoolExecutor(min(len(block), os.cpu_count() or 1)) as pool:
            return np.array(list(pool.map(column, range(len(block)))))

    # -- sources -------------------------------------------------------------------------------

    def _source_points(self, sources: Any, position: int | None = None) -> SourcePoints:
        if isinstance(sources, SourcePoints):
            return sources
        name = "sources" if position is None else f"source set {position}"
        return SourcePoints.at_vertices(
            as_vertices(sources, self.n_vertices, name), self.n_vertices
        )

    # -- the object ----------------------------------------------------------------------------

    @property
    def n_vertices(self) -> int:
        """Number N of vertices."""
        return self.metric.n_vertices

    def prepare(self) -> "HeatMethod":
        """Factorise now rather than on first use, and return the method.

        The Poisson system is left out where distances are refined: they do not need it.
        """
        self._heat_systems()
        if self._sweeper is None:
            self._poisson()
        else:
            self._sweeper.prepare()
        return self

    @property
    def nbytes(self) -> int:
        """Bytes of the factors made so far."""
        factors = [system.factor for system in self._systems or []]
        if self._poisson_factor is not None:
            factors.append(self._poisson_factor)
        return sum(factor.nbytes for factor in factors)

    def __getstate__(self) -> dict[str, Any]:
        """Recipes and matrices travel; factors are made again where they arrive."""
        private = ("_lock", "_systems", "_poisson_factor", "_sweeper")
        return {name: value for name, value in self.__dict__.items() if name not in private}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._sweeper = WavefrontSweeper(self.metric) if self.refine else None
        self._lock = threading.RLock()
        self._systems = None
        self._poisson_factor = None

    def __repr__(self) -> str:
        diffusion = (
            "" if self.diffusion is self.metric else f", diffusion={self.diffusion.gradient!r}"
        )
        boundary = "" if self.boundary == "neumann" else f", boundary={self.boundary!r}"
        boundary += ", refine=True" if self.refine else ""
        return (
            f"HeatMethod({self.n_vertices} vertices, {self.metric.gradient!r}{diffusion}, "
            f"time={self.time:.4g}{boundary}, heat_solver={self.heat_solver!r}, "
            f"poisson_solver={self.poisson_solver!r}, factors of {self.nbytes / 1e6:.1f} MB)"
        )


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


def as_vertices(sources: Any, n_vertices: int, name: str = "sources") -> IntArray:
    """Return `sources` as a one-dimensional array of vertex indices, checked.

    Raises
    ------
    InvalidSourceError
        None at all, something that is not an integer, an index out of range.
    """
    try:
        array = np.atleast_1d(np.asarray(sources))
    except (ValueError, TypeError) as error:
        raise InvalidSourceError(f"{name} cannot be read as indices: {error}") from error
    if array.size == 0:
        raise InvalidSourceError(f"{name}: there are none; give at least one vertex")
    if array.dtype.kind not in "iu" or array.ndim != 1:
        raise InvalidSourceError(
            f"{name} must be vertex indices, one integer or a one-dimensional array of them, "
            f"not {array.dtype} of shape {np.shape(sources)}"
        )
    outside = (array < 0) | (array >= n_vertices)
    if outside.any():
        raise InvalidSourceError(
            f"{name}: vertex {array[outside][0]} does not exist; there are {n_vertices}, "
            "numbered from 0"
        )
    return np.asarray(array, dtype=np.int64)


def _time_step(time: float | None, time_factor: float, spacing: float) -> float:
    try:
        given = {"time": None if time is None else float(time), "time_factor": float(time_factor)}
    except (TypeError, ValueError) as error:
        raise InvalidOptionError(f"time and time_factor must be numbers: {error}") from error
    for name, value in given.items():
        if value is not None and not (np.isfinite(value) and value > 0):
            raise InvalidOptionError(f"{name} must be positive and finite, not {value}")
    if time is not None and time_factor != 1.0:
        raise InvalidOptionError("give time or time_factor, not both")
    return float(time) if time is not None else float(time_factor) * spacing**2
