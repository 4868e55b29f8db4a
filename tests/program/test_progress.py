"""Progress: what people are shown while they wait, on a terminal and off it."""

import os
import subprocess
import sys
import time

import pytest

from geodesic_toolkit.cli import progress


def test_progress_off_a_terminal_is_a_plain_line_now_and_then(monkeypatch, capsys):
    monkeypatch.setattr(progress, "FIRST_PLAIN_LINE", 0.05)
    with progress.Progress() as shown, shown.step("thinking"):
        time.sleep(0.3)
    lines = capsys.readouterr().err.splitlines()
    assert 1 <= len(lines) <= 5
    assert lines[0] == "still working: thinking (0 s)"


def test_quick_work_shows_no_progress(capsys):
    with progress.Progress() as shown, shown.step("thinking"):
        shown.advance(1, 2)
    assert capsys.readouterr().err == ""
    assert list(shown.timings) == ["thinking"]


def test_progress_has_a_bar_and_says_how_long_it_will_take(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    shown = progress.Progress()
    with shown.step("computing"):
        assert shown._bar == "computing (0 s)"
        shown.advance(400, 1000)  # resumed
        now[0] = 105.0
        shown.advance(450, 1000)
        assert shown._line == "computing: 450 of 1000 (5 s)"  # too early to tell
        now[0] = 120.0
        shown.advance(600, 1000)
        assert shown._bar == f"{'━' * 14}{'─' * 10} computing: 600 of 1000 (20 s, about 40 s to go)"
        now[0] = 1100.0
        shown.advance(800, 1000)
        assert shown._line == "computing: 800 of 1000 (1000 s, about 8 min to go)"
        shown.advance(1000, 1000)
        assert shown._line == "computing: 1000 of 1000 (1000 s)"
    assert shown._line == "working (1000 s)"


@pytest.mark.skipif(os.name != "posix", reason="needs a pseudo-terminal")
def test_progress_on_a_terminal_is_a_line_that_goes_again():
    import pty

    program = (
        "import time\n"
        "from geodesic_toolkit.cli import progress\n"
        "progress.DELAY_OF_FIRST_MESSAGE = 0.05\n"
        "with progress.Progress() as shown, shown.step('thinking'):\n"
        "    shown.advance(3, 7)\n"
        "    time.sleep(1)\n"
        "    shown.say('warning: [bold] as it is')\n"
        "    time.sleep(0.3)\n"
    )
    ours, theirs = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "80"}
    with subprocess.Popen(
        [sys.executable, "-c", program], stderr=theirs, env=environment
    ) as process:
        os.close(theirs)
        said = b""
        while True:
            try:
                piece = os.read(ours, 4096)
            except OSError:  # how Linux says that the other end has closed
                break
            if not piece:
                break
            said += piece
    os.close(ours)
    assert process.returncode == 0
    assert b"thinking: 3 of 7 (" in said
    assert b"warning: [bold] as it is" in said
    assert said.endswith((b"\x1b[?25h", b"\x1b[2K"))  # the line is wiped and the cursor is back
