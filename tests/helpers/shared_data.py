"""Files of the shared data set, which cannot be distributed with the project."""

from pathlib import Path

import pytest

SHARED_DATA = Path(__file__).resolve().parents[3] / "shared" / "data"


def shared_file(name: str) -> Path:
    """Return a file of the shared data set, or skip where it is absent."""
    path = SHARED_DATA / name
    if not path.exists():
        pytest.skip(f"the shared data set is not beside this checkout (wanted {name})")
    return path
