"""Experiment 2: noise on the vertices."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.solver.solver import GeodesicSolver
from geodesic_toolkit_study.subject import Subject, error_of

__all__ = ["Noise", "rank_correlation", "study_noise"]

LEVELS = (0.001, 0.0025, 0.005, 0.01)
"""Standard deviations of the noise, as shares of the bounding box's diagonal."""


@dataclass
class Noise:
    """Results of the experiment; everything at t = h² of the mesh that is measured.

    Attributes
    ----------
    rows : list of dict
        One for each level and source.
    subjects : dict
        From the level to the noisy mesh.
    distances, log_heats : dict
        From (level, source), level 0 being the clean mesh, to the distance and to log u.
    """

    rows: list[dict[str, Any]] = field(default_factory=list)
    subjects: dict[float, Subject] = field(default_factory=dict)
    distances: dict[tuple[float, int], FloatArray] = field(default_factory=dict)
    log_heats: dict[tuple[float, int], FloatArray] = field(default_factory=dict)


def study_noise(subject: Subject) -> Noise:
    """Move the vertices by Gaussian noise; compare heat, distance and true distance."""
    found = Noise()
    shift = np.random.default_rng(subject.seed).normal(size=subject.mesh.vertices.shape)
    for source in subject.sources:
        found.log_heats[0.0, source] = subject.method.log_heat(source)
        found.distances[0.0, source] = subject.method.distance(source)
    for level in LEVELS:
        sigma = level * subject.diagonal
        mesh = TriangleMesh(subject.mesh.vertices + sigma * shift, subject.mesh.faces)
        noisy = Subject(mesh, subject.name, subject.sources)
        automatic = GeodesicSolver(mesh, refine=False)
        found.subjects[level] = noisy
        for source in subject.sources:
            log_heat = noisy.method.log_heat(source)
            distance = noisy.method.distance(source)
            found.log_heats[level, source] = log_heat
            found.distances[level, source] = distance
            clean_log = found.log_heats[0.0, source]
            clean_distance = found.distances[0.0, source]
            found.rows.append(
                {
                    "source": source,
                    "sigma_of_diagonal": level,
                    "sigma_of_edge": sigma / subject.h,
                    "edge_growth": 100 * (noisy.h / subject.h - 1),
                    "rank_correlation_of_u": rank_correlation(clean_log, log_heat),
                    "rank_correlation_of_distance": rank_correlation(clean_distance, distance),
                    "change_of_distance": error_of(distance, clean_distance)["mean"],
                    "change_of_true": error_of(noisy.true(source), subject.true(source))["mean"],
                    "error_on_clean": subject.error(clean_distance, source)["mean"],
                    "non_positive": noisy.method.heat_report(source).non_positive,
                    "error_on_noisy": noisy.error(distance, source)["mean"],
                    "error_of_auto": noisy.error(automatic.distance(source), source)["mean"],
                    "error_across": subject.error(distance, source)["mean"],
                }
            )
    return found


def rank_correlation(first: FloatArray, second: FloatArray) -> float | None:
    """Return Spearman's rank correlation where both are finite; None where one does not vary.

    Examples
    --------
    >>> import numpy as np
    >>> rank_correlation(np.array([1.0, 2.0, 9.0]), np.array([-3.0, -2.0, -1.0]))
    1.0
    """
    from scipy.stats import rankdata  # half a second: not before it is needed

    both = np.isfinite(first) & np.isfinite(second)
    ranks = np.stack([rankdata(first[both]), rankdata(second[both])])
    if both.sum() < 2 or (np.ptp(ranks, axis=1) == 0).any():
        return None
    return round(float(np.asarray(np.corrcoef(ranks))[0, 1]), 6)
