"""Fixtures that every test may use."""

import signal

import pytest
from hypothesis import HealthCheck, settings
from sample_files import write_off
from shared_data import shared_file

from geodesic_toolkit.registry.catalog import readers
from geodesic_toolkit.registry.registry import CORE
from geodesic_toolkit.testing import shapes

# Helpers that check something say what they found, as tests do.
pytest.register_assert_rewrite("browser", "command_line")

# No test looks at the clock: a busy machine is slow to begin with, and that is not a failure.
settings.register_profile("calm", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("calm")

if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    # So it is in what a shell runs in the background, and children would ignore Ctrl-C as well.
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Mark as quick what is not marked as slow: a new test is in the quick run by itself."""
    for item in items:
        if item.get_closest_marker("slow") is None:
            item.add_marker(pytest.mark.quick)


@pytest.fixture(scope="session")
def shared_data():
    """The function from a file name of the shared data set to its path; skips where absent."""
    return shared_file


@pytest.fixture(scope="session")
def readers_of_the_core():
    """The readers of the core alone, whatever plugins are installed beside it."""
    return [entry for entry in readers._entries() if entry.distribution == CORE]


@pytest.fixture(autouse=True)
def _only_readers_of_the_core(monkeypatch, readers_of_the_core):
    """Read files as without plugins, which may take solids for themselves."""
    monkeypatch.setattr(readers, "_discovered", readers_of_the_core)


@pytest.fixture
def sphere_file(tmp_path):
    """A file with a sphere of 162 vertices."""
    return write_off(tmp_path / "sphere.off", shapes.icosphere(2))


@pytest.fixture
def graph_file(tmp_path):
    """A file with a path of two edges, of lengths 1 and 2."""
    path = tmp_path / "path.edges"
    path.write_text("0 1 1.0\n1 2 2.0\n")
    return path


@pytest.fixture
def register():
    """The function that registers a plugin for the time of a test."""
    registered = []

    def register(registry, name, plugin):
        registry.register(name, plugin)
        registered.append((registry, name))

    yield register
    for registry, name in registered:
        registry.unregister(name)
