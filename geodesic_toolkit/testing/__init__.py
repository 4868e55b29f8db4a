"""Shapes with closed-form distances, and contracts as executable checks.

The core, its plugins and ``geodesic-toolkit check NAME`` run the same checks; this package does not
import a test framework.
"""

from geodesic_toolkit.testing import shapes
from geodesic_toolkit.testing.conformance import (
    Check,
    ConformanceReport,
    Measured,
    Outcome,
    run_checks,
)
from geodesic_toolkit.testing.domain import check_domain, domain_checks
from geodesic_toolkit.testing.laplace_operator import (
    check_laplace_operator,
    laplace_operator_checks,
)
from geodesic_toolkit.testing.linear_solver import check_linear_solver, linear_solver_checks
from geodesic_toolkit.testing.samples import DomainSamples, Sample, samples_of

__all__ = [
    "Check",
    "ConformanceReport",
    "DomainSamples",
    "Measured",
    "Outcome",
    "Sample",
    "check_domain",
    "check_laplace_operator",
    "check_linear_solver",
    "domain_checks",
    "laplace_operator_checks",
    "linear_solver_checks",
    "run_checks",
    "samples_of",
    "shapes",
]
