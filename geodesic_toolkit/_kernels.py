"""Compiled kernels: which there are, and whether waiting for them is worth it.

Numba compiles a kernel when its module is imported for the first time on a machine (seconds), and
loads it from its cache after that (tenths of a second in every process). A small job is done sooner
without either.
"""

import importlib
import os
import sys
from pathlib import Path

__all__ = ["MODULES", "cached", "loaded", "warm", "worthwhile"]

MODULES = (
    "geodesic_toolkit._assembly",
    "geodesic_toolkit._descent",
    "geodesic_toolkit._assembly",
    "geodesic_toolkit._descent",
    "geodesic_toolkit.linear.supernodal._ordering",
    "geodesic_toolkit.linear.supernodal._elimination",
    "geodesic_toolkit.linear.supernodal._numeric",
    "geodesic_toolkit.linear.supernodal._solve",
)
"""Modules whose import compiles or loads the kernels of :class:`~geodesic_toolkit.HeatMethod`."""

LOADING = 60_000
"""Vertices from which on a job without the kernels takes longer than loading them."""

COMPILING = 500_000
"""Vertices from which on it takes longer than compiling them."""


def worthwhile(n_vertices: int) -> bool:
    """Return whether a job on so many vertices is done sooner with the kernels than without."""
    if loaded():
        return True
    return n_vertices >= COMPILING or (n_vertices >= LOADING and cached())


def loaded() -> bool:
    """Return whether this process has them."""
    return all(name in sys.modules for name in MODULES)


def cached() -> bool:
    """Return whether an earlier process has left all of them compiled, without importing Numba."""
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
        importlib.import_module(name)


def _parts(module: str) -> list[str]:
    *folders, name = module.split(".")[1:]
    return [*folders, f"{name}.py"]


def _is_cached(source: Path) -> bool:
    """Return whether one of Numba's places holds an index for `source` that is not older."""
    places = [source.parent / "__pycache__"]
    if "NUMBA_CACHE_DIR" in os.environ:  # a folder for each source folder, below it
        places = list(Path(os.environ["NUMBA_CACHE_DIR"]).glob(f"{source.parent.name}_*"))
    stamp = source.stat().st_mtime
    indices = [index for place in places for index in place.glob(f"{source.stem}.*.nbi")]
    return any(index.stat().st_mtime >= stamp for index in indices)
