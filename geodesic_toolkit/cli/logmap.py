"""``geodesic-toolkit logmap``: the logarithmic map of a point."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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
from geodesic_toolkit.cli.curves import Picture, solver_of
from geodesic_toolkit.cli.run import Run
from geodesic_toolkit.cli.several import Answer, answer_each
from geodesic_toolkit.cli.targets import Targets
from geodesic_toolkit.cli.welding import Welded, read_welded

if TYPE_CHECKING:  # importing NumPy takes longer than all of --help
    from geodesic_toolkit.analysis.directions.log_map import LogMap

__all__ = ["logmap"]

N_SECTORS = 24


def logmap(
    paths: Inputs,
    *,
    source: Annotated[
        str,
        typer.Option(
            metavar="PLACE",
            help='A vertex index, or a point "x,y,z" that is snapped to the shape.',
            show_default=False,
        ),
    ],
    mask: Mask = None,
    weld: Weld = None,
    refine: Refine = None,
    output: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE",
            help="Write the map to a .ply or .obj file with texture coordinates, or to a .csv, "
            ".npy or .json file; may be given several times.",
        ),
    ] = None,
    picture: Picture = None,
    squares: Annotated[
        bool, typer.Option("--squares", help="Draw squares instead of rings and sectors.")
    ] = False,
    json: Json = False,
) -> None:
    """Direction and length of the shortest geodesic from a place on INPUT to every vertex."""
    from geodesic_toolkit.io.log_maps import check_log_map_output

    place = parse_sources([source])
    answer_each(
        partial(_answer, place=place, mask=mask, weld=weld, refine=refine, squares=squares),
        paths,
        Targets(tables=tuple(output or ()), check_table=check_log_map_output, picture=picture),
        used=files_of(mask, [source]),
        json=json,
    )


def _answer(
    run: Run,
    path: Path,
    targets: Targets,
    *,
    place: list[int] | list[list[float]],
    mask: MarkedVertices | None,
    weld: float | None,
    refine: bool | None,
    squares: bool,
) -> Answer:
    import numpy as np

    from geodesic_toolkit.analysis.directions.log_map import log_map

    with run.step("reading"):
        shape, masked = read_welded(path, weld, run, mask=mask)
    with run.step("factorising"):
        solver = solver_of(shape.domain, masked, refine)
    with run.step("solving"):
        log = log_map(solver, shape.sources(place, masked))
    _write(run, targets, shape, log, squares)
    longest = log.distance[np.isfinite(log.distance)].max()
    content = {
        "n_vertices": shape.file.n_vertices,
        "source": place,
        "refined": solver.method.refine,
        "reached": int(np.isfinite(shape.values(log.distance)).sum()),
        "longest": longest,
        "frame": log.frame,
    }
    rows = [
        ("source", "; ".join(map(str, place))),
        ("first axis", " ".join(f"{part:.6g}" for part in log.frame[0])),
        ("second axis", " ".join(f"{part:.6g}" for part in log.frame[1])),
        ("longest", f"{longest:.6g}"),
    ]
    return Answer(shape, content, rows)


def _write(run: Run, targets: Targets, shape: Welded, log: "LogMap", squares: bool) -> None:
    if targets.tables:
        from geodesic_toolkit.io import write_log_map

        with run.step("writing"):
            own = _of_file(log, shape)
            for table in targets.tables:
                write_log_map(table, shape.file, own)
    if targets.picture is not None:
        from geodesic_toolkit import viz

        with run.step("rendering"):
            checkers = viz.Checkers(log.coordinates, sectors=0 if squares else N_SECTORS)
            viz.plot(
                shape.domain, log.distance, path=targets.picture, checkers=checkers, isolines=0
            )


def _of_file(log: "LogMap", shape: Welded) -> "LogMap":
    """Return a map at the vertices of the domain as one at those of the file."""
    from dataclasses import replace

    names = ("coordinates", "distance", "angle", "arrival", "spread")
    return replace(log, **{name: shape.values(getattr(log, name)) for name in names})
