"""Laws as executable checks: the check, its outcome, and the report of several checks."""

import math
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any, NamedTuple

from geodesic_toolkit.errors import ConformanceError, GeodesicWarning, InvalidOptionError

__all__ = ["Check", "ConformanceReport", "Measured", "Outcome", "as_checks", "run_checks", "worst"]


class Measured(NamedTuple):
    """A measurement of a law, which holds if ``figure <= bound``.

    Attributes
    ----------
    figure : float
        The measured value, 0 at best; NaN breaks every law.
    bound : float
        The largest value that the law allows.
    where : str
        The sample, and details that help to find the fault.
    """

    figure: float
    bound: float
    where: str

    @property
    def holds(self) -> bool:
        """True if the figure is within the bound."""
        return self.figure <= self.bound


def worst(measurements: Iterable[Measured]) -> Measured | None:
    """Return the measurement that is farthest above its bound, or nearest to it; None if empty."""

    def excess(measured: Measured) -> float:
        if math.isnan(measured.figure):
            return math.inf
        if measured.bound > 0:
            return measured.figure / measured.bound
        return math.inf if measured.figure > 0 else 0.0

    return max(measurements, key=excess, default=None)


@dataclass(frozen=True)
class Outcome:
    """The outcome of one check.

    Attributes
    ----------
    law : str
        The name of the law.
    statement : str
        The law in one line.
    figure, bound : float or None
        The measured value and its bound; both None if the law does not apply to the subject, or
        measuring it raised an error.
    where : str
        The worst sample, or the error that was raised.
    held : bool
        Whether the law held.
    expected_failure : str or None
        The declared reason for the law to fail.
    """

    law: str
    statement: str
    figure: float | None
    bound: float | None
    where: str
    held: bool
    expected_failure: str | None = None

    @property
    def applies(self) -> bool:
        """Return whether the law applies to the subject."""
        return self.figure is not None or not self.held

    @property
    def ok(self) -> bool:
        """True if the law held, or failed as declared; an unexpected success is not ok."""
        return self.held == (self.expected_failure is None)

    def __str__(self) -> str:
        measured = "" if self.figure is None else f" {self.figure:.3g} (at most {self.bound:.3g})"
        location = f" [{self.where}]" if self.where else ""
        if self.expected_failure is None:
            verdict = "holds" if self.held else "is broken"
        elif self.held:
            verdict = (
                f"holds, but is declared to fail ({self.expected_failure}): remove the declaration"
            )
        else:
            verdict = f"fails as declared ({self.expected_failure})"
        return f"{self.law} {verdict}:{measured} {self.statement}{location}"


@dataclass(frozen=True)
class Check:
    """A check of one law on one subject: call it as a test, or use :meth:`run` for its figures.

    Attributes
    ----------
    law : str
        The name of the law, such as ``"stiffness_is_symmetric"``.
    statement : str
        The law in one line.
    measure : callable
        Returns the worst measurement, or None if the law does not apply.
    expected_failure : str or None
        The known reason for the law to fail, if any.
    """

    law: str
    statement: str
    measure: Callable[[], Measured | None]
    expected_failure: str | None = None

    def run(self) -> Outcome:
        """Run the check and return its outcome; an error of the subject breaks the law."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", GeodesicWarning)
                measured = self.measure()
        except Exception as error:  # noqa: BLE001 - an error of the subject is a finding
            raised = f"{type(error).__name__}: {error}"
            return self._outcome(None, None, raised, held=False)
        if measured is None:
            return self._outcome(None, None, "does not apply", held=True)
        return self._outcome(
            float(measured.figure), float(measured.bound), measured.where, held=bool(measured.holds)
        )

    def _outcome(
        self, figure: float | None, bound: float | None, where: str, *, held: bool
    ) -> Outcome:
        return Outcome(self.law, self.statement, figure, bound, where, held, self.expected_failure)

    def __call__(self) -> None:
        """Raise unless the law holds, or fails as declared.

        Raises
        ------
        ConformanceError
            The message has the law, the figure and the bound.
        """
        outcome = self.run()
        if not outcome.ok:
            raise ConformanceError(str(outcome))

    def __str__(self) -> str:
        return self.law


@dataclass(frozen=True)
class ConformanceReport:
    """The outcomes of all checks on one subject.

    Attributes
    ----------
    subject : str
        Its repr.
    outcomes : tuple of Outcome
        One per law.
    """

    subject: str
    outcomes: tuple[Outcome, ...]

    @property
    def ok(self) -> bool:
        """True if every law held or failed as declared."""
        return all(outcome.ok for outcome in self.outcomes)

    @property
    def broken(self) -> tuple[Outcome, ...]:
        """The outcomes that are not as expected."""
        return tuple(outcome for outcome in self.outcomes if not outcome.ok)

    def or_raise(self) -> "ConformanceReport":
        """Return the report, or raise a `ConformanceError` that lists every broken law."""
        if not self.ok:
            raise ConformanceError(str(self))
        return self

    def as_dict(self) -> dict[str, Any]:
        """Return plain Python objects, for JSON; figures that are not finite become None."""
        rows = [asdict(outcome) | {"ok": outcome.ok} for outcome in self.outcomes]
        for row in rows:
            if row["figure"] is not None and not math.isfinite(row["figure"]):
                row["figure"] = None
        return {"subject": self.subject, "ok": self.ok, "laws": rows}

    def __str__(self) -> str:
        good = len(self.outcomes) - len(self.broken)
        lines = [f"{self.subject}: {good} of {len(self.outcomes)} laws as expected"]
        return "\n".join(lines + [f"  {outcome}" for outcome in self.broken])


def as_checks(
    laws: Sequence[Callable[[Any], Iterable[Measured]]],
    subject: Any,
    expected_failures: Mapping[str, str],
) -> list[Check]:
    """Return one check for each law, a function from the subject to its measurements.

    The function's name is the name of the law, and the first line of its docstring the statement.

    Raises
    ------
    InvalidOptionError
        A failure is declared for a law that does not exist.
    """
    names = [law.__name__ for law in laws]
    unknown = sorted(set(expected_failures) - set(names))
    if unknown:
        raise InvalidOptionError(
            f"expected_failures names {', '.join(unknown)}; the laws are {', '.join(names)}"
        )
    return [
        Check(
            law=law.__name__,
            statement=(law.__doc__ or "").strip().splitlines()[0],
            measure=partial(_measured, law, subject),
            expected_failure=expected_failures.get(law.__name__),
        )
        for law in laws
    ]


def _measured(law: Callable[[Any], Iterable[Measured]], subject: object) -> Measured | None:
    return worst(law(subject))


def run_checks(subject: object, checks: Iterable[Check]) -> ConformanceReport:
    """Return the report of `checks`, each run once.

    Parameters
    ----------
    subject : object
        The subject of the checks, for the report.
    checks : iterable of Check
        Results of :func:`laplace_operator_checks` or :func:`linear_solver_checks`.

    Returns
    -------
    ConformanceReport
        Every law with its figure and its bound, including broken laws.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> solver = gt.SuperLU()
    >>> gt.testing.run_checks(solver, gt.testing.linear_solver_checks(solver)).ok
    True
    """
    return ConformanceReport(repr(subject), tuple(check.run() for check in checks))
