"""Steepest descent on distances over measured faces: a first course for a path."""

from __future__ import annotations

import numpy as np

from geodesic_toolkit.analysis.paths.measured_faces import FacesAround
from geodesic_toolkit.core.types import FloatArray

__all__ = ["course_down"]

AT_VERTEX = 1e-6
"""Share of an edge within which a course goes on from its end."""


def course_down(
    surface: FacesAround, height: FloatArray, start: int, ends: set[int]
) -> list[list[int]]:
    """Return the course of steepest descent from a vertex to one of others.

    Parameters
    ----------
    surface : FacesAround
    height : ndarray of float64
        At all vertices; linear in each face.
    start : int
    ends : set of int

    Returns
    -------
    list of list of int
        Of each point the vertex, or the ends of the edge. Empty where the course ends elsewhere: in
        a local minimum, or where no face leads down.
    """
    course, share, came_from = [[start]], 0.0, -1
    for _ in range(3 * len(surface.faces)):
        here = course[-1]
        if len(here) == 1:
            if here[0] in ends:
                return course
            step = _from_vertex(surface, height, here[0])
        else:
            step = _from_edge(surface, height, here, share, came_from, ends)
        if step is None:
            return []
        there, share, came_from = step
        if len(there) > 1 and not AT_VERTEX < share < 1 - AT_VERTEX:
            there = [there[round(share)]]
        course.append(there)
    return []


_Step = tuple[list[int], float, int]
"""A place, the share of the second vertex in it, and the face that leads there."""


def _from_vertex(surface: FacesAround, height: FloatArray, vertex: int) -> _Step | None:
    """Return the steepest step down from a vertex."""
    steepest, found = 0.0, None
    for face in surface.around(vertex):
        corners = surface.corners(face)
        for other in corners:
            if other == vertex:
                continue
            drop = height[vertex] - height[other]
            length = surface.edge_length(face, vertex, other)
            if drop > steepest * length:
                steepest, found = drop / length, ([other], 0.0, face)
        rates, slope = _rates(surface, height, face)
        tail, head = (other for other in corners if other != vertex)
        along = [rates[corners.index(tail)], rates[corners.index(head)]]
        if slope > steepest and min(along) > 0:
            steepest, found = slope, ([tail, head], along[1] / sum(along), face)
    return found


def _from_edge(
    surface: FacesAround,
    height: FloatArray,
    edge: list[int],
    share: float,
    came_from: int,
    ends: set[int],
) -> _Step | None:
    """Return the step from a point of an edge across the next face, or down along the edge."""
    tail, head = edge
    for face in surface.with_corners(tail, head):
        if face == came_from:
            continue
        corners = surface.corners(face)
        other = next(vertex for vertex in corners if vertex not in edge)
        if other in ends:
            return [other], 0.0, face
        rates, _ = _rates(surface, height, face)
        rate = dict(zip(corners, rates, strict=True))
        if rate[other] > 0:
            # weights are (1 - share, share, 0) + t rates until one of the first is 0
            left = (1 - share) / -rate[tail] if rate[tail] < 0 else np.inf
            right = share / -rate[head] if rate[head] < 0 else np.inf
            time = min(left, right)
            kept = head if left < right else tail
            return [kept, other], min(1.0, time * rate[other]), face
    lower = min(edge, key=lambda vertex: float(height[vertex]))
    return [lower], 0.0, came_from


def _rates(surface: FacesAround, height: FloatArray, face: int) -> tuple[list[float], float]:
    """Return how weights of corners change on the way straight down, and the slope; 0 if flat."""
    (_, p, q), h = surface.frames(np.array([face]))[0].tolist(), height[surface.faces[face]]
    area = p[0] * q[1] - p[1] * q[0]
    if not area > 0:
        return [0.0, 0.0, 0.0], 0.0
    first, second = float(h[1] - h[0]), float(h[2] - h[0])
    x = (first * q[1] - second * p[1]) / area
    y = (second * p[0] - first * q[0]) / area
    one, other = -(x * q[1] - y * q[0]) / area, -(y * p[0] - x * p[1]) / area
    return [-(one + other), one, other], float(np.hypot(x, y))
