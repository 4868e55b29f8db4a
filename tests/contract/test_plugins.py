"""Are the plugins beside the core what the documentation says, and is the core free of them?"""

import re
import tomllib
from pathlib import Path

import pytest

from geodesic_toolkit.cli.scaffold import PluginKind, files_of, names_of

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "plugins" / "geodesic-toolkit-example"
PLUGINS = sorted(path.parent for path in ROOT.glob("plugins/*/pyproject.toml"))
PAGE = (ROOT / "docs" / "writing_an_operator.md").read_text(encoding="utf-8")

FILES = ["pyproject.toml", "src/geodesic_toolkit_example/__init__.py", "tests/test_conformance.py"]


@pytest.mark.parametrize("name", FILES)
def test_the_page_on_writing_an_operator_shows_the_example_s_own_files(name):
    (shown,) = re.findall(
        rf"^```\w+\n# {re.escape(name)}\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE
    )
    assert shown == (EXAMPLE / name).read_text(encoding="utf-8")


def test_the_example_is_what_the_program_writes():
    files = files_of(PluginKind.operator, names_of(EXAMPLE.name))
    del files["LICENSE"]  # which names the authors
    assert files == {name: (EXAMPLE / name).read_text(encoding="utf-8") for name in files}


def test_the_conformance_test_of_a_plugin_is_five_lines():
    text = (EXAMPLE / "tests" / "test_conformance.py").read_text(encoding="utf-8")
    code = [line for line in text.splitlines() if line and not line.startswith(("import", "from"))]
    assert len(code) <= 5


@pytest.mark.parametrize("plugin", PLUGINS, ids=lambda path: path.name)
def test_a_plugin_has_what_a_distribution_needs(plugin):
    project = tomllib.loads((plugin / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["name"] == plugin.name
    assert any(group.startswith("geodesic_toolkit.") for group in project["entry-points"])
    assert any(re.match(r"geodesic-toolkit(\[\w+\])?>=", need) for need in project["dependencies"])
    assert (plugin / "LICENSE").read_text(encoding="utf-8").startswith("MIT License")
    assert (plugin / "README.md").read_text(encoding="utf-8").startswith(f"# {plugin.name}\n")
    if {"geodesic_toolkit.operators", "geodesic_toolkit.solvers"} & project["entry-points"].keys():
        assert (plugin / "tests" / "test_conformance.py").is_file()
    assert list(plugin.glob("tests/test_*.py"))
    assert list(plugin.glob("src/*/py.typed"))


def test_the_core_imports_no_plugin():
    packages = [path.name for path in ROOT.glob("plugins/*/src/geodesic_toolkit_*")]
    assert len(packages) == len(PLUGINS)
    for source in (ROOT / "geodesic_toolkit").rglob("*.py"):
        text = source.read_text(encoding="utf-8")
        assert not [name for name in packages if name in text], source
