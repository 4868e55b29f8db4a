"""Fronts that a kind of domain brings, readers before those of the core, lengths of its own."""

from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np
import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import InvalidOptionError, PluginConflictError
from geodesic_toolkit.registry.registry import CORE, Registry, _Entry


class Beads(gt.Domain):
    """Beads in a row, of which neighbours are 2 apart in cost and 1 in space."""

    n_vertices = 5

    @property
    def positions(self):
        return np.arange(5.0)[:, None] * [1.0, 0.0, 0.0]

    def spans(self, vertices, weights):
        return 2 * super().spans(vertices, weights)


@dataclass(frozen=True)
class RowFronts(gt.Fronts):
    """The distance along the row, straight from what is known."""

    def distances(self, begins, vertices, known, starts):
        assert (known >= starts).all()
        steps = 2.0 * np.abs(np.arange(5) - vertices[:, None]) + known[:, None]
        return np.stack([steps[a:b].min(axis=0) for a, b in pairwise(begins)])


@dataclass(frozen=True, kw_only=True)
class BeadLaplacian(gt.LaplaceOperator):
    domains: ClassVar = (Beads,)

    def assemble(self, domain):
        edges = np.column_stack([np.arange(4), np.arange(1, 5)])
        gradient = gt.EdgeGradient(edges, np.full(4, 0.5), np.ones(5))
        return gt.Discretization(
            mass=np.full(5, 2.0),
            stiffness=gradient.stiffness(),
            gradient=gradient,
            spacing=2.0,
            boundary=np.zeros(5, dtype=bool),
            fronts=RowFronts(),
        )


def solver(**options):
    return gt.GeodesicSolver(Beads(), operator=BeadLaplacian(), **options)


@pytest.mark.parametrize("refine", ["auto", "across", True])
def test_the_fronts_of_a_kind_take_the_place_of_heat(refine):
    found = solver(refine=refine)
    assert found.distance(1).tolist() == [2.0, 0.0, 2.0, 4.0, 6.0]
    assert found.distances([[0], [0, 4]])[1].tolist() == [0.0, 2.0, 4.0, 2.0, 0.0]
    assert found.diagnosis.across


def test_the_reason_is_in_the_diagnosis():
    assert solver().diagnosis.reason == "fronts can cross the elements"
    plain = solver(time_factor=2.0)
    assert not plain.method.across
    assert plain.diagnosis.reason == "heat, as its own options are given"


def test_fronts_receive_the_offsets_of_sources():
    found = solver().distance(gt.OffsetSources([0, 4], [3.0, 0.0]))
    assert found.tolist() == [3.0, 5.0, 4.0, 2.0, 0.0]


def test_a_kind_measures_places_in_units_of_its_own():
    halfway = gt.Located([[1, 2]], [[0.5, 0.5]])
    assert solver().distance(halfway).tolist() == [3.0, 1.0, 1.0, 3.0, 5.0]


def test_without_fronts_nothing_can_go_across():
    with pytest.raises(InvalidOptionError, match="operators that bring fronts"):
        gt.GeodesicSolver(gt.testing.shapes.grid(4), refine="across")


def registry(*distributions):
    found = Registry("group", "reader", lambda plugin: None)
    found._discovered = [
        _Entry("mesh", name, "1", "module:name", lambda name=name: f"reader of {name}")
        for name in distributions
    ]
    return found


def test_the_reader_of_another_distribution_is_asked_before_the_core():
    readers = registry(CORE, "acme")
    assert readers.candidates("mesh") == ["reader of acme", f"reader of {CORE}"]
    assert registry(CORE).candidates("mesh") == [f"reader of {CORE}"]
    assert registry("acme").candidates("mesh") == ["reader of acme"]


def test_two_readers_of_others_are_a_conflict():
    with pytest.raises(PluginConflictError, match="acme-one:mesh"):
        registry("acme-one", "acme-two", CORE).candidates("mesh")


def test_a_reader_leaves_a_file_to_the_core_by_returning_none(tmp_path, monkeypatch):
    from geodesic_toolkit.io import reading

    file = tmp_path / "triangle.off"
    file.write_text("OFF 3 1 0   0 0 0   1 0 0   0 1 0   3 0 1 2")
    core = gt.readers.candidates("off")
    asked = []
    monkeypatch.setattr(
        reading.readers, "candidates", lambda suffix: [asked.append, *core], raising=True
    )
    assert isinstance(gt.read(file), gt.TriangleMesh)
    assert asked == [file]
