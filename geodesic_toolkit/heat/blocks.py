"""Blocks of source sets, each solved with one pass over a factor, on several threads."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.sources.points import SourcePoints

__all__ = [
    "MIN_VERTICES_PER_THREAD",
    "PROCESSORS",
    "SOURCE_SETS_PER_BLOCK",
    "in_blocks",
    "on_threads",
    "side_by_side",
]

SOURCE_SETS_PER_BLOCK = 16
"""Source sets solved at once: they share one pass over a factor, and stay in cache."""

PROCESSORS = os.cpu_count() or 1

MIN_VERTICES_PER_THREAD = 10_000
"""Number of vertices above which a factor, or a block of sources, takes longer than starting a
thread."""

Report = TypeVar("Report")


def in_blocks(
    points: list[SourcePoints],
    distances: FloatArray,
    solve: Callable[[list[SourcePoints], FloatArray], Report],
    *,
    threads: bool,
) -> Iterator[tuple[int, Report]]:
    """Fill distances (K, N) block by block, and yield the number of rows and report of each block.

    Parameters
    ----------
    points : list of SourcePoints
    distances : ndarray of shape (K, N)
        Written by `solve`, some rows in each call.
    solve : callable
        Function of source sets and their rows that returns a report.
    threads : bool
        True if blocks may run in parallel, unless `solve` uses all processors itself.
    """

    def solve_from(start: int) -> tuple[int, Report]:
        block = points[start : start + SOURCE_SETS_PER_BLOCK]
        return len(block), solve(block, distances[start : start + len(block)])

    starts = range(0, len(points), SOURCE_SETS_PER_BLOCK)
    if len(starts) == 1 or distances.shape[1] < MIN_VERTICES_PER_THREAD or not threads:
        yield from map(solve_from, starts)
        return
    with ThreadPoolExecutor(min(len(starts), PROCESSORS)) as pool:
        yield from pool.map(solve_from, starts)


def on_threads(
    solve: Callable[[int], Report], starts: Sequence[int], n_vertices: int
) -> list[Report]:
    """Return what a function finds for each block, by its first source set, in their order."""
    if len(starts) == 1 or n_vertices < MIN_VERTICES_PER_THREAD:
        return [solve(start) for start in starts]
    with ThreadPoolExecutor(min(len(starts), PROCESSORS)) as pool:
        return list(pool.map(solve, starts))


def side_by_side(
    first: Callable[[], object], second: Callable[[], object], n_vertices: int
) -> None:
    """Call two functions, the second on another thread if the domain is large enough."""
    if n_vertices < MIN_VERTICES_PER_THREAD:
        first()
        second()
        return
    with ThreadPoolExecutor(1) as pool:
        other = pool.submit(second)
        first()
        other.result()
