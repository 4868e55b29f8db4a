"""The command as a person starts it."""

import subprocess
import sys

import pytest

SQUARE = "OFF 4 2 0  0 0 0  1 0 0  1 1 0  0 1 0  3 0 1 2  3 0 2 3"


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "square.off"
    path.write_text(SQUARE)
    return path


def run(*arguments):
    program = [sys.executable, "-m", "geodesic_toolkit", "plugin-name"]
    words = [*program, *map(str, arguments)]
    return subprocess.run(words, capture_output=True, text=True, check=False)


def test_the_farthest_vertex_of_a_square_is_the_opposite_one(file):
    done = run(file, "--source", 3)
    assert done.stderr == ""
    vertex, distance = done.stdout.split()
    assert vertex == "1"
    assert float(distance) == pytest.approx(2**0.5, rel=0.01)


def test_a_vertex_that_does_not_exist_is_wrong_usage(file):
    done = run(file, "--source", 4)
    assert (done.returncode, done.stdout) == (2, "")
    assert "vertex 4" in done.stderr


def test_the_command_explains_itself():
    assert "farthest" in run("--help").stdout
