"""The algebra of a shape: mass, stiffness, and a gradient whose adjoint is the divergence.

The divergence is always the adjoint of the gradient: every discretization satisfies the identity
``L = Gᵀ W G`` with L = -Δ positive semidefinite, on which the heat method rests. This package
imports geometry and domains.
"""

from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.edge_gradient import EdgeGradient
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.discretization.fronts import Fronts
from geodesic_toolkit.discretization.gradient import Gradient
from geodesic_toolkit.discretization.subdivision import Subdivision

__all__ = [
    "Discretization",
    "EdgeGradient",
    "ElementGradient",
    "Fronts",
    "Gradient",
    "Subdivision",
]
