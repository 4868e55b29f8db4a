"""Positive heat: a diffusion with positive weights replaces one whose heat is not positive."""

import threading
from collections.abc import Sequence
from functools import cached_property, partial

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.core.warning import warn
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.heat import Heat
from geodesic_toolkit.discretization.positivity import has_wrong_signs, positive_part
from geodesic_toolkit.errors import NonPositiveHeatWarning
from geodesic_toolkit.heat.diffusion import Boundary, HeatFlow, HeatReport
from geodesic_toolkit.linear.base import Analysis, LinearSolver
from geodesic_toolkit.refinement.wavefronts import made_of_triangles
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["PositiveFlow", "worse"]


class PositiveFlow:
    """Step 1 of the heat method, and its substitute if heat is not positive.

    Parameters
    ----------
    diffusion : Discretization
    times : float or ndarray of shape (N,)
        Time step t, in squared length.
    boundary : {"neumann", "dirichlet", "average"}
    solver : LinearSolver
    analysis : Analysis
        Analysis of the solver, which other systems share.
    """

    def __init__(
        self,
        diffusion: Discretization,
        times: float | FloatArray,
        boundary: Boundary,
        solver: LinearSolver,
        analysis: Analysis,
    ) -> None:
        self._diffusion, self._solver, self._boundary = diffusion, solver, boundary
        self._make = partial(
            HeatFlow, times=times, boundary=boundary, solver=solver, analysis=analysis
        )
        self.own = self._make(diffusion)
        self._substitute: HeatFlow | None = None
        self._lock = threading.Lock()

    def diffuse(
        self, block: Sequence[SourcePoints], workspace: FloatArray | None = None
    ) -> tuple[Heat, HeatReport | None]:
        """Return the heat of source sets, and the worst report if one is harmful.

        Parameters
        ----------
        block : sequence of SourcePoints
        workspace : ndarray of shape (N, K), optional
            Memory to which the heat may be written.
        """
        heat, reports = self.own.diffuse(block, workspace=workspace)
        harmful = [k for k, report in enumerate(reports) if report.harmful]
        worst = None
        for k in harmful:
            worst = worse(worst, reports[k])
        if not harmful or not self._solver.componentwise:
            return heat, worst
        positive, _ = self._positive().diffuse([block[k] for k in harmful])
        return heat.replaced(harmful, positive), worst

    def _positive(self) -> HeatFlow:
        """Return the flow with the positive part of the weights, on the same edges."""
        with self._lock:
            if self._substitute is None:
                self._substitute = self._make(positive_part(self._diffusion))
            return self._substitute

    def log_solve(self, loads: FloatArray) -> tuple[FloatArray, bool]:
        """Return log u for any loads at vertices, and True if all heat is positive.

        If it is not, log u is that of the substitute. Boundaries are insulated.

        Parameters
        ----------
        loads : ndarray of shape (N, K), float64
            Not negative.

        Returns
        -------
        log_heat : ndarray of shape (N, K), float64
            ``-inf`` at vertices without heat.
        is_positive : bool
        """
        log_heat = self.own.log_solve(loads)
        if not self._solver.componentwise or not self.own.is_cold(log_heat, loads):
            return log_heat, True
        return self._positive().log_solve(loads), False

    def is_positive(self, load: FloatArray) -> bool:
        """Return True if all heat of a load (N,) is positive; at once if no weight is wrong."""
        return not self._has_wrong_signs or self.own.is_positive(load)

    @cached_property
    def _has_wrong_signs(self) -> bool:
        return has_wrong_signs(self._diffusion.rows)

    @property
    def nbytes(self) -> int:
        """Bytes of the factors made so far."""
        return sum(flow.nbytes for flow in (self.own, self._substitute) if flow is not None)

    def warn_of(self, report: HeatReport | None, metric: Discretization) -> None:
        """Warn of heat that is not positive and makes distances wrong, and say what is better."""
        if report is not None:
            warn(self._complaint(report, metric), NonPositiveHeatWarning)

    def _complaint(self, report: HeatReport, metric: Discretization) -> str:
        found = (
            f"the heat is not positive at {report.non_positive} of {report.reached} vertices, and "
            "distances are not reliable; "
        )
        if not self._solver.componentwise:
            return found + "an iterative solver cannot resolve it, a direct one can"
        if self._boundary == "dirichlet" and not has_wrong_signs(self._diffusion.rows):
            return found + 'a boundary held at zero blocks the heat: use boundary="average"'
        found += (
            "the diffusion has weights of the wrong sign, and was replaced by its positive part: "
        )
        if self._diffusion.triangulation not in {"", "intrinsic Delaunay"}:
            return found + "on a triangle mesh CotanLaplacian(intrinsic_delaunay=True) is better"
        if made_of_triangles(metric):
            return found + "refine=True is better, as it uses only the order of the heat"
        return found + "elements with fewer obtuse angles are better: remesh the shape"


def worse(one: HeatReport | None, other: HeatReport | None) -> HeatReport | None:
    """Return the report with the larger share of vertices with heat that is not positive."""
    if one is None or other is None:
        return other if one is None else one
    return max(one, other, key=lambda report: report.non_positive / report.reached)
