"""A matrix of distances as tasks: fixed ranges of rows, each computed on its own.

The ranges depend only on the shape of the matrix. Every worker passes a task to the solver as one
list of source sets, so that the result is the same to the last bit.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from geodesic_toolkit.core.types import IntArray
from geodesic_toolkit.errors import InvalidSourceError
from geodesic_toolkit.solver.solver import GeodesicSolver
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["EveryVertex", "RowTask", "Rows", "Sets", "rows_of_task", "vertices_of"]

Rows: TypeAlias = NDArray[np.floating[Any]] | csr_array
"""Rows of a matrix: dense, or only the entries up to a limit."""

TASK_BYTES = 32e6
"""Bytes of the float64 rows of a task: at most about a second of work, which may be lost."""

FEWEST, MOST = 16, 1024
"""Smallest number of rows of a task; fewer would not fill the blocks of the solvers."""

MIN_TASKS = 64
"""Number of tasks to aim at, for progress and for many workers, if there are enough rows."""


@dataclass(frozen=True)
class EveryVertex:
    """Source sets of one vertex each, in order; a vertex that cannot be a source reaches nothing.

    Parameters
    ----------
    vertices : ndarray of shape (K,), int64
        All vertices, or those that the vertices of a file were merged into.
    """

    vertices: IntArray

    def __len__(self) -> int:
        return len(self.vertices)

    def __getitem__(self, rows: slice) -> "EveryVertex":
        return EveryVertex(self.vertices[rows])


Sets: TypeAlias = EveryVertex | Sequence[SourcePoints] | IntArray
"""Source sets: all vertices, located sources, or vertices known to be present."""


@dataclass(frozen=True, eq=False)
class RowTask:
    """Some rows of a matrix, with everything that a worker needs except the solver.

    Parameters
    ----------
    number : int
        Its position in the list of tasks.
    start, stop : int
        The range of rows.
    sets : EveryVertex, sequence of SourcePoints, or ndarray
        Sources, one set per row.
    targets : ndarray of shape (T,), int64, optional
        The vertices that are columns; all by default.
    dtype : dtype
        Of the rows.
    limit : float, optional
        Entries above it are omitted from a sparse result.
    """

    number: int
    start: int
    stop: int
    sets: Sets
    targets: IntArray | None
    dtype: np.dtype[Any]
    limit: float | None

    def compute(self, solver: GeodesicSolver) -> Rows:
        """Return the rows, dense or thinned."""
        found, rows = _located(solver, self.sets)
        if self.limit is not None:
            return self._near(solver, found, rows)
        distances = np.full((len(self.sets), solver.domain.n_vertices), np.inf)
        if len(rows) == len(self.sets):
            distances = solver.distances(found)
        elif len(rows):
            distances[rows] = solver.distances(found)
        if self.targets is not None:
            distances = distances[:, self.targets]
        return distances.astype(self.dtype, copy=False)

    def _near(self, solver: GeodesicSolver, found: Any, rows: IntArray) -> csr_array:
        """Return the entries up to the limit; zeros among them are stored too."""
        assert self.limit is not None  # for the type checker
        # Numbers just above the limit may be rounded to it.
        limit = self.limit * (1 + float(np.finfo(self.dtype).eps))
        shape = (len(self.sets), solver.domain.n_vertices)
        if not len(rows):
            return csr_array(shape, dtype=self.dtype)
        near = solver.near(found, limit)
        values = near.distances.astype(self.dtype, copy=False)
        within = values <= np.float64(self.limit)  # not a Python float, which float32 would round
        counts = np.zeros(len(self.sets), dtype=np.int64)
        counts[rows] = np.diff(np.concatenate([[0], np.cumsum(within)])[near.begins])
        starts = np.concatenate([[0], np.cumsum(counts)])
        matrix = csr_array((values[within], near.vertices[within], starts), shape=shape)
        if self.targets is None:
            return matrix
        chosen = csr_array(matrix[:, self.targets])
        chosen.sort_indices()
        return chosen


def _located(solver: GeodesicSolver, sets: Sets) -> tuple[Any, IntArray]:
    """Return the sources that there are, and the row of each."""
    if not isinstance(sets, EveryVertex):
        return sets, np.arange(len(sets))
    located = [_source_at(solver, vertex) for vertex in sets.vertices.tolist()]
    rows = [row for row, source in enumerate(located) if source is not None]
    return [located[row] for row in rows], np.array(rows, dtype=np.int64)


def _source_at(solver: GeodesicSolver, vertex: int) -> SourcePoints | None:
    """Return a vertex as a source, or None if it cannot be one: masked, or missing in a cloud."""
    try:
        return solver.locate(vertex)  # once, here, instead of in each block
    except InvalidSourceError:
        return None


def rows_of_task(n_rows: int, n_vertices: int) -> int:
    """Return the number of rows per task: `TASK_BYTES` of them, or fewer for enough tasks.

    Examples
    --------
    >>> from geodesic_toolkit.analysis.matrix.tasks import rows_of_task
    >>> rows_of_task(10_242, 10_242), rows_of_task(100, 1_000_000), rows_of_task(3, 10)
    (160, 16, 16)
    """
    fitting = min(TASK_BYTES / (8 * n_vertices), n_rows / MIN_TASKS, MOST)
    return max(FEWEST, int(fitting) // FEWEST * FEWEST)


def vertices_of(sets: Sets) -> IntArray | None:
    """Return the source vertices, one per row, or None if a set is anything else."""
    if isinstance(sets, EveryVertex):
        return sets.vertices
    return sets if isinstance(sets, np.ndarray) else None
