"""The linter of prose reads every kind of text, and names the line and a better word."""

import importlib.util
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def linter():
    """The script, as a module."""
    spec = importlib.util.spec_from_file_location("prose", ROOT / "tools" / "prose.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def lines_of(linter, tmp_path, monkeypatch):
    """The function that returns the lines which are reported in a file."""
    monkeypatch.setattr(linter, "ROOT", tmp_path)

    def found(name, source):
        (tmp_path / name).write_text(source, encoding="utf-8")
        return [line for line, _, _ in linter.complaints(Path(name))]

    return found


PYTHON = '''"""A good summary.

A line with a luggage.
"""

room = "luggage"  # a name and a key are not prose
text = "the luggage of a task"  # luggage


def test_a_luggage():
    """Whether it is there."""
    raise ValueError(f"luggage {room}")
'''


def test_comments_docstrings_messages_and_names_of_tests_are_read(lines_of):
    assert lines_of("a.py", PYTHON) == [3, 7, 7, 10, 11, 12]


def test_documents_are_read_outside_code(lines_of):
    page = "Luggage and `luggage`.\n\n```python\nluggage = 1\n```\n\nluggage\n"
    assert lines_of("a.md", page) == [1, 7]


def test_comments_and_messages_of_kernels_are_read(lines_of):
    kernel = '#include "luggage.hpp"\nint luggage; // luggage\nthrow Error("no luggage left");\n'
    assert lines_of("a.cpp", kernel) == [2, 3]


def test_an_exception_needs_a_reason(lines_of):
    excused = "# luggage  prose: the name of a file\n# luggage  prose: so\n"
    assert lines_of("a.py", excused) == [2]
