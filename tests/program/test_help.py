"""The help of commands, and what every command has in common."""

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from command_line import run, run_process

import geodesic_toolkit as gt
from geodesic_toolkit.cli.commands import EXAMPLES
from geodesic_toolkit.cli.program import COMMANDS
from geodesic_toolkit.viz.live.view import View

DOCS = Path(__file__).parents[2] / "docs"

NAMES = [function.__name__.replace("_", "-") for function in COMMANDS]


@pytest.fixture
def files(tmp_path, monkeypatch):
    """Enter a folder with the files that the examples name; pages end when they are there."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("webbrowser.open", lambda url: True)
    monkeypatch.setattr("geodesic_toolkit.viz.live.view.View.wait", View.stop)
    ball = gt.testing.shapes.icosphere(3, radius=0.1)
    text = [f"OFF\n{ball.n_vertices} {ball.n_faces} 0"]
    text += [" ".join(map(str, row)) for row in ball.vertices.tolist()]
    text += [" ".join(map(str, [3, *row])) for row in ball.faces.tolist()]
    (tmp_path / "bunny.off").write_text("\n".join(text))
    gt.write("scan.ply", gt.PointCloud(ball.vertices), np.zeros(ball.n_vertices))
    gt.write("terrain.ply", gt.testing.shapes.grid(9), np.zeros(81))
    np.savetxt("seconds_per_metre.csv", np.linspace(1, 2, 128))
    np.savetxt("trees.csv", ball.vertices[:9], delimiter=",")
    torus = gt.testing.shapes.torus(24, 12)
    gt.write("torus.ply", torus, np.zeros(torus.n_vertices))
    gt.write("ring.ply", torus, np.zeros(torus.n_vertices))
    turn = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    circle = 0.06 * np.column_stack([np.cos(turn), np.sin(turn), np.full(60, 4 / 3)])
    lines = [f"v {x} {y} {z}" for x, y, z in circle.tolist()]
    (tmp_path / "circle.obj").write_text(
        "\n".join([*lines, f"l {' '.join(map(str, range(1, 61)))} 1"])
    )
    return tmp_path


@pytest.mark.parametrize("name", NAMES)
def test_every_command_has_examples_json_and_quiet_in_its_help(name):
    text = run(name, "--help").stdout
    assert f"\n    geodesic-toolkit {EXAMPLES[name][0]}\n" in text
    assert "--json" in text
    assert "--quiet" in text


@pytest.mark.slow
@pytest.mark.parametrize("line", [line for lines in EXAMPLES.values() for line in lines])
def test_an_example_runs_as_it_is_printed(files, line):
    if "--picture" in line:
        pytest.importorskip("pyvista")
    if line.startswith("view"):
        pytest.importorskip("viser")
    words, _, rest = line.partition(" < ")
    given = (files / "bunny.off").read_bytes() if rest else None
    result = run(*shlex.split(words), input=given)
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize("name", NAMES)
def test_a_quiet_command_prints_no_warnings(files, name):
    if name == "distance":
        loud = run("distance", "bunny.off", "--source", "3,3,3")
        assert "warning: " in loud.stderr
        still = run("distance", "bunny.off", "--source", "3,3,3", "--quiet")
        assert still.stderr == ""
        assert still.stdout.startswith("shape")
        found = run("distance", "bunny.off", "--source", "3,3,3", "-q", "--json")
        assert json.loads(found.stdout)["warnings"]
    else:
        assert run(name, "--quiet", "--help").exit_code == 0


def test_a_quiet_command_still_reports_its_error(files):
    failed = run("distance", "bunny.off", "--source", "99999", "-q")
    assert failed.exit_code == 2
    assert "error: " in failed.stderr


@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("dist", "distance"),
        ("distance --so", "--source"),
        ("signed bunny.off scan.ply --cur", "--curve"),
    ],
)
def test_a_shell_completes_commands_and_options(words, found):
    done = run_process(
        _GEODESIC_TOOLKIT_COMPLETE="complete_bash",
        COMP_WORDS=f"geodesic-toolkit {words}",
        COMP_CWORD=str(len(words.split())),
    )
    assert found in done.stdout.split()


def documented(section):
    """Return the keys in the tables of a section of the page of JSON results."""
    text = (DOCS / "json.md").read_text(encoding="utf-8")
    rows = text.split(f"\n## {section}\n")[1].split("\n## ")[0].splitlines()
    cells = [row.split("|")[1] for row in rows if row.startswith("| `")]
    return {key for cell in cells for key in re.findall(r"`(\w+)`", cell)}


ONCE = [(name, lines[0]) for name, lines in EXAMPLES.items()]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "line"), [*ONCE, ("doctor", "doctor bunny.off")])
def test_json_has_the_documented_keys(files, name, line):
    if "--picture" in line or name in ("compare", "demo"):
        pytest.importorskip("pyvista")
    if name == "view":
        pytest.importorskip("viser")
    found = json.loads(run(*shlex.split(line.partition(" --picture")[0]), "--json").stdout)
    known = documented(name)
    assert set(found) <= known | documented("All commands")
    if name == "doctor":
        shape = {"input", "diagnosis", "recommendations"}
        known = known & shape if "input" in found else known - shape
    assert known <= set(found)
