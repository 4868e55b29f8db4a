"""The number of threads of kernels over points."""

import os

__all__ = ["threads_for"]

POINTS_PER_THREAD = 2000
"""Number of points per thread that is worth starting."""


def threads_for(n_points: int) -> int:
    """Return the number of threads for a number of points; results do not depend on it."""
    return max(1, min(_processors(), n_points // POINTS_PER_THREAD))


def _processors() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
