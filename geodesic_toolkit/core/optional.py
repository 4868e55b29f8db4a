"""Packages of the optional extras: imported where they are used, and asked for by name."""

import importlib
from typing import Any

from geodesic_toolkit.errors import MissingDependencyError

__all__ = ["require"]

PACKAGES = {"vtkmodules": "vtk"}
"""Distributions whose modules are called otherwise."""


def require(module: str, extra: str, purpose: str) -> Any:
    """Import and return a module of an extra.

    Parameters
    ----------
    module : str
        With the name of its package.
    extra : str
        That of this project which installs it.
    purpose : str
        What it is for, as the subject and the verb of the message.

    Raises
    ------
    MissingDependencyError
        It is not installed, or does not import.

    Examples
    --------
    >>> from geodesic_toolkit.core.optional import require
    >>> require("vtkmodules.none", "viz", "Pictures need")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    geodesic_toolkit.errors.MissingDependencyError: Pictures need vtk: pip install ...
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise MissingDependencyError(
            f"{purpose} {PACKAGES.get(package, package)}: "
            f'pip install "geodesic-toolkit[{extra}]" ({error})'
        ) from error
