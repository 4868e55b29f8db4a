"""The run of a command: its steps, its warnings, and a stdout reserved for results."""

import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from geodesic_toolkit.cli.output import one_line
from geodesic_toolkit.cli.progress import Progress
from geodesic_toolkit.errors import GeodesicWarning

if TYPE_CHECKING:
    from geodesic_toolkit.solver.solver import GeodesicSolver

__all__ = ["Run", "method_in_words", "running"]


class Run:
    """The state of a running command.

    Attributes
    ----------
    warnings : list of str
        The warnings, in order, each once.
    """

    def __init__(self, progress: Progress) -> None:
        self.warnings: list[str] = []
        self.step = progress.step
        self.advance = progress.advance
        self._progress = progress

    @property
    def timings(self) -> dict[str, float]:
        """Seconds of each step so far, to the microsecond, and their total."""
        spent = {**self._progress.timings, "total": sum(self._progress.timings.values())}
        return {name: round(seconds, 6) for name, seconds in spent.items()}

    @property
    def took(self) -> str:
        """The elapsed time as text."""
        return ", ".join(f"{name} {seconds:.2f} s" for name, seconds in self.timings.items())

    def warn(self, message: object, kind: str = "") -> None:
        """Print a warning on stderr, with the kind that it has, and keep it for the result."""
        text = f"{one_line(message)} [{kind}]" if kind else one_line(message)
        if text not in self.warnings:
            self.warnings.append(text)
            self._progress.say(f"warning: {text}")

    def note(self, message: object) -> None:
        """Print a note on stderr that is not a warning."""
        self._progress.say(f"note: {one_line(message)}")


def method_in_words(solver: "GeodesicSolver") -> str:
    """Return the operator of a solver, its linear solvers, and whether it refines, as text."""
    method = solver.method
    names = dict.fromkeys([repr(method.heat_solver), repr(method.poisson_solver)])
    refined = ", refined" if method.refine else ""
    return f"{solver.operator!r}, {' and '.join(names)}{refined}"


@contextmanager
def running(about: str = "") -> Iterator[Run]:
    """Show progress, turn warnings into lines on stderr, and keep libraries off stdout.

    Lines on stderr begin with `about`.
    """
    with _only_results_on_stdout(), warnings.catch_warnings(), Progress(about) as progress:
        run = Run(progress)

        def show_warning(
            message: Warning | str, category: type[Warning], *_: Any, **__: Any
        ) -> None:
            run.warn(message, category.__name__)

        warnings.simplefilter("always", GeodesicWarning)
        warnings.showwarning = show_warning
        yield run


@contextmanager
def _only_results_on_stdout() -> Iterator[None]:
    """Redirect to stderr what compiled libraries print on stdout, where it would break JSON."""
    try:
        stdout, stderr = sys.__stdout__.fileno(), sys.__stderr__.fileno()  # type: ignore[union-attr]
    except (AttributeError, OSError, ValueError):  # closed, or without a descriptor
        yield
        return
    sys.stdout.flush()
    kept = os.dup(stdout)
    os.dup2(stderr, stdout)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, stdout)
        os.close(kept)
