"""The version and the supported Pythons are said once, or everywhere the same."""

import re
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

import geodesic_toolkit as gt

ROOT = Path(__file__).resolve().parents[2]
WORKFLOW = ROOT / ".github" / "workflows" / "tests.yml"


def test_the_citation_has_the_version_of_the_package():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.findall(r"^version: (\S+)$", citation, flags=re.MULTILINE) == [gt.__version__]


def test_the_installed_distribution_has_the_version_of_the_package():
    assert metadata.version("geodesic-toolkit") == gt.__version__


@pytest.mark.skipif(not WORKFLOW.exists(), reason="a source distribution has no workflows")
def test_the_classifiers_are_the_pythons_that_are_tested():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    found = re.findall(r"Python :: (3\.\d+)$", "\n".join(project["classifiers"]), re.MULTILINE)
    tested = re.search(r"python: \[(.*)\]", WORKFLOW.read_text(encoding="utf-8"))[1]
    assert found == re.findall(r"3\.\d+", tested)
    assert project["requires-python"] == f">={found[0]}"
