"""The linear solver of a matrix, settled once: "auto" may change its mind, and the last bit too."""

import copy
from collections.abc import Mapping

from geodesic_toolkit.linear.base import LinearSolver
from geodesic_toolkit.linear.superlu import SuperLU
from geodesic_toolkit.linear.supernodal import Supernodal
from geodesic_toolkit.solver import GeodesicSolver

__all__ = ["as_begun", "settled"]


def _interchangeable() -> list[LinearSolver]:
    """Return those between which "auto" chooses, by size and by what is compiled at the time.

    Distances agree to the rounding of a compact factor.
    """
    return [SuperLU(), Supernodal(), Supernodal(compact=True)]


def settled(solver: GeodesicSolver, n_sources: int) -> GeodesicSolver:
    """Return the solver as it is best for so many sources, whose linear solver stays what it is.

    In tasks and in other processes it would decide anew, by fewer sources and what is loaded there.
    """
    solver._hasten(n_sources)  # noqa: SLF001 - asked for all sources at once, which no task has
    fixed = copy.copy(solver)
    fixed._automatic = False  # noqa: SLF001
    return fixed


def as_begun(solver: GeodesicSolver, then: Mapping[str, str]) -> GeodesicSolver:
    """Return the solver with the linear solver that an unfinished matrix was begun with.

    Parameters
    ----------
    solver : GeodesicSolver
    then : mapping of str to str
        The request of that matrix.

    Returns
    -------
    GeodesicSolver
        The same one where its linear solver is no matter of choice: a difference is then one of
        the request.
    """
    known = {repr(candidate): candidate for candidate in _interchangeable()}
    before = {then.get("heat solver", ""), then.get("Poisson solver", "")}
    now = {repr(solver.method.heat_solver), repr(solver.method.poisson_solver)}
    if before == now or len(before) > 1 or not (before | now) <= known.keys():
        return solver
    changed = copy.copy(solver)
    changed.method = solver.method.with_solver(known[before.pop()])
    return changed
