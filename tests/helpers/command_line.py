"""The program as the tests run it."""

import os
import subprocess
import sys
from unittest.mock import patch

from typer.testing import CliRunner

from geodesic_toolkit.cli import app, progress


def run(*arguments, **options):
    """Run the program in this process, without lines of progress however slow the machine is."""
    with patch.object(progress, "FIRST_PLAIN_LINE", 3600.0):
        return CliRunner().invoke(app, [str(argument) for argument in arguments], **options)


def run_process(*arguments, **environment):
    """Run the program in a process of its own, as a person does."""
    return subprocess.run(
        [sys.executable, "-m", "geodesic_toolkit", *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, **environment},
    )


def fails(result, status, *words):
    """Check an exit status, and that there is a short, clear line and nothing else."""
    assert result.exit_code == status, result.output
    assert result.stdout == ""
    lines = result.stderr.splitlines()
    assert 1 <= len(lines) <= 3
    assert "Traceback" not in result.stderr
    for word in words:
        assert word in result.stderr
