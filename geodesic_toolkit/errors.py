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
    "NoisyCloudWarning",
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
    """The data of a mesh, cloud or graph are invalid: the message names the first bad element.

    Notes
    -----
    Cause: An index that is not a vertex, often because indices were counted from 1; NaN
    coordinates; a face with fewer than three corners; points as rows of two or four numbers; an
    edge length that is not positive.

    Cure: Correct the element that the message names. In files that were written by hand, look at
    the first index. `geodesic-toolkit doctor FILE` describes what was read.
    """


class UnsupportedDomainError(GeodesicError, TypeError):
    """The chosen operator or function does not support this kind of domain, or its state.

    Notes
    -----
    Cause: A function for meshes got a cloud or a graph, or an operator a shape that it has no
    stiffness for.

    Cure: The message names the kinds that are accepted. :func:`as_domain` converts shapes of other
    libraries; `geodesic-toolkit plugins` lists operators with the kinds of domain that they take.
    """


class InvalidSourceError(GeodesicError, IndexError):
    """Sources that do not name points of the domain.

    Notes
    -----
    Cause: A vertex index that is negative or too large; a point that is NaN; a number where a list
    is needed; no source at all; vertices and points mixed in one list.

    Cure: Vertices are integers from 0 to N - 1; points are rows of three numbers in the unit of the
    shape. Several sets of sources are a list of lists for `distances`.
    """


class InvalidCurveError(InvalidSourceError):
    """A curve that does not follow the surface; the message says which, and where it leaves it.

    Notes
    -----
    Cause: Points of a curve that lie off the surface, in another unit, or on two sides of a gap.

    Cure: Sample the curve more densely, or give it as vertices or as surface points.
    """


class UnreachableError(GeodesicError, ValueError):
    """No path connects two points between which one was requested.

    Notes
    -----
    Cause: The points lie in different connected components, or a mask separates them.

    Cure: Distances are ``inf`` there. `geodesic-toolkit doctor FILE` counts the components, and
    `--weld` joins them where a seam is the cause. An embedding has no ``inf``: embed each
    component.
    """


class ContractibleLoopError(GeodesicError, ValueError):
    """A loop that shrinks to a point, where a closed geodesic was asked for.

    Notes
    -----
    Cause: The loop does not surround a handle or a hole, or the surface has neither.

    Cure: Give a loop that does, or mask both ends of a limb to make a tube of it. For a loop that
    only needs to enclose something, use a geodesic disc.
    """


class InvalidOptionError(GeodesicError, ValueError):
    """An option has a value outside its allowed ones.

    Notes
    -----
    Cause: A misspelt value, a number out of its range, or two options that exclude each other.

    Cure: The message lists the values that are allowed.
    """


class InvalidDiscretizationError(GeodesicError, ValueError):
    """An operator returned data that break the contract of a discretization.

    Notes
    -----
    Cause: An operator of a plugin returned a matrix that is not symmetric, has rows that do not sum
    to zero, has masses that are not positive, or gradients of another shape.

    Cure: Run `geodesic-toolkit check OPERATOR`, which names the law that is broken. The sign of the
    stiffness is a frequent cause: L = -Δ is positive semidefinite here.
    """


class ReadError(GeodesicError, ValueError):
    """A file cannot be read as a mesh, cloud or graph.

    Notes
    -----
    Cause: A file that is truncated, has another format than its name says, or holds a shape of
    another kind.

    Cure: The message names the line or the part. Convert the file with the program that wrote it,
    or read it with a library of your choice and give its object to :func:`as_domain`.
    """


class WriteError(GeodesicError, OSError):
    """An output cannot be written; an existing file is unchanged.

    Notes
    -----
    Cause: A folder that is missing or read-only, a full disk, or a format that cannot hold the
    result.

    Cure: Choose another path or one of the formats that the message lists.
    """


class MissingDependencyError(GeodesicError, ImportError):
    """An optional package, or a system library that it needs, is missing; the message names it.

    Notes
    -----
    Cause: An extra that was not installed, or a wheel whose system library is missing.

    Cure: Install what the message names, for example ``pip install 'geodesic-toolkit[viz]'``.
    """


class NotEnoughMemoryError(GeodesicError, MemoryError):
    """The work would not fit into memory; the message has the required size.

    Notes
    -----
    Cause: A factor, or a matrix of distances, that is larger than the free memory.

    Cure: Thin a cloud, write a matrix to a file with `output=`, or use a machine with more memory.
    """


class SolverError(GeodesicError, RuntimeError):
    """A linear solver failed: a singular or indefinite matrix, or no convergence.

    Notes
    -----
    Cause: A matrix that is singular or not positive definite, or an iteration that does not
    converge.

    Cure: Direct solvers are the default, because heat spans hundreds of orders of magnitude. With
    an iterative one, loosen its tolerance, or use it for the Poisson equation alone.
    """


class ConformanceError(GeodesicError, AssertionError):
    """A plugin breaks laws of its contract; the message names each with its figure and bound.

    Notes
    -----
    Cause: An operator, a domain or a solver that breaks a law which the heat method relies on.

    Cure: The message has the figure and its bound for each law; :doc:`/writing_an_operator` derives
    them.
    """


class PluginError(GeodesicError):
    """Root of the errors of plugins."""


class UnknownPluginError(PluginError, LookupError):
    """There is no plugin of that name; the message lists near misses and installed plugins.

    Notes
    -----
    Cause: A misspelt name, or a plugin that is not installed in this environment.

    Cure: `geodesic-toolkit plugins` lists what is installed.
    """


class PluginLoadError(PluginError, ImportError):
    """A plugin is registered but could not be imported, or does not fit its group.

    Notes
    -----
    Cause: A plugin whose own imports fail, or which was made for another version.

    Cure: `geodesic-toolkit plugins` shows its error; reinstall or remove the distribution that it
    names.
    """


class PluginConflictError(PluginError, LookupError):
    """Two distributions register the same name; the message names both.

    Notes
    -----
    Cause: Two installed distributions have the same name for different things.

    Cure: Uninstall one of the two that the message names.
    """


class GeodesicWarning(UserWarning):
    """Root of every warning of this package."""


class ReadWarning(GeodesicWarning):
    """A file or object was read with changes, such as polygons split into triangles.

    Notes
    -----
    Cause: Polygons that were split into triangles, repeated points, faces without area, or
    attributes that distances do not need.

    Cure: Nothing, if the change is what you expect. Polygons are kept by the plugin
    ``geodesic-toolkit-polygon``.
    """


class CoarseMeshWarning(GeodesicWarning):
    """Plain heat has an error of 4 % or more on a part of a mesh; refined distances are better.

    Notes
    -----
    Cause: Plain heat was asked for (``refine=False``), and the mesh has few faces, long thin faces,
    or a time step that is too long for its features.

    Cure: Use refined distances, which are the default; or subdivide the mesh.
    """


class CurveWarning(GeodesicWarning):
    """The points of a cloud follow a line, but were treated as a surface.

    Notes
    -----
    Cause: A coil, a wire or the track of a vehicle, whose turns are near each other; or the track
    of a probe over a surface, which is correct.

    Cure: If the line itself is the shape, make a :class:`Graph` of its points in their order.
    """


class FragmentedCloudWarning(GeodesicWarning):
    """A point cloud is disconnected: points are not connected to some of their neighbours.

    Notes
    -----
    Cause: Gaps that are wider than a few spacings, or several objects in one scan.

    Cure: If the gaps are real, the distance beyond them is ``inf``, and nothing needs to be done.
    Otherwise give ``PointCloudLaplacian(k=...)`` more neighbours, make the density even with
    :func:`thin`, or give correct normals with the cloud. An embedding by ``GeodesicIsomap`` has no
    ``inf``, and adds the shortest edges between components: take more ``n_neighbors``, or embed
    each component.
    """


class UnevenCloudWarning(GeodesicWarning):
    """A cloud is sampled too unevenly for plain heat; refined distances are reliable.

    Notes
    -----
    Cause: Plain heat was asked for on a sweep of a spinning scanner, or on parts of different
    density.

    Cure: Use refined distances, which are the default, or thin the cloud to one spacing.
    """


class NoisyCloudWarning(GeodesicWarning):
    """The points of a cloud are so far off the surface that distances are unreliable.

    Notes
    -----
    Cause: Noise of half of the spacing or more, or so few points that legs and ears are as wide as
    the spacing, or points that fill a volume.

    Cure: Smooth the points along their normals. If the shape is much wider than the spacing,
    :func:`thin` the cloud to a spacing of three times the noise or more. If the points are few,
    give more, or a mesh.
    """


class NonPositiveHeatWarning(GeodesicWarning):
    """The heat is not positive at some vertices, and distances from it are unreliable.

    Refined distances use only the order of the heat, and are not affected.

    Notes
    -----
    Cause: A mesh with very obtuse triangles and an operator that keeps them, an operator of a
    plugin with positive entries off the diagonal, or an iterative solver.

    Cure: Use the default intrinsic Delaunay triangulation, refined distances, or a direct solver.
    """


class FarSourceWarning(GeodesicWarning):
    """A source point is far from the shape to which it was snapped; the units may differ.

    Notes
    -----
    Cause: A point in millimetres for a mesh in metres, a point in another coordinate system, or a
    point that belongs to another shape.

    Cure: Compare the distance by which the point was moved with the size of the shape; the message
    has both.
    """


class SeamWarning(GeodesicWarning):
    """The surface of a mesh is cut along seams: boundary edges coincide with others.

    Notes
    -----
    Cause: A file format that repeats vertices along the seams of a texture, or two halves that were
    exported one by one.

    Cure: Give `--weld 0` on the command line, or merge the vertices before you make the mesh. If
    the cut is real, nothing needs to be done.
    """


class NormalsWarning(GeodesicWarning):
    """Normals were estimated by a fallback method; the message names the missing package.

    Notes
    -----
    Cause: Open3D is not installed, or a system library that it needs is missing.

    Cure: Install the package that the message names, or give normals with the cloud. The normals
    that were used instead come from the covariance of neighbours, and are less reliable at creases.
    """
