"""Shortest paths: descent on the refined distance, then straightening across the faces."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_array, vstack

from geodesic_toolkit.analysis.paths.candidates import best_path
from geodesic_toolkit.analysis.paths.cloud import CloudPath, path_on_cloud
from geodesic_toolkit.analysis.paths.edges import EdgePath, path_along_edges
from geodesic_toolkit.analysis.paths.fronts import first_to_arrive, refined_distance
from geodesic_toolkit.analysis.paths.insertion import Insertion, insert_points
from geodesic_toolkit.analysis.paths.polyline import Polyline, without_repeats
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.domains import PointCloud, TriangleMesh
from geodesic_toolkit.errors import InvalidSourceError, UnreachableError
from geodesic_toolkit.geometry.triangles import proper_faces
from geodesic_toolkit.laplacians.cotan import CotanLaplacian
from geodesic_toolkit.solver.solver import GeodesicSolver, check_solver
from geodesic_toolkit.sources.kinds import OffsetSources
from geodesic_toolkit.sources.locate import locate_sources
from geodesic_toolkit.sources.points import SourcePoints
from geodesic_toolkit.sources.surface_point import SurfacePoint

__all__ = ["GeodesicPath", "geodesic_path"]


@dataclass(frozen=True, eq=False, repr=False)
class GeodesicPath(Polyline):
    """A polyline on a triangle mesh, from source to target.

    Between two consecutive points it is straight and within one face.

    Attributes
    ----------
    mesh : TriangleMesh
    surface_points : tuple of SurfacePoint
        The P points; they can be sources, also as a ``Curve``.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> solver = gt.GeodesicSolver(gt.testing.shapes.grid(5))
    >>> path = gt.geodesic_path(solver, 0, 23)
    >>> path
    GeodesicPath(10 points, length 1.25)
    >>> solver.distance(path.surface_points).shape  # from a curve
    (25,)
    """

    mesh: TriangleMesh
    surface_points: tuple[SurfacePoint, ...]

    @cached_property
    def points(self) -> FloatArray:
        """The (P, 3) positions of the points."""
        faces = [point.face for point in self.surface_points]
        weights = np.array([point.barycentric for point in self.surface_points])
        corners = self.mesh.vertices[self.mesh.faces[faces]]
        positions: FloatArray = np.einsum("pc,pcd->pd", weights, corners)
        return positions


def geodesic_path(
    solver: GeodesicSolver, source: Any, target: Any
) -> GeodesicPath | CloudPath | EdgePath:
    """Return a shortest path on a mesh, a cloud or a graph from the nearest source to a target.

    Descent on the refined distance from the target passes through a strip of faces. The strip is
    unfolded, the shortest line through it drawn, and the strip moved to the other side of a vertex
    wherever that is shorter. The result is a geodesic of the polyhedron: every path close to it is
    at least as long. If paths far apart are almost equally long (around different sides of a
    mountain), it may not be the shortest: on scans and models it is longer by a few thousandths at
    most, on crumpled surfaces by up to a few per cent.

    On a cloud the path runs through the triangles of the local stars. It may keep a bend where
    stars disagree, which a mesh would straighten. It passes through the points as they
    are: noise of a third of the spacing makes it 2 to 4 % longer than the distance, which is
    measured along the tangent planes.

    On a graph, and on other domains with edges, it is the shortest path along edges, which
    is longer than a distance across faces.

    Parameters
    ----------
    solver : GeodesicSolver
        Its heat orders the vertices; nothing is factorised.
    source : int, array-like, SurfacePoint, sequence of them, Curve or OffsetSources
        As for :meth:`GeodesicSolver.distance`. Among sources with offsets the path begins at the
        one with the least offset plus length; its length does not include the offset.
    target : int, array-like of float, or SurfacePoint
        One point. On a cloud a point in space is snapped to the nearest point.

    Returns
    -------
    GeodesicPath, CloudPath or EdgePath
        On a mesh, on a cloud, and along edges. A single point if the target is a source.

    Raises
    ------
    InvalidOptionError
        `solver` is not a solver.
    UnsupportedDomainError
        A cloud whose operator makes no triangles; a domain without edges.
    InvalidSourceError
        Sources or a target that do not name points; a masked source; several targets.
    UnreachableError
        No triangle connects the target with a source.

    References
    ----------
    S.-Q. Xin, G.-J. Wang, *Efficiently determining a locally exact shortest path on polyhedral
    surfaces*, 2007, https://doi.org/10.1016/j.cad.2007.08.001

    Examples
    --------
    >>> import numpy as np
    >>> import geodesic_toolkit as gt
    >>> solver = gt.GeodesicSolver(gt.testing.shapes.icosphere(3))
    >>> path = gt.geodesic_path(solver, 0, [0.0, 0.0, 1.0])
    >>> path.points[-1].round(3)
    array([0., 0., 1.])
    """
    check_solver(solver, "a path")
    domain = solver.domain
    if isinstance(target, OffsetSources):
        raise InvalidSourceError("target: a target has no offset; offsets are for sources")
    sources = solver.locate(source, "source")
    goal = locate_sources(domain, target, "target", passable=solver.passable)
    if goal.count != 1:
        raise InvalidSourceError(
            f"target: a path ends at one point, not at {goal.count}; call it for each"
        )
    if isinstance(domain, PointCloud):
        return path_on_cloud(solver, sources, goal)
    if not isinstance(domain, TriangleMesh):
        return path_along_edges(solver, sources, goal)
    metric = _with_triangles(solver)
    back = refined_distance(solver, metric, goal)
    if sources.delayed:
        sources = first_to_arrive(sources, back)
    distance = refined_distance(solver, metric, sources)
    path = _path_on_mesh(domain, distance, back, sources, goal)
    if path is None:
        seams = f". {solver.seams.finding}; {solver.seams.cure}" if solver.seams else ""
        raise UnreachableError(
            f"no face connects the target {target!r} with a source; they are in different "
            f"components of the mesh, outside all faces, or behind masked vertices{seams}"
        )
    return path


def _path_on_mesh(
    mesh: TriangleMesh,
    distance: FloatArray,
    back: FloatArray,
    sources: SourcePoints,
    goal: SourcePoints,
) -> GeodesicPath | None:
    """Return the path that descends the refined distance from a point of a mesh to the sources.

    None if no face connects them.
    """
    conducting = np.isfinite(distance)[mesh.faces].all(axis=1)  # not those of masked vertices
    original = np.flatnonzero(proper_faces(mesh.faces) & conducting)
    both = csr_array(vstack([goal.weights, sources.weights]))
    split = insert_points(mesh.vertices, mesh.faces[original], both)
    start, ends = int(split.vertex_of_point[0]), split.vertex_of_point[1:]
    added = np.zeros(len(split.vertices) - len(distance))
    height, behind = np.concatenate([distance, added]), np.concatenate([back, added])
    height[start], behind[ends] = (goal.weights @ distance)[0], sources.weights @ back
    height[ends], behind[start] = 0.0, 0.0
    beside = np.flatnonzero((split.faces == start).any(axis=1))
    if start in ends and len(beside):
        return GeodesicPath(
            mesh, (_surface_point(mesh, original, split, (int(beside[0]), [start], np.ones(1))),)
        )
    unreached = start in ends or not np.isfinite(height[start])
    if unreached:
        return None
    best = best_path(split.vertices, split.faces, height, behind, start=start, ends=ends)
    if best is None:
        return None
    parts = best.faces[::-1].tolist(), best.ends[::-1].tolist(), best.weights[::-1]
    points = (_surface_point(mesh, original, split, at) for at in zip(*parts, strict=True))
    path = GeodesicPath(mesh, tuple(points))
    kept = without_repeats(path.points, mesh.vertices[mesh.used])
    return GeodesicPath(mesh, tuple(path.surface_points[index] for index in kept))


def _with_triangles(solver: GeodesicSolver) -> Discretization:
    """Return the metric of a solver, or that of its mesh if the solver's has no triangles."""
    metric, mesh = solver.method.metric, solver.passable
    gradient = metric.on_surface
    three = isinstance(gradient, ElementGradient) and gradient.elements.shape[1] == 3
    if isinstance(mesh, TriangleMesh) and not three:
        return CotanLaplacian().assemble(mesh)
    return metric


def _surface_point(
    mesh: TriangleMesh,
    original: IntArray,
    split: Insertion,
    at: tuple[int, list[int], FloatArray],
) -> SurfacePoint:
    """Return a point of the split mesh as a point of the old face that contains it.

    The point is given by a face of the split mesh, vertices of this face, and their shares.
    """
    face, vertices, shares = at
    whole = int(original[split.parents[face]])
    weights = np.zeros(3)
    for vertex, share in zip(vertices, shares.tolist(), strict=True):
        weights += share * split.weights_on(mesh.faces[whole], vertex)
    a, b, c = weights.tolist()
    return SurfacePoint(whole, (a, b, c))
