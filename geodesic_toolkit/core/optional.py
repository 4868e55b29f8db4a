"""Packages of the optional extras: imported where they are used, with an error if missing."""

import importlib
from typing import Any

from geodesic_toolkit.errors import MissingDependencyError

__all__ = ["require"]

PACKAGES = {"vtkmodules": "vtk"}
"""Names of distributions whose modules have other names."""


def require(module: str, extra: str, purpose: str) -> Any:
    """Import and return a module of an extra.

    Parameters
    ----------
    module : str
        The full name of the module, with its package.
    extra : str
        The extra of this project that installs it.
    purpose : str
        Its purpose, as the subject and the verb of the message.

    Raises
    ------
    MissingDependencyError
        The module is not installed, or does not import.

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
