"""`distance_matrix`: distances of many sources, in memory or on disk, in one process or many."""

import os
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from geodesic_toolkit.analysis.matrix.fingerprints import (
    digest,
    fingerprint_of_solver,
    fingerprint_of_sources,
    fingerprint_of_versions,
)
from geodesic_toolkit.analysis.matrix.stores import (
    DenseFile,
    InMemory,
    Plan,
    SparseFile,
    SparseInMemory,
    Store,
    check_disk,
    require_zarr,
)
from geodesic_toolkit.analysis.matrix.symmetry import Symmetrize, check_symmetrize, widened
from geodesic_toolkit.analysis.matrix.tasks import (
    EveryVertex,
    Rows,
    RowTask,
    Sets,
    rows_of_task,
    vertices_of,
)
from geodesic_toolkit.analysis.matrix.unfinished import Unfinished
from geodesic_toolkit.analysis.matrix.workers import check_executor, computed
from geodesic_toolkit.core.atomic import as_path, check_output
from geodesic_toolkit.core.checks import real_number
from geodesic_toolkit.core.types import IntArray
from geodesic_toolkit.errors import InvalidOptionError, WriteError
from geodesic_toolkit.heat.method import Progress
from geodesic_toolkit.solver.solver import GeodesicSolver, check_solver
from geodesic_toolkit.sources.points import as_vertices

__all__ = ["MATRIX_SUFFIXES", "check_matrix_output", "distance_matrix"]

MATRIX_SUFFIXES = (".npy", ".zarr", ".npz")


def distance_matrix(
    solver: GeodesicSolver,
    sources: Any = None,
    *,
    targets: ArrayLike | None = None,
    dtype: DTypeLike = np.float64,
    symmetrize: Symmetrize = "mean",
    max_distance: float | None = None,
    out: str | os.PathLike[str] | None = None,
    resume: bool = True,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Any:
    """Return the matrix of geodesic distances from K source sets to N vertices.

    Rows are computed in tasks of fixed ranges. The result therefore has the same bits in memory
    and in a file, in one process and in many, in one run and resumed.

    Parameters
    ----------
    solver : GeodesicSolver
    sources : array-like of int, or iterable of sources, optional
        Each as for :meth:`GeodesicSolver.distance`; a one-dimensional array of integers means as
        many single sources. All vertices by default; vertices that cannot be sources (masked ones,
        missing points of a cloud) have rows of ``inf``.
    targets : array-like of int, optional
        Vertices that are the columns; all by default. Pass the sources again for the square matrix
        between them.
    dtype : {float64, float32}
        Of the result. The computation is in float64.
    symmetrize : {"mean", "min", "max"} or None
        The value of an entry and of the one that mirrors it, as heat distances are not symmetric.
        For square matrices whose rows and columns are the same vertices; others do not change.
    max_distance : float, optional
        Keep the entries up to this distance, in a sparse matrix; they are those of the dense one,
        to the bit. Refined distances and fronts across graphs end a little beyond it, so that a
        row costs what lies within: on graphs that alone, and on triangles the heat of all vertices
        as well, a tenth of a full row. Plain heat costs the full row. The zeros of the diagonal are
        stored entries, as neighbour searches expect: an entry that is not stored is farther, and
        ``eliminate_zeros`` would lose the zeros.
    out : path-like, optional
        A file to write: ``.npy``, or ``.zarr`` with one task per chunk, or with `max_distance`
        SciPy's ``.npz``. It is put in place when it is complete. Until then a folder beside it,
        ``NAME.partial``, holds the finished rows. Dense symmetric matrices temporarily need twice
        their size on disk, and a few hundred megabytes of memory whatever their size.
    resume : bool
        Resume from the files that an interrupted run of the same request left beside `out`;
        otherwise discard them.
    executor : concurrent.futures.Executor, optional
        The workers: a process pool, loky's, ``Client(...).get_executor()`` of dask,
        ``MPIPoolExecutor`` of mpi4py. Each process unpickles and factorises the solver once,
        and keeps it for the next call with it. The executor stays open.
    progress : callable, optional
        Called with the number of rows done and their total, at the start and after each task.

    Returns
    -------
    ndarray, memmap, zarr.Array or csr_array, of shape (K, N) or (K, T)
        In the unit of the domain, ``inf`` if no source is connected. Files are opened for
        reading: an ``.npy`` as a memory map, a ``.zarr`` as its array. Sparse if `max_distance`
        is given.

    Raises
    ------
    InvalidSourceError
        As for :meth:`GeodesicSolver.distances`, before any work; or a target is out of range.
    InvalidOptionError
        An option outside its values; a file that does not fit the other options; an unfinished
        matrix of another request beside `out` (the message names the differences).
    NotEnoughMemoryError
        A dense matrix in memory that would not fit.
    WriteError
        `out` cannot be written, or another run is writing it.
    MissingDependencyError
        A ``.zarr`` without the package zarr.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> solver = gt.GeodesicSolver(gt.testing.shapes.icosphere(2))
    >>> gt.distance_matrix(solver, [0, 1, 2]).shape
    (3, 162)
    >>> square = gt.distance_matrix(solver, dtype="float32")
    >>> square.shape, bool((square == square.T).all())
    ((162, 162), True)
    >>> near = gt.distance_matrix(solver, max_distance=0.5)
    >>> round(near.nnz / 162)  # vertices not farther than half a radius
    8
    """
    check_solver(solver, "a matrix")
    check_executor(executor)
    check_symmetrize(symmetrize)
    plan = _plan(
        solver,
        _sets(solver, sources),
        None if targets is None else as_vertices(targets, solver.domain.n_vertices, "targets"),
        dtype=_dtype(dtype),
        symmetrize=symmetrize,
        limit=_limit(max_distance),
    )
    output = None if out is None else check_matrix_output(out, sparse=plan.limit is not None)
    store = _store(solver, plan, output, resume=bool(resume))
    try:
        return _filled(solver, store, executor, progress)
    finally:
        store.close()


def _filled(
    solver: GeodesicSolver, store: Store, executor: Executor | None, progress: Progress | None
) -> Any:
    missing = [task for task in store.plan.tasks if not store.done[task.number]]
    total = store.plan.shape[0]
    done = total - sum(task.stop - task.start for task in missing)
    if progress is not None:
        progress(done, total)
    for task, rows in computed(solver, missing, executor):
        store.put(task, rows)
        done += task.stop - task.start
        if progress is not None:
            progress(done, total)
    return store.finish()


# -- the request -----------------------------------------------------------------------------------


def _dtype(dtype: DTypeLike) -> np.dtype[Any]:
    try:
        chosen = np.dtype(dtype)
    except TypeError as error:
        raise InvalidOptionError(f"dtype must be float64 or float32, not {dtype!r}") from error
    if chosen not in (np.dtype(np.float64), np.dtype(np.float32)):
        raise InvalidOptionError(f"dtype must be float64 or float32, not {chosen}")
    return chosen


def _limit(max_distance: Any) -> float | None:
    if max_distance is None:
        return None
    limit = real_number(max_distance, "max_distance")
    if not (np.isfinite(limit) and limit >= 0):
        raise InvalidOptionError(f"max_distance must be finite and not negative, not {limit}")
    return limit


def _sets(solver: GeodesicSolver, sources: Any) -> Sets:
    """Return the source sets, each checked."""
    n_vertices = solver.domain.n_vertices
    if isinstance(sources, EveryVertex):
        return sources
    if sources is None:
        return EveryVertex(np.arange(n_vertices))
    located = solver.locate_sets(sources)
    try:
        array = np.asarray(sources)
    except (ValueError, TypeError):  # sets of different kinds and lengths
        return located
    if array.ndim == 1 and array.dtype.kind in "iu":
        return as_vertices(array, n_vertices)
    return located


def _plan(
    solver: GeodesicSolver,
    sets: Sets,
    columns: IntArray | None,
    *,
    dtype: np.dtype[Any],
    symmetrize: Symmetrize,
    limit: float | None,
) -> Plan:
    n_vertices = solver.domain.n_vertices
    across = np.arange(n_vertices) if columns is None else columns
    rows = vertices_of(sets)
    how = symmetrize if rows is not None and np.array_equal(rows, across) else None
    kept = None if limit is None else widened(limit, how)
    step = rows_of_task(len(sets), n_vertices)
    tasks = []
    for number, start in enumerate(range(0, len(sets), step)):
        stop = min(start + step, len(sets))
        tasks.append(RowTask(number, start, stop, sets[start:stop], columns, dtype, kept))
    request = {
        "sources": fingerprint_of_sources(sets),
        "targets": "every vertex" if columns is None else f"{len(columns)} {digest(columns)}",
        "dtype": dtype.name,
        "symmetrize": how or "no",
        "max_distance": repr(limit),
        "rows of a task": str(step),
    }

    def again(numbers: IntArray, limit: float) -> Rows:
        assert rows is not None  # for the type checker: the matrix is symmetric
        some = rows[numbers]
        own = EveryVertex(some) if isinstance(sets, EveryVertex) else some
        return RowTask(-1, 0, len(numbers), own, columns, dtype, limit).compute(solver)

    return Plan(
        tasks=tasks,
        shape=(len(sets), len(across)),
        dtype=dtype,
        symmetrize=how,
        limit=limit,
        request=request,
        again=again,
    )


# -- the output ------------------------------------------------------------------------------------


def check_matrix_output(out: str | os.PathLike[str], *, sparse: bool) -> Path:
    """Return the path of `out`, links resolved, or raise if it cannot become a matrix.

    Call it before any work. `sparse` is true if a `max_distance` is given; the errors are those of
    `distance_matrix`.
    """
    path = as_path(out)
    suffix = path.suffix.lower()
    if suffix in MATRIX_SUFFIXES and sparse != (suffix == ".npz"):
        raise InvalidOptionError(
            f"{path}: a matrix thinned by max_distance is sparse, so write a .npz file"
            if sparse
            else f"{path}: a .npz file is for sparse matrices; give max_distance, or write .npy "
            "or .zarr"
        )
    if suffix == ".zarr":
        require_zarr()
        if path.exists():  # only another store may be replaced
            if not (path / "zarr.json").exists():
                raise WriteError(f"{path} exists and is not a zarr store; give another name")
            check_output(path / "zarr.json", (".json",))
            return Path(os.path.realpath(path))
    check_output(path, MATRIX_SUFFIXES)
    return Path(os.path.realpath(path))


def _store(solver: GeodesicSolver, plan: Plan, output: Path | None, *, resume: bool) -> Store:
    if output is None:
        return InMemory(plan) if plan.limit is None else SparseInMemory(plan)
    request = {
        **fingerprint_of_solver(solver),
        **plan.request,
        "file": output.suffix.lower(),
        "versions": fingerprint_of_versions(),
    }
    unfinished = Unfinished(output, request, len(plan.tasks), resume=resume)
    try:
        if plan.limit is not None:
            return SparseFile(plan, unfinished)
        todo = float(np.mean(~unfinished.done)) + (plan.symmetrize is not None)
        check_disk(output.parent, plan.nbytes * todo, output)
        return DenseFile(plan, unfinished)
    except BaseException:  # also Ctrl-C: unlock the folder, then re-raise
        unfinished.close()
        raise
