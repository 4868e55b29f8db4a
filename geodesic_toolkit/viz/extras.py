"""Optional packages, asked for by name where they are missing."""

import importlib
from typing import Any

from geodesic_toolkit.errors import MissingDependencyError

__all__ = ["require"]


def require(module: str, extra: str, purpose: str) -> Any:
    """Import and return `module`.

    Raises
    ------
    MissingDependencyError
        It is not installed, or does not import; the message names the extra that has it.
    """
    package = module.partition(".")[0]
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise MissingDependencyError(
            f"{purpose} need {package}, which does not import ({error}); "
            f'install it with: pip install "geodesic-toolkit[{extra}]"'
        ) from error
