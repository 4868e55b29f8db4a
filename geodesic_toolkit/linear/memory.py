"""Estimates of the memory that work takes, compared with the memory that is available."""

import math
import os
from pathlib import Path

import numpy as np

from geodesic_toolkit.errors import NotEnoughMemoryError

__all__ = ["array_bytes", "available_memory", "factor_bytes", "require_memory"]

MEMINFO = Path("/proc/meminfo")

FILL_PER_UNKNOWN = 2.0
"""Entries of L and U for one unknown and each power of two of their number, on surfaces.

Measured with a minimum-degree ordering: 2.8 to 3.4 on square grids of 2,500 to 160,000 vertices, 3
to 12 on scans of 3,000 to 134,000, 2.8 to 4.8 on clouds. An estimate must not reject work that
fits, so it is below the smallest of these.
"""

MAX_ENTRIES_PER_ROW_OF_TREES = 4
"""Maximum entries per row in matrices of paths and trees, whose factors have almost no fill-in."""

MIN_BYTES_CHECKED = 1e8
"""Requests below this size are not compared with the available memory."""

BYTES_PER_ENTRY = 12
"""Bytes of an entry: its value and a row index."""


def factor_bytes(unknowns: int, entries: int) -> float:
    """Return a lower estimate of the bytes of the factors of a sparse symmetric matrix.

    Nested dissection needs O(n log n) entries for planar graphs, and an ordering cannot do better
    (A. George, 1973, https://doi.org/10.1137/0710032).

    Examples
    --------
    >>> from geodesic_toolkit.linear.memory import factor_bytes
    >>> round(factor_bytes(1_000_000, 7_000_000) / 1e6)  # megabytes
    478
    """
    if entries <= MAX_ENTRIES_PER_ROW_OF_TREES * unknowns:
        return float(BYTES_PER_ENTRY * entries)
    return BYTES_PER_ENTRY * FILL_PER_UNKNOWN * unknowns * math.log2(max(unknowns, 2))


def available_memory() -> float:
    """Return the bytes that a process may still allocate, or infinity if they are not known."""
    try:
        for line in MEMINFO.read_text(encoding="ascii").splitlines():
            name, _, value = line.partition(":")
            if name == "MemAvailable":
                return 1024.0 * float(value.split()[0])
    except (OSError, ValueError, IndexError):  # not Linux: use sysconf
        pass
    try:
        return float(os.sysconf("SC_AVPHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):  # the system does not count pages
        return math.inf


def array_bytes(*things: object) -> int:
    """Return the bytes of the arrays that objects hold in their attributes, each counted once.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit.linear.memory import array_bytes
    >>> mesh = gt.testing.shapes.icosphere(2)  # 162 vertices, 320 faces, 8 bytes a number
    >>> array_bytes(mesh, mesh) == 8 * 3 * (162 + 320)
    True
    """
    arrays: dict[int, np.ndarray] = {}
    waiting = list(things)
    while waiting:
        thing = waiting.pop()
        if isinstance(thing, np.ndarray):
            while isinstance(thing.base, np.ndarray):
                thing = thing.base
            arrays[id(thing)] = thing
        elif type(thing).__module__.startswith(("geodesic_toolkit", "scipy.sparse")):
            waiting += vars(thing).values()
    return sum(array.nbytes for array in arrays.values())


def require_memory(needed: float, work: str) -> None:
    """Raise if `work` needs more memory than is available.

    Raises
    ------
    NotEnoughMemoryError
        The message gives the needed and the available memory.
    """
    available = math.inf if needed < MIN_BYTES_CHECKED else available_memory()
    if needed > available:
        raise NotEnoughMemoryError(
            f"{work} needs about {needed / 1e9:.3g} GB of memory, and {available / 1e9:.3g} GB are "
            "available"
        )
