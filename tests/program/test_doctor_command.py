"""The command ``doctor``: its findings about a shape, and about the installation."""

import json
from importlib import metadata

import numpy as np
import pytest
from command_line import run
from sample_files import write_off

import geodesic_toolkit as gt
from geodesic_toolkit.cli import doctor, probes
from geodesic_toolkit.testing import shapes

# -- a shape -------------------------------------------------------------------------------------


def test_doctor_says_what_a_shape_is_like(tmp_path):
    two = shapes.disjoint_union(shapes.grid(5), shapes.icosphere(1))
    path = write_off(tmp_path / "two.off", two)
    result = run("doctor", path)
    assert result.exit_code == 0
    assert "2 components" in result.stdout
    assert "16 vertices are on a boundary" in result.stdout
    report = json.loads(run("doctor", path, "--json").stdout)
    assert report["diagnosis"]["components"] == 2
    assert len(report["recommendations"]) == 2


def test_doctor_finds_nothing_on_a_sphere(sphere_file):
    assert "Nothing stands out" in run("doctor", sphere_file).stdout


def test_doctor_advises_what_the_mesh_allows(tmp_path):
    sliver = gt.TriangleMesh([[0, 0, 0], [1, 0, 0], [0.5, 0.001, 0]], [[0, 1, 2]])
    result = run("doctor", write_off(tmp_path / "sliver.off", sliver))
    assert "intrinsic_delaunay=True" in result.stdout
    fins = gt.TriangleMesh(
        [[0, 0, 0], [1, 0, 0], [0.5, 0.001, 0], [0.5, 0, 1], [0.5, 0, -1]],
        [[0, 1, 2], [0, 1, 3], [0, 1, 4]],
    )
    result = run("doctor", write_off(tmp_path / "fins.off", fins))
    assert "1 edges have more than two faces" in result.stdout
    assert "intrinsic_delaunay=True" not in result.stdout


# -- the installation ----------------------------------------------------------------------------


def test_doctor_examines_the_installation(monkeypatch):
    monkeypatch.setattr(
        doctor,
        "probe_all",
        lambda: {
            "open3d": probes.Probe(False, "libusb is missing"),
            "pictures": probes.Probe(True, "9 bytes"),
            "pages": probes.Probe(True, "9 bytes"),
        },
    )
    result = run("doctor")
    assert result.exit_code == 0
    assert f"numpy {metadata.version('numpy')}" in " ".join(result.stdout.split())
    assert "problem: open3d: libusb is missing" in result.stdout
    report = json.loads(run("doctor", "--json").stdout)
    assert report["open3d"] == {"works": False, "detail": "libusb is missing"}
    assert report["problems"] == ["open3d: libusb is missing"]
    packages = {row["package"]: row for row in report["packages"]}
    assert packages["numpy"]["version"] == np.__version__
    assert "pytest" not in packages


def test_a_probe_survives_what_kills_its_process(monkeypatch):
    missing = "libusb-1.0.so.0: cannot open shared object file: No such file or directory"
    monkeypatch.setattr(
        probes,
        "PROGRAMS",
        {
            "fine": "print(1); print(2)",
            "abort": "import os; os.abort()",
            "library": f"raise ImportError({missing!r})",
        },
    )
    found = probes.probe_all()
    assert found["fine"] == probes.Probe(True, "2")
    assert not found["abort"].works
    assert "apt-get install libusb-1.0-0" in found["library"].detail


def test_a_probe_does_not_wait_for_ever(monkeypatch):
    monkeypatch.setattr(probes, "PROBE_TIMEOUT", 0.1)
    monkeypatch.setattr(probes, "PROGRAMS", {"endless": "import time; time.sleep(100)"})
    assert probes.probe_all() == {"endless": probes.Probe(False, "no answer in 0.1 s")}


@pytest.mark.slow
@pytest.mark.parametrize(("name", "package"), [("pictures", "pyvista"), ("pages", "k3d")])
def test_what_a_probe_tries_works_where_the_package_does(name, package, capsys):
    pytest.importorskip(package)
    exec(probes.PROGRAMS[name])
    assert capsys.readouterr().out.endswith(" bytes\n")
