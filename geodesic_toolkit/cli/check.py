"""``geodesic-toolkit check``: measure whether a plugin obeys the laws of its contract."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from geodesic_toolkit.cli.arguments import Json
from geodesic_toolkit.cli.output import aligned, show, show_json, versions
from geodesic_toolkit.cli.run import running

if TYPE_CHECKING:
    from geodesic_toolkit.testing import ConformanceReport, Outcome

__all__ = ["check"]

BROKEN = 1
"""Exit status if a law is broken."""

Name = Annotated[
    str,
    typer.Argument(
        metavar="NAME",
        help="An operator or a solver; operator:NAME or solver:NAME if the name is ambiguous.",
    ),
]


def check(name: Name, json: Json = False) -> None:
    """Check an operator or a solver against its contract; exit status 1 if a law is broken.

    For an operator on a kind of domain of its own, that kind is checked as well.
    """
    with running() as run, run.step(f"checking {name}"):
        kind, report = _checked(name)
    if json:
        content = {"kind": kind, "name": name, **report.as_dict()}
        show_json({**content, "warnings": run.warnings, "versions": versions()})
    else:
        _show_report(kind, report)
    if not report.ok:
        raise typer.Exit(BROKEN)


def _checked(name: str) -> tuple[str, "ConformanceReport"]:
    """Return the kind of a plugin, and the report on it with its default options."""
    from geodesic_toolkit import testing
    from geodesic_toolkit.registry import catalog

    kind, short = _kind_and_name(name, catalog.operators, catalog.solvers)
    if kind == "solver":
        solver = catalog.solvers.resolve(short)
        return kind, testing.run_checks(solver, testing.linear_solver_checks(solver))
    operator = catalog.operators.resolve(short)
    checks = testing.laplace_operator_checks(operator)
    for own in operator.domains:
        if own.has("samples"):  # a kind of domain that comes with the operator
            checks += testing.domain_checks(own.samples().generic)
    return kind, testing.run_checks(operator, checks)


def _kind_and_name(name: str, operators: Any, solvers: Any) -> tuple[str, str]:
    """Return the registry that has the plugin, and the name without its prefix.

    Raises
    ------
    PluginConflictError
        The name is that of an operator and of a solver.
    """
    from geodesic_toolkit.errors import PluginConflictError, UnknownPluginError

    prefix, colon, short = name.partition(":")
    if colon and prefix in ("operator", "solver"):
        return prefix, short
    if name in operators and name in solvers:
        raise PluginConflictError(
            f"{name!r} is an operator and a solver; ask for operator:{name} or solver:{name}"
        )
    if name not in operators and name not in solvers:
        raise UnknownPluginError(
            f"no operator or solver {name!r} (operators: {', '.join(operators)}; "
            f"solvers: {', '.join(solvers)})"
        )
    return ("solver" if name in solvers else "operator"), name


def _show_report(kind: str, report: "ConformanceReport") -> None:
    table = [("LAW", "FIGURE", "BOUND", "RESULT")]
    table += [
        (row.law, _number(row.figure), _number(row.bound), _result(row)) for row in report.outcomes
    ]
    for line in aligned(table):
        show(line)
    good = len(report.outcomes) - len(report.broken)
    show(f"\n{kind} {report.subject}: {good} of {len(report.outcomes)} laws as expected")
    for row in report.broken:
        show(f"\n{row}")


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def _result(row: "Outcome") -> str:
    if row.expected_failure is not None:
        return "holds unexpectedly" if row.held else f"fails as declared: {row.expected_failure}"
    if row.applies:
        return "ok" if row.held else "BROKEN"
    return "does not apply"
