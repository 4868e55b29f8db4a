"""Shortest paths through a strip of measured faces, and through the strips beside it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from geodesic_toolkit.analysis.paths.metric.dense_graph import Leg
from geodesic_toolkit.analysis.paths.metric.faces import FacesAround
from geodesic_toolkit.analysis.paths.metric.refraction import Polylines, refracted
from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["Drawn", "drawn_through", "shortest_beside"]

MIN_SHORTENING = 1e-12
"""Share of the length by which a path must become shorter to be led through other faces."""

MAX_TRIES = 4
"""Other sides of vertices that are tried though they are longer at first.

With 0, 9 of 89 paths on a sphere and two tori are longer than those of a mesh without costs, by up
to 4.5e-4; with 4, 8 and 16 only 3 are, in 1.7, 2.4 and 3.9 times the time.
"""

MAX_TURNS = 1_000
"""Times that a strip is changed at most; each made the path shorter all the same."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """The shortest path through a strip of S faces: S + 1 points.

    Attributes
    ----------
    leg : Leg
    ends : ndarray of shape (S + 1, 2), int64
        The ends of the edge on which each point lies; twice the same at a vertex.
    lines : Polylines
    """

    leg: Leg
    ends: IntArray
    lines: Polylines

    @property
    def strip(self) -> list[int]:
        """The faces."""
        return self.leg.strip

    @property
    def length(self) -> float:
        """Length of the path."""
        return float(self.lines.lengths.sum())


@dataclass(frozen=True)
class _Detour:
    """Faces instead of those from `first` to `last`: on the other side of a vertex, for example."""

    first: int
    last: int
    faces: list[int]


def shortest_beside(surface: FacesAround, path: Drawn) -> Drawn:
    """Return the shortest path through the strips that lead from one to the next, from a path on.

    The strip is led around the other side of every vertex beside it where that makes the path
    shorter with the points before and after it as they are. A path that no such step shortens is
    a locally shortest one. A path may also be led to an edge that is cheaper beyond, along it, and
    back. Then the other sides that lengthen it least are tried with all points
    free: a path passes a pointed vertex on one side or the other, and neither can be pulled over.
    """
    for _ in range(MAX_TURNS):
        other = _next(surface, path, list(_detours(surface, path, _bends(path))))
        if other is None:
            detours = [*_detours(surface, path, _beside(path)), *_returns(surface, path)]
            other = _next(surface, path, detours, MAX_TRIES)
        if other is None:
            break
        path = other
    return path


def _next(
    surface: FacesAround, path: Drawn, detours: list[_Detour], most_tries: int = 0
) -> Drawn | None:
    """Return a shorter path through some of these detours; None if there is none."""
    if not detours:
        return None
    gains = _gains(surface, path, detours)
    order = np.argsort(-gains, kind="stable").tolist()
    least = MIN_SHORTENING * path.length
    better = _apart([detours[place] for place in order if gains[place] > least])
    tries = [better] if better else []
    tries += [[detours[place]] for place in order[:most_tries] if gains[place] <= least]
    for chosen in tries:
        strip = surface.without_returns(_led(path.strip, chosen))
        other = drawn_through(surface, Leg(strip, path.leg.start, path.leg.end))
        if other.length < path.length * (1 - MIN_SHORTENING):
            return other
    return None


def _bends(path: Drawn) -> set[int]:
    """Return the vertices at which a path has points, except for its ends."""
    shares = path.lines.shares[1:-1]
    edges = path.ends[1:-1]
    return {*edges[shares == 0, 0].tolist(), *edges[shares == 1, 1].tolist()} - _ends(path)


def _beside(path: Drawn) -> set[int]:
    """Return the vertices of the edges that a path crosses, except for its ends."""
    return set(path.ends[1:-1].ravel().tolist()) - _ends(path)


def _ends(path: Drawn) -> set[int]:
    return {path.leg.start, path.leg.end}


def _led(strip: list[int], detours: list[_Detour]) -> list[int]:
    """Return a strip led through detours, which do not overlap."""
    led = list(strip)
    for detour in sorted(detours, key=lambda one: one.first, reverse=True):
        led[detour.first : detour.last + 1] = detour.faces
    return led


def _apart(detours: list[_Detour]) -> list[_Detour]:
    """Return detours that do not overlap, the first of those that do."""
    chosen: list[_Detour] = []
    for detour in detours:
        if all(detour.last < other.first or other.last < detour.first for other in chosen):
            chosen.append(detour)
    return chosen


def drawn_through(surface: FacesAround, leg: Leg) -> Drawn:
    """Return the shortest path through a strip."""
    edges = surface.common_edges(np.array(leg.strip))
    ends = np.vstack([[[leg.start] * 2], edges, [[leg.end] * 2]])
    shares = np.full(len(ends), 0.5)
    shares[[0, -1]] = 0.0
    return Drawn(leg, ends, refracted(_lines(surface, np.array(leg.strip), ends, shares)))


def _lines(surface: FacesAround, faces: IntArray, ends: IntArray, shares: FloatArray) -> Polylines:
    """Return polylines through faces (P - 1,), -1 between them, of points (P,) on edges.

    The first and the last of each polyline stay.
    """
    within = faces >= 0
    frames = surface.frames(np.maximum(faces, 0)) * within[:, None, None]
    corners = surface.faces[np.maximum(faces, 0)]
    tails, heads = (
        (corners[:, None] == at[..., None]).argmax(axis=2) for at in (ends[:-1], ends[1:])
    )
    free = np.zeros(len(ends), dtype=np.bool_)
    free[1:-1] = within[1:] & within[:-1]
    return Polylines(frames, tails, heads, free, shares)


def _detours(surface: FacesAround, path: Drawn, vertices: set[int]) -> Iterator[_Detour]:
    """Yield the detours around some of the vertices of the edges that a path crosses."""
    edges = path.ends[1:-1].tolist()
    for first, edge in enumerate(edges):
        for vertex in edge:
            if vertex not in vertices or (first and vertex in edges[first - 1]):
                continue
            last = first + 1
            while last < len(edges) and vertex in edges[last]:
                last += 1
            faces = surface.other_side(path.strip[first : last + 1], vertex)
            if faces:
                yield _Detour(first, last, faces)


def _returns(surface: FacesAround, path: Drawn) -> Iterator[_Detour]:
    """Yield the detours to an edge of a face that is cheaper in the face beyond it, and back."""
    strip = path.strip
    for place, face in enumerate(strip):
        near = strip[max(place - 1, 0) : place + 2]
        for beyond in surface.cheaper_beside(face):
            if beyond not in near:
                yield _Detour(place, place, [face, beyond, face])


def _gains(surface: FacesAround, path: Drawn, detours: list[_Detour]) -> FloatArray:
    """Return by how much detours are shorter, between the points where they begin and end."""
    faces = np.array([face for detour in detours for face in (*detour.faces, -1)])
    within = (faces[:-2] >= 0) & (faces[1:-1] >= 0)  # points between two faces of one detour
    ends = np.zeros((len(faces), 2), dtype=np.int64)
    shares = np.full(len(faces), 0.5)
    ends[1:-1][within] = surface.common_edges(faces[:-1])[within]
    first, last = np.array([(detour.first, detour.last + 1) for detour in detours]).T
    stops = np.flatnonzero(faces < 0)
    begins = np.concatenate([[0], stops[:-1] + 1])
    for places, given in ((begins, first), (stops, last)):
        ends[places], shares[places] = path.ends[given], path.lines.shares[given]
    lines = _lines(surface, faces[:-1], ends, shares)
    lengths = np.add.reduceat(refracted(lines, exact=False).lengths, begins)
    passed = np.concatenate([[0.0], np.cumsum(path.lines.lengths)])
    return np.asarray(passed[last] - passed[first] - lengths)
