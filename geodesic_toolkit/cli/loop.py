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
from geodesic_toolkit.errors import InvalidOptionError

__all__ = ["loop"]


def loop(
    paths: Inputs,
    *,
    through: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PLACES",
            help='Places on the loop before it is pulled taut. Vertex indices "500,620,710"; a '
            'point "x,y,z", of which one number has a decimal '
            "point, that is snapped to the shape; or a file of vertices. Give it several times for "
            "several points, in order; three places or more.",
            show_default=False,
        ),
    ] = None,
    at: Annotated[
        str | None,
        typer.Option(
            metavar="PLACE",
            help='Shortest loop through this vertex, or point "x,y,z", that does not shrink to a '
            "point. Without --through and --at: the shortest of the whole mesh, its girth.",
            show_default=False,
        ),
    ] = None,
    min_hole: Annotated[
        float,
        typer.Option(
            metavar="LENGTH", help="Shortest loop: holes with a shorter boundary count as filled."
        ),
    ] = 0.0,
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
    """Closed geodesic on the mesh INPUT: through places, or the shortest that there is."""
    from geodesic_toolkit.io.curves import check_curve_output

    if through and (at is not None or min_hole):
        raise InvalidOptionError("--at and --min-hole are for the shortest loop, without --through")
    if not through and (keep or min_length):
        raise InvalidOptionError("--keep and --min-length are for a loop --through places")
    given = through or ([] if at is None else [at])
    answer_each(
        partial(
            _answer,
            places=parse_waypoints(given, "--through" if through else "--at"),
            pulled=bool(through),
            keep=keep,
            min_length=min_length,
            min_hole=min_hole,
            mask=mask,
            weld=weld,
        ),
        paths,
        Targets(
            tables=tuple(output or ()), check_table=check_curve_output, picture=picture, html=html
        ),
        used=files_of(mask, given),
        json=json,
    )


def _answer(
    run: Run,
    path: Path,
    targets: Targets,
    *,
    places: list[int] | list[list[float]],
    pulled: bool,
    keep: bool,
    min_length: float,
    min_hole: float,
    mask: MarkedVertices | None,
    weld: float | None,
) -> Answer:
    from geodesic_toolkit.analysis.paths.loops import geodesic_loop
    from geodesic_toolkit.analysis.paths.shortest_loops import shortest_loop

    with run.step("reading"):
        shape, masked = read_welded(path, weld, run, mask=mask)
        mesh = as_mesh(shape.domain, "loops")
    with run.step("factorising"):
        solver = solver_of(mesh, masked)
    with run.step("pulling"):
        stops = shape.sources(places, masked) if places else None
        if pulled:
            found = geodesic_loop(solver, stops, through=keep, min_length=min_length)
        else:
            found = shortest_loop(solver, stops, min_hole=min_hole)
    values = None
    if targets.drawn:
        with run.step("solving"):
            values = solver.distance(found.curve)
    write_lines(run, targets, mesh, [found], values, sources=[])
    content = {
        "n_vertices": shape.file.n_vertices,
        "through": places if pulled else None,
        "keep": keep,
        "shortest": not pulled,
        "at": places[0] if places and not pulled else None,
        "min_hole": min_hole,
        "length": found.length,
        "n_points": len(found.surface_points),
        "points": found.points,
    }
    rows = [
        ("through" if pulled else "at", "; ".join(map(str, places)) or "the whole mesh"),
        (
            "loop" if pulled else "shortest loop",
            f"length {found.length:.6g}, {len(found.surface_points)} points",
        ),
    ]
    return Answer(shape, content, rows)
