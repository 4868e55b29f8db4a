"""Plugins add commands to the program."""

from typing import Annotated

import pytest
import typer
from command_line import fails, run

import geodesic_toolkit as gt
from geodesic_toolkit.cli.extensions import commands
from geodesic_toolkit.errors import PluginLoadError


def greet(name: str, *, times: Annotated[int, typer.Option(min=1)] = 1) -> None:
    """Greet a person."""
    for _ in range(times):
        typer.echo(f"hello {name}")


def test_a_function_becomes_a_command_with_its_options(register):
    register(commands, "greet", greet)
    result = run("greet", "Ada", "--times", 2)
    assert (result.exit_code, result.stdout) == (0, "hello Ada\nhello Ada\n")
    assert "greet" in run("--help").stdout
    assert "Greet a person." in run("greet", "-h").stdout
    fails(run("greet", "Ada", "--times", 0), 2, "--times")


def test_what_a_command_raises_is_an_exit_status(register):
    def broken() -> None:
        raise gt.errors.InvalidOptionError("three is not a colour")

    register(commands, "broken", broken)
    fails(run("broken"), 2, "three is not a colour")


def test_a_command_of_the_core_is_not_replaced(register):
    register(commands, "doctor", greet)
    assert run("doctor", "--help").stdout.count("Greet") == 0
    assert run("--help").stdout.count("  doctor ") == 1


def test_a_command_that_does_not_load_hurts_only_itself(monkeypatch):
    monkeypatch.setattr(commands, "_local", [*commands._local])
    commands.register("torn", greet)
    entry = commands._local[-1]

    def load():
        raise ImportError("no such wheel")

    entry.load, entry.loaded = load, None
    shown = run("--help")
    assert shown.exit_code == 0
    assert "torn" not in shown.stdout
    result = run("torn")
    assert result.exit_code != 0
    assert "no such wheel" in result.stderr
    assert "no such wheel" in run("plugins").stdout


def test_a_command_must_be_a_function():
    with pytest.raises(PluginLoadError, match="cannot be called"):
        commands.register("three", 3)


def test_a_command_that_is_not_installed_says_what_has_it(monkeypatch):
    monkeypatch.setattr(commands, "_discovered", [])
    fails(run("study", "mesh.off"), 2, "pip install geodesic-toolkit-study")


def test_an_unknown_command_is_wrong_usage():
    result = run("stdy")
    assert result.exit_code == 2
    assert "No such command" in result.stderr
