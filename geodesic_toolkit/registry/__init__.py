"""Operators, linear solvers and readers by name, including those of plugins.

Imports the base classes of laplacians and linear solvers; built-in ones are found on demand.
"""

from geodesic_toolkit.registry.registry import PluginStatus, Registry

__all__ = ["PluginStatus", "Registry"]
