"""Fixtures for the tests of solids."""

from pathlib import Path

import pytest

SHARED_DATA = Path(__file__).resolve().parents[4] / "shared" / "data"


@pytest.fixture(scope="session")
def shared_data():
    """The function from a file name of the shared data set to its path; skips where absent."""

    def shared_file(name):
        path = SHARED_DATA / name
        if not path.exists():
            pytest.skip(f"the shared data set is not beside this checkout (wanted {name})")
        return path

    return shared_file
