"""The registries themselves, and what "auto" means."""

from typing import Any

from geodesic_toolkit._kernels import worthwhile
from geodesic_toolkit.domains import Domain, Graph, PointCloud, TriangleMesh
from geodesic_toolkit.errors import InvalidOptionError, PluginLoadError, UnsupportedDomainError
from geodesic_toolkit.laplacians.base import LaplaceOperator
from geodesic_toolkit.linear.base import LinearSolver
from geodesic_toolkit.linear.supernodal import Supernodal
from geodesic_toolkit.registry import Registry

__all__ = ["fast_solver", "operators", "readers", "resolve_operator", "resolve_solvers", "solvers"]


def _subclass_of(base: type) -> Any:
    def accepts(plugin: object) -> str | None:
        if isinstance(plugin, type) and issubclass(plugin, base):
            return None
        return f"{plugin!r} is not a subclass of {base.__name__}"

    return accepts


def _is_callable(plugin: object) -> str | None:
    return None if callable(plugin) else f"{plugin!r} cannot be called"


operators: Registry[type[LaplaceOperator]] = Registry(
    "geodesic_toolkit.operators",
    "operator",
    _subclass_of(LaplaceOperator),
    {"robust": "geodesic-toolkit-robust"},
)
"""Laplace operators by name."""

solvers: Registry[type[LinearSolver]] = Registry(
    "geodesic_toolkit.solvers", "solver", _subclass_of(LinearSolver)
)
"""Linear solvers by name."""

readers: Registry[Any] = Registry("geodesic_toolkit.readers", "reader", _is_callable)
"""Functions from a path to a domain, by file suffix without its dot."""

PREFERRED = {TriangleMesh: "cotan", PointCloud: "pointcloud", Graph: "uniform"}
"""The operator that "auto" takes for the domains of the core."""

AUTO_OPTIONS: dict[str, dict[str, Any]] = {"cotan": {"intrinsic_delaunay": "auto"}}
"""Options that "auto" adds to it."""

COMPACT = 20_000
"""Unknowns from which on a factor does not stay in the processor's cache, and half of it pays."""


def resolve_operator(choice: object, domain: Domain) -> LaplaceOperator:
    """Return the operator for a name, class, instance or "auto".

    Raises
    ------
    UnsupportedDomainError
        "auto", and no installed operator takes this kind of domain.
    """
    if choice != "auto":
        operator: LaplaceOperator = operators.resolve(choice)
        return operator
    for kind, name in PREFERRED.items():
        if isinstance(domain, kind):
            return operators[name](**AUTO_OPTIONS.get(name, {}))
    for name in operators:
        try:
            candidate = operators[name]
        except PluginLoadError:  # a broken plugin hurts only itself; `status` shows it
            continue
        if isinstance(domain, candidate.domains):
            return candidate()
    raise UnsupportedDomainError(
        f"no installed operator discretizes a {type(domain).__name__} "
        f"(installed: {', '.join(operators)})"
    )


def resolve_solvers(choice: object, n_unknowns: int = 0) -> tuple[LinearSolver, LinearSolver]:
    """Return the solvers for the heat and the Poisson step.

    Parameters
    ----------
    choice : str, class, instance or dict
        One for both steps, or ``{"heat": ..., "poisson": ...}``. "auto" is ``"supernodal"`` where
        its compiled kernels are worth waiting for, and ``"superlu"`` elsewhere. A solver that is
        not componentwise accurate serves the Poisson step only, beside the default one.
    n_unknowns : int
        Size of the systems, by which "auto" decides.

    Raises
    ------
    InvalidOptionError
        A dictionary with other keys.
    """
    if isinstance(choice, dict):
        unknown = set(choice) - {"heat", "poisson"}
        if unknown:
            raise InvalidOptionError(
                f'solver has the keys "heat" and "poisson", not {", ".join(map(repr, unknown))}'
            )
        parts = (choice.get("heat", "auto"), choice.get("poisson", "auto"))
        return _solver(parts[0], n_unknowns), _solver(parts[1], n_unknowns)
    solver = _solver(choice, n_unknowns)
    if solver.componentwise or getattr(solver, "allow_heat", False):
        return solver, solver
    return _solver("auto", n_unknowns), solver


def _solver(choice: object, n_unknowns: int) -> LinearSolver:
    if choice == "auto":
        return fast_solver(n_unknowns) if worthwhile(n_unknowns) else solvers["superlu"]()
    solver: LinearSolver = solvers.resolve(choice)
    return solver


def fast_solver(n_unknowns: int) -> LinearSolver:
    """Return the solver that "auto" prefers once its kernels are there."""
    return Supernodal(compact=n_unknowns >= COMPACT)
