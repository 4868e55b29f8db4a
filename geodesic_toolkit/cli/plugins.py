"""``geodesic-toolkit plugins``: list the installed plugins, including broken ones."""

from typing import TYPE_CHECKING

from geodesic_toolkit.cli.arguments import Json
from geodesic_toolkit.cli.output import aligned, one_line, show, show_json, versions
from geodesic_toolkit.cli.run import running

if TYPE_CHECKING:
    from geodesic_toolkit.registry.registry import PluginStatus

__all__ = ["plugin_rows", "plugins"]


def plugins(json: Json = False) -> None:
    """List operators, solvers, readers, writers and commands of plugins, including broken ones."""
    with running() as run, run.step("loading the plugins"):
        rows = plugin_rows()
    if json:
        content = [
            {
                "kind": kind,
                "name": row.name,
                "distribution": row.distribution,
                "version": row.version,
                "state": "ok" if row.usable else "error",
                "error": row.error,
                "references": row.references,
                "target": row.target,
            }
            for kind, row in rows
        ]
        show_json({"plugins": content, "warnings": run.warnings, "versions": versions()})
        return
    table = [("KIND", "NAME", "STATE", "VERSION", "DISTRIBUTION", "REFERENCES")]
    for kind, row in rows:
        state = "ok" if row.usable else "error"
        references = " ".join(f"doi:{doi}" for doi in row.references) or "-"
        table.append((kind, row.name, state, row.version or "-", row.distribution, references))
    for line in aligned(table):
        show(line)
    for _, row in rows:
        if row.error is not None:
            show(f"\n{row.name}: {one_line(row.error)}")


def plugin_rows() -> list[tuple[str, "PluginStatus"]]:
    """Return the kind and the status of every plugin; imports all of them."""
    from geodesic_toolkit.cli.extensions import commands
    from geodesic_toolkit.registry import catalog

    registries = (catalog.operators, catalog.solvers, catalog.readers, catalog.writers, commands)
    return [(registry.kind, row) for registry in registries for row in registry.status()]
