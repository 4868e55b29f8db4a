"""Refinement: wavefronts that follow the curvature of the surface, swept over its triangles.

The heat method's error, one to three per cent, comes from solving a smoothed problem. Its order is
correct, however: vertices sorted by heat are nearly sorted by distance. In that order the distance
of each vertex follows from triangles whose other corners have distances already, by unfolding into
the plane.

The front that crosses a triangle is a circle around a virtual source. If its radius were the
distance itself, the surface between source and triangle would be treated as flat, and the method
would be first order. So every vertex carries the geodesic curvature κ of the front through it, the
virtual source lies at 1/κ, and κ follows the Riccati equation ``κ' = -κ² - K`` with K the Gaussian
curvature: second order on smooth surfaces.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.core.arrays import empty, joined
from geodesic_toolkit.core.near import NearRows
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.discretization.heat import Heat
from geodesic_toolkit.errors import UnsupportedDomainError
from geodesic_toolkit.geometry.frames import ComplexArray
from geodesic_toolkit.geometry.intrinsic import MOST_SIDES, cut_disagreeing
from geodesic_toolkit.refinement.sight import Sight, in_sight, missing_triangles
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["WavefrontSweeper", "made_of_triangles"]

SWEEP_TOLERANCE = 1e-6
"""Improvement, in mean edge lengths, below which a vertex is left as it is.

With 3e-4 sweeps take 1 % less time (87.7 instead of 89.0 ms of CPU a source at 557,000 vertices),
and distances differ by as much as 3e-4 of the largest; over the rings of a long tube the direction
of the front is no longer updated.
"""

MAX_SWEEPS = 100
"""Maximum number of sweeps that improve distances, unless a vertex has not been reached; usually
there are two, of which the second changes nothing."""

MAX_RETURNS_PER_VERTEX = 8
"""Number of times per vertex that a sweep may go back in its order; it does so 0.01 to 0.1 times,
and then one sweep is enough. The limit bounds sweeps if heat is unrelated to distance.

Measured at 173,000 vertices: 36 ms a source, and 154 ms without returns. Distances differ by 0.005
edge lengths on average, in both directions: the mean error from 100 sources on a fox of 313
vertices is 0.733 %, without 0.735 %; from 25 on a horse of 2,400 it is 0.193 % and 0.194 %.
"""

MAX_RETURNS_PER_POINT = 0.1
"""The same on point clouds, whose stars are not symmetric, so that returns may continue for long.

With 8 a sweep over 54,000 points of a street took 6.8 s instead of 0.3. With 0.1 sweeps take 0.04
to 0.9 of the time without returns, at worst 1.3 times as long: 18 clouds of 300 to 307,000 points,
of sensors and of surfaces, three sources each. Mean errors of 48 sources on eight clouds are equal
to 0.002 percentage points for anything from 0 to 8.
"""

MIN_VERTICES_OF_EARLY_RETURNS = 1_000
"""Minimum number of vertices for returns in the first sweep; on smaller meshes it follows the order
of the heat, because returns do not save time there.

In the battery of docs/accuracy.md this matters for one source, of five on a fox of 313 vertices:
the error on this mesh is 0.44 % with such a first sweep and 0.52 % without. With a hundred sources
there is no difference. Seven meshes, of 20 to 60 sources each: 0.2225 and 0.2224 %.
"""

CURVATURE_OF_HALF_WEIGHT = 0.3
"""Curvature of a vertex, K h², at which it is halved.

A vertex is not a sample of a smooth surface if its angle defect is of the order of 1; there the
front splits instead of bending. K is damped to ``K / (1 + |K| h² / CURVATURE_OF_HALF_WEIGHT)``; on
smooth surfaces the damping vanishes with h².
"""

CURVATURE_OF_HALF_WEIGHT_ON_STARS = 0.1
"""The same on point clouds, whose stars disagree. The mean error over random samples of five meshes
is 0.95 % with it, 1.08 % with 0.3 and 0.74 % without curvature; over clouds of the vertices of ten
meshes 0.25, 0.26 and 0.45 %."""

MIN_DEFECT_OF_CORNERS = 0.5
"""Minimum absolute angle defect of a vertex whose edges are not flipped.

Over the battery of docs/accuracy.md the mean error is 0.172 % on the given triangles, 0.179 if all
are made Delaunay (that fox has vertices of 0.5 to 1.5, and its error rises from 0.44 to 0.67) and
0.161 with this limit; 0.3 and 0.7 give 0.162 and 0.166.
"""

MIN_ANGLE_OF_REFLEX_CORNERS = 0.8
"""Minimum angle beyond π at a boundary vertex around which fronts along an edge turn: the region
behind it sees only that vertex. The error on plates with a notch is 0.42 instead of 0.55 %, on a
mesh with holes 0.53 instead of 0.64. A limit of 0.1 gives 0.51 there, but 0.45 instead of 0.19 on
the small shells of a truck, whose rims are rarely corners. Inside the surface the front is bent by
K already, and a turn in addition is worse.
"""


def made_of_triangles(metric: Discretization) -> bool:
    """Return True if a discretization has triangles for fronts: its own, or a subdivision."""
    return metric.subdivision is not None or _has_triangles(metric)


def _has_triangles(metric: Discretization) -> bool:
    gradient = metric.on_surface
    return isinstance(gradient, ElementGradient) and gradient.of_planes


@dataclass(frozen=True, eq=False)
class WavefrontSweeper:
    """Triangles prepared for sweeps; shared by all sources and threads.

    Parameters
    ----------
    metric : Discretization
        The elements of its gradient must be triangles.

    Raises
    ------
    UnsupportedDomainError
        The elements are not triangles.
    """

    metric: Discretization

    def __post_init__(self) -> None:
        if not _has_triangles(self.metric):
            raise UnsupportedDomainError(
                "refinement needs triangles, and this discretization has "
                f"{self.metric.gradient!r}; use refine=False"
            )

    def prepare(self) -> "WavefrontSweeper":
        """Compute the data that all sources share, and return the sweeper."""
        _ = self._fronts
        return self

    def distance(self, log_heat: FloatArray, points: SourcePoints) -> FloatArray:
        """Return refined distances (N,) from one set of sources, in the order of log u, (N,)."""
        distances = empty((1, len(log_heat)), np.float64)
        self.fill(distances, Heat.of_log(log_heat[:, None]), [points])
        return np.asarray(distances[0])

    def fill(
        self,
        distances: FloatArray,
        heat: Heat,
        block: Sequence[SourcePoints],
        *,
        n_threads: int = 1,
        kappas: FloatArray | None = None,
    ) -> None:
        """Write refined distances from each of K source sets.

        Parameters
        ----------
        distances : ndarray of shape (K, N), float64
            ``inf`` at vertices that triangles do not connect to a source.
        heat : Heat of shape (N, K)
            Gives the order of visits.
        block : sequence of SourcePoints
            Distances at and around the points are taken as exact.
        n_threads : int, optional
            Threads that share the sets.
        kappas : ndarray of shape (K, N), float64, optional
            Takes the geodesic curvature of the front at each vertex.
        """
        late = any(points.delayed for points in block)
        self._fronts.sweep(*self._arguments(heat, block), distances, kappas, n_threads, late)

    def near(self, heat: Heat, block: Sequence[SourcePoints], limits: FloatArray) -> NearRows:
        """Return refined distances from each of K source sets up to a limit, and of some beyond.

        Up to the limit they are to the bit those of `fill`.

        Parameters
        ----------
        heat : Heat of shape (N, K)
        block : sequence of SourcePoints
        limits : ndarray of shape (K,), float64

        Returns
        -------
        NearRows
        """
        late = any(points.delayed for points in block)
        return NearRows(
            *self._fronts.sweep_near(*self._arguments(heat, block), limits, have_offsets=late)
        )

    def _arguments(
        self, heat: Heat, block: Sequence[SourcePoints]
    ) -> tuple[
        FloatArray, bool, IntArray, IntArray, FloatArray, FloatArray, FloatArray, int, int, int
    ]:
        """Return the first arguments of both kernels: the heat, the sources, and the effort."""
        fronts = [self._fronts_at(points) for points in block]
        vertices, known, curvatures = (joined(parts) for parts in zip(*fronts, strict=True))
        begins = np.array([0, *accumulate(len(own) for own, _, _ in fronts)], dtype=np.int64)
        scales = np.minimum.reduceat(self.metric.scales[vertices], begins[:-1])
        count = self._gradient.n_vertices
        returns = MAX_RETURNS_PER_POINT if self._gradient.stars else MAX_RETURNS_PER_VERTEX
        return (
            *heat.for_kernels(),
            begins,
            vertices,
            known,
            curvatures,
            SWEEP_TOLERANCE * scales,
            int(returns * count),
            int(count < MIN_VERTICES_OF_EARLY_RETURNS),
            MAX_SWEEPS,
        )

    def distance_within(self, points: SourcePoints, latest: FloatArray) -> FloatArray:
        """Return refined distances (N,) from one set of sources to vertices that are near enough.

        No heat is needed: vertices are visited as fronts come to them.

        Parameters
        ----------
        points : SourcePoints
        latest : ndarray of shape (N,), float64
            Fronts do not enter a vertex at this distance or later.

        Returns
        -------
        ndarray of shape (N,), float64
            ``inf`` at vertices that fronts do not enter.
        """
        distances = empty((len(latest),), np.float64)
        vertices, known, curvatures = self._fronts_at(points)
        self._fronts.sweep_limited(
            vertices,
            known,
            curvatures,
            SWEEP_TOLERANCE * float(self.metric.scales[vertices].min()),
            latest,
            MAX_SWEEPS * len(latest),
            distances,
            have_offsets=points.delayed,
        )
        return distances

    def tracer(self, turns: ComplexArray, mirrored: BoolArray) -> _native.Tracer:
        """Return the triangles with the directions of their edges, for what fronts carry along.

        Parameters
        ----------
        turns : ndarray of shape (E, 3), complex128
            From tangent frames at the corners into the triangles, as :class:`Frames` has them.
        mirrored : ndarray of shape (E,), bool
        """
        gradient, stars = self._gradient, self._gradient.stars
        flat = _native.edge_lengths(gradient.inverse_frames)
        paired = not stars and 0 < gradient.elements.size <= MOST_SIDES
        twin = self._twins[0].copy() if paired else np.zeros(0, dtype=np.int64)
        pairs = np.ascontiguousarray(turns).view(np.float64)
        angles, scales = _native.directions_of(gradient.elements, flat, pairs, mirrored, twin)
        held = self._held
        if held is not None:
            _native.flip_edges_with_directions(
                gradient.elements.copy(), flat, twin, held, angles, scales
            )
        elements, frames, _ = self._triangles
        return _native.Tracer(
            elements,
            frames,
            stars,
            bool(len(self.metric.surface_frames)),
            self.metric.boundary,
            flat,
            angles,
            scales,
            self._curvature,
            self._reflex,
        )

    def _fronts_at(self, points: SourcePoints) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return the vertices at and around points, and the front there: d and κ.

        A point of a cloud may be in almost no star except its own, because others represent or hide
        it. If such a point is a source, distances to the points of its own star are set directly.
        On repeated passes in pairs this reduces the worst error from 19 to 2 %; if all sources did
        so, the error on bunny.off would rise by a hundredth.

        Around a source between vertices, fronts also begin at what is in sight besides these.
        """
        vertices, known, curvatures = points.vertices, points.distances, points.curvatures
        if points.delayed:
            known = known + points.starts[points.rows]
        if len(self._seldom_updated):
            for place in np.flatnonzero(self._seldom_updated[vertices] & (points.distances == 0)):
                others, lengths = self._ring(int(vertices[place]))
                vertices = np.append(vertices, others)
                curvatures = np.append(curvatures, 1 / lengths)
                known = np.append(known, known[place] + lengths)
        if points.front_curvatures is None and not points.are_vertices:
            sight = self.in_sight(points)
            vertices = np.append(vertices, sight.vertices)
            known = np.append(known, sight.distances + points.starts[sight.rows])
            curvatures = np.append(curvatures, 1 / sight.distances)
        return vertices, known, curvatures

    def in_sight(self, points: SourcePoints) -> Sight:
        """Return the vertices in sight of sources between vertices, besides those around them."""
        self.prepare()
        given, frames = self.metric.unflipped or self._gradient, self.metric.surface_frames
        frames = frames if len(frames) else given.inverse_frames
        return in_sight(points, given, frames, self._hidden)

    @cached_property
    def _hidden(self) -> BoolArray:
        """A mask, (N,), of the vertices of triangles that are not those that fronts cross.

        A source in such a triangle may be hidden from its corners by edges that were flipped.
        """
        given, mask = self.metric.unflipped, self._flipped.copy()
        if given is not None:
            mask[missing_triangles(given.elements, self._gradient.elements)] = True
        return mask

    def _ring(self, centre: int) -> tuple[IntArray, FloatArray]:
        """Return the other points of a star, and their distances."""
        gradient, given = self._gradient, self.metric.surface_frames
        rows = np.flatnonzero(gradient.elements[:, 0] == centre)
        others = gradient.elements[rows]
        lengths = _native.edge_lengths(
            np.ascontiguousarray((given if len(given) else gradient.inverse_frames)[rows])
        )
        ring, first = np.unique(others[:, 1:], return_index=True)
        return ring, lengths[:, [2, 1]].ravel()[first]

    @cached_property
    def _seldom_updated(self) -> BoolArray:
        """A mask, (N,), of points in the stars of fewer than 3 of 4 of their neighbours.

        It is empty if there are none.
        """
        gradient = self._gradient
        if not gradient.stars:
            return np.zeros(0, dtype=np.bool_)
        own = np.bincount(gradient.elements[:, 0], minlength=gradient.n_vertices)
        others = np.bincount(gradient.elements[:, 1:].ravel(), minlength=gradient.n_vertices)
        seldom = 2 * others < 3 * own  # a star that has a point has two triangles with it
        return np.asarray(seldom if seldom.any() else seldom[:0])

    @cached_property
    def _fronts(self) -> _native.Sweeper:
        """The triangles and their curvature, prepared for any source.

        Intermediate data, which take the same memory again, are not kept.
        """
        fronts = _native.Sweeper(self._corners, self._curvature, self._reflex)
        _ = self._flipped
        for name in (
            "_corners",
            "_curvature",
            "_reflex",
            "_defects",
            "_triangles",
            "_held",
            "_twins",
        ):
            self.__dict__.pop(name, None)
        return fronts

    @cached_property
    def _corners(self) -> _native.Corners:
        """The triangles around each vertex.

        If stars overlap, a vertex is updated only from its own star, which comes first: the
        shortest of several slightly different measurements would be too short. If stars are
        measured in space, and so differ little, it is also updated from triangles that its star
        lacks.
        """
        elements, frames, _ = self._triangles
        stars, add_missed = self._gradient.stars, bool(len(self.metric.surface_frames))
        boundary, agree = self.metric.boundary, self.metric.edges_agree
        return _native.gather_corners(elements, frames, stars, add_missed, boundary, agree)

    @cached_property
    def _triangles(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """The triangles that fronts cross: (elements, inverse frames, areas).

        They are measured along the surface if that is known. On a mesh they are intrinsically
        Delaunay, but keep the edges of vertices that are not samples of a smooth surface.
        """
        gradient, given = self._gradient, self.metric.surface_frames
        elements, inverse, areas = gradient.elements, gradient.inverse_frames, gradient.measure
        if len(given):
            return elements, given, areas
        held = self._held
        if held is None:
            return elements, inverse, areas
        faces, lengths = elements.copy(), _native.edge_lengths(inverse)
        if not _native.flip_edges(faces, lengths, self._twins[0].copy(), held):
            return elements, inverse, areas
        return faces, *_native.measure_lengths(lengths)

    @cached_property
    def _flipped(self) -> BoolArray:
        """A mask, (N,), of the vertices of triangles whose edges are flipped here."""
        given, flipped = self._gradient.elements, self._triangles[0]
        mask = np.zeros(self._gradient.n_vertices, dtype=np.bool_)
        if flipped is not given:
            mask[given[(flipped != given).any(axis=1)]] = True
        return mask

    @cached_property
    def _held(self) -> BoolArray | None:
        """The (N,) vertices whose edges are not flipped; None where nothing is."""
        gradient = self._gradient
        if len(self.metric.surface_frames) or self.metric.triangulation == "intrinsic Delaunay":
            return None  # in the latter case nothing is left to flip
        paired = not gradient.stars and 0 < gradient.elements.size <= MOST_SIDES
        inverse = gradient.inverse_frames
        if not paired or not (inverse[:, 0] * inverse[:, 2]).all():
            return None
        if not self._twins[1]:
            return None
        return np.asarray(~self.metric.boundary & (np.abs(self._defects) > MIN_DEFECT_OF_CORNERS))

    @cached_property
    def _twins(self) -> tuple[IntArray, bool]:
        """The twins of half-edges, and whether neighbours agree; flips change a copy of twins."""
        gradient = self._gradient
        twin, coherent = _native.sorted_half_edges(gradient.elements, gradient.n_vertices).twins()
        if not self.metric.edges_agree:
            cut_disagreeing(twin, _native.edge_lengths(gradient.inverse_frames))
        return twin, coherent

    @cached_property
    def _torn(self) -> IntArray:
        """The vertices of edges about whose length two triangles disagree.

        The angles around them do not sum to a curvature.
        """
        gradient = self._gradient
        sides = _native.edge_lengths(gradient.inverse_frames)
        twin, _ = _native.sorted_half_edges(gradient.elements, gradient.n_vertices).twins()
        halves = np.flatnonzero(cut_disagreeing(twin, sides))
        ends = [gradient.elements[halves // 3, (halves + step) % 3] for step in (1, 2)]
        return np.concatenate(ends)

    @cached_property
    def _defects(self) -> FloatArray:
        """The angle defects, (N,): 2π, or π at the boundary, minus the total angles."""
        triangles = (self._gradient.elements, self._gradient.inverse_frames)
        return _native.angle_defects(*triangles, self.metric.boundary)

    @cached_property
    def _reflex(self) -> BoolArray:
        """A mask, (N,), of reflex corners of the boundary, around which fronts turn."""
        boundary = self.metric.boundary
        if self._gradient.stars or not boundary.any():
            return np.zeros(len(boundary), dtype=np.bool_)
        return np.asarray(boundary & (self._defects < -MIN_ANGLE_OF_REFLEX_CORNERS))

    @property
    def _gradient(self) -> ElementGradient:
        gradient = self.metric.on_surface
        assert isinstance(gradient, ElementGradient)  # for the type checker; checked on creation
        return gradient

    @cached_property
    def _curvature(self) -> FloatArray:
        """The (N,) Gaussian curvature, angle defect over area, averaged over one-rings.

        Stars have an angle defect if they are measured in space; in tangent planes they are flat,
        and their differences are mostly noise.
        """
        gradient = self._gradient
        if gradient.stars and not len(self.metric.surface_frames):
            return np.zeros(gradient.n_vertices)
        elements, frames, areas = self._triangles
        boundary = self.metric.boundary
        if gradient.stars:
            return _native.star_curvatures(
                elements, frames, boundary, CURVATURE_OF_HALF_WEIGHT_ON_STARS
            )
        defects = self._defects
        if not self.metric.edges_agree:
            defects = defects.copy()
            defects[self._torn] = 0.0
        triangles = (elements, areas, defects)
        return _native.curvatures(*triangles, self._corners, boundary, CURVATURE_OF_HALF_WEIGHT)
