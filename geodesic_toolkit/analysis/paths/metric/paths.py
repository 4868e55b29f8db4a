"""Shortest paths under costs and metric tensors: across faces, refracted at their edges."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geodesic_toolkit.analysis.paths.candidates import Candidate
from geodesic_toolkit.analysis.paths.insertion import Insertion, insert_points
from geodesic_toolkit.analysis.paths.metric.dense_graph import Leg, legs_between, legs_of
from geodesic_toolkit.analysis.paths.metric.descent import Descent
from geodesic_toolkit.analysis.paths.metric.faces import FacesAround, segment_length
from geodesic_toolkit.analysis.paths.metric.strips import Drawn, drawn_through, shortest_beside
from geodesic_toolkit.analysis.paths.path import GeodesicPath, path_from_candidate
from geodesic_toolkit.analysis.paths.prepared import PreparedMesh
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.domains.measured import MeasuredFaces
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["path_on_metric", "pulled_through"]


def path_on_metric(
    prepared: PreparedMesh, sources: SourcePoints, goal: SourcePoints
) -> GeodesicPath | None:
    """Return a locally shortest path from the nearest of the sources to a goal.

    Faces that a short path may cross are those whose corners both ends reach on little more than
    the distance. Among them the shortest path through points on edges is found, and then that
    through its strip of faces and the strips beside it.

    Parameters
    ----------
    prepared : PreparedMesh
        Of faces with lengths of their own.
    sources, goal : SourcePoints
        The goal is a single one.

    Returns
    -------
    GeodesicPath or None
        None if no face connects them.
    """
    distance = prepared.distance(sources)
    if not np.isfinite(distance[goal.vertices]).all():
        return None
    surface = _surface(prepared, distance, [goal, sources])
    start, ends = int(surface.places[0]), surface.places[1:]
    if start in ends:
        return surface.point(start)
    near = np.isfinite(prepared.near_path(goal, distance))
    drawn = surface.drawn(distance, near, start, ends)
    return surface.path(drawn, backward=True) if drawn else None


def pulled_through(prepared: PreparedMesh, stops: list[SourcePoints]) -> GeodesicPath | int:
    """Return the locally shortest path to which paths from place to place are pulled.

    Parameters
    ----------
    prepared : PreparedMesh
        Of faces with lengths of their own.
    stops : list of SourcePoints
        Two or more, single ones.

    Returns
    -------
    GeodesicPath or int
        The number of a place that no face connects with the one before it.
    """
    distances = [prepared.distance(stop) for stop in stops[:-1]]
    surface = _surface(prepared, distances[0], stops)
    legs: list[Leg] = []
    for index, (here, there) in enumerate(pairwise(surface.places.tolist())):
        goal, distance = stops[index + 1], distances[index]
        drawn: list[Drawn] = []
        if np.isfinite(distance[goal.vertices]).all():
            near = np.isfinite(prepared.near_path(goal, distance))
            drawn = surface.drawn(distance, near, there, np.array([here]))
        if not drawn:
            return index + 1
        legs += [Leg(path.strip[::-1], path.leg.end, path.leg.start) for path in drawn[::-1]]
    joined = [drawn_through(surface.faces, leg) for leg in _joined(surface.faces, legs)]
    return surface.path([shortest_beside(surface.faces, path) for path in joined], backward=False)


@dataclass(frozen=True, eq=False)
class _Surface:
    """The reached faces of a mesh, split so that places are vertices.

    Attributes
    ----------
    mesh : MeasuredFaces
    numbers : ndarray of int64
        The faces of the mesh that were split.
    split : Insertion
    faces : FacesAround
        The parts.
    places : ndarray of int64
        The vertex of each place.
    """

    mesh: MeasuredFaces
    numbers: IntArray
    split: Insertion
    faces: FacesAround
    places: IntArray

    def drawn(self, height: FloatArray, near: BoolArray, start: int, ends: IntArray) -> list[Drawn]:
        """Return a locally shortest path, in legs, from a vertex to the nearest of others.

        It begins as the shorter of the course of steepest descent, and of the shortest path through
        points on the edges of all faces that a short path may cross, whose length is a few tenths
        of a per cent off.

        Parameters
        ----------
        height : ndarray of shape (N,), float64
            The distance from the others.
        near : ndarray of shape (N,), bool
            The vertices near which a short path may run.
        start : int
        ends : ndarray of int64

        Returns
        -------
        list of Drawn
            Empty if no face connects them.
        """
        whole = np.asarray(near[self.mesh.faces[self.numbers]].any(axis=1))
        inside = whole[self.split.parents]
        heights = np.concatenate([height, self._heights_of_added(height)])
        heights[ends] = 0.0
        down = Descent(self.faces, heights, set(ends.tolist())).course(start)
        courses = [legs_of(self.faces, down), self._legs(np.flatnonzero(inside), start, ends)]
        if not courses[-1]:  # fronts have not come where the path runs
            courses.append(self._legs(np.arange(len(inside)), start, ends))
        drawn = [[drawn_through(self.faces, leg) for leg in legs] for legs in courses if legs]
        best = min(drawn, key=_length, default=[])
        return [shortest_beside(self.faces, path) for path in best]

    def _heights_of_added(self, height: FloatArray) -> FloatArray:
        """Return the values of a height (N,) at the added vertices."""
        added = self.split.added
        return np.array(
            [sum(share * height[vertex] for vertex, share in point.items()) for point in added]
        )

    def _legs(self, among: IntArray, start: int, ends: IntArray) -> list[Leg]:
        count = len(self.split.vertices)
        if not len(among):
            return []
        return legs_between(self.faces, among, count, start=start, ends=ends)

    def point(self, vertex: int) -> GeodesicPath | None:
        """Return a vertex as a path; None if it has no face."""
        beside = np.flatnonzero((self.faces.faces == vertex).any(axis=1))
        if not len(beside):
            return None
        at = Candidate(beside[:1], np.array([[vertex, vertex]]), np.array([[1.0, 0.0]]))
        return path_from_candidate(self.mesh, self.numbers, self.split, at)

    def path(self, drawn: list[Drawn], *, backward: bool) -> GeodesicPath:
        """Return a path of legs, from its end to its start if backward."""
        turn = slice(None, None, -1 if backward else 1)
        strips = [leg.strip[turn] for leg in drawn[turn]]
        shares = np.concatenate([leg.lines.shares[turn] for leg in drawn[turn]])
        way = Candidate(  # each segment in the face of the point where it ends
            np.concatenate([[strip[0], *strip] for strip in strips]),
            np.concatenate([leg.ends[turn] for leg in drawn[turn]]),
            np.column_stack([1 - shares, shares]),
        )
        return path_from_candidate(self.mesh, self.numbers, self.split, way)


def _surface(prepared: PreparedMesh, distance: FloatArray, places: list[SourcePoints]) -> _Surface:
    """Return the faces that a distance reaches, with places as vertices."""
    mesh, reached = prepared.mesh, prepared.reached_by(distance)
    assert isinstance(mesh, MeasuredFaces)  # for the type checker; the caller has checked
    if all(place.are_vertices for place in places):
        vertices = np.concatenate([place.vertices for place in places])
        return _Surface(mesh, reached.numbers, reached.whole, reached.measured, vertices)
    split = insert_points(
        np.zeros((mesh.n_vertices, 3)),  # positions play no part
        reached.whole.faces,
        SourcePoints.together(places).weights,
    )
    faces = FacesAround(split.faces, _lengths_of_parts(mesh, reached.numbers, split))
    return _Surface(mesh, reached.numbers, split, faces, split.vertex_of_point)


def _lengths_of_parts(mesh: MeasuredFaces, numbers: IntArray, split: Insertion) -> FloatArray:
    """Return the edge lengths of parts of faces, (G, 3)."""
    old = numbers[split.parents]
    lengths = mesh.lengths[old]
    for part in np.flatnonzero((split.faces != mesh.faces[old]).any(axis=1)):
        at = np.array([split.weights_on(mesh.faces[old[part]], int(v)) for v in split.faces[part]])
        lengths[part] = segment_length(lengths[part], at[[2, 0, 1]] - at[[1, 2, 0]])
    return lengths


def _length(drawn: list[Drawn]) -> float:
    return sum(path.length for path in drawn)


def _joined(surface: FacesAround, legs: list[Leg]) -> list[Leg]:
    """Return legs of which each begins where the last one ends as one, where faces connect them."""
    whole = [legs[0]]
    for leg in legs[1:]:
        last = whole[-1]
        first, then = last.strip[-1], leg.strip[0]
        between = [first] if first == then else surface.chain(first, then, leg.start)
        if not between:
            whole.append(leg)
            continue
        strip = surface.without_returns([*last.strip, *between[1:-1], *leg.strip])
        whole[-1] = Leg(strip, last.start, leg.end)
    return whole
