"""Experiment 3: which Laplacian the heat flows in."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.laplacians.base import LaplaceOperator
from geodesic_toolkit.laplacians.cotan import CotanLaplacian
from geodesic_toolkit.laplacians.uniform import UniformLaplacian
from geodesic_toolkit_study.noise import rank_correlation
from geodesic_toolkit_study.subject import Subject

__all__ = ["Discretizations", "study_discretizations"]

UNIFORM = UniformLaplacian(mass="identity")

CASES: tuple[tuple[str, LaplaceOperator, str], ...] = (
    ("cotan, Voronoi areas", CotanLaplacian(mass="voronoi"), "h"),
    ("cotan, barycentric areas", CotanLaplacian(), "h"),
    ("uniform, identity mass", UNIFORM, "h"),
    ("uniform, identity mass", UNIFORM, "1"),
    ("cotan, Voronoi areas", CotanLaplacian(mass="voronoi"), "h^2"),
    ("cotan, barycentric areas", CotanLaplacian(), "h^2"),
)
"""Diffusions and time steps; the first four are those of the first experiments."""


@dataclass
class Discretizations:
    """Results of the experiment.

    Attributes
    ----------
    rows : list of dict
        One for each case and source.
    heats : dict
        From (diffusion, time, source) to log10 of u over its largest value.
    distances : dict
        From the same to the distance.
    """

    rows: list[dict[str, Any]] = field(default_factory=list)
    heats: dict[tuple[str, str, int], FloatArray] = field(default_factory=dict)
    distances: dict[tuple[str, str, int], FloatArray] = field(default_factory=dict)


def study_discretizations(subject: Subject) -> Discretizations:
    """Diffuse by each operator; gradient and Poisson equation stay those of the mesh."""
    found = Discretizations()
    for diffusion, operator, time in CASES:
        method = subject.heat_method(
            diffusion=operator.assemble(subject.mesh), time=subject.times[time]
        )
        for source in subject.sources:
            log_heat = method.log_heat(source) / np.log(10)
            heat = log_heat - log_heat.max()
            distance = method.distance(source)
            error = subject.error(distance, source)
            found.heats[diffusion, time, source] = heat
            found.distances[diffusion, time, source] = distance
            found.rows.append(
                {
                    "diffusion": diffusion,
                    "time": time,
                    "source": source,
                    "decades_of_u": float(-heat[np.isfinite(heat)].min()),
                    "rank_correlation": rank_correlation(-heat, subject.true(source)),
                    "mean_error": error["mean"],
                    "largest_error": error["largest"],
                }
            )
    return found
