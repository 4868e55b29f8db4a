"""Operators, linear solvers and readers by name, including those of plugins.

Imports laplacians and linear solvers, for the meaning of "auto"; plugins are loaded on demand.
"""

from geodesic_toolkit.registry.registry import PluginStatus, Registry

__all__ = ["PluginStatus", "Registry"]
