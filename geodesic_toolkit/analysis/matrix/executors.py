"""Tasks through any `concurrent.futures.Executor`, or without one: one code path."""

import os
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait

from geodesic_toolkit.analysis.matrix import workers
from geodesic_toolkit.analysis.matrix.tasks import Rows, RowTask
from geodesic_toolkit.errors import InvalidOptionError, SolverError
from geodesic_toolkit.solver.solver import GeodesicSolver

__all__ = ["check_executor", "computed"]

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
    with workers.at_home(solver) as token:
        yield from _Dispatch(solver, token, tasks, executor).results()


class _Dispatch:
    """Tasks on their way to workers, and the solver to those that lack it.

    A task goes out without the solver. A worker that has none under the token says so at once, and
    the task goes out again with the solver in its luggage: it travels about once a worker, and not
    with every task. Few such tasks are under way at a time, and one more with each that is done, so
    that a queue never fills with copies and many workers are soon served. Those that would be too
    many wait until one is done, and ask again.
    """

    def __init__(
        self,
        solver: GeodesicSolver,
        token: workers.Token,
        tasks: Sequence[RowTask],
        executor: Executor,
    ) -> None:
        self._solver, self._token, self._executor = solver, token, executor
        self._pending = deque(tasks)
        self._turned_back: deque[RowTask] = deque()
        self._under_way: dict[Future[workers.Answer], tuple[RowTask, bool]] = {}
        self._payload: bytes | None = None
        self._sending = 0
        processors = os.cpu_count() or 1
        largest = max((task.stop - task.start for task in tasks), default=1)
        row_bytes = 8 * solver.domain.n_vertices
        self._most = max(2 * processors, int(WAITING_BYTES / (largest * row_bytes)))
        self._most_sending = 2

    def results(self) -> Iterator[tuple[RowTask, Rows]]:
        """Yield tasks with their rows until all are done."""
        try:
            self._send_out()
            while self._under_way:
                done, _ = wait(self._under_way, return_when=FIRST_COMPLETED)
                # Tasks that came back for want of a solver first: a worker that has computed with
                # one has it for them, too, and they need not take it along.
                for future in sorted(done, key=lambda future: self._under_way[future][1]):
                    yield from self._received(future)
                self._send_out()
        except BrokenExecutor as error:
            raise SolverError(
                f"executor: a worker ended abruptly ({error}); its memory may have been too small "
                "for the solver: use fewer of them"
            ) from error
        finally:
            for future in self._under_way:
                future.cancel()

    def _received(self, future: "Future[workers.Answer]") -> Iterator[tuple[RowTask, Rows]]:
        task, with_solver = self._under_way.pop(future)
        self._sending -= with_solver
        answer = future.result()
        if answer.rows is None:
            self._turned_back.append(task)
            return
        if with_solver:
            self._most_sending += 1
            self._pending.extendleft(reversed(self._turned_back))
            self._turned_back.clear()
        answer.repeat_warnings()
        yield task, answer.rows

    def _send_out(self) -> None:
        while self._turned_back and self._sending < self._most_sending:
            self._submit(self._turned_back.popleft(), with_solver=True)
        # Those turned back count: else all tasks would come to ask in vain while the first compute.
        while self._pending and len(self._under_way) + len(self._turned_back) < self._most:
            self._submit(self._pending.popleft(), with_solver=False)

    def _submit(self, task: RowTask, *, with_solver: bool) -> None:
        if with_solver and self._payload is None:
            self._payload = workers.pickled(self._solver)
        payload = self._payload if with_solver else None
        future = self._executor.submit(workers.compute, self._token, payload, task)
        self._under_way[future] = (task, with_solver)
        self._sending += with_solver
