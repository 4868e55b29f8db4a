"""The command ``new-plugin``: does it write plugins that pass their own tests, or nothing?"""

import compileall
import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from command_line import fails, run

from geodesic_toolkit.cli import scaffold
from geodesic_toolkit.cli.scaffold import PluginKind, files_of, names_of
from geodesic_toolkit.errors import WriteError


def installed(folder):
    """Make the plugin in `folder` known to Python, as an installer does; return its sources."""
    project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    information = folder / "src" / "fresh-0.1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    )
    lines = [
        line
        for group, points in project["entry-points"].items()
        for line in (f"[{group}]", *(f"{name} = {target}" for name, target in points.items()))
    ]
    (information / "entry_points.txt").write_text("\n".join(lines) + "\n")
    return folder / "src"


@pytest.mark.slow
@pytest.mark.parametrize("kind", PluginKind)
def test_a_new_plugin_passes_its_own_tests(kind, tmp_path):
    result = run("new-plugin", "fresh", "--kind", kind, "--directory", tmp_path / "new")
    assert result.exit_code == 0, result.output
    folder = tmp_path / "new" / "fresh"
    assert compileall.compile_dir(folder, quiet=1)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir", ".", "tests"],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(installed(folder))},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("kind", PluginKind)
def test_nothing_of_the_template_is_left_in_the_names(kind):
    for name, text in files_of(kind, names_of("geodesic-toolkit-fresh")).items():
        for word in ("distribution-name", "package_name", "plugin-"):
            assert word not in name
            assert word not in text, name


@pytest.mark.parametrize("kind", PluginKind)
def test_json_lists_all_files(kind, tmp_path):
    result = run("new-plugin", "Fresh.One", "--kind", kind, "--directory", tmp_path, "--json")
    content = json.loads(result.stdout)
    written = {str(path) for path in (tmp_path / "Fresh.One").rglob("*") if path.is_file()}
    assert set(content["outputs"]) == written
    assert content["kind"] == kind
    assert (content["name"], content["package"]) == ("fresh-one", "fresh_one")
    assert content["distribution"] == "Fresh.One"
    assert f"{tmp_path}/Fresh.One/src/fresh_one/py.typed" in written or os.name == "nt"


@pytest.mark.parametrize("name", ["", "-hodge", "hodge-", "ho dge", "../hodge", "hödge", "a/b"])
def test_a_name_that_is_not_that_of_a_distribution_is_refused(name, tmp_path):
    fails(run("new-plugin", "--directory", tmp_path, "--", name), 2, "name of a distribution")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["3d", "class", "a-1.2" + "\n"])
def test_a_name_whose_package_could_not_be_imported_is_refused(name, tmp_path):
    fails(run("new-plugin", name, "--directory", tmp_path), 2)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["json", "NumPy", "geodesic-toolkit"])
def test_the_name_of_another_package_is_refused(name, tmp_path):
    fails(run("new-plugin", name, "--directory", tmp_path), 2, "exists in this environment")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("operator", "cotan"),
        ("domain", "cotan"),
        ("solver", "superlu"),
        ("reader", "ply"),
        ("reader", "gz"),
        ("command", "doctor"),
    ],
)
def test_the_name_of_an_installed_plugin_is_refused(kind, name, tmp_path):
    arguments = ("--kind", kind, "--directory", tmp_path)
    fails(run("new-plugin", f"geodesic-toolkit-{name}", *arguments), 2, repr(name))
    assert not list(tmp_path.iterdir())


def test_a_folder_that_exists_is_not_changed(tmp_path):
    (tmp_path / "fresh").mkdir()
    (tmp_path / "fresh" / "mine").write_text("work of weeks")
    fails(run("new-plugin", "fresh", "--directory", tmp_path), 2, "exists already")
    assert [path.name for path in tmp_path.rglob("*")] == ["fresh", "mine"]


def test_a_plugin_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    count = 0

    def full(self, *arguments, **options):
        nonlocal count
        count += 1
        if count == 3:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(WriteError, match="No space left"):
        scaffold.write_plugin(PluginKind.reader, names_of("fresh"), tmp_path)
    assert not list(tmp_path.iterdir())


def test_an_unknown_kind_is_refused_with_the_known_ones(tmp_path):
    fails(run("new-plugin", "fresh", "--kind", "writer", "--directory", tmp_path), 2, "reader")
