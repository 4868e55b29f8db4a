"""``geodesic-toolkit compare``: compare variants of computing distances on a shape."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from geodesic_toolkit.cli.arguments import Inputs, Json, Weld, files_of, parse_sources
from geodesic_toolkit.cli.output import aligned, one_line
from geodesic_toolkit.cli.run import Run
from geodesic_toolkit.cli.several import Answer, answer_each
from geodesic_toolkit.cli.targets import Targets
from geodesic_toolkit.cli.welding import read_welded

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
    paths: Inputs,
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
    sources = parse_sources(source)
    answer_each(
        partial(_answer, sources=sources, of=of, weld=weld),
        paths,
        Targets(picture=picture),
        used=files_of(None, source),
        json=json,
    )


def _answer(
    run: Run,
    path: Path,
    targets: Targets,
    *,
    sources: list[int] | list[list[float]],
    of: str,
    weld: float | None,
) -> Answer:
    from geodesic_toolkit.analysis.comparison import compare as compared

    with run.step("reading"):
        shape, _ = read_welded(path, weld, run)
        targets.check_domain(shape.domain)
    with run.step("comparing"):
        comparison = compared(shape.domain, shape.sources(sources), progress=run.advance)
    if targets.picture is not None:
        with run.step("rendering"):
            _draw(comparison, of, targets.picture)
    sources_of_file = shape.firsts(comparison.sources)
    good = [row for row in comparison.rows if row.failure is None]
    content = {
        "domain": type(shape.file).__name__,
        "n_vertices": shape.file.n_vertices,
        "n_merged": shape.domain.n_vertices,
        "sources": sources_of_file,
        "reference": comparison.reference_name,
        "ways": [row.as_dict() for row in comparison.rows],
        "outputs": [str(target) for target in targets.paths],
    }
    rows = [
        ("sources", ", ".join(map(str, sources_of_file.tolist()))),
        ("against", comparison.reference_name),
        ("warned", ", ".join(row.variant.name for row in good if row.warnings) or "-"),
    ]
    lines = [*aligned([HEADINGS, *map(_cells, good)]), "", *_exceptions(comparison)]
    return Answer(shape, content, rows, lines)


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


def _exceptions(comparison: "Comparison") -> Iterator[str]:
    for row in comparison.rows:
        if row.failure is not None:
            yield f"{row.variant.name}: failed: {one_line(row.failure)}"
        elif row.unreached:
            yield f"{row.variant.name}: {row.unreached} vertices have no distance"


def _cells(row: "Row") -> tuple[str, ...]:
    shares = (row.mean, row.largest, row.of_diameter, row.asymmetry)
    return (
        row.variant.name,
        *(f"{100 * share:.3f} %" for share in shares),
        f"{1e3 * row.build:.1f} ms",
        f"{1e3 * row.per_source:.2f} ms",
        f"{row.factor_bytes / 1e6:.1f} MB",
    )
