"""Experiment 1: the time step, and what an iterative solver does to the heat."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.heat.method import HeatMethod
from geodesic_toolkit.linear.cg import CG
from geodesic_toolkit.linear.superlu import SuperLU
from geodesic_toolkit_study.krylov import conjugate_gradients, heat_matrix, rings
from geodesic_toolkit_study.subject import Subject

__all__ = ["LARGEST_POISSON_BY_CG", "TimeStep", "distance_from_heat", "study_time_step"]

RTOL = 1e-5
"""SciPy's default tolerance for conjugate gradients, which the first experiments used."""

LARGEST_POISSON_BY_CG = 5_000
"""Vertices up to which the Poisson equation is solved by conjugate gradients as well.

They take thousands of steps there on meshes of thin triangles, and change almost nothing.
"""

TOLERANCES = tuple(10.0**-power for power in range(5, 15))


@dataclass
class TimeStep:
    """Results of the experiment.

    Attributes
    ----------
    rows : list of dict
        One for each source, time and solver.
    tolerances : list of dict
        One for each source and tolerance of conjugate gradients, at t = h².
    distances : dict
        From (source, time, solver) to the distance.
    heats : dict
        From (source, solver) to the heat at t = h².
    rings : dict
        From the source to the number of edges from it to each vertex.
    spread : dict
        From the source to the number of vertices that each step of conjugate gradients reached.
    """

    rows: list[dict[str, Any]] = field(default_factory=list)
    tolerances: list[dict[str, Any]] = field(default_factory=list)
    distances: dict[tuple[int, str, str], FloatArray] = field(default_factory=dict)
    heats: dict[tuple[int, str], FloatArray] = field(default_factory=dict)
    rings: dict[int, FloatArray] = field(default_factory=dict)
    spread: dict[int, IntArray] = field(default_factory=dict)

    @property
    def heat_zeros(self) -> list[dict[str, Any]]:
        """Number of entries of the heat that are exactly 0, one object for each run."""
        names = ("source", "time", "solver", "rtol", "zeros")
        return [{name: row[name] for name in names} for row in self.rows]


def study_time_step(subject: Subject) -> TimeStep:
    """Solve both systems by conjugate gradients and directly, at three time steps."""
    found = TimeStep()
    direct = SuperLU()
    by_cg = subject.mesh.n_vertices <= LARGEST_POISSON_BY_CG
    poisson = subject.heat_method(poisson_solver=CG(rtol=RTOL)) if by_cg else subject.method
    for name, time in subject.times.items():
        matrix = heat_matrix(subject.metric, time)
        factor = direct.factorize(matrix)
        for source in subject.sources:
            spike = np.zeros(subject.mesh.n_vertices)
            spike[source] = 1.0
            run = conjugate_gradients(matrix, spike, RTOL)
            exact_heat = factor.solve(spike)
            _add(found, subject, (source, name, "cg"), run.solution, poisson)
            found.rows[-1] |= {"rtol": RTOL, "iterations": run.iterations}
            found.rows[-1]["converged"] = run.converged
            _add(found, subject, (source, name, "superlu"), exact_heat, subject.method)
            if name == "h^2":
                found.heats |= {(source, "cg"): run.solution, (source, "superlu"): exact_heat}
                found.spread[source] = run.non_zero
                found.rings[source] = rings(matrix, source)
                for rtol in TOLERANCES:
                    again = conjugate_gradients(matrix, spike, rtol)
                    row = _row(subject, source, again.solution, subject.method)[0]
                    row |= {"rtol": rtol, "iterations": again.iterations}
                    found.tolerances.append(row | {"converged": again.converged})
    return found


def distance_from_heat(method: HeatMethod, heat: FloatArray, source: int) -> FloatArray:
    """Return the distance from raw heat, whatever its values: no logarithm, no repair.

    X = -∇u/|∇u| on each face, zero where the gradient is; then ``L φ = Gᵀ W X``. This is the
    method as it is first written down. The library works on log u instead, over an unlimited
    range, and would hide what this experiment is about.
    """
    gradient = method.metric.gradient
    assert isinstance(gradient, ElementGradient)  # that of a mesh
    slope = (gradient.matrix @ heat).reshape(len(gradient.elements), -1)
    length = np.linalg.norm(slope, axis=1, keepdims=True)
    direction = np.divide(slope, length, out=np.zeros_like(slope), where=length > 0)
    potential = method.integrate(-direction)
    components = method.metric.components
    reached = components == components[source]
    distance: FloatArray = np.where(reached, potential - potential[source], np.inf)
    return distance


def _add(
    found: TimeStep,
    subject: Subject,
    key: tuple[int, str, str],
    heat: FloatArray,
    method: HeatMethod,
) -> None:
    row, distance = _row(subject, key[0], heat, method)
    found.rows.append(
        {"source": key[0], "time": key[1], "t": subject.times[key[1]], "solver": key[2]}
        | {"rtol": None, "iterations": None, "converged": True}
        | row
    )
    found.distances[key] = distance


def _row(
    subject: Subject, source: int, heat: FloatArray, method: HeatMethod
) -> tuple[dict[str, Any], FloatArray]:
    """Return the figures of one heat, and its distance; other components do not count."""
    own = heat[subject.reached(source)]
    distance = distance_from_heat(method, heat, source)
    error = subject.error(distance, source)
    return {
        "source": source,
        "zeros": int((own == 0).sum()),
        "non_positive": int((own <= 0).sum()),
        "mean_error": error["mean"],
        "largest_error": error["largest"],
    }, distance
