"""Plugins: lazy, isolated, deterministic; broken, duplicate and unknown ones included."""

import subprocess
import sys
from textwrap import dedent

import pytest

import geodesic_toolkit as gt
from geodesic_toolkit.errors import (
    InvalidOptionError,
    PluginConflictError,
    PluginLoadError,
    UnknownPluginError,
)

GOOD = """
from dataclasses import dataclass
from geodesic_toolkit import LaplaceOperator, TriangleMesh

@dataclass(frozen=True, kw_only=True)
class Good(LaplaceOperator):
    option: int = 1
    domains = (TriangleMesh,)
    references = ("10.1000/good",)

    def assemble(self, domain):
        raise NotImplementedError

not_an_operator = 42
"""


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Put fake installed distributions on the path: `install(name, module, entries, code)`."""

    def put(distribution, module, entries, code, group="geodesic_toolkit.operators"):
        home = tmp_path / distribution
        info = home / f"{distribution.replace('-', '_')}-1.0.dist-info"
        info.mkdir(parents=True)
        (info / "METADATA").write_text(
            f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 1.0\n"
        )
        lines = "\n".join(f"{name} = {module}:{target}" for name, target in entries.items())
        (info / "entry_points.txt").write_text(f"[{group}]\n{lines}\n")
        (home / f"{module}.py").write_text(dedent(code))
        monkeypatch.syspath_prepend(str(home))
        monkeypatch.delitem(sys.modules, module, raising=False)
        gt.operators.refresh()

    yield put
    monkeypatch.undo()
    gt.operators.refresh()


def test_the_core_goes_through_the_same_door():
    assert gt.operators["cotan"] is gt.CotanLaplacian
    assert gt.operators["geodesic-toolkit:uniform"] is gt.UniformLaplacian
    assert gt.solvers["superlu"] is gt.SuperLU
    assert gt.solvers["cg"] is gt.CG


def test_a_good_plugin_is_found_by_either_name(install):
    install("acme-laplace", "acme_good", {"acme": "Good"}, GOOD)
    assert "acme" in gt.operators
    assert gt.operators["acme"].__name__ == "Good"
    assert gt.operators["acme-laplace:acme"] is gt.operators["acme"]
    status = {row.name: row for row in gt.operators.status()}["acme"]
    assert (status.distribution, status.version, status.usable) == ("acme-laplace", "1.0", True)
    assert status.references == ("10.1000/good",)


def test_nothing_is_imported_before_it_is_asked_for(install):
    install("acme-laplace", "acme_lazy", {"lazy": "Good"}, GOOD)
    assert "lazy" in list(gt.operators)
    assert len(gt.operators) >= 3
    assert "acme_lazy" not in sys.modules
    assert gt.operators["lazy"]
    assert "acme_lazy" in sys.modules


@pytest.mark.parametrize(
    "failure", ["import no_such_module", "1 / 0", "raise SystemError('x')", "def"]
)
def test_a_broken_plugin_hurts_only_itself(install, failure):
    install("acme-broken", "acme_broken", {"broken": "Good"}, failure)
    assert gt.operators["cotan"] is gt.CotanLaplacian
    with pytest.raises(PluginLoadError, match="'broken' of acme-broken does not load"):
        gt.operators["broken"]
    status = {row.name: row for row in gt.operators.status()}["broken"]
    assert not status.usable
    assert "acme-broken" in status.error


def test_a_plugin_of_the_wrong_kind_says_so(install):
    install("acme-wrong", "acme_wrong", {"wrong": "not_an_operator"}, GOOD)
    with pytest.raises(PluginLoadError, match="42 is not a subclass of LaplaceOperator"):
        gt.operators["wrong"]


def test_a_duplicate_name_is_an_error_only_when_it_is_asked_for(install):
    install("acme-one", "acme_one", {"twin": "Good"}, GOOD)
    install("acme-two", "acme_two", {"twin": "Good"}, GOOD)
    assert gt.operators["cotan"] is gt.CotanLaplacian
    assert {"acme-one:twin", "acme-two:twin"} <= set(gt.operators)
    with pytest.raises(PluginConflictError, match='"acme-one:twin" or "acme-two:twin"'):
        gt.operators["twin"]
    assert gt.operators["acme-two:twin"].__module__ == "acme_two"


def test_a_plugin_may_not_take_the_place_of_a_built_in_silently(install):
    install("acme-cotan", "acme_cotan", {"cotan": "Good"}, GOOD)
    with pytest.raises(PluginConflictError, match='"geodesic-toolkit:cotan"'):
        gt.operators["cotan"]


def test_an_unknown_name_lists_near_misses_and_what_is_installed():
    with pytest.raises(UnknownPluginError, match=r"did you mean 'cotan'\? .*uniform"):
        gt.operators["cotna"]
    with pytest.raises(UnknownPluginError, match="no solver 'cholesky'"):
        gt.GeodesicSolver(gt.testing.shapes.grid(3), solver="cholesky")


def test_an_unknown_name_that_a_package_provides_names_the_package(monkeypatch):
    monkeypatch.setitem(gt.operators.install_hints, "acme", "acme-laplace")
    with pytest.raises(UnknownPluginError, match="pip install acme-laplace"):
        gt.operators["acme"]


def test_a_name_a_class_and_an_instance_are_all_accepted():
    by_name = gt.operators.resolve("cotan", mass="voronoi")
    by_class = gt.operators.resolve(gt.CotanLaplacian, mass="voronoi")
    instance = gt.CotanLaplacian(mass="voronoi")
    assert by_name == by_class == gt.operators.resolve(instance)


@pytest.mark.parametrize("choice", [42, int, gt.SuperLU, gt.SuperLU(), None])
def test_an_object_that_is_not_a_plugin_is_refused(choice):
    with pytest.raises(InvalidOptionError, match="is not an operator"):
        gt.operators.resolve(choice)


def test_options_that_a_plugin_does_not_take_are_refused():
    with pytest.raises(InvalidOptionError, match="unexpected keyword argument 'masses'"):
        gt.operators.resolve("cotan", masses="voronoi")
    with pytest.raises(InvalidOptionError, match="has its options already"):
        gt.operators.resolve(gt.CotanLaplacian(), mass="voronoi")


def test_a_class_can_be_registered_for_the_process_and_taken_back():
    class Local(gt.LaplaceOperator):
        domains = (gt.TriangleMesh,)

        def assemble(self, domain):
            raise NotImplementedError

    gt.operators.register("local", Local)
    try:
        assert gt.operators["local"] is Local
        with pytest.raises(PluginConflictError, match="already"):
            gt.operators.register("local", Local)
    finally:
        gt.operators.unregister("local")
    assert "local" not in gt.operators
    with pytest.raises(UnknownPluginError):
        gt.operators.unregister("local")
    with pytest.raises(PluginLoadError, match="not a subclass"):
        gt.operators.register("local", int)


def test_a_plugin_domain_finds_its_operator_through_auto(install):
    install(
        "acme-line",
        "acme_line",
        {"line": "LineLaplacian"},
        """
        from dataclasses import dataclass
        import numpy as np
        from geodesic_toolkit import Domain, Graph, LaplaceOperator, UniformLaplacian

        class Line(Domain):
            n_vertices = 5

        @dataclass(frozen=True, kw_only=True)
        class LineLaplacian(LaplaceOperator):
            domains = (Line,)

            def assemble(self, domain):
                steps = np.arange(5)
                path = Graph(5, np.column_stack([steps[:-1], steps[1:]]))
                return UniformLaplacian(dim=1).assemble(path)
        """,
    )
    import acme_line

    distance = gt.geodesic_distance(acme_line.Line(), 0)
    assert distance.round().tolist() == [0, 1, 2, 3, 4]


@pytest.mark.slow
def test_the_registries_are_not_shadowed_by_any_submodule():
    code = """
    import importlib, pkgutil
    import geodesic_toolkit as gt
    for module in pkgutil.walk_packages(gt.__path__, "geodesic_toolkit."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    from geodesic_toolkit.registry.registry import Registry
    assert isinstance(gt.operators, Registry) and isinstance(gt.solvers, Registry)
    assert isinstance(gt.readers, Registry)
    """
    subprocess.run([sys.executable, "-c", dedent(code)], check=True)
