"""The program of a user that type checkers read runs, too."""

import ast
import runpy
from pathlib import Path

import pytest

import geodesic_toolkit as gt

PROGRAM = Path(__file__).resolve().parents[1] / "typing" / "user.py"


def test_the_program_that_type_checkers_read_runs():
    for package in ("pyvista", "k3d", "matplotlib"):
        pytest.importorskip(package)
    runpy.run_path(str(PROGRAM), run_name="__main__")


def test_type_checkers_see_every_public_name():
    seen = ast.parse(Path(gt.__file__).read_text(encoding="utf-8"))
    imported = {
        alias.name
        for node in ast.walk(seen)
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert set(gt.__all__) - imported == {"__version__"}
