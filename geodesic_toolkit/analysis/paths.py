"""Shortest paths: down the refined distance, then straightened across the faces."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array, vstack
from scipy.sparse.csgraph import dijkstra

from geodesic_toolkit._typing import FloatArray, IntArray
from geodesic_toolkit.analysis.descent import descend
from geodesic_toolkit.domains import OffsetSources, SurfacePoint, TriangleMesh
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    UnreachableError,
    UnsupportedDomainError,
)
from geodesic_toolkit.geometry.fans import Fans
from geodesic_toolkit.geometry.insertion import Insertion, insert_points
from geodesic_toolkit.geometry.strips import Way, beside_cones, shortest_way
from geodesic_toolkit.geometry.triangles import edges_of_faces, proper_faces
from geodesic_toolkit.gradient import ElementGradient
from geodesic_toolkit.laplacians.cotan import CotanLaplacian
from geodesic_toolkit.refine import WavefrontSweeper
from geodesic_toolkit.solver import GeodesicSolver
from geodesic_toolkit.source_points import SourcePoints
from geodesic_toolkit.sources import locate_sources

__all__ = ["GeodesicPath", "geodesic_path"]

SAME = 1e-12
"""Share of the size of the mesh within which two points are one."""


@dataclass(frozen=True, eq=False)
class GeodesicPath:
    """A polyline on a triangle mesh, from source to target.

    Between two of its points it runs straight through one face.

    Attributes
    ----------
    mesh : TriangleMesh
    surface_points : tuple of SurfacePoint
        P points; :meth:`GeodesicSolver.distance` takes them as sources, and ``Curve`` of them.

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

    @property
    def length(self) -> float:
        """Length of the polyline, in the unit of the mesh."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())

    def __repr__(self) -> str:
        return f"GeodesicPath({len(self.surface_points)} points, length {self.length:.6g})"


def geodesic_path(solver: GeodesicSolver, source: Any, target: Any) -> GeodesicPath:
    """Return a shortest path over the faces of a mesh from the nearest source to a target.

    The refined distance from the sources is descended from the target; the strip of faces passed
    on the way is unfolded, the shortest line through it drawn, and the strip led around the other
    side of a vertex wherever that is shorter. What comes out is a geodesic of the polyhedron: no
    path close to it is shorter. Of several far apart that are almost equally long (over different
    sides of a mountain) it need not be the shortest: on scans and models it is but for a few
    thousandths, on crumpled surfaces it can be some per cent longer.

    Parameters
    ----------
    solver : GeodesicSolver
        Of a TriangleMesh; its heat gives the distances their order, no factor is made.
    source : int, array-like of int, array-like of float, SurfacePoint or sequence of them
        As :meth:`GeodesicSolver.distance` takes them.
    target : int, array-like of float, or SurfacePoint
        One place.

    Returns
    -------
    GeodesicPath
        One point where the target is a source.

    Raises
    ------
    InvalidOptionError
        Something else than a solver.
    UnsupportedDomainError
        The domain is no triangle mesh. The local triangles of a cloud overlap, so that there are
        no strips of them to unfold: make a mesh of the cloud first.
    InvalidSourceError
        Sources or a target that name no place; several targets.
    UnreachableError
        No face connects the target with a source.

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
    if not isinstance(solver, GeodesicSolver):
        raise InvalidOptionError(
            f"a path needs a GeodesicSolver, not a {type(solver).__name__}; "
            "make one of the mesh: GeodesicSolver(mesh)"
        )
    mesh = solver.domain
    if not isinstance(mesh, TriangleMesh):
        raise UnsupportedDomainError(
            f"paths run through the faces of a TriangleMesh; a {type(mesh).__name__} has none that "
            "fit together, so make a mesh of it first"
        )
    if isinstance(source, OffsetSources):
        raise InvalidSourceError("source: a path has no offset; give the places alone")
    sources, goal = locate_sources(mesh, source, "source"), locate_sources(mesh, target, "target")
    if goal.weights.shape[0] != 1:
        raise InvalidSourceError(
            f"target: a path leads to one place, not to {goal.weights.shape[0]}; "
            "ask for a path to each"
        )
    original = np.flatnonzero(proper_faces(mesh.faces))
    both = csr_array(vstack([goal.weights, sources.weights]))
    split = insert_points(mesh.vertices, mesh.faces[original], both)
    start, ends = int(split.places[0]), split.places[1:]
    distance = _refined(solver, mesh, sources)
    height = np.concatenate([distance, np.zeros(len(split.vertices) - len(distance))])
    height[start] = (goal.weights @ distance)[0]
    height[ends] = 0.0
    fans = Fans(split.vertices, split.faces)
    if start in ends and fans.around(start):
        return GeodesicPath(
            mesh, (_surface_point(mesh, original, split, fans.around(start)[0], {start: 1.0}),)
        )
    if start in ends or not np.isfinite(height[start]):
        raise UnreachableError(
            f"no face connects the target {target!r} with a source; they lie in different "
            "components of the mesh, or in no face"
        )
    crossings = _best_way(fans, height, start, set(ends.tolist()))
    points = [
        _surface_point(mesh, original, split, face, weights) for face, weights in crossings[::-1]
    ]
    return GeodesicPath(mesh, tuple(_without_repeats(mesh, points)))


def _refined(solver: GeodesicSolver, mesh: TriangleMesh, sources: SourcePoints) -> FloatArray:
    """Return the refined distance, whether the solver refines or not."""
    method = solver.method
    if method.refine:
        return method.distance(sources)
    metric, gradient = method.metric, method.metric.gradient
    if not (isinstance(gradient, ElementGradient) and gradient.elements.shape[1] == 3):
        metric = CotanLaplacian().assemble(mesh)
    around = sources.weights.indices.astype(np.int64)
    return WavefrontSweeper(metric).distance(
        method.log_heat(sources), around, sources.distances, sources.curvatures
    )


def _best_way(
    fans: Fans, height: FloatArray, start: int, ends: set[int]
) -> list[tuple[int, dict[int, float]]]:
    """Return the points of a geodesic from a vertex to one of several, each in a face.

    Near a place where ways of equal length meet, steepest descent may take the wrong one: so it
    sets out to every neighbour that is lower, too, and the shortest of what comes out is taken.
    """
    best: list[tuple[Way, int, int]] = []
    for stops, strips in _descents(fans, height, start, ends):
        ways = [
            (shortest_way(fans, strip, first, last), first, last)
            for strip, first, last in _joined(fans, stops, strips)
        ]
        if not best or _length(ways) < _length(best):
            best = ways
    crossings: list[tuple[int, dict[int, float]]] = []
    for way, first, last in best:
        crossings += beside_cones(fans, way, first, last).crossings
    return crossings


def _length(ways: list[tuple[Way, int, int]]) -> float:
    return sum(way.length for way, _, _ in ways)


def _descents(
    fans: Fans, height: FloatArray, start: int, ends: set[int]
) -> Iterator[tuple[list[int], list[list[int]]]]:
    """Go down from a vertex in every way; where none leads to an end, along edges."""
    arrived = False
    seen: set[int] = set()
    stops, strips = descend(fans, height, start)
    if stops[-1] in ends:
        arrived = True
        yield stops, strips
    for face in fans.around(start):
        for neighbour in fans.others(face, start):
            if neighbour in seen or not height[neighbour] < height[start]:
                continue
            seen.add(neighbour)
            stops, strips = descend(fans, height, neighbour)
            if stops[-1] in ends:
                arrived = True
                yield [start, *stops], [[face], *strips]
    if not arrived:  # into hollows that are none of the sources
        yield _along_edges(fans, start, ends)


def _along_edges(fans: Fans, start: int, ends: set[int]) -> tuple[list[int], list[list[int]]]:
    """Return the shortest way along edges, as `descend` does."""
    count = len(fans.vertices)
    edges, _ = edges_of_faces(fans.faces, count)
    lengths = np.linalg.norm(np.diff(fans.vertices[edges], axis=1)[:, 0], axis=1)
    graph = csr_array(coo_array((lengths, tuple(edges.T)), shape=(count, count)))
    distance, before = dijkstra(  # the stubs know only sparse matrices
        graph,  # type: ignore[call-overload]
        directed=False,
        indices=start,
        return_predecessors=True,
    )
    stops = [min(ends, key=lambda end: distance[end])]
    while stops[-1] != start:
        stops.append(int(before[stops[-1]]))
    stops.reverse()
    return stops, [[fans.at_edge(a, b)[0]] for a, b in pairwise(stops)]


def _joined(
    fans: Fans, stops: list[int], strips: list[list[int]]
) -> list[tuple[list[int], int, int]]:
    """Join strips around the vertices between them: (strip, first vertex, last vertex).

    More than one where the surface hangs together at a vertex only.
    """
    legs = [(list(strips[0]), stops[0], stops[1])]
    for strip, first, last in zip(strips[1:], stops[1:-1], stops[2:], strict=True):
        chain = fans.chain(legs[-1][0][-1], strip[0], first)
        if chain is None:
            legs.append((list(strip), first, last))
        else:
            legs[-1] = (legs[-1][0] + chain[1:] + strip[1:], legs[-1][1], last)
    return legs


def _surface_point(
    mesh: TriangleMesh, original: IntArray, split: Insertion, face: int, at: dict[int, float]
) -> SurfacePoint:
    """Return a point of a part of a face as one of the face."""
    whole = int(original[split.parents[face]])
    weights = np.zeros(3)
    for vertex, share in at.items():
        weights += share * split.weights_on(mesh.faces[whole], vertex)
    a, b, c = weights.tolist()
    return SurfacePoint(whole, (a, b, c))


def _without_repeats(mesh: TriangleMesh, points: list[SurfacePoint]) -> list[SurfacePoint]:
    """Leave out points that are where the one before them is; the ends stay as they are."""
    places = GeodesicPath(mesh, tuple(points)).points
    near = SAME * float(np.ptp(mesh.vertices, axis=0).max())
    kept = [0]
    for index in range(1, len(points)):
        if np.linalg.norm(places[index] - places[kept[-1]]) > near:
            kept.append(index)
    kept[-1] = len(points) - 1 if len(kept) > 1 else 0
    return [points[index] for index in kept]
