"""Discrete gradients, each with its normalisation and its adjoint.

The divergence never stands alone: it is the adjoint of the gradient, so that every discretization
keeps the identity ``L = Gᵀ W G`` on which the heat method rests.
"""

from geodesic_toolkit.gradient.base import Gradient
from geodesic_toolkit.gradient.edges import EdgeGradient
from geodesic_toolkit.gradient.elements import ElementGradient

__all__ = ["EdgeGradient", "ElementGradient", "Gradient"]
