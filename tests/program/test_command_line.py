"""The program as a person starts it: how it explains itself, and what is plugged into it."""

import json
import os
import subprocess
import sys
from importlib import metadata

import numpy as np
import pytest
from command_line import run, run_process

import geodesic_toolkit as gt


@pytest.mark.slow
def test_the_program_runs_end_to_end(sphere_file, tmp_path):
    output = tmp_path / "d.npy"
    done = run_process("distance", sphere_file, "--source", 3, "--output", output, "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["reached"] == 162
    assert "warning" not in done.stderr
    assert np.load(output).shape == (162,)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="needs file names that are any bytes")
def test_a_file_name_that_is_not_text_does_no_harm(sphere_file, tmp_path):
    odd = os.fsdecode(b"\xff\xe9.off")
    sphere_file.rename(tmp_path / odd)
    done = run_process("distance", tmp_path / odd, "--source", 3, "--json")
    assert json.loads(done.stdout)["input"].endswith(odd)
    done = run_process(
        "distance", tmp_path / odd, "--source", 3, "--output", f"{tmp_path}/{odd}.npy"
    )
    assert "\\udcff\\udce9.off.npy" in done.stdout


def test_the_version_is_that_of_the_package():
    done = run_process("--version")
    assert done.stdout == f"geodesic-toolkit {gt.__version__}\n"


@pytest.mark.parametrize("option", ["--help", "-h"])
@pytest.mark.parametrize(
    "command", [[], ["demo"], ["distance"], ["compare"], ["plugins"], ["doctor"]]
)
def test_every_command_explains_itself(command, option):
    result = run(*command, option)
    assert result.exit_code == 0
    assert result.stdout.startswith("Usage: geodesic-toolkit")


def test_help_imports_nothing_heavy():
    program = (
        "import sys\n"
        "import geodesic_toolkit.cli\n"
        "print([name for name in ('numpy', 'scipy', 'rich') if name in sys.modules])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"


def test_the_entry_point_is_the_program():
    (point,) = metadata.entry_points(group="console_scripts", name="geodesic-toolkit")
    assert point.value == "geodesic_toolkit.cli:main"
    assert callable(point.load())


# -- plugins -------------------------------------------------------------------------------------


def test_plugins_lists_the_core_s_own():
    result = run("plugins")
    assert result.exit_code == 0
    for name in ("cotan", "uniform", "superlu", "cg", "off", "ply"):
        assert name in result.stdout.split()
    assert "doi:10.1080/10586458.1993.10504266" in result.stdout


@pytest.mark.slow
def test_plugins_shows_broken_ones(tmp_path):
    information = tmp_path / "halfbaked-1.2.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: halfbaked\nVersion: 1.2\n")
    (information / "entry_points.txt").write_text(
        "[geodesic_toolkit.operators]\nraw = halfbaked.missing:Operator\n"
    )
    listing = run_process("plugins", PYTHONPATH=str(tmp_path))
    assert listing.returncode == 0
    assert "halfbaked.missing" in listing.stdout
    rows = json.loads(run_process("plugins", "--json", PYTHONPATH=str(tmp_path)).stdout)["plugins"]
    broken = [row for row in rows if row["state"] == "error"]
    assert [(row["kind"], row["name"], row["version"]) for row in broken] == [
        ("operator", "raw", "1.2")
    ]
    assert "No module named 'halfbaked'" in broken[0]["error"]
    assert {row["kind"] for row in rows} >= {"operator", "solver", "reader"}
