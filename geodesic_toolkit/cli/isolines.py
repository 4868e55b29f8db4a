"""``geodesic-toolkit isolines``: lines of equal distance."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from geodesic_toolkit.cli.arguments import (
    Inputs,
    Json,
    MarkedVertices,
    Mask,
    Refine,
    Weld,
    files_of,
    parse_sources,
)
from geodesic_toolkit.cli.curves import Lines, Page, Picture, as_mesh, solver_of, write_lines
from geodesic_toolkit.cli.run import Run
from geodesic_toolkit.cli.several import Answer, answer_each
from geodesic_toolkit.cli.targets import Targets
from geodesic_toolkit.cli.welding import read_welded

__all__ = ["isolines"]


def isolines(
    paths: Inputs,
    *,
    source: Annotated[
        list[str],
        typer.Option(
            metavar="PLACE",
            help='A vertex index; a point "x,y,z" that is snapped to the shape; or a file of '
            "vertices. Give it several times for the distance from the nearest of them.",
            show_default=False,
        ),
    ],
    level: Annotated[
        list[float],
        typer.Option(
            metavar="D",
            help="A distance; may be given several times.",
            show_default=False,
        ),
    ],
    mask: Mask = None,
    weld: Weld = None,
    refine: Refine = None,
    output: Lines = None,
    picture: Picture = None,
    html: Page = None,
    json: Json = False,
) -> None:
    """Lines at given distances from the sources on the mesh INPUT, with length and area inside."""
    from geodesic_toolkit.io.curves import check_curve_output

    sources = parse_sources(source)
    answer_each(
        partial(_answer, sources=sources, levels=level, mask=mask, weld=weld, refine=refine),
        paths,
        Targets(
            tables=tuple(output or ()), check_table=check_curve_output, picture=picture, html=html
        ),
        used=files_of(mask, source),
        json=json,
    )


def _answer(
    run: Run,
    path: Path,
    targets: Targets,
    *,
    sources: list[int] | list[list[float]],
    levels: list[float],
    mask: MarkedVertices | None,
    weld: float | None,
    refine: bool | None,
) -> Answer:
    import numpy as np

    from geodesic_toolkit.analysis.curves.isolines import isolines as lines_of
    from geodesic_toolkit.analysis.curves.measures import area_above, curve_length

    with run.step("reading"):
        shape, masked = read_welded(path, weld, run, mask=mask)
        mesh = as_mesh(shape.domain, "isolines")
    with run.step("factorising"):
        solver = solver_of(mesh, masked, refine)
    with run.step("solving"):
        distances = solver.distance(shape.sources(sources, masked))
    with run.step("drawing lines"):
        curves = [(value, lines_of(mesh, distances, value)) for value in levels]
        found = [
            {
                "level": value,
                "n_lines": len(lines),
                "n_closed": sum(line.closed for line in lines),
                "length": sum(curve_length(mesh, line) for line in lines),
                "area_within": area_above(mesh, -distances, -value),
            }
            for value, lines in curves
        ]
    every = [line for _, lines in curves for line in lines]
    if not every:
        top = distances[np.isfinite(distances)].max()
        run.warn(f"no line is at these distances: those on the mesh go from 0 to {top:.6g}")
    write_lines(run, targets, mesh, every, distances if targets.drawn else None, isolines=0)
    content = {"n_vertices": shape.file.n_vertices, "sources": sources, "levels": found}
    return Answer(shape, content, [(f"at {one['level']:g}", _described(one)) for one in found])


def _described(one: dict[str, float]) -> str:
    return (
        f"{one['n_lines']} lines, {one['n_closed']} of them closed, length {one['length']:.6g}; "
        f"area within {one['area_within']:.6g}"
    )
