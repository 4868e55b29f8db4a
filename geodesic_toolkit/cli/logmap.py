"""``geodesic-toolkit logmap``: the logarithmic map of a point."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from geodesic_toolkit.cli.arguments import Input, Json, Mask, Refine, Weld, parse_sources
from geodesic_toolkit.cli.curves import Picture, solver_of
from geodesic_toolkit.cli.output import aligned, show, show_json, versions
from geodesic_toolkit.cli.run import running
from geodesic_toolkit.cli.welding import Welded, check_weld, welded
from geodesic_toolkit.errors import InvalidOptionError

if TYPE_CHECKING:  # importing NumPy takes longer than all of --help
    from geodesic_toolkit.analysis.directions.log_map import LogMap

__all__ = ["logmap"]

N_SECTORS = 24


def logmap(
    path: Input,
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
    import numpy as np

    from geodesic_toolkit.analysis.directions.log_map import log_map
    from geodesic_toolkit.io import read, write_log_map

    place = parse_sources([source])
    check_weld(weld)
    tables = tuple(output or ())
    written = (*tables, *(() if picture is None else (picture,)))
    _check(path, tables, picture)
    with running() as run:
        if picture is not None:
            from geodesic_toolkit.core.optional import require

            require("pyvista", "viz", "Pictures need")
        with run.step("reading"):
            shape = welded(read(path), weld, run)
            masked = shape.mask(None if mask is None else mask.mask(shape.file.n_vertices))
        with run.step("factorising"):
            solver = solver_of(shape.domain, masked, refine)
        with run.step("solving"):
            log = log_map(solver, shape.sources(place, masked))
        if tables:
            with run.step("writing"):
                own = _of_file(log, shape)
                for table in tables:
                    write_log_map(table, shape.file, own)
        if picture is not None:
            from geodesic_toolkit import viz

            with run.step("rendering"):
                checkers = viz.Checkers(log.coordinates, sectors=0 if squares else N_SECTORS)
                viz.plot(shape.domain, log.distance, path=picture, checkers=checkers, isolines=0)
    longest = log.distance[np.isfinite(log.distance)].max()
    if json:
        show_json(
            {
                "input": str(path),
                "n_vertices": shape.file.n_vertices,
                "source": place,
                "refined": solver.method.refine,
                "reached": int(np.isfinite(shape.values(log.distance)).sum()),
                "longest": longest,
                "frame": log.frame,
                "timings": run.timings,
                "warnings": run.warnings,
                "outputs": [str(target) for target in written],
                "versions": versions(),
            }
        )
        return
    rows = [
        ("shape", repr(shape.file)),
        *shape.rows,
        ("source", "; ".join(map(str, place))),
        ("first axis", " ".join(f"{part:.6g}" for part in log.frame[0])),
        ("second axis", " ".join(f"{part:.6g}" for part in log.frame[1])),
        ("longest", f"{longest:.6g}"),
        ("took", run.took),
        *(("wrote", str(target)) for target in written),
    ]
    show("\n".join(aligned(rows)))


def _check(path: Path, tables: tuple[Path, ...], picture: Path | None) -> None:
    """Raise before any work if a file could not be written after it."""
    from geodesic_toolkit.io import check_output
    from geodesic_toolkit.io.log_maps import check_log_map_output

    seen = {path.resolve(): "the input"}
    for target in (*tables, *(() if picture is None else (picture,))):
        if target.resolve() in seen:
            raise InvalidOptionError(f"{target} would overwrite {seen[target.resolve()]}")
        seen[target.resolve()] = "another output"
    for table in tables:
        check_log_map_output(table)
    if picture is not None:
        check_output(picture, (".png",))


def _of_file(log: "LogMap", shape: Welded) -> "LogMap":
    """Return a map at the vertices of the domain as one at those of the file."""
    from dataclasses import replace

    names = ("coordinates", "distance", "angle", "arrival", "spread")
    return replace(log, **{name: shape.values(getattr(log, name)) for name in names})
