"""Shortest paths: descent on the refined distance, then straightening across the faces."""

from functools import partial
from typing import Any

import numpy as np
from scipy.sparse import csr_array, vstack

from geodesic_toolkit import _native
from geodesic_toolkit.analysis.paths.candidates import Candidate, best_path
from geodesic_toolkit.analysis.paths.chains import (
    Course,
    located_stops,
    path_through,
    pieces_between,
    unreachable_error,
)
from geodesic_toolkit.analysis.paths.cloud import CloudPath, path_on_cloud
from geodesic_toolkit.analysis.paths.edges import EdgePath, path_along_edges
from geodesic_toolkit.analysis.paths.fronts import first_to_arrive
from geodesic_toolkit.analysis.paths.insertion import insert_points
from geodesic_toolkit.analysis.paths.metric.paths import path_on_metric
from geodesic_toolkit.analysis.paths.path import (
    GeodesicPath,
    joined_pieces,
    path_from_candidate,
)
from geodesic_toolkit.analysis.paths.prepared import PreparedMesh, prepared_mesh
from geodesic_toolkit.domains import PointCloud, TriangleMesh
from geodesic_toolkit.domains.measured import MeasuredFaces
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
)
from geodesic_toolkit.solver.solver import GeodesicSolver, check_solver
from geodesic_toolkit.sources.kinds import OffsetSources
from geodesic_toolkit.sources.locate import locate_sources
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["geodesic_path"]


def geodesic_path(
    solver: GeodesicSolver,
    source: Any,
    target: Any = None,
    *,
    via: Any = None,
    through: bool = False,
    closed: bool = False,
) -> GeodesicPath | CloudPath | EdgePath:
    """Return a shortest path on a mesh, a cloud or a graph from the nearest source to a target.

    Without a target the sources are way points, and each piece between one and the next is a
    shortest path.

    Descent on the refined distance from the target passes through a strip of faces. The strip is
    unfolded, the shortest line through it drawn, and the strip moved to the other side of a vertex
    wherever that is shorter. The result is a geodesic of the polyhedron: every path close to it is
    at least as long. If paths far apart are almost equally long (around different sides of a
    mountain), it may not be the shortest: on scans and models it is longer by a few thousandths at
    most, on crumpled surfaces by up to a few per cent.

    A path `via` places passes holes, hills and valleys on the side of these places: the shortest
    path along edges through all of them is pulled taut. The result is as short as any path close to
    it. It leaves the places, unless it must run `through` them.

    On a cloud the path runs through the triangles of the local stars. It may keep a bend where
    stars disagree, which a mesh would straighten. It passes through the points as they
    are: noise of a third of the spacing makes it 2 to 4 % longer than the distance, which is
    measured along the tangent planes.

    On a mesh with costs, metric tensors or edge lengths alone it is a locally shortest path in that
    metric, through faces and refracted where the cost jumps, or along the edges of cheaper faces;
    its `length` is that of the distances.

    On a domain with a subdivision into triangles it runs across those, and they are the `mesh` of
    the path. On a graph, and on other domains with edges, it is the shortest path along edges,
    which is longer than a distance across faces.

    Parameters
    ----------
    solver : GeodesicSolver
        Its heat orders the vertices; nothing is factorised.
    source : int, array-like, SurfacePoint, sequence of them, Curve or OffsetSources
        As for :meth:`GeodesicSolver.distance`. Among sources with offsets the path begins at the
        one with the least offset plus length; its length does not include the offset. Without a
        target, at least two way points in order.
    target : int, array-like of float, or SurfacePoint, optional
        One point. Paths on a cloud begin and end at its points: places are snapped to the nearest.
    via : int, array-like, SurfacePoint or sequence of them, optional
        Places in order between one source and the target, on a mesh.
    through : bool
        Keep the places of `via` on the path.
    closed : bool
        Go on from the last way point to the first, where there is no target.

    Returns
    -------
    GeodesicPath, CloudPath or EdgePath
        On a mesh, also one with costs, on a cloud, and along edges. A single point if the target is
        a source.

    Raises
    ------
    InvalidOptionError
        Something else than a solver; options that do not go together.
    UnsupportedDomainError
        A cloud whose operator makes no triangles; a kind of domain without edges; way points, or
        places to go via, on anything but a mesh.
    InvalidSourceError
        Sources or a target that name no place; a masked source; several targets; a way point that
        is the one before it.
    UnreachableError
        No triangle connects the target with a source, or a way point with the next.

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

    Around the other side of a torus:

    >>> torus = gt.GeodesicSolver(gt.testing.shapes.torus(48, 24))
    >>> near, far = gt.geodesic_path(torus, 0, 240), gt.geodesic_path(torus, 0, 240, via=[720])
    >>> round(far.length / near.length, 1)
    2.8
    """
    check_solver(solver, "a path")
    if target is None:
        return _through_all(solver, source, via=via, through=through, closed=closed)
    if closed:
        raise InvalidOptionError(
            "closed=True is for way points alone: geodesic_path(solver, [a, b, c], closed=True)"
        )
    if via is not None:
        stops = located_stops(solver, [(source, "source"), (via, "via"), (target, "target")])
        path = path_through(solver, stops, Course(held=bool(through)))
        assert path is not None  # for the type checker: only closed ones shrink to points
        return path
    if through:
        raise InvalidOptionError("through=True is for the places of via=; give some")
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
    on = solver.method.metric.subdivision
    mesh = domain if on is None else on.mesh
    if not isinstance(mesh, TriangleMesh | MeasuredFaces):
        return path_along_edges(solver, sources, goal)
    prepared = prepared_mesh(solver)
    of_curve = sources.front_curvatures is not None  # descent may end at any of its samples
    if sources.delayed or of_curve:
        sources = first_to_arrive(sources, prepared.distance(goal)[: domain.n_vertices])
    path = _path_on_mesh(prepared, sources, goal)
    if path is None:
        raise unreachable_error(solver, f"the target {target!r} with a source")
    return path


def _through_all(
    solver: GeodesicSolver, places: Any, *, via: Any, through: bool, closed: bool
) -> GeodesicPath:
    """Return the path of shortest pieces from each way point to the next."""
    if via is not None or through:
        raise InvalidOptionError("via= and through= lead to a target; there is none")
    stops = located_stops(solver, [(places, "way points")], closed=closed)
    domain = solver.domain
    assert isinstance(domain, TriangleMesh | MeasuredFaces)  # located_stops has raised
    between = partial(_path_on_mesh, prepared_mesh(solver))
    pieces = pieces_between(stops, between, closed=bool(closed))
    if isinstance(pieces, int):
        before = (pieces - 1) % stops.count
        raise unreachable_error(solver, f"way point {pieces} with way point {before}")
    return joined_pieces(domain, pieces, closed=bool(closed))


def _path_on_mesh(
    prepared: PreparedMesh, sources: SourcePoints, goal: SourcePoints
) -> GeodesicPath | None:
    """Return the path that descends the refined distance from a point of a mesh to the sources.

    None if no face connects them.
    """
    if isinstance(prepared.mesh, MeasuredFaces):
        return path_on_metric(prepared, sources, goal)
    distance = prepared.distance(sources)
    sources, goal = prepared.on_mesh(sources), prepared.on_mesh(goal)
    if not np.isfinite(distance[goal.vertices]).all():
        return None
    back = prepared.near_path(goal, distance)
    mesh, reached = prepared.mesh, prepared.reached_by(distance)
    split = reached.whole
    at_vertices = goal.are_vertices and sources.are_vertices
    if at_vertices:
        start, ends = int(goal.vertices[0]), sources.vertices
    else:
        both = csr_array(vstack([goal.weights, sources.weights]))
        split = insert_points(mesh.vertices, split.faces, both)
        start, ends = int(split.vertex_of_point[0]), split.vertex_of_point[1:]
    if start in ends:
        beside = np.flatnonzero((split.faces == start).any(axis=1))
        if not len(beside):
            return None
        at_start = np.array([[start, start]])
        point = Candidate(beside[:1], at_start, np.array([[1.0, 0.0]]))
        return path_from_candidate(mesh, reached.numbers, split, point)
    if at_vertices:
        best = best_path(reached.surface, distance, back, start=start, ends=ends)
    else:
        added = np.zeros(len(split.added))
        height, behind = np.concatenate([distance, added]), np.concatenate([back, added])
        height[start], behind[ends] = (goal.weights @ distance)[0], sources.weights @ back
        height[ends], behind[start] = 0.0, 0.0
        surface = _native.Surface(split.vertices, split.faces)
        best = best_path(surface, height, behind, start=start, ends=ends)
    if best is None:
        return None
    return path_from_candidate(mesh, reached.numbers, split, best.backward)
