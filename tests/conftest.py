"""Fixtures that every test may use."""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from geodesic_toolkit import _kernels

# No test looks at the clock: a busy machine is slow to begin with, and that is no failure.
settings.register_profile("calm", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("calm")

# Whether kernels are used depends on whether the process has them, and the last bits of results on
# that: here they are always there. Commands that tests run in processes of their own do without.
_kernels.warm()

SHARED_DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


def shared_file(name: str) -> Path:
    """Return a file of the shared data set, or skip where it is absent."""
    path = SHARED_DATA / name
    if not path.exists():
        pytest.skip(f"the shared data set is not beside this checkout (wanted {name})")
    return path


@pytest.fixture(scope="session")
def shared_data():
    """The function from a file name of the shared data set to its path; skips where absent."""
    return shared_file
