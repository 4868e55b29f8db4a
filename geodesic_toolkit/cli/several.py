"""The results of a command: of one input, or of several, each with a status."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import typer

from geodesic_toolkit.cli.exits import kind_of, report
from geodesic_toolkit.cli.output import aligned, one_line, show, show_json, versions
from geodesic_toolkit.cli.run import Run, running
from geodesic_toolkit.cli.targets import Targets
from geodesic_toolkit.cli.welding import Welded

__all__ = ["Answer", "answer_each"]


@dataclass(frozen=True)
class Answer:
    """The result of one input.

    Parameters
    ----------
    shape : Welded
    content : dict
        Further keys of JSON, besides those of all commands.
    rows : sequence of (str, str), optional
        Names and values for the text, between the shape and the steps; none of these if omitted.
    lines : sequence of str
        Lines of text above the rows.
    """

    shape: Welded
    content: dict[str, Any]
    rows: Sequence[tuple[str, str]] | None = None
    lines: Sequence[str] = ()


def answer_each(
    answer: Callable[[Run, Path, Targets], Answer],
    paths: Sequence[Path],
    targets: Targets,
    *,
    used: Iterable[Path | None] = (),
    json: bool,
) -> None:
    """Print the result of one input, or those of several with a table of their statuses.

    Parameters
    ----------
    answer : callable
        Takes the run, the path and the output files of an input, and returns its result.
    paths : sequence of Path
        The inputs.
    targets : Targets
        The output files, with ``{name}`` for the name of each input.
    used : iterable of Path or None
        Other files that no output may overwrite.
    json : bool
        Print one object: of several inputs, with a list of ``results``.

    Raises
    ------
    GeodesicError
        An output cannot be written, or the only input fails.
    typer.Exit
        One of several inputs fails: with the highest of their statuses.
    """
    each = targets.of_each(paths, *(file for file in used if file is not None))
    if len(paths) == 1:
        content, lines = _answered(answer, paths[0], each[paths[0]])
        if json:
            show_json(content)
        else:
            show("\n".join(lines))
        return
    results: list[dict[str, Any]] = []
    for path, own in each.items():
        about = f"{one_line(path)}: "
        try:
            content, lines = _answered(answer, path, own, about)
        except Exception as error:  # noqa: BLE001 - reported, and the rest are tried
            failure = {"kind": kind_of(error), "message": one_line(error)}
            results.append({"input": str(path), "status": report(error, about), "error": failure})
        else:
            results.append({**content, "status": 0, "error": None})
            if not json:
                show("\n".join([about.rstrip(), *lines, ""]))
    if json:
        show_json({"results": results})
    else:
        _show_table(results)
    if status := max(result["status"] for result in results):
        raise typer.Exit(status)


def _answered(
    answer: Callable[[Run, Path, Targets], Answer], path: Path, targets: Targets, about: str = ""
) -> tuple[dict[str, Any], list[str]]:
    """Return the result of an input as JSON and as lines of text."""
    with running(about) as run:
        if targets.drawn:
            with run.step("loading graphics"):
                targets.load_graphics()
        found = answer(run, path, targets)
    content = {
        "input": str(path),
        **found.content,
        "timings": run.timings,
        "warnings": run.warnings,
        "outputs": [str(target) for target in targets.paths],
        "versions": versions(),
    }
    if found.rows is None:
        return content, [*found.lines]
    rows = [
        *found.shape.rows,
        *found.rows,
        ("took", run.took),
        *(("wrote", str(target)) for target in targets.paths),
    ]
    return content, [*found.lines, *aligned(rows)]


def _show_table(results: Sequence[dict[str, Any]]) -> None:
    rows = [("INPUT", "STATUS", "")]
    for result in results:
        status, error = ("failed" if result["status"] else "done"), result["error"]
        rows.append((one_line(result["input"]), status, error["message"] if error else ""))
    for line in aligned(rows):
        show(line)
