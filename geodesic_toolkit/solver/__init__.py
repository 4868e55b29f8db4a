"""One shape, many sources: the solver that users hold, and what it tells of itself.

Imports everything below it, down to domains; nothing below imports it.
"""

from geodesic_toolkit.solver.solver import GeodesicSolver

__all__ = ["GeodesicSolver"]
