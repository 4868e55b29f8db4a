"""Steepest descent on distances over measured faces: a first course for a path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from geodesic_toolkit.analysis.paths.metric.faces import FacesAround
from geodesic_toolkit.core.types import FloatArray

__all__ = ["Descent"]

AT_VERTEX = 1e-6
"""Share of an edge within which a course goes on from its end."""

MAX_POINTS_PER_FACE = 3
"""Points per face after which a course is given up; one that goes down is never that long."""


class _Step(NamedTuple):
    """A vertex or the ends of an edge, the share of the second one, the face that leads there."""

    support: list[int]
    share: float
    face: int


@dataclass(frozen=True, eq=False)
class Descent:
    """Steepest descent over measured faces.

    Attributes
    ----------
    surface : FacesAround
    height : ndarray of float64
        At all vertices; linear in each face.
    ends : set of int
        Vertices at which a course ends.
    """

    surface: FacesAround
    height: FloatArray
    ends: set[int]

    def course(self, start: int) -> list[list[int]]:
        """Return the course from a vertex: of each point the vertex, or the ends of the edge.

        Empty where it does not lead to an end: in a local minimum, or where no face leads down.
        """
        step = _Step([start], 0.0, -1)
        course = [step.support]
        for _ in range(MAX_POINTS_PER_FACE * len(self.surface.faces)):
            if len(step.support) == 1 and step.support[0] in self.ends:
                return course
            onward = self._from_edge(step) if len(step.support) > 1 else self._from_vertex(step)
            if onward is None:
                return []
            step = onward
            if len(step.support) > 1 and not AT_VERTEX < step.share < 1 - AT_VERTEX:
                step = _Step([step.support[round(step.share)]], 0.0, step.face)
            course.append(step.support)
        return []

    def _from_vertex(self, last: _Step) -> _Step | None:
        """Return the steepest step down from a vertex, along an edge or across a face."""
        vertex = last.support[0]
        steepest, found = 0.0, None
        for face in self.surface.around(vertex):
            rate, slope = self._down(face)
            tail, head = (other for other in rate if other != vertex)
            for other in (tail, head):
                drop = float(self.height[vertex] - self.height[other])
                length = self.surface.edge_length(face, vertex, other)
                if drop > steepest * length:
                    steepest, found = drop / length, _Step([other], 0.0, face)
            if slope > steepest and rate[tail] > 0 and rate[head] > 0:
                share = rate[head] / (rate[tail] + rate[head])
                steepest, found = slope, _Step([tail, head], share, face)
        return found

    def _from_edge(self, last: _Step) -> _Step:
        """Return the step from a point of an edge across the next face, or down along the edge."""
        (tail, head), share, came_from = last
        for face in self.surface.with_corners(tail, head):
            if face == came_from:
                continue
            rate, _ = self._down(face)
            other = next(vertex for vertex in rate if vertex not in (tail, head))
            if other in self.ends:
                return _Step([other], 0.0, face)
            if rate[other] > 0:  # weights change by the rates until that of tail or head is 0
                to_head = (1 - share) / -rate[tail] if rate[tail] < 0 else np.inf
                to_tail = share / -rate[head] if rate[head] < 0 else np.inf
                beside = head if to_head < to_tail else tail
                weight = min(to_head, to_tail) * rate[other]
                return _Step([beside, other], min(1.0, weight), face)
        lower = tail if self.height[tail] < self.height[head] else head
        return _Step([lower], 0.0, came_from)

    def _down(self, face: int) -> tuple[dict[int, float], float]:
        """Return how the weights of the corners change straight down, and the slope; 0 if flat."""
        (_, p, q) = self.surface.frames(np.array([face]))[0].tolist()
        corners = self.surface.corners(face)
        low, first, second = self.height[corners].tolist()
        area = p[0] * q[1] - p[1] * q[0]
        if not area > 0:
            return dict.fromkeys(corners, 0.0), 0.0
        x = ((first - low) * q[1] - (second - low) * p[1]) / area  # the gradient
        y = ((second - low) * p[0] - (first - low) * q[0]) / area
        one, other = (y * q[0] - x * q[1]) / area, (x * p[1] - y * p[0]) / area
        return dict(zip(corners, (-(one + other), one, other), strict=True)), float(np.hypot(x, y))
