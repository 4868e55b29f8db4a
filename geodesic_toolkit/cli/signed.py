"""``geodesic-toolkit signed``: the signed distance from curves."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geodesic_toolkit.cli.arguments import Input, Json, Mask, Refine, Weld
from geodesic_toolkit.cli.curves import Page, Picture, solver_of
from geodesic_toolkit.cli.output import aligned, show, show_json, versions
from geodesic_toolkit.cli.run import running
from geodesic_toolkit.cli.targets import Targets
from geodesic_toolkit.cli.welding import check_weld, welded

if TYPE_CHECKING:  # importing NumPy takes longer than all of --help
    from geodesic_toolkit.domains import Domain
    from geodesic_toolkit.sources.kinds import Curve

__all__ = ["signed"]


def signed(
    path: Input,
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
    import numpy as np

    from geodesic_toolkit.analysis.signed import signed_distance
    from geodesic_toolkit.io import read

    check_weld(weld)
    targets = Targets(tables=tuple(output or ()), picture=picture, html=html)
    targets.check(path, *curve, *(unsigned or ()), *([] if mask is None else [mask.path]))
    with running() as run:
        if targets.drawn:
            with run.step("loading graphics"):
                targets.load_graphics()
        with run.step("reading"):
            shape = welded(read(path), weld, run)
            targets.check_domain(shape.domain)
            masked = shape.mask(None if mask is None else mask.mask(shape.file.n_vertices))
            curves, others = _curves(curve, shape.file), _curves(unsigned or [], shape.file)
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
    result = {
        "input": str(path),
        "domain": type(shape.domain).__name__,
        "n_vertices": shape.file.n_vertices,
        "n_curves": len(curves),
        "n_closed": sum(each.closed for each in curves),
        "n_unsigned": len(others),
        "reached": len(finite),
        "n_negative": int((finite < 0).sum()),
        "minimum": finite.min(initial=np.inf),
        "maximum": finite.max(initial=-np.inf),
        "timings": run.timings,
        "warnings": run.warnings,
        "outputs": [str(target) for target in targets.paths],
        "versions": versions(),
    }
    if json:
        show_json(result)
        return
    rows = [
        ("shape", repr(shape.file)),
        *shape.rows,
        ("curves", f"{len(curves)}, {result['n_closed']} of them closed"),
        *([("unsigned", str(len(others)))] if others else []),
        ("distance", f"{result['minimum']:.6g} to {result['maximum']:.6g}"),
        ("took", run.took),
        *(("wrote", str(target)) for target in targets.paths),
    ]
    show("\n".join(aligned(rows)))


def _curves(files: list[Path], domain: "Domain") -> "list[Curve]":
    from geodesic_toolkit.io import read_curves

    return [each for file in files for each in read_curves(file, domain)]
