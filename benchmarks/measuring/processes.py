"""Processes of their own: asked by lines of JSON, with a limit to every answer."""

import json
import os
import selectors
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

BENCHMARKS = Path(__file__).resolve().parents[1]


class NoAnswerError(Exception):
    """A process that gave no answer; the message is short enough for a table."""


class Process:
    """A worker of some interpreter, alive until it fails or is closed."""

    def __init__(
        self, module: str, *arguments: str, python: str = sys.executable, **environment: str
    ) -> None:
        self._errors = tempfile.TemporaryFile("w+", encoding="utf-8")  # noqa: SIM115 - until `close`
        self._process = subprocess.Popen(
            [python, "-m", module, *arguments],
            cwd=BENCHMARKS,
            env=user_environment(environment),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
        )

    def ask(self, command: dict[str, Any], limit: float) -> Any:
        """Return the answer to `command`; the process ends where there is none."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write((json.dumps(command) + "\n").encode())
            self._process.stdin.flush()
        except BrokenPipeError:
            pass  # it has died: the answer says how
        return self.answer(limit)

    def answer(self, limit: float) -> Any:
        """Return its next line."""
        assert self._process.stdout is not None
        with selectors.DefaultSelector() as selector:
            selector.register(self._process.stdout, selectors.EVENT_READ)
            if not selector.select(limit):
                self.close()
                raise NoAnswerError(f"over {limit:.0f} s")
        line = self._process.stdout.readline()
        if not line:
            raise NoAnswerError(self._end())
        return json.loads(line)

    def close(self) -> None:
        """End it."""
        self._process.kill()
        self._process.communicate()
        self._errors.close()

    def _end(self) -> str:
        """Return what it died of."""
        status = self._process.wait()
        self._errors.seek(0)
        last = [line for line in self._errors.read().splitlines() if line.strip()][-1:]
        self.close()
        if status == -signal.SIGKILL:
            return "killed, out of memory"
        if status < 0:
            return f"crash ({signal.Signals(-status).name})"
        return last[0][:200] if last else f"exit status {status}"


def user_environment(changes: dict[str, str]) -> dict[str, str]:
    """Return what a user would have: Python keeps the bytecode of what it imports."""
    kept = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    return kept | changes
