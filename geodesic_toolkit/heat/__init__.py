"""The heat method: diffusion, unit gradients, the Poisson step. Begin with ``method``.

It imports discretizations, linear solvers, sources and refinement, but not domains.
"""

from geodesic_toolkit.heat.diffusion import HeatReport
from geodesic_toolkit.heat.method import HeatMethod
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["HeatMethod", "HeatReport", "SourcePoints"]
