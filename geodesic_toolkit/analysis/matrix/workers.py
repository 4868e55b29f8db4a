"""Tasks through any `concurrent.futures.Executor`, whose workers get the solver once."""

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
from geodesic_toolkit.errors import GeodesicWarning, InvalidOptionError, SolverError
from geodesic_toolkit.heat.method import HeatMethod
from geodesic_toolkit.solver.solver import GeodesicSolver

__all__ = ["Parcel", "check_executor", "compute", "computed", "pickled"]

WAITING_BYTES = 1e9
"""Of results that may be on their way at once: many workers are busy, and memory is not filled."""


def check_executor(executor: object) -> None:
    """Raise an `InvalidOptionError` for what is not an executor."""
    if executor is not None and not isinstance(executor, Executor):
        raise InvalidOptionError(
            "executor must be a concurrent.futures.Executor (a process pool, loky's, "
            "dask's Client(...).get_executor(), mpi4py's), not a "
            f"{type(executor).__name__}"
        )


def computed(
    solver: GeodesicSolver, tasks: Sequence[RowTask], executor: Executor | None
) -> Iterator[tuple[RowTask, Rows]]:
    """Yield each task with its rows, as they come.

    Parameters
    ----------
    solver : GeodesicSolver
    tasks : sequence of RowTask
    executor : Executor, optional
        Stays open. What was submitted and has not begun is cancelled where the caller stops early.

    Raises
    ------
    InvalidOptionError
        The solver cannot be pickled, and the executor's workers are other processes.
    SolverError
        A worker died.
    Exception
        What a task or the executor raises.
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
            f"executor: a worker ended abruptly ({error}); its memory may have been too small "
            "for the solver: use fewer of them"
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
    """Yield as `computed`; `under_way` holds each task that is out, and whether with the solver.

    A task goes out without the solver. A worker that lacks it refuses at once, and the task goes
    out again with it. Few go so at a time, and one more with each that is done: the queue does not
    fill with copies, many workers are soon served, and the rest ask again.
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
        # Those refused count: else all tasks would ask in vain while the first ones compute.
        while waiting and len(under_way) + len(refused) < most:
            task = waiting.popleft()
            under_way[executor.submit(compute, without, task)] = task, False
        done, _ = wait(under_way, return_when=FIRST_COMPLETED)
        # Refused ones first: a worker that has computed with the solver has it for them, too.
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


# -- what travels to a worker, and stays there -----------------------------------------------------

_names: WeakKeyDictionary[HeatMethod, str] = WeakKeyDictionary()
"""Names unique in the world, by what copies of a solver share."""

_kept: tuple[str, GeodesicSolver] | None = None
"""In a worker: the last solver, as two might not fit into memory.

Workers import this module by its name; in ``__main__`` each task would find another cache.
"""

_lock = threading.Lock()


@dataclass(frozen=True, eq=False)
class Parcel:
    """The name of a solver; for threads of this process the solver, too.

    Parameters
    ----------
    name : str
    solver : GeodesicSolver, optional
        Is left behind where the parcel is pickled.
    content : bytes, optional
        What another process makes the solver from.
    """

    name: str
    solver: GeodesicSolver | None = None
    content: bytes | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return Parcel, (self.name, None, self.content)

    def opened(self) -> GeodesicSolver | None:
        """Return the solver, factorised; None where it is neither here nor in the parcel."""
        global _kept  # noqa: PLW0603 - a cache for the life of the process
        if self.solver is not None:
            return self.solver
        kept = _kept
        if kept is not None and kept[0] == self.name:
            return kept[1]
        if self.content is None:
            return None
        with _lock:  # of the threads of one worker, one factorises
            if _kept is None or _kept[0] != self.name:
                _kept = None
                solver = pickle.loads(self.content)  # noqa: S301 - our own
                solver.method.prepare()
                _kept = self.name, solver
            return _kept[1]


def pickled(solver: GeodesicSolver) -> bytes:
    """Return what a worker makes the solver from.

    Raises
    ------
    InvalidOptionError
        It holds something that cannot be pickled.
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
