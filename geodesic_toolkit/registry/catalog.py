"""The registries, and the meaning of "auto"."""

from typing import Any

from geodesic_toolkit.core.checks import is_one_of
from geodesic_toolkit.domains import Domain, Graph, MeasuredFaces, PointCloud, TriangleMesh
from geodesic_toolkit.errors import InvalidOptionError, PluginLoadError, UnsupportedDomainError
from geodesic_toolkit.laplacians.base import LaplaceOperator
from geodesic_toolkit.laplacians.cotan import CotanLaplacian
from geodesic_toolkit.linear.base import LinearSolver
from geodesic_toolkit.linear.supernodal import Supernodal
from geodesic_toolkit.registry.registry import Registry
from geodesic_toolkit.registry.writer import Writer

__all__ = ["operators", "readers", "resolve_operator", "resolve_solvers", "solvers", "writers"]


def _subclass_of(base: type) -> Any:
    def accepts(plugin: object) -> str | None:
        if isinstance(plugin, type) and issubclass(plugin, base):
            return None
        return f"{plugin!r} is not a subclass of {base.__name__}"

    return accepts


def _is_callable(plugin: object) -> str | None:
    return None if callable(plugin) else f"{plugin!r} cannot be called"


def _is_writer(plugin: object) -> str | None:
    return None if isinstance(plugin, Writer) else f"{plugin!r} is not a Writer"


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

writers: Registry[Writer] = Registry("geodesic_toolkit.writers", "writer", _is_writer)
"""Writers of distances by file suffix without its dot, for kinds of domain of plugins."""

MIN_UNKNOWNS_OF_COMPACT_FACTOR = 20_000
"""Number of unknowns from which on factors are compact. A solve then takes 0.97 of the time at
3,485 unknowns, 0.80 at 13,934, 0.79 at 34,834 and 0.77 at 55,730 (bunny.off, its subdivisions, and
a scan): larger factors exceed the processor's cache, and small ones keep all digits."""


def resolve_operator(choice: object, domain: Domain) -> LaplaceOperator:
    """Return the operator for a name, class, instance or "auto".

    For a kind of domain that is not in the core, "auto" chooses the installed operator that has
    this class among its `domains`, or else the nearest base class; of several such operators, the
    first by name.

    Raises
    ------
    UnsupportedDomainError
        The choice is "auto", and no installed operator supports this kind of domain.
    """
    if not is_one_of(choice, ("auto",)):
        operator: LaplaceOperator = operators.resolve(choice)
        return operator
    # The core's own operators are not looked up by name: scanning all installed distributions
    # takes as long as a mesh of 10,000 vertices.
    if isinstance(domain, TriangleMesh | MeasuredFaces):
        return CotanLaplacian(intrinsic_delaunay="auto")
    if isinstance(domain, PointCloud):
        from geodesic_toolkit.laplacians.pointcloud.operator import PointCloudLaplacian

        return PointCloudLaplacian()
    if isinstance(domain, Graph):
        from geodesic_toolkit.laplacians.uniform import UniformLaplacian

        return UniformLaplacian()
    return _operator_of_kind(type(domain))


def _operator_of_kind(kind: type[Domain]) -> LaplaceOperator:
    """Return the installed operator that is closest to a kind of domain."""
    found: list[tuple[int, str]] = []
    broken = []
    for name in operators:
        try:
            taken = operators[name].domains
        except PluginLoadError:  # skip a broken plugin; `status` shows it
            broken.append(name)
            continue
        steps = [step for step, parent in enumerate(kind.__mro__) if parent in taken]
        if steps:
            found.append((steps[0], name))
    if found:
        return operators[min(found)[1]]()
    others = f"; {', '.join(broken)} does not load, see geodesic-toolkit plugins" if broken else ""
    raise UnsupportedDomainError(
        f"no installed operator discretizes a {kind.__name__} (installed: {', '.join(operators)}"
        f"{others}); an operator that does names {kind.__name__} in its attribute domains"
    )


def resolve_solvers(
    choice: object, n_unknowns: int = 0, *, refine: bool = False
) -> tuple[LinearSolver, LinearSolver]:
    """Return the solvers for the heat and the Poisson step.

    Parameters
    ----------
    choice : str, class, instance or dict
        One for both steps, or ``{"heat": ..., "poisson": ...}``. "auto" is ``"supernodal"``. A
        solver that is not componentwise accurate is used for the Poisson step only, with the
        solver that it names for the heat (`LinearSolver.for_heat`), or "auto".
    n_unknowns : int
        Size of the systems; "auto" uses it to decide whether factors are compact.
    refine : bool
        Whether only the order of the heat is used, for which six digits are enough at any size.

    Raises
    ------
    InvalidOptionError
        The dictionary has other keys.
    """
    compact = bool(refine) or n_unknowns >= MIN_UNKNOWNS_OF_COMPACT_FACTOR
    if isinstance(choice, dict):
        unknown = set(choice) - {"heat", "poisson"}
        if unknown:
            raise InvalidOptionError(
                f'solver needs the keys "heat" and "poisson", not {", ".join(map(repr, unknown))}'
            )
        parts = (choice.get("heat", "auto"), choice.get("poisson", "auto"))
        return _solver(parts[0], compact), _solver(parts[1], compact)
    solver = _solver(choice, compact)
    return solver.for_heat() or _solver("auto", compact), solver


def _solver(choice: object, compact: bool) -> LinearSolver:
    if is_one_of(choice, ("auto",)):
        return Supernodal(compact=compact)
    solver: LinearSolver = solvers.resolve(choice)
    return solver
