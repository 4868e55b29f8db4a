"""A command for geodesic-toolkit: the vertex that is farthest from another one."""

from pathlib import Path
from typing import Annotated

import typer

__all__ = ["farthest"]


def farthest(
    path: Annotated[Path, typer.Argument(exists=True, dir_okay=False, metavar="INPUT")],
    source: Annotated[int, typer.Option(help="Index of the vertex to start at.")] = 0,
) -> None:
    """Print the vertex of INPUT that is farthest from another one, and its distance."""
    # Imported here, because `geodesic-toolkit --help` imports this module.
    import numpy as np

    import geodesic_toolkit as gt

    distance = gt.geodesic_distance(gt.read(path), source)
    reached = np.where(np.isfinite(distance), distance, -1.0)
    vertex = int(reached.argmax())
    typer.echo(f"{vertex} {reached[vertex]:.6g}")
