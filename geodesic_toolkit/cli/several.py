"""Several inputs of a command: each has a result or an error, and all are tried."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Protocol

import typer

from geodesic_toolkit.cli.exits import exit_status, kind_of, report
from geodesic_toolkit.cli.output import aligned, one_line, say, show, show_json
from geodesic_toolkit.errors import GeodesicError

__all__ = ["answer_each"]


class Result(Protocol):
    """The result of one input, as text and as JSON."""

    def as_dict(self) -> dict[str, Any]:
        """Return everything, for JSON."""
        ...


def answer_each(paths: Sequence[Path], answer: Callable[[Path], Result], *, json: bool) -> None:
    """Print the result of one input, or those of several with a table of their statuses.

    Parameters
    ----------
    paths : sequence of Path
    answer : callable
        Takes a path and returns its result.
    json : bool
        Print one object: of several inputs, with a list of ``results``.

    Raises
    ------
    GeodesicError
        The only input fails.
    typer.Exit
        One of several inputs fails: with the highest of their statuses.
    """
    if len(paths) == 1:
        result = answer(paths[0])
        if json:
            show_json(result.as_dict())
        else:
            show(str(result))
        return
    statuses, results, failures = [], [], []
    for path in paths:
        try:
            result = answer(path)
        except (GeodesicError, MemoryError) as error:
            statuses.append(exit_status(error))
            say(f"{path}:", error=True)
            report(error)
            failures.append(one_line(error))
            failure = {"kind": kind_of(error), "message": failures[-1]}
            results.append({"input": str(path), "status": statuses[-1], "error": failure})
        else:
            statuses.append(0)
            failures.append("")
            results.append({**result.as_dict(), "status": 0, "error": None})
            if not json:
                show(f"{result}\n")
    if json:
        show_json({"results": results})
    else:
        rows = [("INPUT", "STATUS", "")]
        for path, status, messages in zip(paths, statuses, failures, strict=True):
            rows.append((str(path), "failed" if status else "done", messages))
        for line in aligned(rows):
            show(line)
    if any(statuses):
        raise typer.Exit(max(statuses))
