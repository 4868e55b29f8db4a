"""Progress on stderr: nothing for two seconds, then a line that names the current step."""

import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import TracebackType
from typing import Self

from geodesic_toolkit.cli.output import is_quiet, say

__all__ = ["Progress"]

DELAY_OF_FIRST_MESSAGE = 2.0
"""Seconds before the first message: most work is done by then."""

FIRST_PLAIN_LINE = 5.0
"""Seconds before the first line without a terminal; each following delay is twice as long."""

BAR_WIDTH = 24
"""Number of characters of a bar."""

DELAY_OF_FORECAST = 10
"""Seconds of counting before the remaining time is estimated."""


@dataclass(frozen=True)
class _Count:
    """The progress of a step, and its start: a resumed step begins in the middle."""

    done: int
    total: int
    at: float
    began_with: int
    began_at: float

    @property
    def rest(self) -> str:
        """The estimate of the remaining time in words; empty if there is none yet."""
        spent, made = self.at - self.began_at, self.done - self.began_with
        if spent < DELAY_OF_FORECAST or made <= 0 or self.done >= self.total:
            return ""
        seconds = spent * (self.total - self.done) / made
        return (
            f", about {seconds:.0f} s to go"
            if seconds < 100
            else f", about {seconds / 60:.0f} min to go"
        )


class Progress:
    """A context that shows the progress of its steps on stderr.

    On a terminal it is a line that updates itself and is erased at the end; elsewhere it is a plain
    line at growing intervals. A separate thread shows it, also while a library computes.

    Parameters
    ----------
    about : str
        The beginning of every line.
    now : callable
        The clock, in seconds from some moment.
    wait : callable
        Waits for an event for so many seconds at most, and returns whether it came.

    Attributes
    ----------
    timings : dict of str to float
        Seconds of each step.
    """

    def __init__(
        self,
        about: str = "",
        *,
        now: Callable[[], float] = time.perf_counter,
        wait: Callable[[threading.Event, float], bool] = threading.Event.wait,
    ) -> None:
        self._about, self._now, self._wait = about, now, wait
        self.timings: dict[str, float] = {}
        self._label = ""
        self._counted: _Count | None = None
        self._since = self._now()
        self._done = threading.Event()
        self._lock = threading.Lock()
        self._show_above: Callable[[str], None] = say
        self._thread = threading.Thread(target=self._watch, daemon=True)

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        """Name what the block does, and time it."""
        start = self._now()
        self._label, self._since, self._counted = name, start, None
        try:
            yield
        finally:
            self.timings[name] = self.timings.get(name, 0.0) + self._now() - start
            self._label, self._counted = "", None

    def advance(self, done: int, total: int) -> None:
        """Say how much of the step is done; fits the `progress` parameter of the library."""
        now, first = self._now(), self._counted
        began = (done, now) if first is None else (first.began_with, first.began_at)
        self._counted = _Count(done, total, now, *began)

    def say(self, text: str) -> None:
        """Print a line on stderr without breaking the progress line."""
        with self._lock:
            self._show_above(f"{self._about}{text}")

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._done.set()
        self._thread.join()

    @property
    def _line(self) -> str:
        spent = f"{self._now() - self._since:.0f} s"
        counted = self._counted
        if counted is None:
            return f"{self._label or 'working'} ({spent})"
        return f"{self._label}: {counted.done} of {counted.total} ({spent}{counted.rest})"

    @property
    def _bar(self) -> str:
        """The line with a bar, for terminals."""
        counted = self._counted
        if counted is None or not counted.total:
            return f"{self._about}{self._line}"
        full = int(BAR_WIDTH * counted.done / counted.total)
        return f"{'━' * full}{'─' * (BAR_WIDTH - full)} {self._about}{self._line}"

    def _watch(self) -> None:
        if is_quiet():
            return
        terminal = sys.stderr is not None and sys.stderr.isatty()
        if terminal and os.environ.get("TERM") != "dumb":
            if not self._wait(self._done, DELAY_OF_FIRST_MESSAGE):
                self._animate()
            return
        pause = FIRST_PLAIN_LINE
        while not self._wait(self._done, pause):
            self.say(f"still working: {self._line}")
            pause *= 2

    def _animate(self) -> None:
        from rich.console import Console  # takes 0.1 s, so only for longer work

        console = Console(stderr=True)
        with console.status(self._bar) as status:
            with self._lock:
                self._show_above = lambda text: console.print(
                    text, markup=False, highlight=False, soft_wrap=True
                )
            while not self._wait(self._done, 0.2):
                status.update(self._bar)
            with self._lock:
                self._show_above = say
