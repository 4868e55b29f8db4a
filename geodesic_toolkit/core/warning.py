"""Warnings that point at the caller's line, regardless of where in the package they arise."""

import inspect
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeAlias

__all__ = ["Collected", "collected_warnings", "warn"]

PACKAGE = __name__.partition(".")[0] + "."

Collected: TypeAlias = list[tuple[str, type[Warning]]]
"""Texts and categories of warnings, in order."""

_collectors: ContextVar[tuple[tuple[type[Warning], Collected], ...]] = ContextVar(
    "collectors", default=()
)


def warn(text: str, category: type[Warning]) -> None:
    """Issue a warning at the line outside this package that caused it."""
    for kind, collected in reversed(_collectors.get()):
        if issubclass(category, kind):
            collected.append((text, category))
            return
    level, frame = 1, inspect.currentframe()
    while frame is not None and frame.f_globals.get("__name__", "").startswith(PACKAGE):
        level, frame = level + 1, frame.f_back
    warnings.warn(text, category, stacklevel=level)


@contextmanager
def collected_warnings(kind: type[Warning]) -> Iterator[Collected]:
    """Collect this package's warnings of a kind in this thread, instead of issuing them.

    `warnings.catch_warnings` would affect the whole process, including other threads.

    Examples
    --------
    >>> from geodesic_toolkit.core.warning import collected_warnings, warn
    >>> with collected_warnings(UserWarning) as collected:
    ...     warn("the mesh is coarse", UserWarning)
    >>> collected
    [('the mesh is coarse', <class 'UserWarning'>)]
    """
    collected: Collected = []
    token = _collectors.set((*_collectors.get(), (kind, collected)))
    try:
        yield collected
    finally:
        _collectors.reset(token)
