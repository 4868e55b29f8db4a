"""Run tasks on any `concurrent.futures.Executor`, whose workers receive the solver once."""

import os
import pickle
import threading
import uuid
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

from geodesic_toolkit.analysis.matrix.tasks import Rows, RowTask
from geodesic_toolkit.core.warning import Collected, collected_warnings, warn
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.errors import GeodesicWarning, InvalidOptionError, SolverError
from geodesic_toolkit.heat.method import HeatMethod
from geodesic_toolkit.solver.solver import GeodesicSolver

__all__ = ["Parcel", "check_executor", "compute", "computed", "pickled"]

WAITING_BYTES = 1e9
"""Bound of the results in transit in bytes: enough for many workers, and little memory."""


def check_executor(executor: object) -> None:
    """Raise an `InvalidOptionError` for what is not an executor."""
    if executor is not None and not isinstance(executor, Executor):
        raise InvalidOptionError(
            "executor must be a concurrent.futures.Executor (a process pool, loky's, "
            "dask's Client(...).get_executor(), mpi4py's), not "
            f"{a_kind_of(executor)}"
        )


def computed(
    solver: GeodesicSolver, tasks: Sequence[RowTask], executor: Executor | None
) -> Iterator[tuple[RowTask, Rows]]:
    """Yield each task with its rows, in order of completion.

    Parameters
    ----------
    solver : GeodesicSolver
    tasks : sequence of RowTask
    executor : Executor, optional
        Stays open. Submitted tasks that have not begun are cancelled if the caller stops early.

    Raises
    ------
    InvalidOptionError
        The solver cannot be pickled, but the executor's workers are other processes.
    SolverError
        A worker died.
    Exception
        Any exception of a task or of the executor.
    """
    if executor is None:
        for task in tasks:
            yield task, task.compute(solver)
        return
    under_way: dict[Future[tuple[Rows, Collected] | None], tuple[RowTask, bool]] = {}
    try:
        yield from _dispatched(solver, tasks, executor, under_way)
    except BrokenExecutor as error:
        raise SolverError(
            f"executor: a worker ended abruptly ({error}); it may have run out of memory: "
            "use fewer workers"
        ) from error
    finally:
        for future in under_way:
            future.cancel()


def _dispatched(
    solver: GeodesicSolver,
    tasks: Sequence[RowTask],
    executor: Executor,
    under_way: dict[Future[tuple[Rows, Collected] | None], tuple[RowTask, bool]],
) -> Iterator[tuple[RowTask, Rows]]:
    """Yield as `computed`; `under_way` maps each submitted task to whether it has the solver.

    A task is first submitted without the solver. A worker that lacks the solver refuses at once,
    and the task is resubmitted with the solver attached. Few tasks carry it at a time, and one more
    with each that is done: copies do not fill the queue, and many workers soon have the solver.
    """
    name = _names.setdefault(solver.method, uuid.uuid4().hex)
    without, with_solver = Parcel(name, solver), None
    waiting, refused = deque(tasks), deque[RowTask]()
    largest = max((task.stop - task.start for task in tasks), default=1)
    fitting = int(WAITING_BYTES / (8 * solver.domain.n_vertices * largest))
    most, most_with_solver = max(2 * (os.cpu_count() or 1), fitting), 2
    while waiting or refused or under_way:
        while refused and sum(sent for _, sent in under_way.values()) < most_with_solver:
            with_solver = with_solver or Parcel(name, solver, pickled(solver))
            task = refused.popleft()
            under_way[executor.submit(compute, with_solver, task)] = task, True
        # Refused tasks count: else all tasks would be refused while the first ones compute.
        while waiting and len(under_way) + len(refused) < most:
            task = waiting.popleft()
            under_way[executor.submit(compute, without, task)] = task, False
        done, _ = wait(under_way, return_when=FIRST_COMPLETED)
        # Refused tasks first: a worker that has computed one already has the solver.
        for future in sorted(done, key=lambda future: under_way[future][1]):
            task, sent = under_way.pop(future)
            answer = future.result()
            if answer is None:
                refused.append(task)
                continue
            if sent:
                most_with_solver += 1
                waiting.extendleft(reversed(refused))
                refused.clear()
            rows, collected = answer
            for text, category in collected:
                warn(text, category)
            yield task, rows


# -- sent to a worker, and kept there --------------------------------------------------------------

_names: WeakKeyDictionary[HeatMethod, str] = WeakKeyDictionary()
"""Globally unique names of solvers, by an object that copies of a solver share."""

_kept: tuple[str, GeodesicSolver] | None = None
"""The last solver of a worker; only one, as two may not fit into memory.

Workers import this module by name; in ``__main__`` each task would have a cache of its own.
"""

_lock = threading.Lock()


@dataclass(frozen=True, eq=False)
class Parcel:
    """The name of a solver; within this process the solver, too.

    Parameters
    ----------
    name : str
    solver : GeodesicSolver, optional
        Not pickled with the parcel.
    content : bytes, optional
        The pickled solver.
    """

    name: str
    solver: GeodesicSolver | None = None
    content: bytes | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return Parcel, (self.name, None, self.content)

    def opened(self) -> GeodesicSolver | None:
        """Return the solver, factorised; None if it is neither cached nor in the parcel."""
        global _kept  # noqa: PLW0603 - a cache for the life of the process
        if self.solver is not None:
            return self.solver
        kept = _kept
        if kept is not None and kept[0] == self.name:
            return kept[1]
        if self.content is None:
            return None
        with _lock:  # only one thread of a worker factorises
            if _kept is None or _kept[0] != self.name:
                _kept = None
                solver = pickle.loads(self.content)  # noqa: S301 - pickled by this package
                solver.method.prepare()
                _kept = self.name, solver
            return _kept[1]


def pickled(solver: GeodesicSolver) -> bytes:
    """Return a solver as bytes for a worker.

    Raises
    ------
    InvalidOptionError
        It holds an object that cannot be pickled.
    """
    try:
        return pickle.dumps(solver, protocol=pickle.HIGHEST_PROTOCOL)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise InvalidOptionError(
            f"executor: the solver cannot be sent to other processes: {error}; define its operator "
            "in a module, or use a thread pool"
        ) from error


def compute(parcel: Parcel, task: RowTask) -> tuple[Rows, Collected] | None:
    """Compute a task; return its rows and warnings, or None where the solver is missing."""
    with collected_warnings(GeodesicWarning) as collected:
        solver = parcel.opened()
        if solver is None:
            return None
        rows = task.compute(solver)
    return rows, list(dict.fromkeys(collected))
