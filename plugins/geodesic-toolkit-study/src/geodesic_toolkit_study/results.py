"""Everything that the experiments found, and its machine-readable form."""

from dataclasses import dataclass
from typing import Any

from geodesic_toolkit.cli.output import plain
from geodesic_toolkit_study.beyond import Beyond
from geodesic_toolkit_study.discretizations import Discretizations
from geodesic_toolkit_study.noise import Noise
from geodesic_toolkit_study.subject import Subject
from geodesic_toolkit_study.sweeps import Times
from geodesic_toolkit_study.time_step import TimeStep

__all__ = ["SCHEMA_VERSION", "TIMES", "Results"]

SCHEMA_VERSION = 1
"""Of ``study.json``; raised when a key changes its meaning or goes."""


TIMES = {"h^2": "h²", "h": "h", "1": "1"}
"""Time steps as the report writes them."""


@dataclass(frozen=True, kw_only=True)
class Results:
    """The mesh of the study, and the results of each experiment."""

    subject: Subject
    time_step: TimeStep
    noise: Noise
    discretizations: Discretizations
    beyond: Beyond
    times: Times
    sizes: list[dict[str, Any]]

    @property
    def figures(self) -> dict[str, Any]:
        """All numbers in the types of JSON; lengths in the unit of the mesh, errors in %."""
        subject = self.subject
        figures: dict[str, Any] = plain(
            {
                "schema_version": SCHEMA_VERSION,
                "name": subject.name,
                "vertices": subject.mesh.n_vertices,
                "faces": subject.mesh.n_faces,
                "mean_edge": subject.h,
                "diagonal": subject.diagonal,
                "sources": list(subject.sources),
                "seed": subject.seed,
                "reference": {str(s): subject.reference(s) for s in subject.sources},
                "heat_zeros": self.time_step.heat_zeros,
                "time_step": self.time_step.rows,
                "tolerances": self.time_step.tolerances,
                "entries_reached": {str(s): n for s, n in self.time_step.spread.items()},
                "noise": self.noise.rows,
                "discretizations": self.discretizations.rows,
                "operators": self.beyond.rows,
                "left_out": self.beyond.left_out,
                "time_factors": self.times.rows,
                "time_rules": self.times.rules,
                "sizes": self.sizes,
            }
        )
        return figures
