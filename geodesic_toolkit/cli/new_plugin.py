"""``geodesic-toolkit new-plugin``: write a distribution with a plugin that works and is tested."""

from pathlib import Path
from typing import Annotated

import typer

from geodesic_toolkit.cli.arguments import Json
from geodesic_toolkit.cli.output import aligned, show, show_json, versions
from geodesic_toolkit.cli.scaffold import PluginKind, check_names, names_of, write_plugin

__all__ = ["new_plugin"]

Name = Annotated[
    str,
    typer.Argument(
        metavar="NAME",
        help="Name of the distribution, and of its folder, as in geodesic-toolkit-hodge.",
        show_default=False,
    ),
]


def new_plugin(
    name: Name,
    *,
    kind: Annotated[PluginKind, typer.Option(help="Kind of plugin.")] = PluginKind.operator,
    directory: Annotated[
        Path,
        typer.Option(
            metavar="DIR", file_okay=False, help="Where the folder of the distribution goes."
        ),
    ] = Path(),
    json: Json = False,
) -> None:
    """Write a distribution with a plugin that works, is typed, and has tests.

    Replace its example by code of your own; the tests check the contract of its kind. The plugin is
    called NAME without geodesic-toolkit-.
    """
    names = names_of(name)
    check_names(names, kind)
    files = write_plugin(kind, names, directory)
    folder = directory / names.distribution
    if json:
        show_json(
            {
                "kind": kind.value,
                "name": names.plugin,
                "distribution": names.distribution,
                "package": names.module,
                "directory": str(folder),
                "outputs": [str(file) for file in files],
                "versions": versions(),
            }
        )
        return
    rows = [
        ("kind", kind.value),
        ("name", names.plugin),
        ("package", names.module),
        *(("written", str(file)) for file in files),
    ]
    for line in aligned(rows):
        show(line)
    show("\nTry it, and then replace the example by code of your own:")
    show(f'  pip install -e "{folder}[test]"')
    show(f'  pytest "{folder}"')
