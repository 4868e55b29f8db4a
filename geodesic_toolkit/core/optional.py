"""Packages of the optional extras: imported where they are used, and asked for by name."""

import importlib
from typing import Any

from geodesic_toolkit.errors import MissingDependencyError

__all__ = ["optional"]


def optional(module: str, extra: str, purpose: str) -> Any:
    """Import and return a module of an extra.

    Parameters
    ----------
    module : str
        Its name, with that of its package.
    extra : str
        The extra of this project that installs it.
    purpose : str
        What needs it, with the verb and the package: "writing .zarr stores needs zarr".

    Raises
    ------
    MissingDependencyError
        It is not installed, or does not import.

    Examples
    --------
    >>> from geodesic_toolkit.core.optional import optional
    >>> optional("no_such_package", "viz", "drawing needs it")
    Traceback (most recent call last):
        ...
    geodesic_toolkit.errors.MissingDependencyError: drawing needs it (No module named \
'no_such_package'): pip install "geodesic-toolkit[viz]"
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise MissingDependencyError(
            f'{purpose} ({error}): pip install "geodesic-toolkit[{extra}]"'
        ) from error
