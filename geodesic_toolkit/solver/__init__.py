"""The solver: one shape, many sources, and diagnosis.

Imports everything below it, down to domains; nothing below imports it.
"""

from geodesic_toolkit.solver.solver import GeodesicSolver

__all__ = ["GeodesicSolver"]
