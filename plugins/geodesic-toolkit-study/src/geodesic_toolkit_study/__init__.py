"""The experiments of a first implementation of the heat method, repeated, explained, surpassed.

:func:`run_study` runs them on any triangle mesh and writes figures, tables and conclusions.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from geodesic_toolkit_study.run import run_study

__all__ = ["run_study"]


def __getattr__(name: str) -> Any:
    if name == "run_study":  # heavy, and `geodesic-toolkit --help` imports the package
        from geodesic_toolkit_study.run import run_study

        return run_study
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
