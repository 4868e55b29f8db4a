"""Laws as executable checks: what a check is, what comes of it, and the report of many."""

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
        What was measured, 0 at best; NaN breaks every law.
    bound : float
        The most that the law allows.
    where : str
        On which sample, and what else helps to find the fault.
    """

    figure: float
    bound: float
    where: str

    @property
    def holds(self) -> bool:
        """True if the figure is within the bound."""
        return self.figure <= self.bound


def worst(measurements: Iterable[Measured]) -> Measured | None:
    """Return the measurement that breaks its bound most, or comes nearest to it; None of none."""

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
        What it says, in one line.
    figure, bound : float or None
        What was measured and the most allowed; both None where the law has nothing to say about
        the subject, or measuring it raised an error.
    where : str
        The sample that came out worst, or the error that was raised.
    held : bool
        Whether the law held.
    expected_failure : str or None
        The reason declared for it to fail.
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
        place = f" [{self.where}]" if self.where else ""
        if self.expected_failure is None:
            verdict = "holds" if self.held else "is broken"
        elif self.held:
            verdict = (
                f"holds, but is declared to fail ({self.expected_failure}): declare it no more"
            )
        else:
            verdict = f"fails as declared ({self.expected_failure})"
        return f"{self.law} {verdict}:{measured} {self.statement}{place}"


@dataclass(frozen=True)
class Check:
    """A check of one law on one subject: call it as a test, or :meth:`run` it for its figures.

    Attributes
    ----------
    law : str
        The name of the law, such as ``"stiffness_is_symmetric"``.
    statement : str
        What it says, in one line.
    measure : callable
        Returns the worst measurement, or None where the law has nothing to say.
    expected_failure : str or None
        Why it is known to fail, where it is.
    """

    law: str
    statement: str
    measure: Callable[[], Measured | None]
    expected_failure: str | None = None

    def run(self) -> Outcome:
        """Return what comes of it; an error that the subject raises is a broken law."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", GeodesicWarning)
                measured = self.measure()
        except Exception as error:  # noqa: BLE001 - a third party's error is a finding, not ours
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
            With the law, the figure and the bound.
        """
        outcome = self.run()
        if not outcome.ok:
            raise ConformanceError(str(outcome))

    def __str__(self) -> str:
        return self.law


@dataclass(frozen=True)
class ConformanceReport:
    """The outcomes of all checks of one subject.

    Attributes
    ----------
    subject : str
        Its repr.
    outcomes : tuple of Outcome
        One a law.
    """

    subject: str
    outcomes: tuple[Outcome, ...]

    @property
    def ok(self) -> bool:
        """True if every law held or failed as declared."""
        return all(outcome.ok for outcome in self.outcomes)

    @property
    def broken(self) -> tuple[Outcome, ...]:
        """The outcomes that are not as they should be."""
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
        lines = [f"{self.subject}: {good} of {len(self.outcomes)} laws as they should be"]
        return "\n".join(lines + [f"  {outcome}" for outcome in self.broken])


def as_checks(
    laws: Sequence[Callable[[Any], Iterable[Measured]]],
    subject: Any,
    expected_failures: Mapping[str, str],
) -> list[Check]:
    """Return one check for each law, a function from the subject to its measurements.

    The law is called by the function's name, and says the first line of its docstring.

    Raises
    ------
    InvalidOptionError
        A failure is declared of a law that there is not.
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
        What they are about, for the report.
    checks : iterable of Check
        As :func:`laplace_operator_checks` and :func:`linear_solver_checks` return them.

    Returns
    -------
    ConformanceReport
        Every law with its figure and its bound, the broken ones too.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> solver = gt.SuperLU()
    >>> gt.testing.run_checks(solver, gt.testing.linear_solver_checks(solver)).ok
    True
    """
    return ConformanceReport(repr(subject), tuple(check.run() for check in checks))
