"""Commands that plugins add to the program."""

from typing import Any

import typer

from geodesic_toolkit.cli.commands import add_command
from geodesic_toolkit.errors import PluginError
from geodesic_toolkit.registry.registry import Registry

__all__ = ["command_of", "commands", "names_of_commands"]


def _why_not_a_command(plugin: object) -> str | None:
    return None if callable(plugin) else f"{plugin!r} cannot be called"


commands: Registry[Any] = Registry(
    "geodesic_toolkit.commands", "command", _why_not_a_command, {"study": "geodesic-toolkit-study"}
)
"""Functions by the names of their commands; typer reads their signatures, as for the core."""


def names_of_commands() -> list[str]:
    """Return the names of the commands of plugins; a broken plugin is skipped."""
    names = []
    for name in commands:
        try:
            _ = commands[name]
        except PluginError:  # `plugins` shows it
            continue
        names.append(name)
    return names


def command_of(name: str) -> Any:
    """Return a command of a plugin, or None if no known plugin has a command of this name.

    Raises
    ------
    UnknownPluginError
        The plugin is known, but not installed.
    PluginLoadError, PluginConflictError
        The plugin does not load, or there are two.
    """
    if name not in commands and name not in commands.install_hints:
        return None
    program = typer.Typer(add_completion=False, rich_markup_mode=None)
    add_command(program, commands[name], name)
    return typer.main.get_command(program)
