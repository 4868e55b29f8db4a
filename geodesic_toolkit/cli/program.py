"""The program: its commands, its options, and the one place where errors become exit statuses."""

import io
import sys
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from geodesic_toolkit import __version__
from geodesic_toolkit.cli.check import check
from geodesic_toolkit.cli.commands import add_command
from geodesic_toolkit.cli.compare import compare
from geodesic_toolkit.cli.demo import demo
from geodesic_toolkit.cli.distance import distance
from geodesic_toolkit.cli.doctor import doctor
from geodesic_toolkit.cli.exits import INTERRUPTED, WRONG_USAGE, report
from geodesic_toolkit.cli.explain import explain
from geodesic_toolkit.cli.extensions import command_of, names_of_commands
from geodesic_toolkit.cli.interrupts import leave_soon, prompt_interrupts
from geodesic_toolkit.cli.isolines import isolines
from geodesic_toolkit.cli.logmap import logmap
from geodesic_toolkit.cli.loop import loop
from geodesic_toolkit.cli.matrix import matrix
from geodesic_toolkit.cli.new_plugin import new_plugin
from geodesic_toolkit.cli.output import say, show
from geodesic_toolkit.cli.plugins import plugins
from geodesic_toolkit.cli.signed import signed
from geodesic_toolkit.cli.view import view

__all__ = ["app", "main"]

NAME = "geodesic-toolkit"


class Program(TyperGroup):
    """The group of commands; an error becomes a line on stderr and an exit status.

    Commands of the core are looked up first, so that they do not wait for the plugins.
    """

    def list_commands(self, context: Any) -> list[str]:
        """Return the names of the core's commands and of those of plugins that load."""
        own = super().list_commands(context)
        return [*own, *(name for name in names_of_commands() if name not in own)]

    def get_command(self, context: Any, name: str) -> Any:
        """Return the command of a name, or None."""
        return super().get_command(context, name) or command_of(name)

    def main(self, *args: Any, **options: Any) -> None:
        """Run the command line and leave with its exit status."""
        try:
            options |= {"prog_name": NAME, "standalone_mode": False}
            status = super().main(*args, **options)
        except (Exception, KeyboardInterrupt) as error:  # noqa: BLE001 - the outermost handler
            status = report(error)
        else:
            # The parser turns Ctrl-C into another status, without a message.
            status = report(KeyboardInterrupt()) if status == INTERRUPTED else status
        sys.exit(status or 0)


app = typer.Typer(
    cls=Program,
    name=NAME,
    help="Geodesic distance on meshes, point clouds and graphs, by the heat method.",
    epilog="Results go to stdout, all else to stderr. Exit status: 0 done, 1 a law is broken "
    "(check), 2 wrong usage, 3 bad input, 4 the computation failed. The command explain takes the "
    "name in brackets at the end of a message.",
    invoke_without_command=True,
    rich_markup_mode=None,  # rich would double the time of --help
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _show_version(wanted: bool) -> None:
    if wanted:
        show(f"{NAME} {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    context: typer.Context,
    version: Annotated[  # noqa: ARG001 - its callback acts
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    """Parse the options before a command, and show the help if there is no command."""
    if context.invoked_subcommand is None:
        say(context.get_help())
        raise typer.Exit(WRONG_USAGE)


COMMANDS = (
    demo,
    distance,
    view,
    signed,
    logmap,
    loop,
    isolines,
    matrix,
    compare,
    plugins,
    new_plugin,
    check,
    doctor,
    explain,
)

for command in COMMANDS:
    add_command(app, command)


def main() -> None:
    """Run the program."""
    if isinstance(sys.stdout, io.TextIOWrapper):  # a file name may not be encodable
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        with prompt_interrupts():
            app()
    except SystemExit as leaving:
        if leaving.code == INTERRUPTED:
            leave_soon()
        raise
