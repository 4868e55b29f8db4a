"""Shortest paths through a strip of measured faces, and through the strips beside it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geodesic_toolkit.analysis.paths.dense_graph import Leg
from geodesic_toolkit.analysis.paths.measured_faces import FacesAround
from geodesic_toolkit.analysis.paths.refraction import Polylines, refracted
from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["Drawn", "shortest_beside"]

MIN_SHORTENING = 1e-12
"""Share of the length by which a path must become shorter to be led through other faces."""

MAX_TRIES = 4
"""Other sides of vertices that are tried though they are longer at first."""

MAX_TURNS = 1_000
"""Times that a strip is changed at most; each made the path shorter all the same."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """The shortest path through a strip of S faces: S + 1 points.

    Attributes
    ----------
    strip : list of int
    ends : ndarray of shape (S + 1, 2), int64
        The ends of the edge on which each point lies; twice the same at a vertex.
    lines : Polylines
    """

    strip: list[int]
    ends: IntArray
    lines: Polylines

    @property
    def length(self) -> float:
        """Length of the path."""
        return float(self.lines.lengths.sum())


@dataclass(frozen=True)
class _Detour:
    """The faces on the other side of a vertex, instead of those from `first` to `last`."""

    first: int
    last: int
    faces: list[int]


def shortest_beside(surface: FacesAround, leg: Leg) -> Drawn:
    """Return the shortest path through a strip and the strips that lead from it step by step.

    The strip is led around the other side of every vertex beside it where that makes the path
    shorter with the points before and after it as they are. A path that no such step shortens is
    a locally shortest one. Then the other sides that lengthen it least are tried with all points
    free: a path passes a pointed vertex on one side or the other, and neither can be pulled over.
    """
    path = _drawn(surface, leg.strip, leg)
    for _ in range(MAX_TURNS):
        other = _next(surface, path, leg)
        if other is None:
            break
        path = other
    return path


def _next(surface: FacesAround, path: Drawn, leg: Leg) -> Drawn | None:
    """Return a shorter path through faces beside those of a path; None if there is none."""
    detours = list(_detours(surface, path))
    if not detours:
        return None
    gains = _gains(surface, path, detours)
    order = np.argsort(-gains, kind="stable").tolist()
    least = MIN_SHORTENING * path.length
    better = _apart([detours[place] for place in order if gains[place] > least])
    tries = [better] if better else []
    tries += [[detours[place]] for place in order[:MAX_TRIES] if gains[place] <= least]
    for chosen in tries:
        other = _drawn(surface, surface.without_returns(_led(path.strip, chosen)), leg)
        if other.length < path.length * (1 - MIN_SHORTENING):
            return other
    return None


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


def _drawn(surface: FacesAround, strip: list[int], leg: Leg) -> Drawn:
    """Return the shortest path through a strip."""
    edges = [surface.common_edge(*pair) for pair in pairwise(strip)]
    ends = np.array([(leg.start, leg.start), *edges, (leg.end, leg.end)], dtype=np.int64)
    shares = np.full(len(ends), 0.5)
    shares[[0, -1]] = 0.0
    return Drawn(strip, ends, refracted(_lines(surface, np.array(strip), ends, shares)))


def _lines(
    surface: FacesAround, faces: IntArray, ends: IntArray, shares: FloatArray
) -> Polylines:
    """Return polylines through faces (P - 1,), -1 between them, of points (P,) on edges.

    The first and the last of each polyline stay.
    """
    within = faces >= 0
    frames = surface.frames(np.maximum(faces, 0)) * within[:, None, None]
    corners = surface.faces[np.maximum(faces, 0)]
    tails, heads = ((corners[:, None] == at[..., None]).argmax(axis=2) for at in (ends[:-1], ends[1:]))
    free = np.zeros(len(ends), dtype=np.bool_)
    free[1:-1] = within[1:] & within[:-1]
    return Polylines(frames, tails, heads, free, shares)


def _detours(surface: FacesAround, path: Drawn) -> Iterator[_Detour]:
    """Yield the detours around vertices beside a path, but not around its ends."""
    edges = path.ends[1:-1].tolist()
    fixed = {int(path.ends[0, 0]), int(path.ends[-1, 0])}
    for first, edge in enumerate(edges):
        for vertex in edge:
            if vertex in fixed or (first and vertex in edges[first - 1]):
                continue
            last = first + 1
            while last < len(edges) and vertex in edges[last]:
                last += 1
            faces = surface.other_side(path.strip[first : last + 1], vertex)
            if faces:
                yield _Detour(first, last, faces)


def _gains(surface: FacesAround, path: Drawn, detours: list[_Detour]) -> FloatArray:
    """Return by how much detours are shorter, between the points where they begin and end."""
    faces: list[int] = []
    ends: list[list[int]] = []
    shares: list[float] = []
    given, at = path.ends.tolist(), path.lines.shares.tolist()
    for detour in detours:
        edges = [list(surface.common_edge(*pair)) for pair in pairwise(detour.faces)]
        ends += [given[detour.first], *edges, given[detour.last + 1]]
        shares += [at[detour.first], *[0.5] * len(edges), at[detour.last + 1]]
        faces += [*detour.faces, -1]
    lines = _lines(surface, np.array(faces[:-1]), np.array(ends), np.array(shares))
    begins = np.cumsum([0, *(len(detour.faces) + 1 for detour in detours[:-1])])
    lengths = np.add.reduceat(refracted(lines, exact=False).lengths, begins)
    passed = np.concatenate([[0.0], np.cumsum(path.lines.lengths)])
    first, last = np.array([(detour.first, detour.last + 1) for detour in detours]).T
    return np.asarray(passed[last] - passed[first] - lengths)
