"""Deprecated names, which still work and warn with their replacement."""

import functools
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from geodesic_toolkit.core.warning import warn

__all__ = ["deprecated_alias", "warn_deprecated"]

P = ParamSpec("P")
R = TypeVar("R")


def warn_deprecated(old: str, new: str, *, since: str) -> None:
    """Warn, at the caller's line outside this package, that a name has been replaced.

    Call it, too, if an argument is given under its old name.

    Parameters
    ----------
    old, new : str
        The deprecated name and its replacement, as users write them.
    since : str
        The version that deprecates it. ``docs/maintaining/releasing.md`` states how long it stays.
    """
    warn(f"{old} is deprecated since version {since}; use {new}", DeprecationWarning)


def deprecated_alias(function: Callable[P, R], old: str, new: str, *, since: str) -> Callable[P, R]:
    """Return a function under its older name, which warns when called.

    Parameters
    ----------
    function : callable
        The function under its current name.
    old, new, since : str
        As for :func:`warn_deprecated`.

    Returns
    -------
    callable
        With the same signature and the same results.
    """

    @functools.wraps(function)
    def alias(*args: P.args, **options: P.kwargs) -> R:
        warn_deprecated(old, new, since=since)
        return function(*args, **options)

    alias.__name__ = alias.__qualname__ = old.rpartition(".")[2]
    alias.__doc__ = f"Deprecated since version {since}: the older name of {new}."
    return alias
