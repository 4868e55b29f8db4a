"""Linear solvers: one file for each, all with one interface."""

from geodesic_toolkit.linear.base import Factor, LinearSolver

__all__ = ["Factor", "LinearSolver"]
