"""The heat method, readable beside the paper.

K. Crane, C. Weischedel, M. Wardetzky, *Geodesics in Heat: A New Approach to Computing Distance
Based on Heat Flow*, ACM Transactions on Graphics 32, 2013, https://doi.org/10.1145/2516971.2516977
"""

from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.arrays import empty
from geodesic_toolkit.core.checks import is_one_of
from geodesic_toolkit.core.near import NearRows
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.discretization.data import Discretization, check_discretization
from geodesic_toolkit.discretization.fronts import Fronts as MetricFronts
from geodesic_toolkit.discretization.heat import Heat
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.heat.blocks import (
    SOURCE_SETS_PER_BLOCK,
    in_blocks,
    on_threads,
    side_by_side,
)
from geodesic_toolkit.heat.diffusion import Boundary, HeatReport
from geodesic_toolkit.heat.graphs import (
    ScaledGradient,
    instead_of_heat,
    limit_to_edges,
    near_instead_of_heat,
)
from geodesic_toolkit.heat.poisson import PoissonStep
from geodesic_toolkit.heat.positive import PositiveFlow, worse
from geodesic_toolkit.heat.refined import Fronts, RefinedStep
from geodesic_toolkit.heat.time_step import time_steps
from geodesic_toolkit.linear.base import Analysis, LinearSolver
from geodesic_toolkit.linear.memory import array_bytes, require_memory
from geodesic_toolkit.linear.patterns import SharedAnalysis
from geodesic_toolkit.refinement.bounds import DistanceBounds
from geodesic_toolkit.refinement.polyhedra import SmallParts
from geodesic_toolkit.refinement.wavefronts import WavefrontSweeper
from geodesic_toolkit.sources.points import SourcePoints, as_vertices

__all__ = ["Boundary", "HeatMethod", "HeatReport", "Progress", "SourcePoints"]

Progress: TypeAlias = Callable[[int, int], None]

SETS_OF_FRONTS_PER_BLOCK = 256
"""Source sets whose near vertices fronts visit in one call; shortest paths along edges need a row
of distances for each."""


class HeatMethod:
    """Geodesic distance by heat, for any discretization, whatever the domain and Laplacian.

    1. Diffuse: ``(M + t L) u = δ`` with L = -Δ positive semidefinite, kept as ``log u`` so that u
       may be arbitrarily small.
    2. Normalise: ``X = -∇u / |∇u|``.
    3. Integrate: ``Δφ = ∇·X``, which is ``L φ = Gᵀ W X``; the right-hand side is *minus* the
       integrated divergence of X, as L is -Δ.

    Both systems are factorised once and used for every source.

    Parameters
    ----------
    metric : Discretization
        Discretization in which gradients are taken and integrated.
    diffusion : Discretization, optional
        Discretization in which heat flows, on the same vertices; the metric by default.
    time : float, optional
        Time step t, in squared length; ``time_factor * metric.scales**2`` by default, one value
        in each connected component.
    time_factor : float
        Time step in units of the squared mean edge length; 1 is the paper's choice. Larger values
        smooth; smaller ones sharpen, until distances follow edges.
    boundary : {"neumann", "dirichlet", "average"}
        Condition on the heat at the boundary: insulated, held at zero, or the mean of both heats.
    heat_solver, poisson_solver : LinearSolver
        Solvers of steps 1 and 3. Step 1 needs a componentwise accurate one.
    refine : bool
        Instead of steps 2 and 3, sweep wavefronts over the triangles in the order of the heat
        (``WavefrontSweeper``). This is several times more accurate, exact at the sources, and does
        not factorise the Poisson system. The metric has to be made of triangles. On a graph whose
        metric has paths along edges, take the shortest of these instead, without heat.
    across : bool
        On a graph whose metric has corners: let fronts cross these, without heat. For a metric with
        fronts of its own: measure with them, without heat.
    bounds : DistanceBounds, optional
        Bounds that refined distances are limited to.
    small_parts : SmallParts, optional
        Components of a mesh on which exact distances replace refined ones.

    Raises
    ------
    InvalidOptionError
        A time step that is not positive and finite, or so long that the mass is lost in rounding;
        both `time` and a `time_factor`; an unknown boundary condition; a heat solver that cannot
        resolve small values.
    UnsupportedDomainError
        Metric and diffusion with different numbers of vertices; refinement of something else than
        triangles or graphs; a graph that heat cannot measure.
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
        across: bool = False,
        bounds: DistanceBounds | None = None,
        small_parts: SmallParts | None = None,
    ) -> None:
        self.metric = check_discretization(metric, "metric")
        self.diffusion = metric if diffusion is None else diffusion
        check_discretization(self.diffusion, "diffusion")
        if self.diffusion.n_vertices != metric.n_vertices:
            raise UnsupportedDomainError(
                f"the diffusion has {self.diffusion.n_vertices} vertices, "
                f"the metric {metric.n_vertices}"
            )
        self.times = time_steps(time, time_factor, metric, self.diffusion)
        if not is_one_of(boundary, ("neumann", "dirichlet", "average")):
            raise InvalidOptionError(
                f'boundary must be "neumann", "dirichlet" or "average", not {boundary!r}'
            )
        self.boundary = boundary
        for name, solver in (("heat_solver", heat_solver), ("poisson_solver", poisson_solver)):
            if not isinstance(solver, LinearSolver):
                raise InvalidOptionError(
                    f"{name} must be a LinearSolver, such as Supernodal(), not {a_kind_of(solver)}"
                )
        if not (heat_solver.componentwise or heat_solver.allow_heat):
            raise InvalidOptionError(
                f"{type(heat_solver).__name__} cannot resolve the small values of heat, far from "
                'the source; use it for the Poisson step only, solver={"poisson": ...}, or accept '
                "this with its option allow_heat=True"
            )
        self.heat_solver = heat_solver
        self.poisson_solver = poisson_solver
        if not isinstance(refine, bool | np.bool_):
            raise InvalidOptionError(f"refine must be True or False, not {refine!r}")
        self.refine = bool(refine)
        self.across = across
        if across and (self.refine or (metric.across_edges is None and metric.fronts is None)):
            raise UnsupportedDomainError(
                "across=True needs refine=False, and a graph with corners for fronts to cross or a "
                "metric with fronts of its own"
            )
        self.bounds, self.small_parts = bounds, small_parts
        paths = metric.along_edges
        if paths is not None and paths.instead_of_heat and not (self.refine or across):
            raise UnsupportedDomainError(f"{paths.instead_of_heat}; use refine=True")
        self._set_up()

    # -- the three steps -----------------------------------------------------------------------

    def _solve(self, block: Sequence[SourcePoints], distances: FloatArray) -> HeatReport | None:
        """Write the distances from one block of source sets, (K, N)."""
        if not self.flows:
            instead_of_heat(self.metric, self.across, block, distances)
            return None
        if self._refined is not None:
            heat, report = self._diffuse(block)
            self._refined.distances(heat, self._at_representatives(block), distances)
            if len(self.metric.representatives):
                distances[:] = self._from_representatives(distances)
            return None  # fronts use only the order of heat: negative values are harmless
        heat, report = self._diffuse(block, self._workspace(block, distances))
        # (M + t L) u = δ is solved; now X = -∇u / |∇u|, and its divergence Gᵀ W X,
        load = self._gradient().descent_load(heat.squeezed())
        # and L φ = Gᵀ W X, with φ = 0 at the sources.
        self._poisson.distances(load, heat, self._at_representatives(block), distances)
        limit_to_edges(self.metric, block, distances)
        return report

    def distance(self, sources: ArrayLike | SourcePoints) -> FloatArray:
        """Return the geodesic distance from one set of sources.

        Parameters
        ----------
        sources : int, array-like of int, or SourcePoints
            Vertex indices, or points between them.

        Returns
        -------
        ndarray of shape (N,), float64
            In the unit of the domain; ``inf`` at vertices that are not connected to a source. The
            distance at a source vertex is exactly 0, or its offset, and distances are never below
            the smallest of these.

        Raises
        ------
        InvalidSourceError
            An empty set, an index out of range, or a value that is not an index.
        """
        distances = empty((1, self.n_vertices), np.float64)
        self._warn_of(self._solve([self._source_points(sources)], distances))
        return np.asarray(distances[0])

    def distances(
        self, source_sets: Iterable[Any], *, progress: Progress | None = None
    ) -> FloatArray:
        """Return the geodesic distances from K sets of sources, solved in blocks.

        Parameters
        ----------
        source_sets : iterable of source sets
            A one-dimensional array of integers means that many single sources.
        progress : callable, optional
            Called with the number of finished sets and their total after each block.

        Returns
        -------
        ndarray of shape (K, N), float64
            One row for each set, as `distance` returns it.

        Raises
        ------
        InvalidSourceError
            As for `distance`; the message names the set.
        NotEnoughMemoryError
            The table would not fit in memory.
        """
        points = [self._source_points(sources, k) for k, sources in enumerate(source_sets)]
        require_memory(
            8.0 * len(points) * self.n_vertices,
            f"the table of distances from {len(points)} source sets to {self.n_vertices} vertices",
        )
        distances = empty((len(points), self.n_vertices), np.float64)
        done, worst = 0, None
        is_refined = self._refined is not None  # sweeps share the processors themselves
        for rows, report in in_blocks(points, distances, self._solve, threads=not is_refined):
            done += rows
            worst = worse(worst, report)
            if progress is not None:
                progress(done, len(points))
        self._warn_of(worst)
        return distances

    def near(self, points: Sequence[SourcePoints], limits: FloatArray) -> NearRows:
        """Return the distances from K source sets up to a limit for each.

        They have the bits of those of `distances`. Where fronts measure them, on graphs and on
        triangles, they end a little beyond the limit; heat alone has no end.

        Parameters
        ----------
        points : sequence of SourcePoints
        limits : ndarray of shape (K,), float64

        Returns
        -------
        NearRows
        """

        def solve(start: int) -> NearRows:
            block = slice(start, start + size)
            return self._near_block(points[block], limits[block])

        size = SOURCE_SETS_PER_BLOCK if self.flows else SETS_OF_FRONTS_PER_BLOCK
        starts = range(0, len(points), size)
        if not self.flows:  # these kernels share the processors themselves
            return NearRows.together([solve(start) for start in starts])
        return NearRows.together(on_threads(solve, starts, self.n_vertices))

    @property
    def ends_at_limits(self) -> bool:
        """True if `near` costs less than `distances`: fronts end, and heat alone does not."""
        if self.flows:
            return self._refined is not None and self._refined.has_near
        fronts = self.metric.fronts if self.across else None
        return fronts is None or type(fronts).near is not MetricFronts.near

    def _near_block(self, block: Sequence[SourcePoints], limits: FloatArray) -> NearRows:
        if not self.flows:
            return near_instead_of_heat(self.metric, self.across, block, limits)
        if self._refined is None or not self._refined.has_near:
            return self._near_of_all(block, limits)
        heat, _ = self._diffuse(block)
        near, are_known = self._refined.near(heat, self._at_representatives(block), limits)
        if len(self.metric.representatives):
            near = near.taken_from(self.metric.representatives)
        rest = np.flatnonzero(~are_known)
        if not len(rest):
            return near
        return near.replaced(
            rest, self._near_of_all([block[k] for k in rest.tolist()], limits[rest])
        )

    def _near_of_all(self, block: Sequence[SourcePoints], limits: FloatArray) -> NearRows:
        """Return the distances up to limits among those to all vertices."""
        distances = empty((len(block), self.n_vertices), np.float64)
        self._warn_of(self._solve(block, distances))
        return NearRows.of_table(distances, limits)

    def fronts(self, points: SourcePoints, around: SourcePoints | None = None) -> Fronts:
        """Return the fronts of one source set, whether distances are refined or not.

        Parameters
        ----------
        points : SourcePoints
        around : SourcePoints, optional
            The same with more vertices around them, for fronts to begin at.

        Returns
        -------
        Fronts

        Raises
        ------
        UnsupportedDomainError
            The metric is not made of triangles.
        """
        heat, _ = self._diffuse([points])
        return self._sweeps.fronts(heat, points, points if around is None else around)

    def log_heat(
        self, sources: ArrayLike | SourcePoints, *, only_order: bool = False
    ) -> FloatArray:
        """Return the logarithm of the heat u of step 1, of shape (N,), over an unlimited range.

        It is ``-inf`` at vertices without heat: in other components, and at a Dirichlet boundary.
        Parameters and errors are those of `distance`. With `only_order`, for callers that use only
        the order of the values, a warning of heat that is not positive is not given.
        """
        heat, worst = self._diffuse([self._source_points(sources)])
        self._warn_of(None if only_order else worst)
        return self._from_representatives(heat.log()[:, 0])

    def heat(self, sources: ArrayLike | SourcePoints) -> FloatArray:
        """Return the heat u of step 1 as the solver gives it, of shape (N,).

        It underflows some 700 edges from the source, and shows the zeros and negative values that
        `log_heat` removes. Parameters and errors are those of `distance`.
        """
        return self._from_representatives(
            self._flow.own.heat(self._at_representatives([self._source_points(sources)]))[:, 0]
        )

    def heat_report(self, sources: ArrayLike | SourcePoints) -> HeatReport:
        """Return a report on the heat of one source set: its reach and non-positive values.

        Parameters and errors are those of `distance`.
        """
        _, reports = self._flow.own.diffuse(
            self._at_representatives([self._source_points(sources)])
        )
        return reports[0]

    def integrate(self, field: FloatArray) -> FloatArray:
        """Return φ with ``L φ = Gᵀ W X`` for any field X, and φ = 0 at one vertex per component.

        Parameters
        ----------
        field : ndarray
            A value for each row of ``metric.gradient.matrix``: (E, dim) on elements, (E,) on edges,
            with one more axis for K fields at once.

        Returns
        -------
        ndarray of shape (N,) or (N, K)
        """
        return self._poisson.factor().solve(self.metric.gradient.adjoint(field))

    # -- step 1 --------------------------------------------------------------------------------

    def log_diffuse(self, loads: FloatArray) -> FloatArray:
        """Return log u with ``(M + t L) u = b`` for any loads b, insulated at boundaries.

        If u would not be positive everywhere, it is the heat of the positive part of the diffusion.

        Parameters
        ----------
        loads : ndarray of shape (N, K), float64
            Not negative.

        Returns
        -------
        ndarray of shape (N, K), float64
            ``-inf`` at vertices without heat.
        """
        return self._flow.log_solve(loads)[0]

    def stays_positive(self, load: FloatArray) -> bool:
        """Return True if the heat of a load is positive at every vertex that it reaches.

        Parameters
        ----------
        load : ndarray of shape (N,), float64
            Heat at time 0, not negative.

        Returns
        -------
        bool
        """
        return self._flow.is_positive(load)

    @property
    def known_analysis(self) -> Analysis | None:
        """The analysis of the heat system, if that has been factorised."""
        return self._heat_analysis.known

    def _diffuse(
        self, block: Sequence[SourcePoints], workspace: FloatArray | None = None
    ) -> tuple[Heat, HeatReport | None]:
        return self._flow.diffuse(self._at_representatives(block), workspace)

    def _workspace(self, block: Sequence[SourcePoints], distances: FloatArray) -> FloatArray | None:
        """Return the memory of the distances, for the heat to be written to.

        Memory is slow the first time that it is written to. Heat of points with an offset is
        needed after the distances, to find the overtaken points, and so needs its own memory.
        """
        if any(points.delayed for points in block):
            return None
        return distances.reshape(self.n_vertices, len(block))

    def _warn_of(self, report: HeatReport | None) -> None:
        self._flow.warn_of(report, self.metric)

    # -- graphs --------------------------------------------------------------------------------

    @property
    def flows(self) -> bool:
        """True if distances come from heat, or from the order in which heat decreases."""
        return not (self.across or (self.refine and self.metric.along_edges is not None))

    def _at_representatives(self, block: Sequence[SourcePoints]) -> Sequence[SourcePoints]:
        """Return sources moved to the representatives of their vertices."""
        others = self.metric.representatives
        return [points.moved_to(others) for points in block] if len(others) else block

    def _from_representatives(self, values: FloatArray) -> FloatArray:
        """Return values (..., N) with that of its representative at each vertex."""
        others = self.metric.representatives
        return np.asarray(values[..., others]) if len(others) else values

    @property
    def local_dimensions(self) -> FloatArray | None:
        """The effective dimension at each vertex by the local scale of a graph, (N,).

        NaN at vertices without edges; None without a local scale.
        """
        if not self.flows or not self.metric.local_scale:
            return None
        return self._gradient.dimensions()

    # -- sources -------------------------------------------------------------------------------

    def _source_points(self, sources: Any, position: int | None = None) -> SourcePoints:
        if isinstance(sources, SourcePoints):
            return sources
        name = "sources" if position is None else f"source set {position}"
        return SourcePoints.at_vertices(
            as_vertices(sources, self.n_vertices, name), self.n_vertices
        )

    # -- the object ----------------------------------------------------------------------------

    def _set_up(self) -> None:
        """Create the state that is not part of the recipe: the steps and their analyses."""
        # Both systems have one pattern if metric and diffusion do.
        self._shares_analysis = self.poisson_solver == self.heat_solver and not self.refine
        self._heat_analysis = SharedAnalysis(self.heat_solver, 2 if self._shares_analysis else 1)
        self._poisson_analysis = (
            self._heat_analysis if self._shares_analysis else SharedAnalysis(self.poisson_solver)
        )
        self._flow = PositiveFlow(
            self.diffusion, self.times, self.boundary, self.heat_solver, self._heat_analysis
        )
        self._poisson = PoissonStep(self.metric, self.diffusion, self._poisson_analysis)
        self._gradient = ScaledGradient(
            self.metric,
            lambda block: self._diffuse(block)[0],
            lambda load: self._poisson.factor().solve(load),
        )
        self._refined = (
            RefinedStep(self.metric, self.small_parts, self.bounds)
            if self.refine and self.flows
            else None
        )

    @cached_property
    def _sweeps(self) -> RefinedStep:
        """The refined step, or where distances are plain one without bounds."""
        return self._refined or RefinedStep(self.metric, None, None)

    @property
    def sweeper(self) -> WavefrontSweeper:
        """The triangles of the metric, prepared for fronts, whether distances are refined or not.

        Raises
        ------
        UnsupportedDomainError
            The metric is not made of triangles.
        """
        return self._sweeps.sweeper

    @property
    def n_vertices(self) -> int:
        """Number N of vertices."""
        return self.metric.n_vertices

    @property
    def time(self) -> float:
        """The time step t, in squared length; that of the largest connected component."""
        if isinstance(self.times, float):
            return self.times
        sizes = np.bincount(self.diffusion.components)
        return float(self.times[np.argmax(self.diffusion.components == sizes.argmax())])

    def prepare(self) -> "HeatMethod":
        """Factorise now rather than on first use, and return the method.

        Refined distances do not need the Poisson system, which is then not factorised.
        """
        if not self.flows:
            return self
        second = self._poisson.factor if self._refined is None else self._refined.prepare
        side_by_side(self._flow.own.systems, second, self.n_vertices)
        self._gradient()
        return self

    @property
    def nbytes(self) -> int:
        """Bytes of the factors made so far."""
        return self._flow.nbytes + self._poisson.nbytes

    @property
    def expected_bytes(self) -> float:
        """Bytes that building was expected to take, estimated before factors were computed.

        They include the discretization, both systems and their factors; 0 if the linear solver
        does not predict that. They are at least the memory of assembly, if the notes of the
        operator give it (`assembly_bytes`): making stars takes more than factors.
        """
        if not self.flows:
            return array_bytes(self.metric, self.diffusion)
        systems = [system.matrix for system in self._flow.own.systems()]
        factors = self._heat_analysis.expected_bytes()
        if factors and not self._shares_analysis and self._refined is None:
            factors += self._poisson_analysis.expected_bytes()
        poisson = 0 if self._refined is not None else self.metric.rows.data.nbytes
        needed = factors + poisson + array_bytes(self.metric, self.diffusion, *systems)
        return float(max(needed, self.metric.notes.get("assembly_bytes", 0.0)))

    def __getstate__(self) -> dict[str, Any]:
        """Return recipes and matrices without factors, which are made again after unpickling."""
        return {name: value for name, value in self.__dict__.items() if not name.startswith("_")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._set_up()

    def __repr__(self) -> str:
        diffusion = (
            "" if self.diffusion is self.metric else f", diffusion={self.diffusion.gradient!r}"
        )
        boundary = "" if self.boundary == "neumann" else f", boundary={self.boundary!r}"
        boundary += ", refine=True" if self.refine else ""
        boundary += ", across=True" if self.across else ""
        return (
            f"HeatMethod({self.n_vertices} vertices, {self.metric.gradient!r}{diffusion}, "
            f"time={self.time:.4g}{boundary}, heat_solver={self.heat_solver!r}, "
            f"poisson_solver={self.poisson_solver!r}, factors of {self.nbytes / 1e6:.1f} MB)"
        )
