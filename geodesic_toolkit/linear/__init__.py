"""Linear solvers: one a file, all behind one contract."""

from geodesic_toolkit.linear.base import Factor, LinearSolver

__all__ = ["Factor", "LinearSolver"]
