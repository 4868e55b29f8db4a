"""Shared parts of the commands of curves: places, files of lines, pictures of them."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geodesic_toolkit.cli.arguments import find_marked
from geodesic_toolkit.cli.run import Run
from geodesic_toolkit.cli.targets import Targets
from geodesic_toolkit.errors import InvalidSourceError

if TYPE_CHECKING:  # importing NumPy takes longer than all of --help
    from geodesic_toolkit.core.types import FloatArray
    from geodesic_toolkit.domains import Domain, TriangleMesh
    from geodesic_toolkit.solver.solver import GeodesicSolver

__all__ = ["Lines", "Page", "Picture", "as_mesh", "parse_waypoints", "solver_of", "write_lines"]

Lines = Annotated[
    list[Path] | None,
    typer.Option(
        metavar="FILE",
        help="Write the lines to a .obj, .ply, .vtp or .csv file; may be given several times.",
    ),
]
Picture = Annotated[Path | None, typer.Option(metavar="FILE", help="Render a .png picture.")]
Page = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Write an .html page to turn the shape in a browser."),
]


def write_lines(
    run: Run,
    targets: Targets,
    domain: "Domain",
    curves: Sequence[Any],
    values: "FloatArray | None" = None,
    **look: Any,
) -> None:
    """Write curves: lines first, so that they are safe if a picture fails.

    Pictures show the `values`, which there are where something is drawn.
    """
    from geodesic_toolkit import viz
    from geodesic_toolkit.io import write_curves

    if targets.tables:
        with run.step("writing"):
            for path in targets.tables:
                write_curves(path, domain, curves)
    if values is None:
        return
    with run.step("rendering"):
        if targets.picture is not None:
            viz.plot(domain, values, path=targets.picture, curves=curves, **look)
        if targets.html is not None:
            viz.save_html(domain, values, targets.html, curves=curves, **look)


def parse_waypoints(texts: Sequence[str], option: str) -> list[int] | list[list[float]]:
    """Return vertex indices, or points in space, in the order in which they were typed.

    Whole numbers between commas are vertices; three numbers of which one has a point are a place.

    Raises
    ------
    InvalidSourceError
        Something else, or vertices and points mixed.
    ReadError
        A file of vertices cannot be read.
    """
    vertices: list[int] = []
    points: list[list[float]] = []
    for text in texts:
        parts = text.split(",")
        try:
            vertices += [int(part) for part in parts]
            continue
        except ValueError:
            pass
        if (marked := find_marked(text)) is not None:
            from geodesic_toolkit.io import read_vertices

            vertices += read_vertices(marked.path, region=marked.region).tolist()
            continue
        points.append(_point(parts, text, option))
    if vertices and points:
        raise InvalidSourceError(
            f"{option}: {vertices[0]} is a vertex and {points[0]} a point; give all of one kind"
        )
    return vertices or points


def _point(parts: list[str], text: str, option: str) -> list[float]:
    try:
        point = [float(part) for part in parts]
    except ValueError:
        point = []
    if len(point) != 3 or not all(map(math.isfinite, point)):
        raise InvalidSourceError(
            f"{option} {text} is neither vertices such as 500,620,710, nor a point such as "
            '"0.1,0.2,0", nor a file of vertices'
        )
    return point


def as_mesh(domain: "Domain", what: str) -> "TriangleMesh":
    """Return a mesh, or raise that one is needed."""
    from geodesic_toolkit.analysis.curves.cuts import as_mesh as checked

    return checked(domain, what)


def solver_of(domain: "Domain", masked: Any, refine: bool | None = None) -> "GeodesicSolver":
    """Return the solver of a shape without the vertices of a mask."""
    from geodesic_toolkit.solver.solver import GeodesicSolver

    return GeodesicSolver(domain, refine="auto" if refine is None else refine, mask=masked)
