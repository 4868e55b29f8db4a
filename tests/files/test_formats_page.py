"""The page of file formats names every format that is read or written."""

import re
from pathlib import Path

import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.io.curve_files import READERS
from geodesic_toolkit.io.outputs import OF_THE_CORE

PAGE = Path(__file__).parents[2] / "docs" / "formats.md"


@pytest.fixture(scope="module")
def rows():
    """Return the cells of each row by the suffixes in it."""
    lines = [
        line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("| `")
    ]
    cells = [line.strip("|").split("|") for line in lines]
    return {suffix: row[1:] for row in cells for suffix in re.findall(r"`(\.\w+)`", row[0])}


def test_every_reader_of_the_package_is_on_the_page(rows):
    own = [status for status in gt.readers.status() if status.distribution == "geodesic-toolkit"]
    assert own
    for status in own:
        assert not rows[f".{status.name}"][0].strip().startswith("no"), status.name


def test_every_format_of_distances_is_on_the_page(rows):
    written = {suffix for suffix, row in rows.items() if not row[1].strip().startswith("no")}
    assert written - {".zarr", ".npz"} == set(OF_THE_CORE)


def test_the_formats_of_curves_are_on_the_page():
    text = PAGE.read_text(encoding="utf-8").rpartition("Curves (")[2]
    assert all(f"`{suffix}`" in text for suffix in READERS)
