"""``geodesic-toolkit compare``: compare variants of computing distances on a shape."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from geodesic_toolkit.cli.arguments import Input, Json, Weld, parse_sources
from geodesic_toolkit.cli.output import aligned, one_line, show, show_json, versions
from geodesic_toolkit.cli.run import Run, running
from geodesic_toolkit.cli.targets import Targets
from geodesic_toolkit.cli.welding import Welded, check_weld, welded

if TYPE_CHECKING:  # importing NumPy takes longer than all of --help
    from geodesic_toolkit.analysis.comparison import Comparison, Row
    from geodesic_toolkit.core.types import FloatArray

__all__ = ["compare"]

HEADINGS = (
    "WAY",
    "MEAN",
    "MAX",
    "OF DIAMETER",
    "ASYMMETRY",
    "BUILD",
    "A SOURCE",
    "FACTORS",
)


def compare(
    path: Input,
    *,
    source: Annotated[
        list[str],
        typer.Option(
            metavar="PLACE",
            help='A vertex index, or a point "x,y,z" that is moved to the nearest vertex. Give it '
            "several times for the distance from the nearest of them; all of one kind.",
            show_default=False,
        ),
    ],
    picture: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Render the error on the shape as a .png picture."),
    ] = None,
    of: Annotated[
        str, typer.Option(metavar="NAME", help="Name of the variant whose error is shown.")
    ] = "auto",
    weld: Weld = None,
    json: Json = False,
) -> None:
    """Compare variants of distances on INPUT: operators, options, refinement.

    Errors are relative to the exact distance along the surface if that is affordable, else to
    the refined one.
    """
    from geodesic_toolkit.analysis.comparison import compare as compared
    from geodesic_toolkit.io import read

    sources = parse_sources(source)
    check_weld(weld)
    targets = Targets(picture=picture)
    targets.check(path)
    with running() as run:
        if targets.drawn:
            with run.step("loading graphics"):
                targets.load_graphics()
        with run.step("reading"):
            shape = welded(read(path), weld, run)
            targets.check_domain(shape.domain)
        with run.step("comparing"):
            comparison = compared(shape.domain, shape.sources(sources), progress=run.advance)
        if picture is not None:
            with run.step("rendering"):
                _draw(comparison, of, picture)
    if json:
        show_json(
            {
                "input": str(path),
                "domain": type(shape.file).__name__,
                "n_vertices": shape.file.n_vertices,
                "n_merged": shape.domain.n_vertices,
                "sources": shape.firsts(comparison.sources),
                "reference": comparison.reference_name,
                "ways": [row.as_dict() for row in comparison.rows],
                "outputs": [str(target) for target in targets.paths],
                "timings": run.timings,
                "warnings": run.warnings,
                "versions": versions(),
            }
        )
    else:
        _show(comparison, shape, run, targets)


def _draw(comparison: "Comparison", name: str, path: Path) -> None:
    from geodesic_toolkit import viz

    error = 100 * comparison.error(name)
    # A single bad vertex beside a source must not dominate the colour scale.
    top = _high_end(error)
    viz.plot(
        comparison.domain,
        error,
        path=path,
        sources=comparison.sources,
        isolines=0,
        limits=(0.0, top),
        label="error",
        unit="%",
        title=f"{name}, against the {comparison.reference_name}",
    )


def _high_end(error: "FloatArray") -> float:
    import numpy as np

    known = error[np.isfinite(error)]
    top = float(np.percentile(known, 98)) if known.size else 0.0
    return top or 1.0


def _show(comparison: "Comparison", shape: Welded, run: Run, targets: Targets) -> None:
    good = [row for row in comparison.rows if row.failure is None]
    for line in aligned([HEADINGS, *map(_cells, good)]):
        show(line)
    show("")
    for row in comparison.rows:
        if row.failure is not None:
            show(f"{row.variant.name}: failed: {one_line(row.failure)}")
        elif row.unreached:
            show(f"{row.variant.name}: {row.unreached} vertices have no distance")
    facts = [
        ("shape", repr(shape.file)),
        *shape.rows,
        ("sources", ", ".join(map(str, shape.firsts(comparison.sources).tolist()))),
        ("against", comparison.reference_name),
        ("warned", ", ".join(row.variant.name for row in good if row.warnings) or "-"),
        ("took", run.took),
        *(("wrote", str(path)) for path in targets.paths),
    ]
    for line in aligned(facts):
        show(line)


def _cells(row: "Row") -> tuple[str, ...]:
    shares = (row.mean, row.largest, row.of_diameter, row.asymmetry)
    return (
        row.variant.name,
        *(f"{100 * share:.3f} %" for share in shares),
        f"{1e3 * row.build:.1f} ms",
        f"{1e3 * row.per_source:.2f} ms",
        f"{row.factor_bytes / 1e6:.1f} MB",
    )
