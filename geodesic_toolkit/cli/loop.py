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

__all__ = ["loop"]


def loop(
    path: Input,
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
    from geodesic_toolkit.analysis.paths.loops import geodesic_loop
    from geodesic_toolkit.io import read

    places = parse_waypoints(through, "--through")
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
            found = geodesic_loop(
                solver, shape.sources(places, masked), through=keep, min_length=min_length
            )
        values = None
        if targets.drawn:
            with run.step("solving"):
                values = solver.distance(found.curve)
        targets.write(run, mesh, [found], values, sources=[])
    result = {
        "input": str(path),
        "n_vertices": shape.file.n_vertices,
        "through": places,
        "keep": keep,
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
        ("through", "; ".join(map(str, places))),
        ("loop", f"length {found.length:.6g}, {len(found.surface_points)} points"),
        ("took", run.took),
        *(("wrote", str(target)) for target in targets.paths),
    ]
    if json:
        show_json(result)
    else:
        show("\n".join(aligned(rows)))
