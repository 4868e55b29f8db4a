"""``geodesic-toolkit study``: the experiments of a first implementation, on a mesh of one's own."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from geodesic_toolkit.cli.arguments import Folder, Input, Json, Weld
from geodesic_toolkit.cli.output import aligned, show, show_json, versions
from geodesic_toolkit.cli.run import running
from geodesic_toolkit.cli.welding import welded
from geodesic_toolkit.errors import InvalidSourceError

__all__ = ["study"]


def study(
    path: Input,
    *,
    out: Folder = Path("geodesic-study"),
    sources: Annotated[
        list[str] | None,
        typer.Option(
            "--sources",
            "--source",
            metavar="VERTICES",
            help='Source vertices: "500,2000", or the option several times. Unless given, these '
            "two, or two far ends of a mesh that does not have them.",
            show_default=False,
        ),
    ] = None,
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="Seed of the noise.")] = 0,
    weld: Weld = None,
    json: Json = False,
) -> None:
    """Study the heat method on a mesh: solvers, time steps, noise, operators, sizes.

    Writes figures, tables and conclusions: study.html to read, study.md, study.json, PNG files.

    Example: geodesic-toolkit study bunny.off --out study
    """
    from geodesic_toolkit.io import read
    from geodesic_toolkit_study.run import run_study

    chosen = None if sources is None else _vertices(sources)
    with running() as run:
        with run.step("reading"):
            shape = welded(read(path), weld, run)
            mesh = shape.domain
            chosen = None if chosen is None else shape.vertices(chosen).tolist()
        figures = run_study(mesh, out, sources=chosen, name=path.stem, seed=seed, step=run.step)
    if json:
        more = {"warnings": run.warnings, "timings": run.timings, "versions": versions()}
        show_json({**figures, **more})
        return
    rows = [
        ("mesh", f"{path.name}, {mesh!r}"),
        *(("heat at t = h²", line) for line in _zeros(figures)),
        ("mean error", _errors(figures)),
        ("took", f"{run.timings['total']:.1f} s"),
        ("report", str(out / "study.html")),
        ("the same as text", str(out / "study.md")),
        ("all numbers", str(out / "study.json")),
        ("figures", f"{len(figures['figures'])} PNG files beside them"),
    ]
    for line in aligned(rows):
        show(line)


def _vertices(sources: list[str]) -> list[int]:
    words = [word.strip() for source in sources for word in source.split(",")]
    try:
        return [int(word) for word in words]
    except ValueError as error:
        raise InvalidSourceError(
            f'--sources {",".join(words)} is not a list of vertices such as "500,2000"'
        ) from error


def _zeros(figures: Mapping[str, Any]) -> list[str]:
    """Return a line a source: zeros by conjugate gradients, and by the direct solver."""
    rows = [row for row in figures["heat_zeros"] if row["time"] == "h^2"]
    lines = []
    for source in figures["sources"]:
        zeros = {row["solver"]: row["zeros"] for row in rows if row["source"] == source}
        lines.append(
            f"from vertex {source}: {zeros['cg']:,} of {figures['vertices']:,} values are 0 by "
            f"conjugate gradients, {zeros['superlu']:,} by the direct solver"
        )
    return lines


def _errors(figures: Mapping[str, Any]) -> str:
    """Return the mean error of each operator over the sources, that of the reference left out."""
    errors: dict[str, list[float]] = {}
    for row in figures["operators"]:
        if row["method"] == f"heat, {figures['reference'][str(row['source'])]}":
            continue
        errors.setdefault(row["method"], []).append(row["mean_error"])
    return ", ".join(f"{name} {sum(all_) / len(all_):.2f} %" for name, all_ in errors.items())
