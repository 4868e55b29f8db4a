"""What runs in a worker: a solver that is unpickled and factorised once a process, and kept.

It lives in a module that a worker imports by its name. A cache in ``__main__`` would be a new one
with each task that arrives, and each task would factorise again.
"""

import os
import pickle
import threading
import uuid
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

from geodesic_toolkit.analysis.matrix.tasks import Rows, RowTask
from geodesic_toolkit.core.warning import warn
from geodesic_toolkit.errors import GeodesicWarning, InvalidOptionError
from geodesic_toolkit.heat.method import HeatMethod
from geodesic_toolkit.solver.solver import GeodesicSolver

__all__ = ["Answer", "Token", "at_home", "compute", "pickled"]


@dataclass(frozen=True)
class Token:
    """The name of a solver, by which workers know whether they have it.

    Parameters
    ----------
    name : str
        Unique in the world, and always the same for one solver and its copies in one process.
    home : int
        The process that the solver comes from.
    """

    name: str
    home: int


@dataclass(frozen=True, eq=False)
class Answer:
    """What a worker sends back.

    Parameters
    ----------
    rows : ndarray or csr_array, optional
        None where the worker does not have the solver and was not sent it.
    warnings : tuple of (str, type)
        What was warned of on the way, where nobody is there to see it.
    """

    rows: Rows | None
    warnings: tuple[tuple[str, type[Warning]], ...] = ()

    def repeat_warnings(self) -> None:
        """Warn here of what the worker was warned of."""
        for text, category in self.warnings:
            warn(text, category)


_tokens: WeakKeyDictionary[HeatMethod, Token] = WeakKeyDictionary()
"""By what copies of a solver share."""

_at_home: dict[str, GeodesicSolver] = {}
_visiting: tuple[str, GeodesicSolver] | None = None
_lock = threading.Lock()
_heard = threading.local()


@contextmanager
def at_home(solver: GeodesicSolver) -> Iterator[Token]:
    """Give the token of a solver; threads of this process find the solver itself by it."""
    token = _tokens.setdefault(solver.method, Token(uuid.uuid4().hex, os.getpid()))
    _at_home[token.name] = solver
    try:
        yield token
    finally:
        _at_home.pop(token.name, None)


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


def compute(token: Token, payload: bytes | None, task: RowTask) -> Answer:
    """Compute a task with the solver of that name; made from `payload` where it is not known."""
    solver = _known(token.name)
    if solver is None and payload is None:
        return Answer(None)
    with _listening(token) as heard:
        if solver is None:
            assert payload is not None  # for the type checker
            solver = _unpacked(token.name, payload)
        rows = task.compute(solver)
    return Answer(rows, tuple(dict.fromkeys(heard)))


def _known(name: str) -> GeodesicSolver | None:
    visiting = _visiting
    if visiting is not None and visiting[0] == name:
        return visiting[1]
    return _at_home.get(name)


def _unpacked(name: str, payload: bytes) -> GeodesicSolver:
    """Return the solver, factorised; the last one stays, as two might not fit into memory."""
    global _visiting  # noqa: PLW0603 - a cache for the life of the process is what this module is
    with _lock:  # of the threads of one worker, one factorises
        solver = _known(name)
        if solver is None:
            _visiting = None
            solver = pickle.loads(payload)  # noqa: S301 - our own, from the process we work for
            solver.method.prepare()
            _visiting = (name, solver)
        return solver


# -- warnings, which nobody would see there --------------------------------------------------------


@contextmanager
def _listening(token: Token) -> Iterator[list[tuple[str, type[Warning]]]]:
    """Collect this package's warnings of this thread; at home they go their usual way."""
    heard: list[tuple[str, type[Warning]]] = []
    if os.getpid() == token.home:
        yield heard
        return
    _listen()
    _heard.warnings = heard
    try:
        yield heard
    finally:
        _heard.warnings = None


def _listen() -> None:
    """Hand this package's warnings to the thread that collects them; once a process.

    `warnings.catch_warnings` would not do: it is not for workers of several threads.
    """
    with _lock:
        if not isinstance(warnings.showwarning, _Collector):
            warnings.showwarning = _Collector(warnings.showwarning)
            warnings.simplefilter("always", GeodesicWarning)


class _Collector:
    """Shows warnings as before, but for those of this package on threads that collect them."""

    def __init__(self, usual: Callable[..., None]) -> None:
        self._usual = usual

    def __call__(
        self, message: Warning | str, category: type[Warning], *rest: Any, **more: Any
    ) -> None:
        heard = getattr(_heard, "warnings", None)
        if heard is not None and issubclass(category, GeodesicWarning):
            heard.append((str(message), category))
        else:
            self._usual(message, category, *rest, **more)
