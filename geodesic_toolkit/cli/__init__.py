"""The command line: one module a command, and what they share."""

from geodesic_toolkit.cli.program import app, main

__all__ = ["app", "main"]
