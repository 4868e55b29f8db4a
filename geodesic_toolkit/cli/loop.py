"""``geodesic-toolkit loop``: a closed geodesic."""

from typing import Annotated

import typer

from geodesic_toolkit.cli.arguments import Input, Json, Mask, Weld
from geodesic_toolkit.cli.curves import (
    CurveTargets,
    Lines,
    Page,
    Picture,
    as_mesh,
    parse_waypoints,
    solver_of,
)
from geodesic_toolkit.cli.output import aligned, show, show_json, versions
from geodesic_toolkit.cli.run import running
from geodesic_toolkit.cli.welding import check_weld, welded
from geodesic_toolkit.errors import InvalidOptionError

__all__ = ["loop"]


def loop(
    path: Input,
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
    from geodesic_toolkit.analysis.paths.loops import geodesic_loop
    from geodesic_toolkit.analysis.paths.shortest_loops import shortest_loop
    from geodesic_toolkit.io import read

    if through and (at is not None or min_hole):
        raise InvalidOptionError("--at and --min-hole are for the shortest loop, without --through")
    if not through and (keep or min_length):
        raise InvalidOptionError("--keep and --min-length are for a loop --through places")
    places = parse_waypoints(
        through or ([] if at is None else [at]), "--through" if through else "--at"
    )
    check_weld(weld)
    targets = CurveTargets(tables=tuple(output or ()), picture=picture, html=html)
    targets.check(path)
    with running() as run:
        targets.load_graphics()
        with run.step("reading"):
            shape = welded(read(path), weld, run)
            mesh = as_mesh(shape.domain, "loops")
            masked = shape.mask(None if mask is None else mask.mask(shape.file.n_vertices))
        with run.step("factorising"):
            solver = solver_of(mesh, masked)
        with run.step("pulling"):
            stops = shape.sources(places, masked) if places else None
            if through:
                found = geodesic_loop(solver, stops, through=keep, min_length=min_length)
            else:
                found = shortest_loop(solver, stops, min_hole=min_hole)
        values = None
        if targets.drawn:
            with run.step("solving"):
                values = solver.distance(found.curve)
        targets.write(run, mesh, [found], values, sources=[])
    result = {
        "input": str(path),
        "n_vertices": shape.file.n_vertices,
        "through": places if through else None,
        "keep": keep,
        "shortest": not through,
        "at": places[0] if places and not through else None,
        "min_hole": min_hole,
        "length": found.length,
        "n_points": len(found.surface_points),
        "points": found.points,
        "timings": run.timings,
        "warnings": run.warnings,
        "outputs": [str(target) for target in targets.paths],
        "versions": versions(),
    }
    rows = [
        ("shape", repr(shape.file)),
        *shape.rows,
        ("through" if through else "at", "; ".join(map(str, places)) or "the whole mesh"),
        (
            "loop" if through else "shortest loop",
            f"length {found.length:.6g}, {len(found.surface_points)} points",
        ),
        ("took", run.took),
        *(("wrote", str(target)) for target in targets.paths),
    ]
    if json:
        show_json(result)
    else:
        show("\n".join(aligned(rows)))
