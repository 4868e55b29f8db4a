"""The command line: one module per command, and shared modules."""

from geodesic_toolkit.cli.program import app, main

__all__ = ["app", "main"]
