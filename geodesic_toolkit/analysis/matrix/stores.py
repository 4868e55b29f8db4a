"""Targets of the rows of a matrix: memory, an .npy file, a zarr store, pieces of a sparse file."""

import abc
import os
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias, final

import numpy as np
from numpy.lib.format import open_memmap
from numpy.typing import NDArray
from scipy.sparse import csr_array, load_npz, save_npz, vstack

from geodesic_toolkit.analysis.matrix.symmetry import (
    symmetric_bands,
    symmetrize_in_place,
    symmetrized_entries,
    unknown_rows,
)
from geodesic_toolkit.analysis.matrix.tasks import Rows, RowTask
from geodesic_toolkit.analysis.matrix.unfinished import Unfinished
from geodesic_toolkit.core.atomic import replacing, sync, writing
from geodesic_toolkit.core.optional import require
from geodesic_toolkit.core.types import BoolArray, IntArray
from geodesic_toolkit.errors import WriteError
from geodesic_toolkit.linear.memory import require_memory

__all__ = [
    "DenseFile",
    "InMemory",
    "Plan",
    "SparseFile",
    "SparseInMemory",
    "Store",
    "check_disk",
    "require_zarr",
]


Again: TypeAlias = Callable[[IntArray, float], Rows]
"""Function of the numbers of R rows, and a limit, that measures these again as far as that."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """The plan of a matrix: its shape, its type, its tasks, and the final steps.

    Parameters
    ----------
    tasks : sequence of RowTask
    shape : tuple of int
    dtype : dtype
    symmetrize : str, optional
        How to make the matrix symmetric; None to leave it.
    limit : float, optional
        The largest distance that a sparse matrix keeps; None for a dense one.
    request : mapping of str to str
        The whole request in words, for the record of an unfinished matrix.
    again : callable
        Measures rows of a sparse matrix that have to be known farther than its tasks do.
    """

    tasks: Sequence[RowTask]
    shape: tuple[int, int]
    dtype: np.dtype[Any]
    symmetrize: str | None
    limit: float | None
    request: Mapping[str, str]
    again: Again

    @property
    def rows_of_task(self) -> int:
        """Number of rows of every task but the last."""
        return self.tasks[0].stop - self.tasks[0].start

    @property
    def nbytes(self) -> float:
        """Bytes of the dense matrix."""
        return float(self.dtype.itemsize) * self.shape[0] * self.shape[1]


class Store(abc.ABC):
    """A target that takes rows in any order and makes a matrix of them.

    Attributes
    ----------
    plan : Plan
    done : ndarray of bool
        One per task: whether an earlier run has stored its rows.
    """

    done: BoolArray

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.done = np.zeros(len(plan.tasks), dtype=bool)

    @abc.abstractmethod
    def put(self, task: RowTask, rows: Rows) -> None:
        """Store the rows of a task."""

    @abc.abstractmethod
    def finish(self) -> Any:
        """Make the matrix symmetric, move it into place, and return it."""

    def close(self) -> None:
        """Release the files; unfinished ones stay for the next run."""
        return


@final
class InMemory(Store):
    """A dense array."""

    def __init__(self, plan: Plan) -> None:
        rows, columns = plan.shape
        require_memory(
            plan.nbytes,
            f"the matrix of {rows} x {columns} distances (to write it to disk, give out= a name "
            "ending in .npy or .zarr; dtype=numpy.float32 halves it, max_distance= thins it)",
        )
        super().__init__(plan)
        self._matrix = np.empty(plan.shape, dtype=plan.dtype)

    def put(self, task: RowTask, rows: Rows) -> None:
        """Copy the rows into the array."""
        self._matrix[task.start : task.stop] = rows

    def finish(self) -> NDArray[np.floating[Any]]:
        """Return the array."""
        if self.plan.symmetrize is not None:
            symmetrize_in_place(self._matrix, self.plan.symmetrize)
        return self._matrix


@final
class SparseInMemory(Store):
    """A csr_array, assembled from thinned blocks."""

    def __init__(self, plan: Plan) -> None:
        super().__init__(plan)
        self._blocks: dict[int, csr_array] = {}

    def put(self, task: RowTask, rows: Rows) -> None:
        """Keep the block."""
        assert isinstance(rows, csr_array)  # for the type checker
        self._blocks[task.number] = rows

    def finish(self) -> csr_array:
        """Return the array."""
        return _assembled([self._blocks.pop(task.number) for task in self.plan.tasks], self.plan)


def _assembled(blocks: list[csr_array], plan: Plan) -> csr_array:
    assert plan.limit is not None  # for the type checker
    matrix = csr_array(vstack(blocks, format="csr"))
    if plan.symmetrize is not None:
        rows, limit = unknown_rows(matrix, plan.symmetrize, plan.limit)
        if len(rows):
            order = np.arange(len(matrix.indptr) - 1)
            order[rows] = len(order) + np.arange(len(rows))
            farther = csr_array(plan.again(rows, limit))
            matrix = csr_array(csr_array(vstack([matrix, farther], format="csr"))[order])
        matrix = symmetrized_entries(matrix, plan.symmetrize, plan.limit)
    index: type[np.signedinteger[Any]] = np.int64
    if max(matrix.nnz, *matrix.shape) <= np.iinfo(np.int32).max:
        index = np.int32  # required by the algorithms of scipy.sparse.csgraph
    parts = (matrix.data, matrix.indices.astype(index), matrix.indptr.astype(index))
    return csr_array(parts, shape=plan.shape)


# -- files -----------------------------------------------------------------------------------------


def check_disk(folder: Path, needed: float, output: Path) -> None:
    """Raise a `WriteError` if the disk has fewer free bytes than needed."""
    with writing(output):
        free = shutil.disk_usage(folder).free
    if needed > free:
        raise WriteError(
            f"{output} cannot be written: it needs about {needed / 1e9:.3g} GB, and "
            f"{free / 1e9:.3g} GB are free in {folder}"
        )


def require_zarr() -> Any:
    """Import and return zarr, or raise a `MissingDependencyError`."""
    return require("zarr", "zarr", "writing .zarr stores needs")


class _OnDisk(Store):
    """Base of stores in files: rows go to disk first, then the mark that says so."""

    def __init__(self, plan: Plan, folder: Unfinished) -> None:
        super().__init__(plan)
        self.done = folder.done
        self._folder = folder

    @abc.abstractmethod
    def _write(self, task: RowTask, rows: Rows) -> None:
        """Write the rows of a task to disk."""

    def put(self, task: RowTask, rows: Rows) -> None:
        """Write the rows, then mark the task as done."""
        with writing(self._folder.folder):
            self._write(task, rows)
            self._folder.mark(task.number)

    def close(self) -> None:
        """Release the folder."""
        self._folder.close()


class _NpyRows:
    """Rows of an .npy file, written at their positions.

    A memory map is not used for writing: on a full disk it would end the process.
    """

    def __init__(self, path: Path, plan: Plan) -> None:
        if not path.exists():
            open_memmap(path, mode="w+", dtype=plan.dtype, shape=plan.shape)  # header and length
        self.path = path
        self._offset = open_memmap(path, mode="r").offset
        self._row_bytes = plan.dtype.itemsize * plan.shape[1]

    def write(self, start: int, rows: NDArray[np.floating[Any]]) -> None:
        with self.path.open("r+b") as file:
            file.seek(self._offset + start * self._row_bytes)
            file.write(np.ascontiguousarray(rows).data)
            file.flush()
            os.fsync(file.fileno())


class _ZarrRows:
    """Rows of a zarr array with one chunk per task."""

    def __init__(self, path: Path, plan: Plan) -> None:
        zarr = require_zarr()
        self.path = path
        self._rows_of_chunk = plan.rows_of_task
        if (path / "zarr.json").exists():
            self._array = zarr.open_array(path, mode="r+")
        else:
            self._array = zarr.create_array(
                path,
                shape=plan.shape,
                dtype=plan.dtype,
                chunks=(plan.rows_of_task, plan.shape[1]),
                fill_value=np.inf,
                zarr_format=3,
                overwrite=True,
            )

    def write(self, start: int, rows: NDArray[np.floating[Any]]) -> None:
        self._array[start : start + len(rows)] = rows
        for first in range(start, start + len(rows), self._rows_of_chunk):
            chunk = self.path / "c" / str(first // self._rows_of_chunk) / "0"
            if chunk.exists():  # zarr does not write a chunk of infinities
                sync(chunk)


@final
class DenseFile(_OnDisk):
    """An .npy file or a zarr store.

    A symmetric one is made at the end from an .npy file of the raw rows, because columns of a zarr
    array cannot be read without reading all of it.
    """

    def __init__(self, plan: Plan, folder: Unfinished) -> None:
        super().__init__(plan, folder)
        suffix = folder.output.suffix.lower()
        self._kind = _ZarrRows if suffix == ".zarr" else _NpyRows
        self._result = folder.folder / f"matrix{suffix}"
        with writing(folder.folder):
            path = self._result if plan.symmetrize is None else folder.folder / "rows.npy"
            if not path.exists():
                self.done[:] = False
            self._rows = (self._kind if plan.symmetrize is None else _NpyRows)(path, plan)

    def _write(self, task: RowTask, rows: Rows) -> None:
        assert isinstance(rows, np.ndarray)  # for the type checker
        self._rows.write(task.start, rows)

    def finish(self) -> Any:
        """Return the matrix: a read-only memory map, or a zarr array opened for reading."""
        if self.plan.symmetrize is not None:
            with writing(self._result):
                result = self._kind(self._result, self.plan)
                raw = np.load(self._rows.path, mmap_mode="r")
                bands = symmetric_bands(raw, self.plan.symmetrize, self.plan.rows_of_task)
                for start, band in bands:
                    result.write(start, band)
                del raw, bands  # Windows cannot move a mapped file
        self._folder.deliver(self._result)
        if self._kind is _NpyRows:
            return np.load(self._folder.output, mmap_mode="r")
        return require_zarr().open_array(self._folder.output, mode="r")


@final
class SparseFile(_OnDisk):
    """An .npz file of SciPy; until it is complete, one piece per task."""

    def __init__(self, plan: Plan, folder: Unfinished) -> None:
        super().__init__(plan, folder)
        for task in plan.tasks:
            self.done[task.number] &= self._piece(task).exists()

    def _write(self, task: RowTask, rows: Rows) -> None:
        assert isinstance(rows, csr_array)  # for the type checker
        with replacing(self._piece(task)) as path:
            save_npz(path, rows, compressed=False)

    def finish(self) -> csr_array:
        """Return the csr_array."""
        pieces = [csr_array(load_npz(self._piece(task))) for task in self.plan.tasks]
        matrix = _assembled(pieces, self.plan)
        with replacing(self._folder.folder / "matrix.npz") as path:
            save_npz(path, matrix)
        self._folder.deliver(self._folder.folder / "matrix.npz")
        return matrix

    def _piece(self, task: RowTask) -> Path:
        return self._folder.folder / f"rows-{task.number:06}.npz"
