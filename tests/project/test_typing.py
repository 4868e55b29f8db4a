"""The program of a user that type checkers read runs, too."""

import runpy
from pathlib import Path

import pytest

PROGRAM = Path(__file__).resolve().parents[1] / "typing" / "user.py"


def test_the_program_that_type_checkers_read_runs():
    for package in ("pyvista", "k3d", "matplotlib"):
        pytest.importorskip(package)
    runpy.run_path(str(PROGRAM), run_name="__main__")
