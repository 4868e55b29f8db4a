"""``geodesic-toolkit matrix``: distances from many vertices to all, and between all of them."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geodesic_toolkit.cli.arguments import (
    Cost,
    Inputs,
    Json,
    MarkedVertices,
    Mask,
    Operator,
    Refine,
    Solver,
    Weld,
    check_plugins,
    files_of,
    kinds_of,
)
from geodesic_toolkit.cli.interrupts import last_words
from geodesic_toolkit.cli.run import Run, method_in_words
from geodesic_toolkit.cli.several import Answer, answer_each
from geodesic_toolkit.cli.targets import Targets
from geodesic_toolkit.cli.welding import Welded, read_welded
from geodesic_toolkit.errors import InvalidOptionError

if TYPE_CHECKING:  # importing NumPy takes longer than all of --help
    from concurrent.futures import Executor

    from geodesic_toolkit.core.types import IntArray
    from geodesic_toolkit.solver.solver import GeodesicSolver

__all__ = ["matrix"]

MAX_LISTED_SOURCES = 8
"""Number of sources listed in the text output; --json lists all of them."""

SHUTDOWN_TIMEOUT = 0.5
"""Seconds for the thread of a pool to notice that its processes have ended."""


class SymmetrizeChoice(StrEnum):
    """The rule that makes two mirrored entries equal."""

    mean = "mean"
    min = "min"
    max = "max"
    none = "none"


def matrix(
    paths: Inputs,
    *,
    output: Annotated[
        Path,
        typer.Option(
            metavar="FILE",
            help="File of the matrix: .npy, .zarr, or with --max-distance .npz.",
            show_default=False,
        ),
    ],
    sources: Annotated[
        Path | None,
        typer.Option(
            exists=True,
            dir_okay=False,
            readable=True,
            metavar="FILE",
            help="Vertices that are the rows: an .npy array, or whole numbers in a .txt or .csv. "
            "Without it and without --landmarks, all vertices.",
        ),
    ] = None,
    landmarks: Annotated[
        int | None,
        typer.Option(
            metavar="K",
            min=1,
            help="Number of rows: vertices spread over the shape, each the farthest from those "
            "before it.",
            show_default=False,
        ),
    ] = None,
    float32: Annotated[
        bool, typer.Option("--float32", help="Write 32-bit numbers: half the size.")
    ] = False,
    symmetrize: Annotated[
        SymmetrizeChoice,
        typer.Option(help="Value of an entry and its mirror image in a square matrix."),
    ] = SymmetrizeChoice.mean,
    max_distance: Annotated[
        float | None,
        typer.Option(
            metavar="X",
            help="Keep only entries up to this distance, in a sparse matrix of SciPy.",
            show_default=False,
        ),
    ] = None,
    mask: Mask = None,
    cost: Cost = None,
    weld: Weld = None,
    operator: Operator = "auto",
    solver: Solver = "auto",
    refine: Refine = None,
    workers: Annotated[int, typer.Option(metavar="N", min=1, help="Number of processes.")] = 1,
    restart: Annotated[
        bool,
        typer.Option("--restart", help="Discard what an interrupted run left, and start again."),
    ] = False,
    json: Json = False,
) -> None:
    """Matrix of the geodesic distances between vertices of INPUT.

    May be interrupted: the same command resumes, and its result is the same to the last bit.
    """
    from geodesic_toolkit.analysis.matrix.matrix import check_matrix_output

    if sources is not None and landmarks is not None:
        raise InvalidOptionError("give --sources or --landmarks, not both")
    check_plugins(solver, operator)
    question = Question(
        sources,
        landmarks,
        mask,
        cost,
        weld,
        workers,
        {"operator": operator, "solver": solver, "refine": "auto" if refine is None else refine},
        {
            "dtype": "float32" if float32 else "float64",
            "symmetrize": None if symmetrize is SymmetrizeChoice.none else symmetrize.value,
            "max_distance": max_distance,
            "resume": not restart,
        },
    )
    targets = Targets(
        tables=(output,),
        check_table=partial(check_matrix_output, sparse=max_distance is not None),
    )
    used = [sources, cost, *files_of(mask)]
    answer_each(question.answer, paths, targets, used=used, json=json)


@dataclass(frozen=True)
class Question:
    """The matrix that is asked of each file, and the options of the solver and of the matrix."""

    sources: Path | None
    landmarks: int | None
    mask: MarkedVertices | None
    cost: Path | None
    weld: float | None
    workers: int
    of_solver: dict[str, Any]
    of_matrix: dict[str, Any]

    def answer(self, run: Run, path: Path, targets: Targets) -> Answer:
        """Compute and write the matrix of one file."""
        from geodesic_toolkit.analysis.matrix.matrix import distance_matrix
        from geodesic_toolkit.io import read_vertices
        from geodesic_toolkit.solver.solver import GeodesicSolver

        (output,) = targets.tables
        with run.step("reading"):
            kinds = kinds_of(self.of_solver["operator"])
            shape, masked = read_welded(path, self.weld, run, mask=self.mask, kinds=kinds)
            shape = shape.with_cost(self.cost)
            rows = None if self.sources is None else read_vertices(self.sources)
        with run.step("factorising"):
            solver = GeodesicSolver(shape.domain, mask=masked, **self.of_solver)
        if self.landmarks is not None:
            with run.step("choosing landmarks"):
                rows = shape.firsts(_landmarks(solver, self.landmarks, run))
        with run.step("computing"), _processes(self.workers) as executor, _resumable(output, run):
            matrix = distance_matrix(
                solver,
                _every(shape) if rows is None else shape.vertices(rows, masked),
                targets=shape.new,
                out=output,
                executor=executor,
                progress=run.advance,
                **self.of_matrix,
            )
        return _result(shape, solver, rows, matrix)


def _every(shape: Welded) -> Any:
    """Return all vertices of the file as sources, including masked ones."""
    from geodesic_toolkit.analysis.matrix.tasks import EveryVertex

    return None if shape.new is None else EveryVertex(shape.new)


def _landmarks(solver: "GeodesicSolver", count: int, run: Run) -> "IntArray":
    from geodesic_toolkit.analysis.sampling import farthest_point_sampling

    return farthest_point_sampling(solver, count, progress=run.advance)


@contextmanager
def _resumable(output: Path, run: Run) -> Iterator[None]:
    """Report where an interrupted run left its rows."""
    folder = output.with_name(f"{output.name}.partial")
    message = f"{folder} holds the rows so far; the same command resumes from there"
    try:
        with last_words(f"note: {message}"):
            yield
    except KeyboardInterrupt:
        if folder.exists():
            run.note(message)
        raise


# -- processes -------------------------------------------------------------------------------------


@contextmanager
def _processes(count: int) -> Iterator["Executor | None"]:
    """Yield a pool of processes, or None for this process alone; all end with the block."""
    if count == 1:
        yield None
        return
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor

    # Not by fork: in a copy of a process with threads a lock may stay locked for ever.
    pool = ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn"))
    try:
        with _children_that_ignore_interrupts():
            for _ in range(count):  # each starts a process
                pool.submit(int)
        yield pool
    except BaseException:  # above all Ctrl-C: end all processes, then re-raise
        with _quiet_about_cancelled_tasks():
            for process in multiprocessing.active_children():  # rather than wait for their tasks
                process.terminate()
            # The end of the program wakes the thread of the pool, and fails if that ends just then.
            # The thread waits for ever if a process was ended in the middle of a result, so the
            # wait is limited.
            closing = threading.Thread(
                target=pool.shutdown, kwargs={"cancel_futures": True}, daemon=True
            )
            closing.start()
            closing.join(SHUTDOWN_TIMEOUT)
        raise
    pool.shutdown()


@contextmanager
def _quiet_about_cancelled_tasks() -> Iterator[None]:
    """Suppress the error in the thread of a pool whose processes were ended.

    The thread marks all tasks as broken and fails at those that were cancelled before.
    """
    from concurrent.futures import InvalidStateError

    usual = threading.excepthook

    def report(failure: threading.ExceptHookArgs) -> None:
        if failure.exc_type is not InvalidStateError:
            usual(failure)

    threading.excepthook = report
    try:
        yield
    finally:
        threading.excepthook = usual


@contextmanager
def _children_that_ignore_interrupts() -> Iterator[None]:
    """Make processes started in the block ignore Ctrl-C from their first instruction on.

    In a terminal Ctrl-C reaches all processes; only this one must handle it.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    usual = signal.signal(signal.SIGINT, signal.SIG_IGN)  # a new process inherits it
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual)


# -- the result ------------------------------------------------------------------------------------


def _result(
    shape: Welded, solver: "GeodesicSolver", sources: "IntArray | None", matrix: Any
) -> Answer:
    method, (rows, columns) = solver.method, matrix.shape
    entries = int(getattr(matrix, "nnz", rows * columns))  # those that are stored
    content = {
        "domain": type(solver.domain).__name__,
        "n_vertices": shape.file.n_vertices,
        "n_merged": solver.domain.n_vertices,
        "sources": "all" if sources is None else sources,
        "shape": [rows, columns],
        "dtype": str(matrix.dtype),
        "entries": entries,
        "operator": repr(solver.operator),
        "solver": {"heat": repr(method.heat_solver), "poisson": repr(method.poisson_solver)},
        "refine": method.refine,
        "time": method.time,
    }
    of = f", {entries} entries" if hasattr(matrix, "nnz") else ""
    text = [
        ("sources", _named(sources)),
        ("method", method_in_words(solver)),
        ("matrix", f"{rows} x {columns}, {matrix.dtype}{of}"),
    ]
    return Answer(shape, content, text)


def _named(sources: "IntArray | None") -> str:
    if sources is None:
        return "every vertex"
    names = ", ".join(map(str, sources[:MAX_LISTED_SOURCES].tolist()))
    more = len(sources) - MAX_LISTED_SOURCES
    return f"vertices {names}" + (f" and {more} more (--json lists them)" if more > 0 else "")
