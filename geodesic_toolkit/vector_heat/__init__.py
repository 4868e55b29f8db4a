"""Vectors in heat: the vector heat method beside the scalar one, over tangent frames.

It knows no domain. Imports the heat method, discretizations and linear solvers.
"""

from geodesic_toolkit.vector_heat.method import VectorHeatMethod

__all__ = ["VectorHeatMethod"]
