"""``geodesic-toolkit distance``: compute, write and draw the distance from sources."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geodesic_toolkit.cli.arguments import (
    BoundaryChoice,
    Cost,
    Inputs,
    Json,
    MarkedVertices,
    Mask,
    Operator,
    Refine,
    Solver,
    TimeFactor,
    Weld,
    check_plugins,
    check_positions,
    check_reach,
    check_thin,
    check_time,
    files_of,
    kinds_of,
    parse_sources,
)
from geodesic_toolkit.cli.output import one_line
from geodesic_toolkit.cli.run import Run, method_in_words
from geodesic_toolkit.cli.several import Answer, answer_each
from geodesic_toolkit.cli.targets import Targets
from geodesic_toolkit.cli.welding import Welded, welded
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.errors import InvalidOptionError

if TYPE_CHECKING:  # importing NumPy takes longer than all of --help
    from geodesic_toolkit.analysis.thinning import Thinned
    from geodesic_toolkit.core.types import BoolArray, FloatArray
    from geodesic_toolkit.domains import Domain, PointCloud
    from geodesic_toolkit.solver.solver import GeodesicSolver
    from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["distance"]


def distance(
    paths: Inputs,
    *,
    source: Annotated[
        list[str],
        typer.Option(
            metavar="PLACE",
            help='A vertex index; a point "x,y,z" that is snapped to the shape; or a file of '
            "vertices (.npy, .txt, .csv, .label; .annot:REGION). Give it several times for the "
            "distance from the nearest of them; all of one kind.",
            show_default=False,
        ),
    ],
    at: Annotated[
        Path | None,
        typer.Option(
            exists=True,
            dir_okay=False,
            readable=True,
            metavar="POINTS",
            help="Give the distance at the points of this file instead of at the vertices: an .npy "
            "or .csv table, a point cloud or a mesh. They may be anywhere on or near INPUT, which "
            "pictures still show.",
        ),
    ] = None,
    reach: Annotated[
        float | None,
        typer.Option(
            metavar="R",
            help="Largest distance of points of --at from the surface: two mean edges, unless "
            "given.",
            show_default=False,
        ),
    ] = None,
    thin: Annotated[
        float | None,
        typer.Option(
            metavar="SPACING",
            help="Compute on points of the cloud that are this far apart, and carry the distances "
            "back to all of them.",
            show_default=False,
        ),
    ] = None,
    mask: Mask = None,
    cost: Cost = None,
    weld: Weld = None,
    operator: Operator = "auto",
    diffusion: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Another operator for the diffusion of heat."),
    ] = None,
    time_factor: TimeFactor = None,
    time: Annotated[
        float | None,
        typer.Option(metavar="T", help="Time step in squared units of length, instead."),
    ] = None,
    boundary: Annotated[
        BoundaryChoice, typer.Option(help="Condition on the heat at boundaries.")
    ] = BoundaryChoice.neumann,
    solver: Solver = "auto",
    refine: Refine = None,
    output: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE",
            help="Write the distances to a .ply, .pcd, .las, .laz, .vtp, .vtk, .vtu, .gii, .npy, "
            ".csv or .txt file, or to standard output as -.csv; may be given several times. With "
            "several INPUTs it has {name}, which is replaced by the name of each without its "
            "suffix. A .ply, .pcd, .las or .laz of the "
            "format of INPUT, or of --at, keeps all other data of that file.",
        ),
    ] = None,
    picture: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Render a .png picture.")
    ] = None,
    html: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write an .html page to turn the shape in a browser."),
    ] = None,
    parts: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Render a .png picture of the components."),
    ] = None,
    cmap: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Colour map of matplotlib for picture and page."),
    ] = None,
    json: Json = False,
) -> None:
    """Geodesic distance of every vertex of INPUT, or of the points --at, from the sources."""
    sources = parse_sources(source)
    check_time(time, time_factor)
    check_reach(reach, at)
    check_thin(thin, mask)
    check_plugins(solver, operator, diffusion)
    options = {
        "operator": operator,
        "diffusion": diffusion,
        "time": time,
        "time_factor": 1.0 if time_factor is None else time_factor,
        "boundary": boundary.value,
        "solver": solver,
        "refine": "auto" if refine is None else refine,
    }
    question = Question(sources, at, reach, thin, mask, cost, weld, options)
    targets = Targets(
        tables=tuple(output or ()), picture=picture, html=html, parts=parts, cmap=cmap
    )
    used = [at, cost, *files_of(mask, source)]
    answer_each(question.answer, paths, targets, used=used, json=json)


@dataclass(frozen=True)
class Question:
    """The distances that are asked of each file, and the options of the solver."""

    sources: list[int] | list[list[float]]
    at: Path | None
    reach: float | None
    thin: float | None
    mask: MarkedVertices | None
    cost: Path | None
    weld: float | None
    options: dict[str, Any]

    def answer(self, run: Run, path: Path, targets: Targets) -> Answer:
        """Compute, write and draw the distances of one file."""
        with run.step("reading"):
            shape, masked, located = _shape(run, path, self)
            targets.check_domain(shape.domain)
            points = _points(self.at, shape.domain)
        thinned = None
        if self.thin is not None:
            with run.step("thinning"):
                thinned, located = _thinned(shape.domain, self.thin, located)
        solver, distances = self._solved(run, shape.domain, masked, thinned, located)
        asked = None
        if points is not None:
            with run.step("asking"):
                found = _at(run, points, solver, distances, located=located, reach=self.reach)
                asked = points, found
        if thinned is not None:
            with run.step("carrying back"):
                distances = thinned.carry_back(
                    distances, solver, sources=located, progress=run.advance
                )
        own = shape.values(distances)
        targets.write(
            run,
            shape.file,
            own,
            self.sources,
            parts=shape.values(_parts(solver, thinned)),
            asked=asked,
            like=path if self.at is None else self.at,
        )
        found = own if asked is None else asked[1]
        result = Result(self, shape, solver, thinned, found, run)
        result.warn_where_nothing_is_reached()
        return Answer(shape, result.as_dict(), result.rows)

    def _solved(
        self,
        run: Run,
        domain: "Domain",
        masked: "BoolArray | None",
        thinned: "Thinned | None",
        located: "SourcePoints",
    ) -> "tuple[GeodesicSolver, FloatArray]":
        from geodesic_toolkit.solver.solver import GeodesicSolver

        with run.step("factorising"):
            solver = GeodesicSolver(
                domain if thinned is None else thinned.cloud, mask=masked, **self.options
            )
        with run.step("solving"):
            return solver, solver.distance(located)


@dataclass(frozen=True)
class Result:
    """The result for one file, as text and as JSON."""

    question: Question
    shape: Welded
    solver: "GeodesicSolver"
    thinned: "Thinned | None"
    distances: "FloatArray"
    run: Run

    @property
    def finite(self) -> "FloatArray":
        """The finite distances of the vertices, or points."""
        import numpy as np

        return self.distances[np.isfinite(self.distances)]

    @property
    def reached(self) -> int:
        """The number of reached vertices."""
        return len(self.finite)

    def warn_where_nothing_is_reached(self) -> None:
        """Warn if no distance but those of the sources is finite."""
        at, sources = self.question.at, self.question.sources
        if at is None and self.reached == len(sources) < len(self.distances):
            self.run.warn(
                "the sources are connected to no other vertex: every other distance is inf"
            )
        elif self.reached == 0:
            self.run.warn(f"no point of {at} has a distance: none is near what the sources reach")

    def as_dict(self) -> dict[str, Any]:
        """Return everything, for JSON."""
        method, finite, asked = self.solver.method, self.finite, self.question
        return {
            "domain": type(self.shape.domain).__name__,
            "n_vertices": self.shape.file.n_vertices,
            "n_merged": self.shape.domain.n_vertices,
            "sources": asked.sources,
            "at": None if asked.at is None else str(asked.at),
            "n_points": None if asked.at is None else len(self.distances),
            "mask": None if asked.mask is None else str(asked.mask),
            "cost": None if asked.cost is None else str(asked.cost),
            "thin": None if self.thinned is None else self.thinned.spacing,
            "n_kept": None if self.thinned is None else self.thinned.cloud.n_vertices,
            "operator": repr(self.solver.operator),
            "diffusion": None if self.solver.diffusion is None else repr(self.solver.diffusion),
            "solver": {"heat": repr(method.heat_solver), "poisson": repr(method.poisson_solver)},
            "refine": method.refine,
            "boundary": method.boundary,
            "time": method.time,
            "spacing": method.metric.spacing,
            "reached": self.reached,
            "unreachable": len(self.distances) - self.reached,
            "min": finite.min() if self.reached else None,
            "mean": finite.mean() if self.reached else None,
            "max": finite.max() if self.reached else None,
            "timings": self.run.timings,
            "warnings": self.run.warnings,
            "notes": method.metric.notes,
        }

    @property
    def rows(self) -> list[tuple[str, str]]:
        """Names and values, for the text."""
        method, finite, asked = self.solver.method, self.finite, self.question
        noun = "vertices" if asked.at is None else "points"
        return [
            ("source", "; ".join(map(_place, asked.sources))),
            *([] if asked.at is None else [("at", f"{len(self.distances)} points of {asked.at}")]),
            *([] if asked.mask is None else [("mask", str(asked.mask))]),
            *([] if asked.cost is None else [("cost", str(asked.cost))]),
            *([] if self.thinned is None else [("thinned", repr(self.thinned.cloud))]),
            ("method", method_in_words(self.solver)),
            ("time step", f"{method.time:.4g}, mean edge length {method.metric.spacing:.4g}"),
            (
                "distance",
                f"min {finite.min():.6g}, mean {finite.mean():.6g}, max {finite.max():.6g}"
                if self.reached
                else "-",
            ),
            (
                "reached",
                f"{self.reached} {noun}, {len(self.distances) - self.reached} unreachable",
            ),
            (
                "notes",
                ", ".join(f"{name} {_short(note)}" for name, note in method.metric.notes.items())
                or "-",
            ),
        ]


def _shape(
    run: Run, path: Path, question: Question
) -> "tuple[Welded, BoolArray | None, SourcePoints]":
    """Return the shape of a file, its mask, and the located sources."""
    from geodesic_toolkit.io import read
    from geodesic_toolkit.solver.masks import check_unmasked, passable_part
    from geodesic_toolkit.sources.locate import locate_sources

    file = read(path, kinds=kinds_of(question.options["operator"]))
    shape = welded(file, question.weld, run).with_cost(question.cost)
    mask = question.mask
    masked = shape.mask(None if mask is None else mask.mask(file.n_vertices))
    passable = shape.domain if masked is None else passable_part(shape.domain, masked)
    sources = shape.sources(question.sources, masked)
    located = locate_sources(shape.domain, sources, passable=passable)
    if masked is not None:
        check_unmasked(located, masked)
    return shape, masked, located


def _parts(solver: "GeodesicSolver", thinned: "Thinned | None") -> "FloatArray":
    """Return the component of each vertex, to draw; for a thinned cloud, of each kept point."""
    import numpy as np

    from geodesic_toolkit.viz import by_part

    found = by_part(solver.method.metric.components)
    if thinned is None:
        return found
    parts = np.full(thinned.full.n_vertices, np.nan)
    parts[thinned.index] = found
    return parts


def _points(at: Path | None, domain: "Domain") -> "PointCloud | None":
    """Return the points at which distances are requested, if any."""
    if at is None:
        return None
    from geodesic_toolkit.io import read_points

    points = read_points(at)
    check_positions(domain)
    return points


def _thinned(
    domain: "Domain", spacing: float, located: "SourcePoints"
) -> tuple["Thinned", "SourcePoints"]:
    """Return a thinned cloud, and its sources, which are kept."""
    from geodesic_toolkit.analysis.thinning import thin
    from geodesic_toolkit.domains import PointCloud
    from geodesic_toolkit.sources.points import SourcePoints

    if not isinstance(domain, PointCloud):
        raise InvalidOptionError(f"--thin is for point clouds, not for {a_kind_of(domain)}")
    thinned = thin(domain, spacing, keep=located.vertices)
    vertices = thinned.vertices_of(located.vertices)
    return thinned, SourcePoints.at_vertices(vertices, thinned.cloud.n_vertices)


def _at(
    run: Run,
    points: "PointCloud",
    solver: "GeodesicSolver",
    distances: "FloatArray",
    *,
    located: "SourcePoints",
    reach: float | None,
) -> "FloatArray":
    """Return the distance at each point; infinite at missing points."""
    import numpy as np

    found = np.full(points.n_vertices, np.inf)
    found[points.present] = solver.interpolate(
        distances,
        points.points[points.present],
        sources=located,
        reach=reach,
        progress=run.advance,
    )
    return found


def _short(note: object) -> str:
    return f"{note:.3g}" if isinstance(note, float) else one_line(note)


def _place(source: int | list[float]) -> str:
    if isinstance(source, int):
        return f"vertex {source}"
    return f"point ({', '.join(f'{coordinate:g}' for coordinate in source)})"
