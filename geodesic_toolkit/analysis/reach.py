"""Paths on large clouds, by distances near the path alone."""

from dataclasses import dataclass, replace

import numpy as np

from geodesic_toolkit._typing import BoolArray, FloatArray, IntArray
from geodesic_toolkit.analysis.star_ways import path_down
from geodesic_toolkit.discretization import Discretization
from geodesic_toolkit.domains import PointCloud
from geodesic_toolkit.gradient import ElementGradient
from geodesic_toolkit.refine import WavefrontSweeper, made_of_triangles
from geodesic_toolkit.solver import GeodesicSolver
from geodesic_toolkit.source_points import SourcePoints

__all__ = ["path_within_reach"]

REGION = 30_000
"""Points of the cloud that fronts are swept over; clouds of no more are taken whole. From source to
target 1,000 spacings away it is a band of 30."""

MOVES = 8
"""Times that the region is moved to where the path has come to its rim; after that the whole cloud
is swept over."""

DOUBT = (1.1, 5.0)
"""Factor and summand, in powers of e, within which heat does not tell which source is nearest: its
decay depends on the direction and on the spacing."""


def path_within_reach(
    solver: GeodesicSolver, sources: SourcePoints, goal: SourcePoints
) -> tuple[IntArray, FloatArray] | None:
    """Return corners and weights of a path, as `path_down` does, from a part of a large cloud.

    The product of the heats of both ends is greatest along the shortest path. Where it is greatest
    fronts are swept from both, and the path found; while that comes to the rim of this region, the
    region is moved along.

    Parameters
    ----------
    solver : GeodesicSolver
        Of a cloud.
    sources, goal : SourcePoints
        At vertices; one is the goal, and none of the sources.

    Returns
    -------
    (corners, weights) or None
        None where the whole cloud is to be looked at: it is not large, heat does not connect, the
        nearest source is in doubt, or the region does not hold the path.
    """
    cloud, method = solver.domain, solver.method
    assert isinstance(cloud, PointCloud)  # for the type checker
    if cloud.n_vertices <= REGION or not made_of_triangles(method.metric):
        return None
    start = int(goal.vertices[0])
    heat, behind = method.log_heat(sources), method.log_heat(goal)
    both = np.where(np.isfinite(heat) & np.isfinite(behind), heat + behind, -np.inf)
    if both[start] == -np.inf:
        return None
    within = np.zeros(cloud.n_vertices, dtype=np.bool_)
    within[np.argpartition(-both, REGION)[:REGION]] = True
    within &= both > -np.inf
    falls = -behind[sources.vertices]
    near = sources.vertices[falls <= DOUBT[0] * falls.min() + DOUBT[1]]
    if not within[start] or not within[near].all():
        return None
    for _ in range(MOVES):
        part = _Part.of(method.metric, within)
        path = part.path(cloud.points, heat, behind, sources, start)
        if path is None:
            return None
        passed = path[0][path[1] > 0]
        if not part.rim[passed].any():
            return path
        within = _around(method.metric, passed, REGION)
        within[near] = True
    return None


@dataclass(frozen=True, eq=False)
class _Part:
    """A part of a metric of stars.

    Attributes
    ----------
    metric : Discretization
        On the vertices of the part.
    vertices : ndarray of shape (n,), int64
        These by their numbers in the whole.
    rim : ndarray of shape (N,), bool
        Vertices of the whole that have lost a triangle.
    """

    metric: Discretization
    vertices: IntArray
    rim: BoolArray

    @classmethod
    def of(cls, metric: Discretization, within: BoolArray) -> "_Part":
        """Return the part on some (N,) vertices."""
        gradient = metric.gradient
        assert isinstance(gradient, ElementGradient)  # for the type checker
        inside = within[gradient.elements]
        whole = inside.all(axis=1)
        rim = np.zeros(len(within), dtype=np.bool_)
        rim[gradient.elements[inside.any(axis=1) & ~whole]] = True
        vertices = np.flatnonzero(within)
        number = np.full(len(within), -1)
        number[vertices] = np.arange(len(vertices))
        part = ElementGradient(
            number[gradient.elements[whole]],
            gradient.coefficients[whole],
            gradient.measure[whole],
            len(vertices),
            stars=gradient.stars,
        )
        frames = metric.surface_frames
        discretization = Discretization(
            mass=metric.mass[vertices],
            stiffness=part.stiffness(),
            gradient=part,
            spacing=metric.spacing,
            boundary=metric.boundary[vertices] | rim[vertices],  # angles there are incomplete
            surface_frames=frames[whole] if len(frames) else frames,
        )
        return cls(discretization, vertices, rim)

    def path(
        self,
        points: FloatArray,
        heat: FloatArray,
        behind: FloatArray,
        sources: SourcePoints,
        start: int,
    ) -> tuple[IntArray, FloatArray] | None:
        """Return the path from sources to a start, in numbers of the whole."""
        here = np.flatnonzero(np.isin(sources.vertices, self.vertices))
        ends = np.searchsorted(self.vertices, sources.vertices[here])
        first = np.searchsorted(self.vertices, [start])
        sweeper, count = WavefrontSweeper(self.metric), len(self.vertices)
        places = replace(
            SourcePoints.at_vertices(ends, count),
            distances=sources.distances[here],
            front_curvatures=sources.curvatures[here],
        )
        distance = sweeper.distance(heat[self.vertices], places)
        back = sweeper.distance(behind[self.vertices], SourcePoints.at_vertices(first, count))
        if not np.isfinite(distance[first[0]]):
            return None
        path = path_down(self.metric, points[self.vertices], distance, back, ends, int(first[0]))
        return None if path is None else (self.vertices[path[0]], path[1])


def _around(metric: Discretization, vertices: IntArray, size: int) -> BoolArray:
    """Return at least so many vertices around some, ring by ring, as far as there are any."""
    starts, neighbours, _ = metric.rows.arrays
    within = np.zeros(metric.n_vertices, dtype=np.bool_)
    front = np.unique(vertices)
    count = 0
    while len(front) and count < size:
        within[front] = True
        count += len(front)
        lengths = starts[front + 1] - starts[front]
        places = np.repeat(starts[front] - np.cumsum(lengths) + lengths, lengths)
        beside = np.unique(neighbours[places + np.arange(len(places))])
        front = beside[~within[beside]]
    return within
