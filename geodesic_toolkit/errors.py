"""Errors and warnings: one root each; every error also derives from the fitting builtin.

Catching :class:`GeodesicError` catches all of them; catching the builtin
(``ValueError`` for bad data, ``IndexError`` for a bad source, ...) works too.
"""

__all__ = [
    "CoarseMeshWarning",
    "ConformanceError",
    "ContractibleLoopError",
    "CurveWarning",
    "FarSourceWarning",
    "FragmentedCloudWarning",
    "GeodesicError",
    "GeodesicWarning",
    "InvalidCurveError",
    "InvalidDiscretizationError",
    "InvalidDomainError",
    "InvalidOptionError",
    "InvalidSourceError",
    "MissingDependencyError",
    "NonPositiveHeatWarning",
    "NormalsWarning",
    "NotEnoughMemoryError",
    "PluginConflictError",
    "PluginError",
    "PluginLoadError",
    "ReadError",
    "ReadWarning",
    "SeamWarning",
    "SolverError",
    "UnevenCloudWarning",
    "UnknownPluginError",
    "UnreachableError",
    "UnsupportedDomainError",
    "WriteError",
]


class GeodesicError(Exception):
    """Root of every error that this package raises deliberately."""


class InvalidDomainError(GeodesicError, ValueError):
    """The data of a mesh, cloud or graph are invalid: the message names the first bad element."""


class UnsupportedDomainError(GeodesicError, TypeError):
    """The chosen operator or function does not support this kind of domain, or its state."""


class InvalidSourceError(GeodesicError, IndexError):
    """Sources that do not name points of the domain."""


class InvalidCurveError(InvalidSourceError):
    """A curve that does not follow the surface; the message says which, and where it leaves it."""


class UnreachableError(GeodesicError, ValueError):
    """No path connects two points between which one was requested."""


class ContractibleLoopError(GeodesicError, ValueError):
    """A loop that shrinks to a point, where a closed geodesic was asked for."""


class InvalidOptionError(GeodesicError, ValueError):
    """An option has a value outside its allowed ones."""


class InvalidDiscretizationError(GeodesicError, ValueError):
    """An operator returned data that break the contract of a discretization."""


class ReadError(GeodesicError, ValueError):
    """A file cannot be read as a mesh, cloud or graph."""


class WriteError(GeodesicError, OSError):
    """An output cannot be written; an existing file is unchanged."""


class MissingDependencyError(GeodesicError, ImportError):
    """An optional package, or a system library that it needs, is missing; the message names it."""


class NotEnoughMemoryError(GeodesicError, MemoryError):
    """The work would not fit into memory; the message has the required size."""


class SolverError(GeodesicError, RuntimeError):
    """A linear solver failed: a singular or indefinite matrix, or no convergence."""


class ConformanceError(GeodesicError, AssertionError):
    """A plugin breaks laws of its contract; the message names each with its figure and bound."""


class PluginError(GeodesicError):
    """Root of the errors of plugins."""


class UnknownPluginError(PluginError, LookupError):
    """There is no plugin of that name; the message lists near misses and installed plugins."""


class PluginLoadError(PluginError, ImportError):
    """A plugin is registered but could not be imported, or does not fit its group."""


class PluginConflictError(PluginError, LookupError):
    """Two distributions register the same name; the message names both."""


class GeodesicWarning(UserWarning):
    """Root of every warning of this package."""


class ReadWarning(GeodesicWarning):
    """A file or object was read with changes, such as polygons split into triangles."""


class CoarseMeshWarning(GeodesicWarning):
    """Plain heat has an error of 4 % or more on a part of a mesh; refined distances are better."""


class CurveWarning(GeodesicWarning):
    """The points of a cloud follow a line, but were treated as a surface."""


class FragmentedCloudWarning(GeodesicWarning):
    """A point cloud is disconnected: points are not connected to some of their neighbours."""


class UnevenCloudWarning(GeodesicWarning):
    """A cloud is sampled too unevenly for plain heat; refined distances are reliable."""


class NonPositiveHeatWarning(GeodesicWarning):
    """The heat is not positive at some vertices, and distances from it are unreliable.

    Refined distances use only the order of the heat, and are not affected.
    """


class FarSourceWarning(GeodesicWarning):
    """A source point is far from the shape to which it was snapped; the units may differ."""


class SeamWarning(GeodesicWarning):
    """The surface of a mesh is cut along seams: boundary edges coincide with others."""


class NormalsWarning(GeodesicWarning):
    """Normals were estimated by a fallback method; the message names the missing package."""
