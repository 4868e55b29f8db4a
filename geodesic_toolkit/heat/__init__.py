"""The heat method: diffusion, unit gradients, the Poisson step. Begin with ``method``.

Imports discretizations, linear solvers, sources and refinement; it knows no domain.
"""

from geodesic_toolkit.heat.diffusion import HeatReport
from geodesic_toolkit.heat.method import HeatMethod
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["HeatMethod", "HeatReport", "SourcePoints"]
