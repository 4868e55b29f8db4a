"""Paths on large clouds, from distances near the path alone."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from geodesic_toolkit.analysis.paths.star_paths import length_of, path_down, stars_connect
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.domains import PointCloud
from geodesic_toolkit.refinement.wavefronts import WavefrontSweeper, made_of_triangles
from geodesic_toolkit.solver.solver import GeodesicSolver
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["path_within_reach"]

MAX_POINTS_OF_REGION = 30_000
"""Number of points of the region over which fronts are swept; smaller clouds are swept whole.
Between a source and a target 1,000 spacings apart the region is a band of 30 spacings."""

AT_ENDS = 2_000
"""Number of points around each end that are added to the region: the set of greatest heat is a
lens, which is a tip at either end."""

MAX_MOVES_OF_REGION = 8
"""Number of times that the region is moved to a path that has reached its rim; then the whole cloud
is swept."""

MIN_RELATIVE_SHORTENING = 1e-4
"""Share of its length by which a path must have become shorter for the region to be moved again.
Paths between almost opposite points of a sphere are equally long in all directions."""

DOUBT_OF_LOG_HEAT = (1.1, 5.0)
"""Factor and summand, in powers of e, within which heat does not decide which source is nearest:
its decay depends on the direction and on the spacing."""


def path_within_reach(
    solver: GeodesicSolver, sources: SourcePoints, goal: SourcePoints
) -> tuple[IntArray, FloatArray] | None:
    """Return the corners and weights of a path, as `path_down` does, from a part of a large cloud.

    The product of the heats of both ends is greatest along the shortest path. Fronts are swept from
    both ends over the region of the greatest products, and the path is found there. If it reaches
    the rim of the region, the region is moved to the path.

    Parameters
    ----------
    solver : GeodesicSolver
        Of a cloud.
    sources, goal : SourcePoints
        At vertices; the goal is a single one, and not a source.

    Returns
    -------
    (corners, weights) or None
        None if the whole cloud is needed: it is not large, heat does not connect the ends, the
        nearest source is in doubt, or the region does not hold the path.
    """
    cloud, method = solver.domain, solver.method
    assert isinstance(cloud, PointCloud)  # for the type checker
    if cloud.n_vertices <= MAX_POINTS_OF_REGION or not made_of_triangles(method.metric):
        return None
    start = int(goal.vertices[0])
    search = _Search(
        method.metric,
        cloud.points,
        method.log_heat(sources),
        method.log_heat(goal),
        sources,
        start,
    )
    within = search.first_region()
    return None if within is None else search.follow(within)


@dataclass(frozen=True, eq=False)
class _Search:
    """A search near the path; `heat` and `behind` are log u (N,) of sources and start."""

    metric: Discretization
    points: FloatArray
    heat: FloatArray
    behind: FloatArray
    sources: SourcePoints
    start: int

    @cached_property
    def near(self) -> IntArray:
        """Vertices of the sources that are candidates for the nearest."""
        falls = -self.behind[self.sources.vertices]
        least = falls.min()
        near: IntArray = self.sources.vertices[
            falls <= DOUBT_OF_LOG_HEAT[0] * least + DOUBT_OF_LOG_HEAT[1]
        ]
        return near

    def first_region(self) -> BoolArray | None:
        """Return whether heat is among the greatest at each vertex; None if that is undecided."""
        both = self.heat + self.behind
        if not np.isfinite(both[self.start]):
            return None
        within = np.zeros(len(both), dtype=np.bool_)
        within[np.argpartition(-both, MAX_POINTS_OF_REGION)[:MAX_POINTS_OF_REGION]] = True
        within &= both > -np.inf
        if not within[self.start] or not within[self.near].all():
            return None
        hottest = self.sources.vertices[np.argmax(self.behind[self.sources.vertices])]
        return within | _around(self.metric, np.array([self.start, hottest]), AT_ENDS)

    def follow(self, within: BoolArray) -> tuple[IntArray, FloatArray] | None:
        """Return the path from a region, which is moved while that makes the path shorter.

        None if it is still moving after `MAX_MOVES_OF_REGION` moves, or if nothing connects.
        """
        best, shortest = None, np.inf
        for move in range(MAX_MOVES_OF_REGION):
            part = _Part.of(self.metric, within)
            path = self.path(part)
            if path is None and move == 0:  # the region of great heat is disconnected
                within = self.around(self.up())
                continue
            if path is None:
                return None
            length = length_of(self.points, *path)
            settled = length >= (1 - MIN_RELATIVE_SHORTENING) * shortest
            if length < shortest:
                best, shortest = path, length
            passed = path[0][path[1] > 0]
            if settled or not part.rim[passed].any():
                return best
            within = self.around(passed)
        return None

    def path(self, part: "_Part") -> tuple[IntArray, FloatArray] | None:
        """Return the path within a part, in vertex indices of the whole cloud."""
        here = np.flatnonzero(np.isin(self.sources.vertices, part.vertices))
        ends = np.searchsorted(part.vertices, self.sources.vertices[here])
        first = np.searchsorted(part.vertices, [self.start])
        sweeper, count = WavefrontSweeper(part.metric), len(part.vertices)
        located = replace(
            SourcePoints.at_vertices(ends, count),
            distances=self.sources.distances[here],
            front_curvatures=self.sources.curvatures[here],
        )
        distance = sweeper.distance(self.heat[part.vertices], located)
        # Heat flows over a bridge, a triangle of one star alone between sheets; the region then
        # holds no other path.
        if not np.isfinite(distance[first[0]]) or not stars_connect(
            part.metric, ends, int(first[0])
        ):
            return None
        goal = SourcePoints.at_vertices(first, count)
        back = sweeper.distance(self.behind[part.vertices], goal)
        points = self.points[part.vertices]
        path = path_down(part.metric, points, distance, back, ends=ends, start=int(first[0]))
        return None if path is None else (part.vertices[path[0]], path[1])

    def up(self) -> IntArray:
        """Return the vertices along edges from the start to a local maximum of the heat."""
        starts, neighbours, _ = self.metric.rows.arrays
        chain = [self.start]
        while True:
            beside = neighbours[starts[chain[-1]] : starts[chain[-1] + 1]]
            hottest = int(beside[np.argmax(self.heat[beside])]) if len(beside) else chain[-1]
            if not self.heat[hottest] > self.heat[chain[-1]]:
                return np.array(chain)
            chain.append(hottest)

    def around(self, vertices: IntArray) -> BoolArray:
        """Return a region around vertices and around the candidates for the nearest source."""
        within = _around(self.metric, vertices, MAX_POINTS_OF_REGION)
        within[self.near] = True
        return within


@dataclass(frozen=True, eq=False)
class _Part:
    """A part of a metric of stars.

    Attributes
    ----------
    metric : Discretization
        On the vertices of the part.
    vertices : ndarray of shape (n,), int64
        Indices of these vertices in the whole.
    rim : ndarray of shape (N,), bool
        Vertices of the whole cloud that have lost a triangle.
    """

    metric: Discretization
    vertices: IntArray
    rim: BoolArray

    @classmethod
    def of(cls, metric: Discretization, within: BoolArray) -> "_Part":
        """Return the part on the vertices where the mask `within` (N,) is true."""
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
            copy=False,
        )
        frames = metric.surface_frames
        discretization = Discretization(
            mass=metric.mass[vertices],
            stiffness=part.stiffness(),
            gradient=part,
            spacing=metric.spacing,
            boundary=metric.boundary[vertices] | rim[vertices],  # angles there are incomplete
            surface_frames=frames[whole] if len(frames) else frames,
            copy=False,
        )
        return cls(discretization, vertices, rim)


def _around(metric: Discretization, vertices: IntArray, size: int) -> BoolArray:
    """Return at least `size` vertices around some, ring by ring, or all that are connected."""
    starts, neighbours, _ = metric.rows.arrays
    within = np.zeros(metric.n_vertices, dtype=np.bool_)
    front = np.unique(vertices)
    count = 0
    while len(front) and count < size:
        within[front] = True
        count += len(front)
        lengths = starts[front + 1] - starts[front]
        positions = np.repeat(starts[front] - np.cumsum(lengths) + lengths, lengths)
        beside = np.unique(neighbours[positions + np.arange(len(positions))]).astype(np.int64)
        front = beside[~within[beside]]
    return within
