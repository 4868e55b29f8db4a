"""CHOLMOD as a linear solver of geodesic-toolkit."""

from geodesic_toolkit_cholmod.cholmod import Cholmod

__all__ = ["Cholmod"]
