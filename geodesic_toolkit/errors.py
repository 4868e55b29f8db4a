"""Errors and warnings: one root each, and every error is also the builtin that fits it.

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
    """Root of every error that this package raises on purpose."""


class InvalidDomainError(GeodesicError, ValueError):
    """A mesh, cloud or graph that cannot be one: the message names the first bad element."""


class UnsupportedDomainError(GeodesicError, TypeError):
    """A domain of a kind, or in a state, that the chosen operator or function cannot take."""


class InvalidSourceError(GeodesicError, IndexError):
    """Sources that do not name places on the domain."""


class InvalidCurveError(InvalidSourceError):
    """A curve that does not follow the surface; the message says which, and where it leaves it."""


class UnreachableError(GeodesicError, ValueError):
    """Two places that nothing connects, where a way from one to the other was asked for."""


class ContractibleLoopError(GeodesicError, ValueError):
    """A loop that shrinks to a point, where a closed geodesic was asked for."""


class InvalidOptionError(GeodesicError, ValueError):
    """An option outside the values it may have."""


class InvalidDiscretizationError(GeodesicError, ValueError):
    """An operator assembled something that breaks the contract of a discretization."""


class ReadError(GeodesicError, ValueError):
    """A file that cannot be read as a mesh, cloud or graph."""


class WriteError(GeodesicError, OSError):
    """An output that cannot be written; what was there before is untouched."""


class MissingDependencyError(GeodesicError, ImportError):
    """An optional package, or a system library beneath it, is missing; the message says which."""


class NotEnoughMemoryError(GeodesicError, MemoryError):
    """The work would not fit into memory; the message says how much it needs."""


class SolverError(GeodesicError, RuntimeError):
    """A linear solver failed: a singular or indefinite matrix, or no convergence."""


class ConformanceError(GeodesicError, AssertionError):
    """A plugin breaks laws of its contract; the message names each with its figure and bound."""


class PluginError(GeodesicError):
    """Root of what can be wrong with plugins."""


class UnknownPluginError(PluginError, LookupError):
    """No plugin of that name; the message lists near misses and what is installed."""


class PluginLoadError(PluginError, ImportError):
    """A plugin is registered but could not be imported, or is not what its group asks for."""


class PluginConflictError(PluginError, LookupError):
    """Two distributions register the same name; the message names both."""


class GeodesicWarning(UserWarning):
    """Root of every warning of this package."""


class ReadWarning(GeodesicWarning):
    """A file or object was read, but not quite as it stands: polygons were triangulated, say."""


class CoarseMeshWarning(GeodesicWarning):
    """Plain heat is 4 % off, or more, on a part of a mesh; the refined distance is better."""


class CurveWarning(GeodesicWarning):
    """The points of a cloud follow one line, and have been taken for a surface."""


class FragmentedCloudWarning(GeodesicWarning):
    """A point cloud has come apart: points among the neighbours of others are not connected."""


class UnevenCloudWarning(GeodesicWarning):
    """A cloud is sampled too unevenly for plain heat to be trusted; refined distances can be."""


class NonPositiveHeatWarning(GeodesicWarning):
    """The heat is not positive at some vertices, and distances from it are not to be trusted.

    Refined ones take an order from the heat and nothing else: they suffer nothing by it.
    """


class FarSourceWarning(GeodesicWarning):
    """A source point lies far from the shape that it was snapped to; the units may differ."""


class SeamWarning(GeodesicWarning):
    """The surface of a mesh is cut along seams: edges of its boundary lie upon others."""


class NormalsWarning(GeodesicWarning):
    """Normals were estimated in another way than the best one; the message says what is missing."""
