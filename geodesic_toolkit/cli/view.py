"""``geodesic-toolkit view``: a page to look and click."""

from contextlib import suppress
from typing import Annotated

import typer

from geodesic_toolkit.cli.arguments import (
    Cost,
    Input,
    Json,
    Mask,
    Operator,
    Refine,
    TimeFactor,
    Weld,
    check_plugins,
    check_time,
    kinds_of,
    parse_sources,
)
from geodesic_toolkit.cli.output import show, show_json, versions
from geodesic_toolkit.cli.run import running
from geodesic_toolkit.cli.welding import welded

__all__ = ["view"]


def view(
    path: Input,
    *,
    source: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PLACE",
            help='The first source: a vertex index; a point "x,y,z" that is snapped to the shape; '
            "or a file of vertices. Give it several times for more sources.",
            show_default=False,
        ),
    ] = None,
    mask: Mask = None,
    cost: Cost = None,
    weld: Weld = None,
    operator: Operator = "auto",
    time_factor: TimeFactor = None,
    refine: Refine = None,
    cmap: Annotated[
        str, typer.Option(metavar="NAME", help="Colour map of matplotlib at first.")
    ] = "viridis",
    isolines: Annotated[
        int, typer.Option(metavar="N", min=0, max=60, help="Number of isolines at first.")
    ] = 20,
    unit: Annotated[str, typer.Option(metavar="NAME", help="Unit of the distances.")] = "",
    port: Annotated[
        int,
        typer.Option(metavar="N", min=0, max=65535, help="Port of the page; 0 for any free one."),
    ] = 0,
    browser: Annotated[
        bool, typer.Option("--open/--no-open", help="Open the page in the default browser.")
    ] = True,
    json: Json = False,
) -> None:
    """Show INPUT in the browser, where a click sets the source, until Ctrl-C.

    The address is printed; it is one of this computer, and others cannot reach it.
    """
    from geodesic_toolkit.io import read
    from geodesic_toolkit.viz.live.view import view as open_view

    sources = None if not source else parse_sources(source)
    check_time(None, time_factor)
    check_plugins("auto", operator)
    with running() as run:
        with run.step("reading"):
            shape = welded(read(path, kinds=kinds_of(operator)), weld, run).with_cost(cost)
            masked = shape.mask(None if mask is None else mask.mask(shape.file.n_vertices))
        found = list(run.warnings)
        with run.step("factorising"):
            page = open_view(
                shape.domain,
                sources=None if sources is None else shape.sources(sources, masked),
                operator=operator,
                mask=masked,
                refine="auto" if refine is None else refine,
                time_factor=1.0 if time_factor is None else time_factor,
                cmap=cmap,
                isolines=isolines,
                unit=unit,
                name=path.stem,
                like=path if weld is None else None,
                port=port,
                browser=browser,
                block=False,
            )
        for text in found:  # those of the start are there
            page.warn(text)
    # Ctrl-C is the end of the page as soon as its address is printed.
    with page, suppress(KeyboardInterrupt):
        if json:
            show_json(
                {
                    "input": str(path),
                    "domain": type(shape.domain).__name__,
                    "n_vertices": shape.file.n_vertices,
                    "n_merged": shape.domain.n_vertices,
                    "mask": None if mask is None else str(mask),
                    "cost": None if cost is None else str(cost),
                    "url": page.url,
                    "timings": run.timings,
                    "warnings": run.warnings,
                    "outputs": [],
                    "versions": versions(),
                }
            )
        else:
            show(page.url)
        page.wait()
