"""Refinement: wavefronts that know the curvature of the surface, swept over its triangles.

The heat method's error, one to three per cent, comes from solving a smoothed problem. Its order is
right, though: vertices sorted by heat are sorted by distance, or nearly. In that order each vertex
can take its distance from triangles whose other corners have theirs, by unfolding into the plane.

The front that crosses a triangle is a circle about a virtual source. If its radius were the
distance itself, the surface between source and triangle would be taken for flat, which makes the
method first order. So every vertex carries the geodesic curvature κ of the front through it, the
virtual source lies at 1/κ, and κ follows the Riccati equation ``κ' = -κ² - K`` with K the Gaussian
curvature: second order on smooth surfaces.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array

from geodesic_toolkit._typing import FloatArray, IntArray
from geodesic_toolkit.discretization import Discretization
from geodesic_toolkit.errors import UnsupportedDomainError
from geodesic_toolkit.gradient import ElementGradient

__all__ = ["WavefrontSweeper"]

TOLERANCE = 3e-4
"""Improvement, in mean edge lengths, below which a vertex is left as it is."""

MAX_SWEEPS = 100
"""Sweeps after which improvement stops, unless some vertex has not been reached; two do most of
it, and real meshes take four to forty."""

COARSE = 0.3
"""Curvature of a vertex, K h², at which it counts for half.

A vertex is no sample of a smooth surface where its angle defect is of the order of 1; there the
front splits instead of bending. K is damped to ``K / (1 + |K| h² / COARSE)``, which on smooth
surfaces vanishes with h².
"""


@dataclass(frozen=True, eq=False)
class WavefrontSweeper:
    """Triangles made ready for sweeps; shared by all sources and threads.

    Parameters
    ----------
    metric : Discretization
        Its gradient's elements must be triangles.

    Raises
    ------
    UnsupportedDomainError
        They are not.
    """

    metric: Discretization

    def __post_init__(self) -> None:
        gradient = self.metric.gradient
        if not (
            isinstance(gradient, ElementGradient) and gradient.coefficients.shape[1:] == (2, 3)
        ):
            raise UnsupportedDomainError(
                f"refinement needs triangles, and this discretization has {gradient!r}; "
                "use refine=False"
            )

    def prepare(self) -> "WavefrontSweeper":
        """Compute what all sources share, and return the sweeper."""
        _ = self._corners, self._curvature
        return self

    def distance(
        self,
        log_heat: FloatArray,
        vertices: IntArray,
        distances: FloatArray,
        curvatures: FloatArray | None = None,
    ) -> FloatArray:
        """Return refined distances.

        Parameters
        ----------
        log_heat : ndarray of shape (N,)
            Gives the order of visits.
        vertices : ndarray of shape (P,), int64
            Vertices at and around the sources.
        distances : ndarray of shape (P,), float64
            Their distances, which are taken as exact.
        curvatures : ndarray of shape (P,), float64, optional
            Geodesic curvature of the front there; unless given that of a circle, infinite at its
            centre.

        Returns
        -------
        ndarray of shape (N,), float64
            ``inf`` where no triangle connects.
        """
        from geodesic_toolkit._wavefront import sweep  # numba takes a second to import

        starts, ends, others, shapes = self._corners
        count = len(log_heat)
        distance, kappa = np.full(count, np.inf), np.zeros(count)
        if curvatures is None:
            with np.errstate(divide="ignore"):
                curvatures = 1 / distances
        nearest_last = np.argsort(-distances, kind="stable")
        distance[vertices[nearest_last]] = distances[nearest_last]
        kappa[vertices[nearest_last]] = curvatures[nearest_last]
        pending = np.zeros(count, dtype=np.bool_)
        for vertex in vertices:
            pending[others[starts[vertex] : starts[vertex + 1]]] = True
        order = np.argsort(-log_heat)
        tolerance = TOLERANCE * float(self.metric.scales[vertices].min())
        triangles = (starts, ends, others, shapes, self._curvature)
        heated, sweeps = np.isfinite(log_heat), 0
        while sweeps < MAX_SWEEPS or np.isinf(distance[heated]).any():
            sweeps += 1
            if sweep(order, *triangles, distance, kappa, pending, tolerance):
                continue
            # Stars need not be mutual: who is heard by the reached but hears none of them itself
            # now listens to every triangle that it is part of.
            pending = np.isinf(distance) & heated & (ends < starts[1:])
            if not pending.any():
                break
            ends = np.where(pending, starts[1:], ends)
            triangles = (starts, ends, others, shapes, self._curvature)
        return distance

    @cached_property
    def _corners(self) -> tuple[IntArray, IntArray, IntArray, FloatArray]:
        """The triangles around each vertex: (starts, ends, others, shapes), as the kernel wants.

        Where stars overlap, a vertex listens to its own star only, which comes first: the shortest
        of several slightly different measurements would be too short.
        """
        gradient = self._triangles
        faces, opposite = gradient.elements, self._edge_lengths
        count = gradient.n_vertices
        total = np.bincount(faces.ravel(), minlength=count)
        heard = total
        foreign = np.zeros(faces.shape, dtype=np.bool_)
        if gradient.stars:
            segment = np.isinf(self._areas)
            foreign[~segment, 1:] = True
            own = np.bincount(faces[~foreign], minlength=count)
            heard = np.where(own > 0, own, total)
        corner = np.lexsort((foreign.ravel(), faces.ravel()))
        face, c = corner // 3, corner % 3
        a, b = (c + 1) % 3, (c + 2) % 3
        others = np.column_stack([faces[face, a], faces[face, b]])
        to_a, to_b, edge = opposite[face, b], opposite[face, a], opposite[face, c]
        with np.errstate(divide="ignore", invalid="ignore"):  # segments have no plane, nor use one
            x = (edge**2 + (to_a - to_b) * (to_a + to_b)) / (2 * edge)
        y = np.sqrt(np.maximum(to_a**2 - x**2, 0.0))
        starts = np.concatenate([[0], np.cumsum(total)])
        shapes = np.column_stack([to_a, to_b, edge, x, y])
        return starts, starts[:-1] + heard, others, shapes

    @property
    def _triangles(self) -> ElementGradient:
        gradient = self.metric.gradient
        assert isinstance(gradient, ElementGradient)  # for the type checker; checked on creation
        return gradient

    @cached_property
    def _areas(self) -> FloatArray:
        """The (E,) areas: two hat gradients span a parallelogram of 1 / (2 area).

        Infinite for a segment, an element (i, j, j) whose gradient has one component.
        """
        p, q = self._triangles.coefficients[:, :, 1], self._triangles.coefficients[:, :, 2]
        with np.errstate(divide="ignore"):
            areas: FloatArray = 0.5 / np.abs(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])
        return areas

    @cached_property
    def _edge_lengths(self) -> FloatArray:
        """The (E, 3) edge lengths, opposite each corner: a hat gradient is 1 / height."""
        steepness = np.linalg.norm(self._triangles.coefficients, axis=1)
        segment = np.isinf(self._areas)
        lengths = 2 * np.where(segment, 0.0, self._areas)[:, None] * steepness
        ends = self._triangles.elements[segment]
        apart = ends[:, [1, 2, 0]] != ends[:, [2, 0, 1]]
        lengths[segment] = apart / steepness[segment].max(axis=1, keepdims=True)
        return np.asarray(lengths, dtype=np.float64)

    @cached_property
    def _curvature(self) -> FloatArray:
        """The (N,) Gaussian curvature, angle defect over area, averaged over one-rings.

        Taken for 0 where stars overlap: each is flat, and how they disagree is mostly noise.
        """
        gradient, boundary = self._triangles, self.metric.boundary
        faces, count = gradient.elements, gradient.n_vertices
        if gradient.stars:
            return np.zeros(count)
        corners = faces.ravel()
        angles = np.bincount(corners, self._angles.ravel(), minlength=count)
        area = np.bincount(corners, np.repeat(gradient.measure / 3, 3), minlength=count)
        pairs = (np.repeat(faces, 3, axis=1).ravel(), np.tile(faces, (1, 3)).ravel())
        ring = csr_array(coo_array((np.ones(len(pairs[0])), pairs), shape=(count, count)))
        # Where sheets meet there is no angle to fall short of: more faces than neighbours.
        sheets = np.bincount(corners, minlength=count) > np.diff(ring.indptr) - 1
        defect = np.where(boundary | sheets | (area == 0), 0.0, 2 * np.pi - angles)
        total = ring @ area
        curvature = np.divide(ring @ defect, total, out=np.zeros(count), where=total > 0)
        spread = np.abs(curvature) * area * 2 / np.sqrt(3)  # K h² where triangles are equilateral
        return np.asarray(curvature / (1 + spread / COARSE), dtype=np.float64)

    @cached_property
    def _angles(self) -> FloatArray:
        """The (E, 3) corner angles: π minus what the other two hat gradients enclose."""
        hats = self._triangles.coefficients
        angles = np.empty((len(hats), 3))
        for corner in range(3):
            p, q = hats[:, :, (corner + 1) % 3], hats[:, :, (corner + 2) % 3]
            turned = np.abs(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])
            angles[:, corner] = np.arctan2(turned, -np.einsum("ed,ed->e", p, q))
        return angles
