"""The programs of users that type checkers read run, too."""

import ast
import re
import runpy
from pathlib import Path

import pytest

import geodesic_toolkit as gt

PROGRAMS = sorted((Path(__file__).resolve().parents[1] / "typing").glob("*.py"))


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: path.name)
def test_a_program_that_type_checkers_read_runs(program):
    for package in ("pyvista", "k3d", "matplotlib"):
        pytest.importorskip(package)
    runpy.run_path(str(program), run_name="__main__")


def test_type_checkers_read_a_use_of_every_public_name():
    text = "".join(program.read_text(encoding="utf-8") for program in PROGRAMS)
    assert [name for name in gt.__all__ if not re.search(rf"\bgt\.{name}\b", text)] == []


def test_type_checkers_see_every_public_name():
    seen = ast.parse(Path(gt.__file__).read_text(encoding="utf-8"))
    imported = {
        alias.name
        for node in ast.walk(seen)
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert set(gt.__all__) - imported == {"__version__"}
