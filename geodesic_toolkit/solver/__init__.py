"""The solver: one shape, many sources, and diagnosis.

It imports all packages below it, down to domains; these do not import it.
"""

from geodesic_toolkit.solver.solver import GeodesicSolver

__all__ = ["GeodesicSolver"]
