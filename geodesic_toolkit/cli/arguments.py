"""Arguments shared by commands, checked before any work."""

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from geodesic_toolkit.cli.streams import is_stream
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.errors import InvalidOptionError, InvalidSourceError

if TYPE_CHECKING:
    from geodesic_toolkit.core.types import BoolArray
    from geodesic_toolkit.domains import Domain

__all__ = [
    "BoundaryChoice",
    "Cost",
    "Folder",
    "Input",
    "Inputs",
    "Json",
    "MarkedVertices",
    "Mask",
    "Operator",
    "Refine",
    "Solver",
    "TimeFactor",
    "Weld",
    "all_existing",
    "check_plugins",
    "check_positions",
    "check_reach",
    "check_thin",
    "check_time",
    "files_of",
    "find_marked",
    "kinds_of",
    "parse_sources",
]


def _existing(path: Path) -> Path:
    """Return a path of a file that exists, or that is a stream."""
    if is_stream(path):
        return path
    if not os.access(path, os.F_OK):
        raise typer.BadParameter(f"File {str(path)!r} does not exist.")
    if path.is_dir():
        raise typer.BadParameter(f"File {str(path)!r} is a directory.")
    if not os.access(path, os.R_OK):
        raise typer.BadParameter(f"File {str(path)!r} is not readable.")
    return path


def all_existing(paths: list[Path] | None) -> list[Path]:
    """Return paths of files that exist, or that are streams; none for None.

    Raises
    ------
    typer.BadParameter
        A file does not exist, is a directory, or cannot be read.
    """
    return [_existing(path) for path in paths or ()]


Input = Annotated[
    Path,
    typer.Argument(
        callback=_existing,
        metavar="INPUT",
        help="A mesh, point cloud or graph; - reads standard input.",
        show_default=False,
    ),
]

Inputs = Annotated[
    list[Path],
    typer.Argument(
        callback=all_existing,
        metavar="INPUT",
        help="Meshes, point clouds or graphs; - reads standard input.",
        show_default=False,
    ),
]


@dataclass(frozen=True)
class MarkedVertices:
    """A file that marks vertices, and the chosen region of it."""

    path: Path
    region: str | None = None

    def mask(self, n_vertices: int) -> "BoolArray":
        """Return a mask of N vertices, true at the marked ones."""
        from geodesic_toolkit.io import read_mask

        return read_mask(self.path, n_vertices, region=self.region)

    def __str__(self) -> str:
        return str(self.path) if self.region is None else f"{self.path}:{self.region}"


def find_marked(text: str) -> MarkedVertices | None:
    """Return the file that ``FILE`` or ``FILE:REGION`` names; None if it does not exist."""
    if _is_file(text):
        return MarkedVertices(Path(text))
    file, colon, region = text.rpartition(":")
    return MarkedVertices(Path(file), region) if colon and _is_file(file) else None


def _is_file(text: str) -> bool:
    # pathlib alone raises for names that are too long, and for folders that may not be entered.
    return os.access(text, os.F_OK) and Path(text).is_file()


def files_of(mask: MarkedVertices | None, places: Sequence[str] = ()) -> list[Path]:
    """Return the files of vertices among a mask and the places typed."""
    return [file.path for file in (mask, *map(find_marked, places)) if file is not None]


def _marked(text: str) -> MarkedVertices:
    found = find_marked(text)
    if found is None:
        raise typer.BadParameter(f"File {text!r} does not exist.")
    return found


Mask = Annotated[
    MarkedVertices | None,
    typer.Option(
        parser=_marked,
        metavar="FILE",
        help="Vertices that no path may cross: an .npy, .txt or .csv file with 1 or 0 for each "
        "vertex, or the indices of those that are masked; a FreeSurfer .label; an .annot or "
        ".label.gii with its region, as in lh.aparc.annot:unknown. Their distance is inf.",
    ),
]

Operator = Annotated[
    str, typer.Option(metavar="NAME", help="Laplace operator; see the command plugins.")
]

Solver = Annotated[
    str, typer.Option(metavar="NAME", help="Linear solver; see the command plugins.")
]

Refine = Annotated[
    bool | None,
    typer.Option(
        "--refine/--no-refine",
        help="Sweep wavefronts over the triangles in the order of the heat, or stay with plain "
        "heat, the paper's own result. Refined distances, which are several times more accurate, "
        "are the default on meshes and clouds.",
        show_default=False,
    ),
]

TimeFactor = Annotated[
    float | None,
    typer.Option(
        metavar="M",
        help="Time step in squared mean edge lengths: 1 unless given; more is smoother.",
        show_default=False,
    ),
]

Folder = Annotated[Path, typer.Option(metavar="DIR", file_okay=False, help="Where the files go.")]

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]


def _tolerance(weld: float | None) -> float | None:
    if weld is not None and not (weld >= 0 and math.isfinite(weld)):
        raise InvalidOptionError(f"--weld must be finite and not negative, not {weld:g}")
    return weld


Weld = Annotated[
    float | None,
    typer.Option(
        callback=_tolerance,
        metavar="TOL",
        help="Merge vertices of a mesh that are no farther apart than this, in its unit, so that "
        "paths cross seams: 0 for those at the same position. Inputs and outputs still use the "
        "vertices of the file.",
        show_default=False,
    ),
]


Cost = Annotated[
    Path | None,
    typer.Option(
        exists=True,
        dir_okay=False,
        readable=True,
        metavar="FILE",
        help="Time that a unit of length takes: an .npy, .txt or .csv file with a positive number "
        "for each face, or for each vertex, of a mesh. Distances are then travel times.",
        show_default=False,
    ),
]


class BoundaryChoice(StrEnum):
    """Boundary conditions of the heat."""

    neumann = "neumann"
    dirichlet = "dirichlet"
    average = "average"


def parse_sources(texts: Sequence[str]) -> list[int] | list[list[float]]:
    """Return vertex indices, or points in space, from the texts typed: all of one kind.

    A file of vertices, ``FILE`` or ``FILE:REGION``, stands for the vertices that it marks.

    Raises
    ------
    InvalidSourceError
        Not a whole number, three numbers or a file; or vertices and points mixed.
    ReadError
        The file cannot be read.
    """
    parsed = [source for text in texts for source in _parse_source(text)]
    vertices = [source for source in parsed if isinstance(source, int)]
    points = [source for source in parsed if not isinstance(source, int)]
    if vertices and points:
        raise InvalidSourceError(
            f"--source {vertices[0]} is a vertex and --source {','.join(map(str, points[0]))} "
            "is a point; give all of one kind"
        )
    return vertices or points


def _parse_source(text: str) -> list[int] | list[list[float]]:
    try:
        if "," not in text:
            return [int(text)]
        point = [float(part) for part in text.split(",")]
    except ValueError:
        point = []
    if len(point) != 3:
        if (marked := find_marked(text)) is not None:
            from geodesic_toolkit.io import read_vertices

            vertices: list[int] = read_vertices(marked.path, region=marked.region).tolist()
            return vertices
        raise InvalidSourceError(
            f"--source {text} is neither a vertex index such as 500, nor a point such as "
            '"0.1,0.2,0", nor a file of vertices such as lh.V1.label'
        )
    if not all(map(math.isfinite, point)):
        raise InvalidSourceError(f"--source {text} is not finite")
    return [point]


def check_time(time: float | None, time_factor: float | None) -> None:
    """Raise an `InvalidOptionError` unless at most one of them is given, positive and finite."""
    if time is not None and time_factor is not None:
        raise InvalidOptionError("give --time or --time-factor, not both")
    for option, value in (("--time", time), ("--time-factor", time_factor)):
        if value is not None and not (value > 0 and math.isfinite(value)):
            raise InvalidOptionError(f"{option} must be positive and finite, not {value:g}")


def check_reach(reach: float | None, at: Path | None) -> None:
    """Raise an `InvalidOptionError` for a reach without points, or one that is not positive."""
    if reach is not None and at is None:
        raise InvalidOptionError("--reach needs points: give --at too")
    if reach is not None and not reach > 0:
        raise InvalidOptionError(f"--reach must be positive, not {reach:g}")


def check_thin(thin: float | None, mask: object) -> None:
    """Raise an `InvalidOptionError` for a spacing that is not valid, or beside a mask."""
    if thin is not None and not (thin > 0 and math.isfinite(thin)):
        raise InvalidOptionError(f"--thin must be positive and finite, not {thin:g}")
    if thin is not None and mask is not None:
        raise InvalidOptionError(
            "--thin and --mask cannot be given together: thinned points do not hold a barrier"
        )


def check_positions(domain: "Domain") -> None:
    """Raise an `InvalidOptionError` if `domain` has no positions, to which points could be near."""
    if not domain.has("positions"):
        raise InvalidOptionError(
            f"--at: {a_kind_of(domain)} has no positions to measure at; omit --at"
        )


def kinds_of(operator: str) -> "tuple[type[Domain], ...]":
    """Return the kinds of domain that a named operator takes; none where it is "auto"."""
    from geodesic_toolkit.registry import catalog

    return () if operator == "auto" else catalog.operators[operator].domains


def check_plugins(solver: str, *operators: str | None) -> None:
    """Raise a `PluginError` unless the solver and the operators are installed and load.

    A process that only helps with the linear systems of another one does so, and exits.
    """
    from geodesic_toolkit.registry import catalog

    solvers = catalog.resolve_solvers(solver)
    for operator in operators:
        if operator is not None and operator != "auto":
            catalog.operators.resolve(operator)
    if not all(each.leads() for each in solvers):
        raise typer.Exit
