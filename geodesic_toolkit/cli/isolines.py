"""``geodesic-toolkit isolines``: lines of equal distance."""

from typing import Annotated

import typer

from geodesic_toolkit.cli.arguments import Input, Json, Mask, Refine, Weld, parse_sources
from geodesic_toolkit.cli.curves import CurveTargets, Lines, Page, Picture, as_mesh, solver_of
from geodesic_toolkit.cli.output import aligned, show, show_json, versions
from geodesic_toolkit.cli.run import running
from geodesic_toolkit.cli.welding import check_weld, welded

__all__ = ["isolines"]


def isolines(
    path: Input,
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
    from geodesic_toolkit.analysis.curves.isolines import isolines as lines_of
    from geodesic_toolkit.analysis.curves.measures import area_above, curve_length
    from geodesic_toolkit.io import read

    sources = parse_sources(source)
    check_weld(weld)
    targets = CurveTargets(tables=tuple(output or ()), picture=picture, html=html)
    targets.check(path)
    with running() as run:
        targets.load_graphics()
        with run.step("reading"):
            shape = welded(read(path), weld, run)
            mesh = as_mesh(shape.domain, "isolines")
            masked = shape.mask(None if mask is None else mask.mask(shape.file.n_vertices))
        with run.step("factorising"):
            solver = solver_of(mesh, masked, refine)
        with run.step("solving"):
            distances = solver.distance(shape.sources(sources, masked))
        with run.step("drawing lines"):
            curves = [(value, lines_of(mesh, distances, value)) for value in level]
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
            run.warn("no line is at these distances: nothing on the mesh is as far as that")
        targets.write(run, mesh, every, distances if targets.drawn else None, isolines=0)
    if json:
        show_json(
            {
                "input": str(path),
                "n_vertices": shape.file.n_vertices,
                "sources": sources,
                "levels": found,
                "timings": run.timings,
                "warnings": run.warnings,
                "outputs": [str(target) for target in targets.paths],
                "versions": versions(),
            }
        )
        return
    rows = [
        ("shape", repr(shape.file)),
        *shape.rows,
        *((f"at {one['level']:g}", _described(one)) for one in found),
        ("took", run.took),
        *(("wrote", str(target)) for target in targets.paths),
    ]
    show("\n".join(aligned(rows)))


def _described(one: dict[str, float]) -> str:
    return (
        f"{one['n_lines']} lines, {one['n_closed']} of them closed, length {one['length']:.6g}; "
        f"area within {one['area_within']:.6g}"
    )
