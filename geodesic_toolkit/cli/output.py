"""Text for people and JSON for programs: results on stdout, all else on stderr."""

import json
import math
import os
import platform
import sys
import threading
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from importlib import metadata
from typing import Any

import typer

from geodesic_toolkit import __version__
from geodesic_toolkit.errors import WriteError

__all__ = [
    "SCHEMA_VERSION",
    "aligned",
    "is_quiet",
    "one_line",
    "plain",
    "quiet",
    "renamed",
    "say",
    "show",
    "show_json",
    "to_stdout",
    "versions",
]

SCHEMA_VERSION = 1
"""Version of the objects of ``--json``; raised if a key is removed or changes its meaning."""

MAX_LENGTH_OF_MESSAGE = 600
"""Number of characters of a message shown: a third party's may hold a whole log."""


_silenced = {"results": threading.Event(), "remarks": threading.Event()}
_names: dict[str, str] = {}


@contextmanager
def quiet(*, results: bool = False, remarks: bool = False) -> Iterator[None]:
    """Print no results, or no remarks: progress, notes and warnings, also of other threads."""
    wanted = {"results": results, "remarks": remarks}
    events = [event for kind, event in _silenced.items() if wanted[kind] and not event.is_set()]
    for event in events:
        event.set()
    try:
        yield
    finally:
        for event in events:
            event.clear()


def is_quiet() -> bool:
    """Return True if remarks are not printed."""
    return _silenced["remarks"].is_set()


@contextmanager
def renamed(names: Mapping[str, str]) -> Iterator[None]:
    """Show files by other names: those of the streams that they stand for."""
    _names.update(names)
    yield
    for name in names:  # after an error they stay, for the line that reports it
        del _names[name]


def _by_names(text: str) -> str:
    for file, name in _names.items():
        text = text.replace(file, name)
    return text


@contextmanager
def to_stdout() -> Iterator[None]:
    """Write to standard output; a reader that has left is not an error, and gets no more.

    Raises
    ------
    WriteError
        Standard output cannot be written.
    """
    try:
        yield
    except OSError as error:
        # Python flushes standard output once more when it ends, which would fail, too.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            raise WriteError(f"standard output cannot be written: {error.strerror}") from error


def show(text: str) -> None:
    """Print a result."""
    if not _silenced["results"].is_set():
        with to_stdout():
            typer.echo(_by_names(text))


def say(text: str, *, error: bool = False) -> None:
    """Print a text that is not a result: a warning or a note; or an error, which is never quiet."""
    if error or not is_quiet():
        with suppress(OSError):  # there is no other place to report that stderr is full
            typer.echo(_by_names(text), err=True)


def show_json(content: Mapping[str, Any]) -> None:
    """Print one JSON object, with the version of its schema first."""
    content = plain({"schema_version": SCHEMA_VERSION, **content})
    show(json.dumps(content, indent=2, allow_nan=False))


def one_line(message: object) -> str:
    """Return a message on one line, truncated to `MAX_LENGTH_OF_MESSAGE`."""
    text = " ".join(str(message).split())
    return text if len(text) <= MAX_LENGTH_OF_MESSAGE else text[: MAX_LENGTH_OF_MESSAGE - 1] + "…"


def aligned(rows: Iterable[Sequence[str]]) -> list[str]:
    """Return rows of cells as lines with the columns aligned, two spaces between them."""
    table = [list(row) for row in rows]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in table
    ]


def versions() -> dict[str, str]:
    """Return the versions on which a result depends."""
    return {
        "geodesic-toolkit": __version__,
        "python": platform.python_version(),
        "numpy": metadata.version("numpy"),
        "scipy": metadata.version("scipy"),
    }


def plain(value: Any) -> Any:
    """Return `value` as a JSON type: NumPy's types as Python's, without NaN and infinity."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):  # NumPy's arrays and scalars
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if value is None or isinstance(value, int | float | bool):
        return value
    return _by_names(str(value))
