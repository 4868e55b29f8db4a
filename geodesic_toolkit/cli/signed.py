"""``geodesic-toolkit signed``: the signed distance from curves."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geodesic_toolkit.cli.arguments import (
    Inputs,
    Json,
    MarkedVertices,
    Mask,
    Refine,
    Weld,
    files_of,
)
from geodesic_toolkit.cli.curves import Page, Picture, solver_of
from geodesic_toolkit.cli.run import Run
from geodesic_toolkit.cli.several import Answer, answer_each
from geodesic_toolkit.cli.targets import Targets
from geodesic_toolkit.cli.welding import read_welded

if TYPE_CHECKING:  # importing NumPy takes longer than all of --help
    from geodesic_toolkit.domains import Domain
    from geodesic_toolkit.sources.kinds import Curve

__all__ = ["signed"]


def signed(
    paths: Inputs,
    *,
    curve: Annotated[
        list[Path],
        typer.Option(
            exists=True,
            dir_okay=False,
            readable=True,
            metavar="FILE",
            help="Lines in an .obj, .ply or .vtp file, as loop and isolines write them; points in "
            "a .csv file with columns x, y and z, or in an .npy table; or a list of vertices. A "
            "line that ends at its first point is closed. Repeat the option for several curves.",
            show_default=False,
        ),
    ],
    unsigned: Annotated[
        list[Path] | None,
        typer.Option(
            exists=True,
            dir_okay=False,
            readable=True,
            metavar="FILE",
            help="More curves, whose distance counts, but not their sides.",
        ),
    ] = None,
    mask: Mask = None,
    weld: Weld = None,
    refine: Refine = None,
    output: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE",
            help="Write the signed distances to a .ply, .pcd, .las, .laz, .vtp, .vtk, .vtu, .gii, "
            ".npy, .csv or .txt file; may be given several times.",
        ),
    ] = None,
    picture: Picture = None,
    html: Page = None,
    json: Json = False,
) -> None:
    """Distance of every vertex of INPUT from curves: positive on their left, else negative."""
    answer_each(
        partial(_answer, curve=curve, unsigned=unsigned or [], mask=mask, weld=weld, refine=refine),
        paths,
        Targets(tables=tuple(output or ()), picture=picture, html=html),
        used=[*curve, *(unsigned or ()), *files_of(mask)],
        json=json,
    )


def _answer(
    run: Run,
    path: Path,
    targets: Targets,
    *,
    curve: list[Path],
    unsigned: list[Path],
    mask: MarkedVertices | None,
    weld: float | None,
    refine: bool | None,
) -> Answer:
    import numpy as np

    from geodesic_toolkit.analysis.signed import signed_distance

    with run.step("reading"):
        shape, masked = read_welded(path, weld, run, mask=mask)
        targets.check_domain(shape.domain)
        curves, others = _curves(curve, shape.file), _curves(unsigned, shape.file)
    with run.step("factorising"):
        solver = solver_of(shape.domain, masked, refine)
    with run.step("solving"):
        found = signed_distance(solver, curves, unsigned=others, refine=refine)
    distances = shape.values(found)
    look: dict[str, Any] = {}
    if targets.drawn:
        from geodesic_toolkit import viz

        look = {**viz.two_sided(distances), "curves": [*curves, *others]}
    targets.write(run, shape.file, distances, [], like=path, **look)
    finite = distances[np.isfinite(distances)]
    if not len(finite):
        run.warn("the curves are connected to no vertex: every distance is inf")
    content = {
        "domain": type(shape.domain).__name__,
        "n_vertices": shape.file.n_vertices,
        "n_curves": len(curves),
        "n_closed": sum(each.closed for each in curves),
        "n_unsigned": len(others),
        "reached": len(finite),
        "n_negative": int((finite < 0).sum()),
        "minimum": finite.min(initial=np.inf),
        "maximum": finite.max(initial=-np.inf),
    }
    rows = [
        ("curves", f"{len(curves)}, {content['n_closed']} of them closed"),
        *([("unsigned", str(len(others)))] if others else []),
        ("distance", f"{content['minimum']:.6g} to {content['maximum']:.6g}"),
    ]
    return Answer(shape, content, rows)


def _curves(files: list[Path], domain: "Domain") -> "list[Curve]":
    from geodesic_toolkit.io import read_curves

    return [each for file in files for each in read_curves(file, domain)]
