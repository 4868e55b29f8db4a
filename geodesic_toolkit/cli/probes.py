"""Probes of heavy packages, each in a separate process, because some crash theirs."""

import re
import subprocess
import sys
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

__all__ = ["Probe", "probe_all"]

PROBE_TIMEOUT = 120
"""Timeout in seconds; importing Open3D from a cold disk has taken thirty."""

PROGRAMS = {
    "open3d": "import open3d; print(open3d.__version__)",
    "pictures": """
import pathlib, tempfile
import geodesic_toolkit as gt
mesh = gt.testing.shapes.grid(4)
with tempfile.TemporaryDirectory() as folder:
    picture = pathlib.Path(folder, "picture.png")
    gt.viz.plot(mesh, mesh.vertices[:, 0], path=picture, sources=[0])
    print(picture.stat().st_size, "bytes")
""",
    "pages": """
import pathlib, tempfile
import geodesic_toolkit as gt
mesh = gt.testing.shapes.grid(4)
with tempfile.TemporaryDirectory() as folder:
    page = pathlib.Path(folder, "page.html")
    gt.viz.save_html(mesh, mesh.vertices[:, 0], page, sources=[0])
    print(page.stat().st_size, "bytes")
""",
}

DEBIAN_PACKAGES: Mapping[str, str] = {
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libOSMesa.so.8": "libosmesa6",
    "libX11.so.6": "libx11-6",
    "libXrender.so.1": "libxrender1",
    "libgomp.so.1": "libgomp1",
    "libusb-1.0.so.0": "libusb-1.0-0",
}
"""The packages of Debian and Ubuntu that provide these system libraries."""


@dataclass(frozen=True)
class Probe:
    """The outcome of a probe.

    Attributes
    ----------
    works : bool
    detail : str
        The output of the program, or the reason of its failure.
    """

    works: bool
    detail: str


def probe_all() -> dict[str, Probe]:
    """Run all probes concurrently."""
    with ThreadPoolExecutor() as pool:
        return dict(zip(PROGRAMS, pool.map(_probe, PROGRAMS.values()), strict=True))


def _probe(program: str) -> Probe:
    try:
        done = subprocess.run(  # noqa: S603 - this interpreter, a program from above
            [sys.executable, "-c", program],
            capture_output=True,
            text=True,
            errors="replace",
            timeout=PROBE_TIMEOUT,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return Probe(False, f"no answer in {PROBE_TIMEOUT} s")
    if done.returncode == 0:
        return Probe(True, _last_line(done.stdout))
    if done.returncode < 0:
        return Probe(False, f"crashes (signal {-done.returncode}){_cure(done.stderr)}")
    return Probe(False, _last_line(done.stderr) + _cure(done.stderr))


def _last_line(text: str) -> str:
    return text.strip().rpartition("\n")[2]


def _cure(text: str) -> str:
    """Return the system package to install if the output names a missing library."""
    missing = re.search(r"(lib[\w.+-]+?\.so(?:\.\d+)*): cannot open shared object file", text)
    package = DEBIAN_PACKAGES.get(missing[1]) if missing else None
    return f"; on Debian or Ubuntu: apt-get install {package}" if package else ""
