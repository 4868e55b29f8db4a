"""The experiments of a first implementation of the heat method, repeated, explained, surpassed.

:func:`run_study` runs them on any triangle mesh and writes figures, tables and conclusions.
"""

from geodesic_toolkit.study.run import run_study

__all__ = ["run_study"]
