"""Work that would not fit into memory is refused before it starts."""

import numpy as np
import pytest
from scipy.sparse import csr_array, diags_array

import geodesic_toolkit as gt
from geodesic_toolkit.errors import NotEnoughMemoryError
from geodesic_toolkit.linear import memory

# -- memory ----------------------------------------------------------------------------------------


@pytest.fixture
def little_memory(monkeypatch, tmp_path):
    """A machine that has 150 MB left."""
    told = tmp_path / "meminfo"
    told.write_text("MemTotal: 16000000 kB\nMemAvailable: 150000 kB\n")
    monkeypatch.setattr(memory, "MEMINFO", told)


@pytest.mark.slow
@pytest.mark.usefixtures("little_memory")
def test_a_table_that_would_not_fit_is_refused_before_the_work():
    solver = gt.GeodesicSolver(gt.Graph(2000, [[i, i + 1] for i in range(1999)]))
    message = r"10000 source sets to 2000 vertices needs about 0.16 GB .* 0.154 GB are available"
    with pytest.raises(NotEnoughMemoryError, match=message):
        solver.distances(np.zeros(10_000, dtype=int))


@pytest.mark.usefixtures("little_memory")
def test_a_factor_that_would_not_fit_is_refused_before_the_work():
    count = 400_000
    band = np.ones(count)
    wide = csr_array(diags_array([band] * 7, offsets=range(-3, 4), shape=(count, count)))
    with pytest.raises(NotEnoughMemoryError, match=r"factorising 400000 unknowns .* available"):
        gt.SuperLU().factorize(wide)


def test_paths_and_trees_are_not_taken_for_surfaces():
    assert memory.factor_bytes(10**8, 3 * 10**8) < 4e9 < memory.factor_bytes(10**8, 7 * 10**8)


def test_where_the_system_does_not_say_how_much_there_is_work_goes_on(monkeypatch, tmp_path):
    monkeypatch.setattr(memory, "MEMINFO", tmp_path / "absent")
    assert memory.available_memory() > 0
    monkeypatch.setattr(memory.os, "sysconf", lambda name: (_ for _ in ()).throw(ValueError(name)))
    assert memory.available_memory() == np.inf
    memory.require_memory(1e30, "anything")
