"""Where the rows of a matrix go: memory, an .npy file, a zarr store, pieces of a sparse file."""

import abc
import os
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray
from scipy.sparse import csr_array, load_npz, save_npz, vstack

from geodesic_toolkit.analysis.matrix.symmetry import (
    symmetric_bands,
    symmetrize_in_place,
    symmetrized_entries,
)
from geodesic_toolkit.analysis.matrix.tasks import Rows, RowTask
from geodesic_toolkit.analysis.matrix.unfinished import Unfinished, writing
from geodesic_toolkit.core.types import BoolArray
from geodesic_toolkit.errors import MissingDependencyError, WriteError
from geodesic_toolkit.linear.memory import require_memory

__all__ = [
    "FileOfRows",
    "InMemory",
    "Plan",
    "SparseFile",
    "SparseInMemory",
    "Store",
    "ZarrOfRows",
    "check_disk",
    "require_zarr",
]


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """The matrix to be: its shape, its type, its tasks, and what is to be done at the end.

    Parameters
    ----------
    tasks : sequence of RowTask
    shape : tuple of int
    dtype : dtype
    symmetrize : str, optional
        Where the matrix is to be made symmetric, how.
    limit : float, optional
        Where it is sparse, what its entries are not above.
    request : mapping of str to str
        All this in words, for the record of an unfinished matrix.
    """

    tasks: Sequence[RowTask]
    shape: tuple[int, int]
    dtype: np.dtype[Any]
    symmetrize: str | None
    limit: float | None
    request: Mapping[str, str]

    @property
    def rows_of_task(self) -> int:
        """Rows of every task but the last."""
        return self.tasks[0].stop - self.tasks[0].start

    @property
    def nbytes(self) -> float:
        """Bytes of the dense matrix."""
        return float(self.dtype.itemsize) * self.shape[0] * self.shape[1]


class Store(abc.ABC):
    """Takes rows in any order and makes a matrix of them.

    Attributes
    ----------
    plan : Plan
    done : ndarray of bool
        One a task: whether its rows are here, from an earlier run too.
    """

    plan: Plan
    done: BoolArray

    @abc.abstractmethod
    def put(self, task: RowTask, rows: Rows) -> None:
        """Take the rows of a task."""

    @abc.abstractmethod
    def finish(self) -> Any:
        """Make the matrix symmetric, put it in its place, and return it."""

    def close(self) -> None:
        """Let go of files; what is unfinished stays for the next run."""
        return


@final
class InMemory(Store):
    """A dense array."""

    def __init__(self, plan: Plan) -> None:
        rows, columns = plan.shape
        require_memory(
            plan.nbytes,
            f"the matrix of {rows} x {columns} distances (on disk it takes none: out= with a name "
            "ending in .npy or .zarr; dtype=numpy.float32 halves it, max_distance= thins it)",
        )
        self.plan = plan
        self.done = np.zeros(len(plan.tasks), dtype=bool)
        self._matrix = np.empty(plan.shape, dtype=plan.dtype)

    def put(self, task: RowTask, rows: Rows) -> None:
        """Copy the rows to their place."""
        self._matrix[task.start : task.stop] = rows
        self.done[task.number] = True

    def finish(self) -> NDArray[np.floating[Any]]:
        """Return the array."""
        if self.plan.symmetrize is not None:
            symmetrize_in_place(self._matrix, self.plan.symmetrize)
        return self._matrix


@final
class SparseInMemory(Store):
    """A csr_array, made of thinned blocks."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.done = np.zeros(len(plan.tasks), dtype=bool)
        self._blocks: dict[int, csr_array] = {}

    def put(self, task: RowTask, rows: Rows) -> None:
        """Keep the block."""
        assert isinstance(rows, csr_array)  # for the type checker
        self._blocks[task.number] = rows
        self.done[task.number] = True

    def finish(self) -> csr_array:
        """Return the array."""
        return _assembled([self._blocks.pop(task.number) for task in self.plan.tasks], self.plan)


def _assembled(blocks: list[csr_array], plan: Plan) -> csr_array:
    assert plan.limit is not None  # for the type checker
    matrix = csr_array(vstack(blocks, format="csr"))
    if plan.symmetrize is not None:
        matrix = symmetrized_entries(matrix, plan.symmetrize, plan.limit)
    index: type[np.signedinteger[Any]] = np.int64
    if max(matrix.nnz, *matrix.shape) <= np.iinfo(np.int32).max:
        index = np.int32  # what the algorithms of scipy.sparse.csgraph take
    parts = (matrix.data, matrix.indices.astype(index), matrix.indptr.astype(index))
    return csr_array(parts, shape=plan.shape)


# -- files -----------------------------------------------------------------------------------------


def check_disk(folder: Path, needed: float, output: Path) -> None:
    """Raise a `WriteError` where a disk has not as many bytes as are needed."""
    with writing(output):
        free = shutil.disk_usage(folder).free
    if needed > free:
        raise WriteError(
            f"{output} cannot be written: it needs about {needed / 1e9:.3g} GB, and "
            f"{free / 1e9:.3g} GB are free in {folder}"
        )


class NpyRows:
    """Rows of a matrix in an .npy file: written by position, read through a memory map.

    A map is not written through: on a full disk it would end the process.
    """

    def __init__(self, path: Path, shape: tuple[int, int], dtype: np.dtype[Any]) -> None:
        self.path = path
        self._shape = shape
        self._row_bytes = shape[1] * dtype.itemsize
        header = {"descr": npy.dtype_to_descr(dtype), "fortran_order": False, "shape": shape}
        with writing(path):
            self._file = path.open("r+b" if path.exists() else "w+b")
            npy.write_array_header_1_0(self._file, header)
            self._offset = self._file.tell()
            self._file.truncate(self._offset + shape[0] * self._row_bytes)

    def write(self, start: int, rows: NDArray[np.floating[Any]], *, durable: bool) -> None:
        """Write rows from row `start` on; `durable` ones are on disk afterwards."""
        with writing(self.path):
            self._file.seek(self._offset + start * self._row_bytes)
            self._file.write(np.ascontiguousarray(rows).data)
            self._file.flush()
            if durable:
                os.fsync(self._file.fileno())

    def array(self) -> NDArray[np.floating[Any]]:
        """Return the matrix as a read-only memory map."""
        array: NDArray[np.floating[Any]] = np.load(self.path, mmap_mode="r")
        return array

    def close(self) -> None:
        """Close the file, with all of it on disk."""
        if not self._file.closed:
            with writing(self.path):
                self._file.flush()
                os.fsync(self._file.fileno())
                self._file.close()


class ZarrRows:
    """Rows of a matrix in a zarr array, of which each task is a chunk."""

    def __init__(self, path: Path, plan: Plan) -> None:
        zarr = require_zarr()
        self.path = path
        self._rows = plan.rows_of_task
        with writing(path):
            if path.exists():
                self._array = zarr.open_array(path, mode="r+")
            else:
                self._array = zarr.create_array(
                    path,
                    shape=plan.shape,
                    dtype=plan.dtype,
                    chunks=(plan.rows_of_task, plan.shape[1]),
                    fill_value=np.inf,
                    zarr_format=3,
                )

    def write(self, start: int, rows: NDArray[np.floating[Any]], *, durable: bool) -> None:
        """Write whole chunks from row `start` on; `durable` ones are on disk afterwards."""
        stop = start + len(rows)
        with writing(self.path):
            self._array[start:stop] = rows
            if durable:
                for chunk in range(start // self._rows, -(-stop // self._rows)):
                    _sync_if_there(self.path / "c" / str(chunk) / "0")


def _sync_if_there(chunk: Path) -> None:
    if chunk.exists():  # one of nothing but infinity is not written
        with chunk.open("rb") as file:
            os.fsync(file.fileno())


def require_zarr() -> Any:
    """Import and return zarr.

    Raises
    ------
    MissingDependencyError
        It is not installed.
    """
    try:
        import zarr
    except ImportError as error:
        raise MissingDependencyError(
            f'writing .zarr stores needs zarr ({error}): pip install "geodesic-toolkit[zarr]"'
        ) from error
    return zarr


class _OnDisk(Store):
    """What stores in files share: the folder of what is unfinished."""

    def __init__(self, plan: Plan, folder: Unfinished) -> None:
        self.plan = plan
        self._folder = folder
        self.done = folder.done

    def close(self) -> None:
        """Let go of the folder."""
        self._folder.close()

    def _restart_without(self, path: Path) -> None:
        """Where the rows are gone (a run that ended while it cleaned up), so are the marks."""
        if not path.exists():
            self.done[:] = False


@final
class FileOfRows(_OnDisk):
    """An .npy file; a symmetric one is made of another with the rows as they came."""

    def __init__(self, plan: Plan, folder: Unfinished) -> None:
        super().__init__(plan, folder)
        self._restart_without(folder.folder / "rows.npy")
        self._rows = NpyRows(folder.folder / "rows.npy", plan.shape, plan.dtype)

    def put(self, task: RowTask, rows: Rows) -> None:
        """Write the rows, then note that they are there."""
        assert isinstance(rows, np.ndarray)  # for the type checker
        self._rows.write(task.start, rows, durable=True)
        self._folder.mark(task.number)

    def finish(self) -> NDArray[np.floating[Any]]:
        """Return the matrix as a read-only memory map."""
        self._rows.close()
        result = self._rows
        if self.plan.symmetrize is not None:
            path = self._folder.folder / "symmetric.npy"
            result = NpyRows(path, self.plan.shape, self.plan.dtype)
            try:
                for start, band in symmetric_bands(self._rows.array(), self.plan.symmetrize):
                    result.write(start, band, durable=False)
            finally:
                result.close()
        self._folder.deliver(result.path)
        array: NDArray[np.floating[Any]] = np.load(self._folder.output, mmap_mode="r")
        return array

    def close(self) -> None:
        """Let go of the file and the folder."""
        self._rows.close()
        super().close()


@final
class ZarrOfRows(_OnDisk):
    """A zarr store; a symmetric one is made of an .npy file, whose columns can be read."""

    def __init__(self, plan: Plan, folder: Unfinished) -> None:
        super().__init__(plan, folder)
        self._path = folder.folder / "matrix.zarr"
        self._rows: NpyRows | ZarrRows
        if plan.symmetrize is not None:
            self._restart_without(folder.folder / "rows.npy")
            self._rows = NpyRows(folder.folder / "rows.npy", plan.shape, plan.dtype)
        else:
            self._restart_without(self._path)
            self._rows = ZarrRows(self._path, plan)

    def put(self, task: RowTask, rows: Rows) -> None:
        """Write the rows, then note that they are there."""
        assert isinstance(rows, np.ndarray)  # for the type checker
        self._rows.write(task.start, rows, durable=True)
        self._folder.mark(task.number)

    def finish(self) -> Any:
        """Return the zarr array, opened for reading."""
        if isinstance(self._rows, NpyRows):
            assert self.plan.symmetrize is not None  # for the type checker
            self._rows.close()
            if self._path.exists():  # of a run that was interrupted here
                shutil.rmtree(self._path)
            result = ZarrRows(self._path, self.plan)
            raw, multiple = self._rows.array(), self.plan.rows_of_task
            for start, band in symmetric_bands(raw, self.plan.symmetrize, multiple):
                result.write(start, band, durable=True)
        self._folder.deliver(self._path)
        return require_zarr().open_array(self._folder.output, mode="r")

    def close(self) -> None:
        """Let go of the file and the folder."""
        if isinstance(self._rows, NpyRows):
            self._rows.close()
        super().close()


@final
class SparseFile(_OnDisk):
    """An .npz file of SciPy; until it is complete, one piece a task."""

    def __init__(self, plan: Plan, folder: Unfinished) -> None:
        super().__init__(plan, folder)
        for task in plan.tasks:
            self.done[task.number] &= self._piece(task).exists()

    def put(self, task: RowTask, rows: Rows) -> None:
        """Write the piece, then note that it is there."""
        assert isinstance(rows, csr_array)  # for the type checker
        path = self._piece(task)
        with writing(path), path.open("wb") as file:
            save_npz(file, rows, compressed=False)
            file.flush()
            os.fsync(file.fileno())
        self._folder.mark(task.number)

    def finish(self) -> csr_array:
        """Return the csr_array."""
        pieces = [csr_array(load_npz(self._piece(task))) for task in self.plan.tasks]
        matrix = _assembled(pieces, self.plan)
        path = self._folder.folder / "matrix.npz"
        with writing(path), path.open("wb") as file:
            save_npz(file, matrix)
            file.flush()
            os.fsync(file.fileno())
        self._folder.deliver(path)
        return matrix

    def _piece(self, task: RowTask) -> Path:
        return self._folder.folder / f"rows-{task.number:06}.npz"
