"""The contract of a Laplace operator, as executable checks."""

from collections.abc import Mapping, Sequence
from typing import Any

from geodesic_toolkit.errors import InvalidOptionError
from geodesic_toolkit.laplacians.base import LaplaceOperator
from geodesic_toolkit.testing.conformance import Check, ConformanceReport, as_checks, run_checks
from geodesic_toolkit.testing.operator_laws import OPERATOR_LAWS, OperatorSubject
from geodesic_toolkit.testing.samples import DomainSamples, samples_of

__all__ = ["OPERATOR_LAWS", "check_laplace_operator", "laplace_operator_checks"]


def laplace_operator_checks(
    operator: LaplaceOperator,
    *,
    samples: Sequence[DomainSamples[Any]] | None = None,
    expected_failures: Mapping[str, str] | None = None,
) -> list[Check]:
    """Return the contract of a Laplace operator as a list of checks, one per law.

    Parameters
    ----------
    operator : LaplaceOperator
        An instance; its options are checked with it.
    samples : sequence of DomainSamples, optional
        The samples to measure on; by default the core's for all kinds in ``operator.domains``.
    expected_failures : mapping of str to str, optional
        Laws that are known to fail, with the reason; added to ``operator.known_failures``. A law
        that holds nevertheless is reported too.

    Returns
    -------
    list of Check
        Calling one raises if its law is broken; ``check.run()`` returns the figures.

    Raises
    ------
    InvalidOptionError
        The operator is not an instance, a kind of domain has no samples, or a failure is declared
        for a law that does not exist.

    Notes
    -----
    As a test module::

        import geodesic_toolkit as gt, pytest
        from my_package import MyLaplacian

        @pytest.mark.parametrize("law", gt.testing.laplace_operator_checks(MyLaplacian()), ids=str)
        def test_my_laplacian_keeps_the_contract(law): law()

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> checks = gt.testing.laplace_operator_checks(gt.CotanLaplacian())
    >>> outcome = {check.law: check for check in checks}["stiffness_is_symmetric"].run()
    >>> outcome.ok, outcome.figure
    (True, 0.0)
    """
    if not isinstance(operator, LaplaceOperator):
        raise InvalidOptionError(f"expected an instance of a LaplaceOperator, not {operator!r}")
    chosen = samples_of(operator.domains) if samples is None else list(samples)
    expected = {**operator.known_failures, **(expected_failures or {})}
    return as_checks(OPERATOR_LAWS, OperatorSubject(operator, chosen), expected)


def check_laplace_operator(
    operator: LaplaceOperator,
    *,
    samples: Sequence[DomainSamples[Any]] | None = None,
    expected_failures: Mapping[str, str] | None = None,
) -> ConformanceReport:
    """Check a Laplace operator against the whole contract.

    Parameters and errors are those of :func:`laplace_operator_checks`.

    Returns
    -------
    ConformanceReport
        Every law with its figure and its bound.

    Raises
    ------
    ConformanceError
        Laws are broken, or laws that were declared to fail hold: the message has all of them, with
        figures and bounds.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> print(gt.testing.check_laplace_operator(gt.UniformLaplacian()))
    UniformLaplacian(dim='auto', mass='metric'): 37 of 37 laws as expected
    """
    checks = laplace_operator_checks(operator, samples=samples, expected_failures=expected_failures)
    return run_checks(operator, checks).or_raise()
