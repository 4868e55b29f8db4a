"""Exit statuses, and the line on stderr that explains a failure."""

import os
import traceback
from typing import Any

import typer

from geodesic_toolkit import errors
from geodesic_toolkit.cli.output import one_line, say

__all__ = ["BAD_INPUT", "FAILED", "INTERRUPTED", "WRONG_USAGE", "exit_status", "kind_of", "report"]

WRONG_USAGE = 2
BAD_INPUT = 3
FAILED = 4
INTERRUPTED = 130

# Base class of all errors of the argument parser; reached through its public subclass, because
# releases of typer differ in its location.
UsageError: type[Any] = typer.BadParameter.__mro__[1]

EXIT_STATUS: tuple[tuple[type[BaseException], int], ...] = (
    (UsageError, WRONG_USAGE),
    (errors.InvalidSourceError, WRONG_USAGE),
    (errors.InvalidOptionError, WRONG_USAGE),
    (errors.PluginError, WRONG_USAGE),
    (errors.MissingDependencyError, WRONG_USAGE),
    (errors.WriteError, WRONG_USAGE),
    (errors.ReadError, BAD_INPUT),
    (errors.InvalidDomainError, BAD_INPUT),
    (errors.UnsupportedDomainError, BAD_INPUT),
    (errors.GeodesicError, FAILED),
    (MemoryError, FAILED),
    (KeyboardInterrupt, INTERRUPTED),
)
"""The first match counts; any other error is unexpected, and has the status `FAILED`."""

DEBUG_VARIABLE = "GEODESIC_TOOLKIT_DEBUG"


def exit_status(error: BaseException) -> int:
    """Return the exit status for an error of a command."""
    return next((status for kind, status in EXIT_STATUS if isinstance(error, kind)), FAILED)


def kind_of(error: BaseException) -> str:
    """Return the name of the class of an error: that of the package for an error of a plugin."""
    names = [one.__name__ for one in type(error).__mro__]
    return next((name for name in names if name in errors.__all__), names[0])


def report(error: BaseException, about: str = "") -> int:
    """Report an error on stderr, in three lines at most, and return the exit status.

    The lines begin with `about`.
    """
    if os.environ.get(DEBUG_VARIABLE) == "1":
        say("".join(traceback.format_exception(error)), error=True)
    for line in _lines(error):
        say(f"{about}{line}", error=True)
    return exit_status(error)


def _lines(error: BaseException) -> list[str]:
    if isinstance(error, KeyboardInterrupt):
        return ["interrupted"]
    if isinstance(error, UsageError):
        context = getattr(error, "ctx", None)
        command = context.command_path if context is not None else "geodesic-toolkit"
        message = one_line(error.format_message())
        return [f"error: {message}", f"see: {command} --help"]
    if isinstance(error, errors.GeodesicError):
        return [f"error: {one_line(error)} [{kind_of(error)}]"]
    if isinstance(error, MemoryError):
        return [f"error: not enough memory: {one_line(error) or 'the system has none left'}"]
    return [
        f"error: unexpected {type(error).__name__}: {one_line(error)}",
        f"This is a bug: please report it with the traceback that {DEBUG_VARIABLE}=1 shows.",
    ]
