"""``geodesic-toolkit explain``: the cause and the cure of an error or a warning."""

import inspect
import re
from typing import Annotated

import typer

from geodesic_toolkit import errors
from geodesic_toolkit.cli.arguments import Json
from geodesic_toolkit.cli.output import aligned, one_line, show, show_json
from geodesic_toolkit.errors import InvalidOptionError

__all__ = ["explain"]

ROLE = re.compile(r":\w+:`/?([^`]*)`")
"""A reference of Sphinx, which a terminal shows as its target."""


def explain(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME",
            help="The name in brackets at the end of a message, such as InvalidSourceError.",
            show_default=False,
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Explain an error or a warning: its cause and its cure; without NAME, list all of them."""
    if name is not None and name not in errors.__all__:
        raise InvalidOptionError(
            f"{name} is not an error or a warning of this package; geodesic-toolkit explain lists "
            "all of them"
        )
    texts = {one: _text(one) for one in ([name] if name else errors.__all__)}
    if json:
        show_json({"messages": texts})
    elif name:
        show(texts[name])
    else:
        for line in aligned([(one, text.partition("\n")[0]) for one, text in texts.items()]):
            show(line)


def _text(name: str) -> str:
    """Return the docstring of a class as paragraphs of plain text."""
    text = getattr(errors, name).__doc__
    if text is None:
        raise InvalidOptionError("Python drops the texts with -OO, or PYTHONOPTIMIZE=2: omit it")
    text = inspect.cleandoc(text)
    paragraphs = re.sub(r"\nNotes\n-+\n", "\n", text).split("\n\n")
    plain = [ROLE.sub(r"\1", one).replace("``", "").replace("*", "") for one in paragraphs]
    return "\n\n".join(one_line(one) for one in plain)
