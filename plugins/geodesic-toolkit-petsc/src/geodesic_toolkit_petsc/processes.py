"""The processes of a job: process 0 leads, and the others help with its linear systems.

Process 0 alone runs the program: it has the shape, and reads, prints and writes. The others wait
for its requests. Each request is an operation that all processes run together on their parts of a
system. So threads, warnings, errors and the end of the program are those of one process, and no
other process can differ from it.
"""

from __future__ import annotations

import atexit
import resource
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from geodesic_toolkit.errors import NotEnoughMemoryError, SolverError
from geodesic_toolkit_petsc.library import Library, library

__all__ = ["Operation", "Processes", "peak_memory", "processes"]

SHORTEST_NAP, LONGEST_NAP = 1e-5, 5e-3
"""Seconds between two looks for a request. MPI's own waiting would take a processor."""

PATIENCE = 30.0
"""Seconds that a failed process waits for the others to end the operation, before it ends the job:
they may wait for it in turn. A failure of PETSc itself reaches all within milliseconds."""

Parts = dict[int, Any]
"""The parts of the systems on one process, by the number of the system."""

Operation = Callable[..., Any]
"""Function of the library, the parts of this process, and the arguments of a request.

All processes call it. With ``data=``, process 0 has what the others get from it. It is a generator
that yields once, between what each process does alone (allocating) and what all do together.
"""


@dataclass(frozen=True)
class _Request:
    """A request of process 0; without an operation, the last one."""

    operation: Operation | None = None
    arguments: dict[str, Any] = field(default_factory=dict)
    released: tuple[int, ...] = ()


class Processes:
    """The processes of this job, as one of them sees them.

    Parameters
    ----------
    loaded : Library
    """

    def __init__(self, loaded: Library) -> None:
        self._library, self._communicator = loaded, loaded.communicator
        self._rank: int = self._communicator.Get_rank()
        self.count: int = self._communicator.Get_size()
        self._parts: Parts = {}
        self._released: list[int] = []
        self._systems = 0
        self._lock = threading.Lock()
        self._state = "open"
        if self._rank == 0:
            atexit.register(self._dismiss)

    # -- process 0 -----------------------------------------------------------------------------

    def new_system(self) -> int:
        """Return the number of a new system."""
        with self._lock:
            self._systems += 1
            return self._systems

    def release(self, system: int) -> None:
        """Release a system with the next request; may be called at any time, as destructors are."""
        self._released.append(system)

    def run(self, operation: Operation, *, data: Any = None, **arguments: Any) -> Any:
        """Run an operation on all processes, and return its result on process 0.

        Raises
        ------
        NotEnoughMemoryError
            A process has run out of memory.
        SolverError
            The operation failed on any process.
        """
        with self._lock:
            if self._state != "open":
                raise SolverError(
                    f"the processes of this job are {self._state}: start the program again"
                )
            released = tuple(self._released)
            del self._released[: len(released)]
            request = _Request(operation, arguments, released)
            self._state = "broken by an interrupt"  # unless the operation ends
            self._send(request)
            result, failures = self._perform(request, data)
            self._state = "open"
        _raise_first(failures, self.count)
        return result

    def _send(self, request: _Request) -> None:
        for rank in range(1, self.count):
            self._communicator.send(request, dest=rank)

    def _dismiss(self) -> None:
        """Let the other processes end, at the end of the program."""
        if self._state == "open":
            self._send(_Request())
            self._state = "dismissed"
            self._parts.clear()
        elif self.count > 1:
            self._communicator.Abort(1)

    # -- the others ----------------------------------------------------------------------------

    def lead(self) -> bool:
        """Return True on process 0. On others, help until it ends, and return False."""
        while self._rank > 0 and self._state == "open":
            request = self._receive()
            if request.operation is None:
                self._state = "dismissed"
                self._parts.clear()
            else:
                self._perform(request, None)
        return self._rank == 0

    def _receive(self) -> _Request:
        nap = SHORTEST_NAP
        while not self._communicator.iprobe(source=0):
            time.sleep(nap)
            nap = min(2 * nap, LONGEST_NAP)
        request: _Request = self._communicator.recv(source=0)
        return request

    # -- all -----------------------------------------------------------------------------------

    def _perform(self, request: _Request, data: Any) -> tuple[Any, list[str | None]]:
        """Run an operation as all do, and return its result and the failure of each process.

        A failure before the operation yields ends it on all processes, so that none waits.
        """
        for system in request.released:
            self._parts.pop(system, None)
        assert request.operation is not None
        steps = request.operation(self._library, self._parts, data=data, **request.arguments)
        result = None
        for _ in range(2):
            failure = None
            try:
                next(steps)
            except StopIteration as end:
                result = end.value
            except Exception as error:  # noqa: BLE001 - process 0 raises it, with its type
                failure = f"{type(error).__name__}: {error}"
            failures = self._agree(failure)
            if any(failures):
                steps.close()
                break
        return result, failures

    def _agree(self, failure: str | None) -> list[str | None]:
        """Return the failures of all processes; end the job if they do not come here."""
        arrived, given_up = self._communicator.Ibarrier(), time.monotonic() + PATIENCE
        if failure is None:
            arrived.Wait()
        while not arrived.Test():
            if time.monotonic() > given_up:
                sys.stderr.write(f"error: process {self._rank} of {self.count}: {failure}\n")
                sys.stderr.flush()
                self._communicator.Abort(4)
            time.sleep(SHORTEST_NAP)
        everyone: list[str | None] = self._communicator.allgather(failure)
        return everyone


def _raise_first(failures: list[str | None], count: int) -> None:
    """Raise what went wrong, with the number of the process if not all say the same."""
    found = [(rank, failure) for rank, failure in enumerate(failures) if failure is not None]
    if not found:
        return
    rank, failure = found[0]
    kind, _, text = failure.partition(": ")
    where = "" if len(set(failures)) == 1 else f"process {rank} of {count}: "
    if kind in {"MemoryError", "NotEnoughMemoryError", "_ArrayMemoryError"}:
        raise NotEnoughMemoryError(f"{where}{text or 'not enough memory'}")
    raise SolverError(where + (text if kind == "SolverError" else failure))


@cache
def processes() -> Processes:
    """Return the processes of this job.

    Raises
    ------
    MissingDependencyError
        PETSc is not installed.
    SolverError
        The processes do not find each other.
    """
    return Processes(library())


def peak_memory() -> list[int]:
    """Return the largest memory that each process had so far, in bytes.

    Returns
    -------
    list of int
        One for each process; process 0 has the shape as well.
    """
    measured: list[int] = processes().run(_peak_memory)
    return measured


def _peak_memory(loaded: Library, parts: Parts, *, data: None) -> Any:  # noqa: ARG001
    yield
    unit = 1 if sys.platform == "darwin" else 1024
    peak = unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return loaded.communicator.gather(peak)
