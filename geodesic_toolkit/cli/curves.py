"""Shared parts of the commands of curves: places, files of lines, pictures of them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geodesic_toolkit.cli.arguments import find_marked
from geodesic_toolkit.cli.run import Run
from geodesic_toolkit.errors import InvalidOptionError, InvalidSourceError

if TYPE_CHECKING:  # importing NumPy takes longer than all of --help
    from geodesic_toolkit.core.types import FloatArray
    from geodesic_toolkit.domains import Domain, TriangleMesh
    from geodesic_toolkit.solver.solver import GeodesicSolver

__all__ = ["CurveTargets", "Lines", "Page", "Picture", "as_mesh", "parse_waypoints", "solver_of"]

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


@dataclass(frozen=True, kw_only=True)
class CurveTargets:
    """The output files of curves.

    Parameters
    ----------
    tables : tuple of Path
    picture, html : Path, optional
    """

    tables: tuple[Path, ...] = ()
    picture: Path | None = None
    html: Path | None = None

    @property
    def paths(self) -> list[Path]:
        """All of them, in the order in which they are written."""
        return [*self.tables, *(path for path in (self.picture, self.html) if path is not None)]

    def check(self, *inputs: Path) -> None:
        """Raise before any work where something could not be written after it."""
        from geodesic_toolkit.io import check_output
        from geodesic_toolkit.io.curves import check_curve_output

        seen = {path.resolve(): "the input" for path in inputs}
        for path in self.paths:
            if path.resolve() in seen:
                raise InvalidOptionError(f"{path} would overwrite {seen[path.resolve()]}")
            seen[path.resolve()] = "another output"
        for path in self.tables:
            check_curve_output(path)
        for drawn, suffix in ((self.picture, ".png"), (self.html, ".html")):
            if drawn is not None:
                check_output(drawn, (suffix,))

    def load_graphics(self) -> None:
        """Import what draws, so that it is found missing before the work and not after it."""
        from geodesic_toolkit.core.optional import require

        if self.picture is not None:
            require("pyvista", "viz", "Pictures need")
        if self.html is not None:
            require("k3d", "viz", "HTML pages need")

    @property
    def drawn(self) -> bool:
        """True if there is a picture or page to draw."""
        return self.picture is not None or self.html is not None

    def write(
        self,
        run: Run,
        domain: "Domain",
        curves: Sequence[Any],
        values: "FloatArray | None" = None,
        **look: Any,
    ) -> None:
        """Write everything: lines first, so that a picture that fails costs no work.

        Pictures show the `values`, which there are where something is drawn.
        """
        from geodesic_toolkit import viz
        from geodesic_toolkit.io import write_curves

        if self.tables:
            with run.step("writing"):
                for path in self.tables:
                    write_curves(path, domain, curves)
        if values is None:
            return
        with run.step("rendering"):
            if self.picture is not None:
                viz.plot(domain, values, path=self.picture, curves=curves, **look)
            if self.html is not None:
                viz.save_html(domain, values, self.html, curves=curves, **look)


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
