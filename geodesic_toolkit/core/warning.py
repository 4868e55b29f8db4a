"""Warnings that point at the caller's line, wherever in the package they arise."""

import inspect
import warnings

__all__ = ["warn"]

PACKAGE = __name__.partition(".")[0] + "."


def warn(text: str, category: type[Warning]) -> None:
    """Issue a warning that names the line outside this package which led to it."""
    level, frame = 1, inspect.currentframe()
    while frame is not None and frame.f_globals.get("__name__", "").startswith(PACKAGE):
        level, frame = level + 1, frame.f_back
    warnings.warn(text, category, stacklevel=level)
