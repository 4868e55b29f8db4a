"""Compiled kernels: which there are, and whether waiting for them is worth it.

Numba compiles a kernel when its module is imported for the first time on a machine (seconds), and
loads it from its cache after that (tenths of a second in every process). A small job is done sooner
without either.
"""

import hashlib
import importlib
import os
import sys
from pathlib import Path

__all__ = [
    "ALL_MODULES",
    "MODULES",
    "cached",
    "load",
    "loaded",
    "warm",
    "worth_a_change",
    "worthwhile",
]

MODULES = (
    "geodesic_toolkit._sides",
    "geodesic_toolkit._assembly",
    "geodesic_toolkit._descent",
    "geodesic_toolkit._flipping",
    "geodesic_toolkit.linear._filling",
    "geodesic_toolkit.linear.supernodal._ordering",
    "geodesic_toolkit.linear.supernodal._elimination",
    "geodesic_toolkit.linear.supernodal._numeric",
    "geodesic_toolkit.linear.supernodal._solve",
)
"""Modules whose import compiles or loads the kernels of :class:`~geodesic_toolkit.HeatMethod`."""

ALL_MODULES = (
    *MODULES,
    "geodesic_toolkit.geometry.poles",
    "geodesic_toolkit.geometry.stars",
)
"""Those, and the kernels of refinement and of point clouds."""

LOADING = 60_000
"""Vertices from which on a job without the kernels takes longer than loading them."""

COMPILING = 200_000
"""Vertices from which on it takes longer than compiling them. Measured: SuperLU factorises 173,000
in 3 s, and had not done with 557,000 after nine minutes."""

LOADING_TIME, COMPILING_TIME = 1.0, 15.0
"""Seconds that loading and compiling take."""

BUILD_TIME, SOLVE_TIME = 2e-6, 4e-7
"""Seconds a vertex, of both factors with the kernels, and that they save a source."""


def worthwhile(n_vertices: int) -> bool:
    """Return whether a job on so many vertices is done sooner with the kernels than without.

    Where it is, all of them are loaded or compiled, and later jobs of any size have them.
    """
    if loaded():
        return True
    if n_vertices >= COMPILING or (n_vertices >= LOADING and cached()):
        warm()
        return True
    return False


def worth_a_change(n_vertices: int, n_sources: int) -> bool:
    """Return whether so many sources take longer with a plain factor than with a new, fast one."""
    wait = 0.0 if loaded() else LOADING_TIME if cached() else COMPILING_TIME
    return n_vertices * (n_sources * SOLVE_TIME - BUILD_TIME) > wait


def loaded() -> bool:
    """Return whether this process has them."""
    return all(name in sys.modules for name in MODULES)


def cached() -> bool:
    """Return whether an earlier process has left them compiled, without importing Numba."""
    return all(_is_cached(Path(__file__).parent.joinpath(*_parts(name))) for name in MODULES)


def warm() -> None:
    """Load all kernels, or compile them: some seconds, once on a machine.

    Examples
    --------
    >>> from geodesic_toolkit import _kernels
    >>> _kernels.warm()
    >>> _kernels.worthwhile(n_vertices=10)
    True
    """
    for name in MODULES:
        load(name)


def load(name: str) -> None:
    """Load one module's kernels, or compile them."""
    importlib.import_module(name)


def _parts(module: str) -> list[str]:
    *folders, name = module.split(".")[1:]
    return [*folders, f"{name}.py"]


def _is_cached(source: Path) -> bool:
    """Return whether one of Numba's places holds an index for `source` as it stands.

    Numba knows sources by their digests, which stand in the index, and before it did by their
    times: an index that is not older will do.
    """
    pattern = f"{source.stem}.*.py{sys.version_info.major}{sys.version_info.minor}*.nbi"
    stamp = source.stat().st_mtime
    indices = [index for place in _places(source.parent) for index in place.glob(pattern)]
    digest = hashlib.sha256(source.read_bytes()).digest()
    return any(index.stat().st_mtime >= stamp or digest in index.read_bytes() for index in indices)


def _places(folder: Path) -> list[Path]:
    """Return where Numba may keep what it has compiled of the sources in a folder."""
    full = os.path.abspath(folder)  # noqa: PTH100 - as Numba does, which follows no links
    mark = hashlib.sha1(full.encode(), usedforsecurity=False).hexdigest()
    if chosen := os.environ.get("NUMBA_CACHE_DIR"):
        return [Path(chosen, f"{folder.name}_{mark}")]
    # Beside the sources or, where that is not allowed, in a folder of the user's.
    return [folder / "__pycache__", _user_cache() / f"{folder.name}_{mark}"]


def _user_cache() -> Path:
    home = os.environ.get("HOME", "")
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", home), "numba", "Cache")
    if sys.platform == "darwin":
        return Path(home, "Library", "Caches", "numba")
    return Path(os.environ.get("XDG_CACHE_HOME", Path(home, ".cache")), "numba")
