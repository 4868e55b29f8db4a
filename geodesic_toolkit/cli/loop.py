"""``geodesic-toolkit loop``: a closed geodesic."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from geodesic_toolkit.cli.arguments import Inputs, Json, MarkedVertices, Mask, Weld, files_of
from geodesic_toolkit.cli.curves import (
    Lines,
    Page,
    Picture,
    as_mesh,
    parse_waypoints,
    solver_of,
    write_lines,
)
from geodesic_toolkit.cli.run import Run
from geodesic_toolkit.cli.several import Answer, answer_each
from geodesic_toolkit.cli.targets import Targets
from geodesic_toolkit.cli.welding import read_welded

__all__ = ["loop"]


def loop(
    paths: Inputs,
    *,
    through: Annotated[
        list[str],
        typer.Option(
            metavar="PLACES",
            help='Vertex indices "500,620,710"; a point "x,y,z", of which one number has a decimal '
            "point, that is snapped to the shape; or a file of vertices. Give it several times for "
            "several points, in order; three places or more.",
            show_default=False,
        ),
    ],
    keep: Annotated[
        bool, typer.Option("--keep", help="Keep the places on the loop, which may have corners.")
    ] = False,
    min_length: Annotated[
        float, typer.Option(metavar="LENGTH", help="A shorter loop counts as contracted.")
    ] = 0.0,
    mask: Mask = None,
    weld: Weld = None,
    output: Lines = None,
    picture: Picture = None,
    html: Page = None,
    json: Json = False,
) -> None:
    """Closed geodesic on the mesh INPUT that a loop through places is pulled to."""
    from geodesic_toolkit.io.curves import check_curve_output

    places = parse_waypoints(through, "--through")
    answer_each(
        partial(_answer, places=places, keep=keep, min_length=min_length, mask=mask, weld=weld),
        paths,
        Targets(
            tables=tuple(output or ()), check_table=check_curve_output, picture=picture, html=html
        ),
        used=files_of(mask, through),
        json=json,
    )


def _answer(
    run: Run,
    path: Path,
    targets: Targets,
    *,
    places: list[int] | list[list[float]],
    keep: bool,
    min_length: float,
    mask: MarkedVertices | None,
    weld: float | None,
) -> Answer:
    from geodesic_toolkit.analysis.paths.loops import geodesic_loop

    with run.step("reading"):
        shape, masked = read_welded(path, weld, run, mask=mask)
        mesh = as_mesh(shape.domain, "loops")
    with run.step("factorising"):
        solver = solver_of(mesh, masked)
    with run.step("pulling"):
        found = geodesic_loop(
            solver, shape.sources(places, masked), through=keep, min_length=min_length
        )
    values = None
    if targets.drawn:
        with run.step("solving"):
            values = solver.distance(found.curve)
    write_lines(run, targets, mesh, [found], values, sources=[])
    content = {
        "n_vertices": shape.file.n_vertices,
        "through": places,
        "keep": keep,
        "length": found.length,
        "n_points": len(found.surface_points),
        "points": found.points,
    }
    rows = [
        ("through", "; ".join(map(str, places))),
        ("loop", f"length {found.length:.6g}, {len(found.surface_points)} points"),
    ]
    return Answer(shape, content, rows)
