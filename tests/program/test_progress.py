"""Progress: the lines that people see while they wait, on a terminal and off it."""

import contextlib
import os
import sys
import threading

import pytest

from geodesic_toolkit.cli import progress


class Clock:
    """A clock that advances with each wait, for a given number of waits, and then stands still."""

    def __init__(self):
        self.now = 100.0
        self.rounds = 0
        self.started, self.stands = threading.Event(), threading.Event()

    def run(self, rounds):
        """Let `rounds` waits pass, and return when the work after the last one is done."""
        self.rounds = rounds
        self.started.set()
        assert self.stands.wait(60)

    def wait(self, done, seconds):
        assert self.started.wait(60)
        if self.rounds == 0:
            self.stands.set()
            return done.wait()
        self.rounds -= 1
        self.now += seconds
        return False

    def progress(self, about=""):
        return progress.Progress(about, now=lambda: self.now, wait=self.wait)


def pieces_of(terminal):
    """Yield the output of a pseudo-terminal whose other end is closed."""
    with contextlib.suppress(OSError):  # Linux has no end of file there, but an error
        while piece := os.read(terminal, 65536):
            yield piece


def test_progress_off_a_terminal_is_a_plain_line_now_and_then(capsys):
    clock = Clock()
    with clock.progress() as shown, shown.step("thinking"):
        clock.run(3)
    assert capsys.readouterr().err.splitlines() == [
        f"still working: thinking ({seconds} s)" for seconds in (5, 15, 35)
    ]
    assert shown.timings == {"thinking": 35.0}


def test_progress_names_what_it_is_about(capsys):
    clock = Clock()
    with clock.progress("a.ply: ") as shown, shown.step("thinking"):
        assert shown._bar == "a.ply: thinking (0 s)"
        clock.run(1)
    assert capsys.readouterr().err == "a.ply: still working: thinking (5 s)\n"


def test_quick_work_shows_no_progress(capsys):
    with progress.Progress() as shown, shown.step("thinking"):
        shown.advance(1, 2)
    assert capsys.readouterr().err == ""
    assert list(shown.timings) == ["thinking"]


def test_progress_has_a_bar_and_says_how_long_it_will_take():
    clock = Clock()
    shown = clock.progress()
    with shown.step("computing"):
        assert shown._bar == "computing (0 s)"
        shown.advance(400, 1000)  # resumed
        clock.now = 105.0
        shown.advance(450, 1000)
        assert shown._line == "computing: 450 of 1000 (5 s)"  # too early for a forecast
        clock.now = 120.0
        shown.advance(600, 1000)
        assert shown._bar == f"{'━' * 14}{'─' * 10} computing: 600 of 1000 (20 s, about 40 s to go)"
        clock.now = 1100.0
        shown.advance(800, 1000)
        assert shown._line == "computing: 800 of 1000 (1000 s, about 8 min to go)"
        shown.advance(1000, 1000)
        assert shown._line == "computing: 1000 of 1000 (1000 s)"
    assert shown._line == "working (1000 s)"


@pytest.mark.skipif(os.name != "posix", reason="needs a pseudo-terminal")
def test_progress_on_a_terminal_is_a_line_that_goes_again(monkeypatch):
    import pty

    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "80")
    ours, theirs = pty.openpty()
    clock = Clock()
    with os.fdopen(theirs, "w") as terminal:
        monkeypatch.setattr(sys, "stderr", terminal)
        with clock.progress() as shown, shown.step("thinking"):
            shown.advance(3, 7)
            clock.run(2)
            shown.say("warning: [bold] as it is")
    said = b"".join(pieces_of(ours))
    os.close(ours)
    assert b"thinking: 3 of 7 (" in said
    assert b"warning: [bold] as it is" in said
    assert said.endswith((b"\x1b[?25h", b"\x1b[2K"))  # the line is wiped and the cursor is back
