"""Operators, linear solvers and readers by name, those of plugins among them.

Imports the base classes of laplacians and linear solvers; built-in ones are found when asked for.
"""

from geodesic_toolkit.registry.registry import PluginStatus, Registry

__all__ = ["PluginStatus", "Registry"]
