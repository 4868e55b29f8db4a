"""The laws of a Laplace operator, by subject matter: functions of a subject."""

from geodesic_toolkit.testing.operator_laws.algebra import ALGEBRA_LAWS
from geodesic_toolkit.testing.operator_laws.data import DATA_LAWS, REFUSAL_LAWS
from geodesic_toolkit.testing.operator_laws.distance import DISTANCE_LAWS
from geodesic_toolkit.testing.operator_laws.frames import FRAME_LAWS
from geodesic_toolkit.testing.operator_laws.subject import OperatorSubject
from geodesic_toolkit.testing.operator_laws.symmetry import SYMMETRY_LAWS
from geodesic_toolkit.testing.recipe_laws import RECIPE_LAWS

__all__ = ["OPERATOR_LAWS", "OperatorSubject"]

OPERATOR_LAWS = (
    *RECIPE_LAWS,
    *DATA_LAWS,
    *ALGEBRA_LAWS,
    *DISTANCE_LAWS,
    *SYMMETRY_LAWS,
    *FRAME_LAWS,
    *REFUSAL_LAWS,
)
"""The contract of :class:`~geodesic_toolkit.LaplaceOperator`, in the order of its report."""
