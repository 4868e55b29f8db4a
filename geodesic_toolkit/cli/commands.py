"""A command of the program: a function, with examples in its help, ``--quiet``, and streams."""

import functools
import inspect
from collections.abc import Callable, Sequence
from typing import Annotated, Any

import typer

from geodesic_toolkit.cli.output import quiet as silence
from geodesic_toolkit.cli.streams import streams

__all__ = ["EXAMPLES", "add_command"]

EXAMPLES: dict[str, tuple[str, ...]] = {
    "demo": ("demo", "demo --out somewhere --json"),
    "distance": (
        "distance bunny.off --source 500 --output d.ply --picture d.png",
        "distance bunny.off --source 500 --source 600 --json",
        "distance terrain.ply --source 0 --cost seconds_per_metre.csv --output seconds.ply",
        "distance scan.ply --source 0 --at trees.csv --output trees_with_distance.csv",
        "distance bunny.off scan.ply --source 0 --output {name}.npy",
        "distance - --source 500 --output -.csv < bunny.off > d.csv",
    ),
    "view": ("view bunny.off", "view bunny.off --source 500 --no-open"),
    "signed": (
        "signed bunny.off --curve circle.obj --output d.ply --picture d.png",
        "signed bunny.off scan.ply --curve circle.obj --output {name}.npy",
    ),
    "logmap": (
        "logmap bunny.off --source 500 --output uv.obj --picture uv.png",
        "logmap bunny.off scan.ply --source 500 --output {name}.csv",
    ),
    "loop": (
        "loop torus.ply --through 0,8,16 --output loop.obj --picture loop.png",
        "loop torus.ply ring.ply --through 0,8,16 --output loop_of_{name}.obj",
    ),
    "isolines": (
        "isolines bunny.off --source 500 --level 0.05 --level 0.1 --output circles.obj",
        "isolines bunny.off terrain.ply --source 0 --level 0.1 --output circles_of_{name}.csv",
    ),
    "matrix": (
        "matrix bunny.off --float32 --output D.npy",
        "matrix bunny.off --max-distance 0.1 --output D.npz",
        "matrix bunny.off scan.ply --landmarks 100 --output {name}.npy",
    ),
    "compare": ("compare bunny.off --source 500", "compare bunny.off terrain.ply --source 0"),
    "plugins": ("plugins", "plugins --json"),
    "new-plugin": ("new-plugin geodesic-toolkit-hodge --kind operator",),
    "check": ("check cotan", "check solver:supernodal --json"),
    "doctor": ("doctor", "doctor bunny.off", "doctor bunny.off scan.ply --json"),
    "explain": ("explain", "explain SeamWarning"),
}
"""Command lines by the name of the command, without that of the program."""

Quiet = Annotated[
    bool,
    typer.Option("--quiet", "-q", help="Print results and errors alone: no progress or warnings."),
]


def add_command(app: typer.Typer, function: Callable[..., None], name: str = "") -> None:
    """Add a function to a program as a command.

    Parameters
    ----------
    app : typer.Typer
    function : callable
        Its parameters are those of the command, and its docstring the help.
    name : str
        The name of the command: that of the function with hyphens, unless given.
    """
    name = name or function.__name__.replace("_", "-")
    app.command(name, epilog=_in_help(EXAMPLES.get(name, ())))(_with_quiet(function))


def _in_help(examples: Sequence[str]) -> str | None:
    """Return examples as an epilog whose lines are not wrapped, after a mark of a paragraph."""
    lines = [f"  geodesic-toolkit {line}" for line in examples]
    return "\n".join(["\b", "Examples:", *lines]) if lines else None


def _with_quiet(function: Callable[..., None]) -> Callable[..., None]:
    """Return a function with an option more, which does not reach the function itself."""

    @functools.wraps(function)
    def command(*args: Any, quiet: bool = False, **options: Any) -> None:
        with silence(remarks=quiet), streams(options) as files:
            function(*args, **files)

    own = inspect.signature(function, eval_str=True)
    option = inspect.Parameter(
        "quiet", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=Quiet
    )
    command.__signature__ = own.replace(  # type: ignore[attr-defined]
        parameters=[*own.parameters.values(), option]
    )
    command.__annotations__ = {one.name: one.annotation for one in own.parameters.values()}
    command.__annotations__["quiet"] = Quiet
    return command
