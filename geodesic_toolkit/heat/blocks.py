"""Many source sets: solved in blocks, which share the reading of a factor, on several threads."""

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["PROCESSORS", "WORTH_A_THREAD", "in_blocks", "side_by_side"]

SOURCE_SETS_PER_BLOCK = 16
"""Source sets solved at once: they share the reading of a factor, and stay in cache."""

PROCESSORS = os.cpu_count() or 1

WORTH_A_THREAD = 10_000
"""Vertices from which on a factor, or a block of sources, takes longer than to start a thread."""

Report = TypeVar("Report")


def in_blocks(
    points: list[SourcePoints],
    distances: FloatArray,
    solve: Callable[[list[SourcePoints], FloatArray], Report],
    *,
    threads: bool,
) -> Iterator[tuple[int, Report]]:
    """Fill distances (K, N) block by block, and yield how many rows each has and its report.

    Parameters
    ----------
    points : list of SourcePoints
    distances : ndarray of shape (K, N)
        Written to by `solve`, some rows a call.
    solve : callable
        From source sets and their rows to a report.
    threads : bool
        Whether blocks may run side by side; not where `solve` uses all processors itself.
    """

    def one(start: int) -> tuple[int, Report]:
        block = points[start : start + SOURCE_SETS_PER_BLOCK]
        return len(block), solve(block, distances[start : start + len(block)])

    starts = range(0, len(points), SOURCE_SETS_PER_BLOCK)
    if len(starts) == 1 or distances.shape[1] < WORTH_A_THREAD or not threads:
        yield from map(one, starts)
        return
    with ThreadPoolExecutor(min(len(starts), PROCESSORS)) as pool:
        yield from pool.map(one, starts)


def side_by_side(
    first: Callable[[], object], second: Callable[[], object], n_vertices: int
) -> None:
    """Call two functions, the second on another thread where that pays."""
    if n_vertices < WORTH_A_THREAD:
        first()
        second()
        return
    with ThreadPoolExecutor(1) as pool:
        other = pool.submit(second)
        first()
        other.result()
