"""Algebraic multigrid as a linear solver of geodesic-toolkit."""

from geodesic_toolkit_amg.multigrid import AMG

__all__ = ["AMG"]
