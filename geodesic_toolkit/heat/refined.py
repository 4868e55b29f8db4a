"""The refined step, in place of steps 2 and 3: fronts in the order of the heat, and bounds."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from geodesic_toolkit.core.arrays import empty
from geodesic_toolkit.core.near import NearRows
from geodesic_toolkit.core.types import BoolArray, FloatArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.heat import Heat
from geodesic_toolkit.errors import UnsupportedDomainError
from geodesic_toolkit.heat.blocks import MIN_VERTICES_PER_THREAD, PROCESSORS
from geodesic_toolkit.refinement.bounds import DistanceBounds
from geodesic_toolkit.refinement.polyhedra import SmallParts
from geodesic_toolkit.refinement.wavefronts import WavefrontSweeper
from geodesic_toolkit.sources.points import SourcePoints
from geodesic_toolkit.sources.subdivided import on_subdivision

__all__ = ["Fronts", "RefinedStep"]


class Fronts(NamedTuple):
    """The fronts of one source set, as they came to each vertex.

    Attributes
    ----------
    distances : ndarray of shape (N,), float64
        Refined, exact on small parts, and within bounds.
    swept : ndarray of shape (N,), float64
        The same as sweeps left them.
    curvatures : ndarray of shape (N,), float64
        The geodesic curvature κ of the front there; ``inf`` at a point.
    """

    distances: FloatArray
    swept: FloatArray
    curvatures: FloatArray


class RefinedStep:
    """Fronts swept over triangles, exact distances on small parts, and bounds.

    Parameters
    ----------
    metric : Discretization
        A metric made of triangles, or with a subdivision that is.
    small_parts : SmallParts, optional
        Components whose refined distances are replaced by exact ones; of the subdivision, if there
        is one.
    bounds : DistanceBounds, optional
        Bounds that distances are limited to; likewise.

    Attributes
    ----------
    sweeper : WavefrontSweeper
        Of the metric, or of its subdivision.
    """

    def __init__(
        self,
        metric: Discretization,
        small_parts: SmallParts | None,
        bounds: DistanceBounds | None,
    ) -> None:
        self._subdivision = metric.subdivision
        self.sweeper = WavefrontSweeper(
            metric if metric.subdivision is None else metric.subdivision.metric
        )
        self._small_parts, self._bounds = small_parts, bounds

    def distances(self, heat: Heat, block: Sequence[SourcePoints], distances: FloatArray) -> None:
        """Write refined distances, (K, N); the sweeps of a block share the processors."""
        if self._subdivision is None:
            self._sweep(heat, block, distances)
            return
        finer = empty((len(block), self._subdivision.mesh.n_vertices), np.float64)
        self._sweep(
            Heat.of_log(self._subdivision.extended(heat.log())),
            [on_subdivision(points, self._subdivision) for points in block],
            finer,
        )
        distances[:] = finer[:, : self._subdivision.n_vertices]

    @property
    def has_near(self) -> bool:
        """True if `near` can be called: the triangles have no vertices but those of the domain."""
        return self._subdivision is None

    def near(
        self, heat: Heat, block: Sequence[SourcePoints], limits: FloatArray
    ) -> tuple[NearRows, BoolArray]:
        """Return distances up to a limit, to the bit those of `distances`.

        Parameters
        ----------
        heat : Heat of shape (N, K)
        block : sequence of SourcePoints
        limits : ndarray of shape (K,), float64

        Returns
        -------
        near : NearRows
        are_known : ndarray of shape (K,), bool
            False for rows of which more has to be known, and which `distances` has to measure.
        """
        near = self.sweeper.near(heat, block, limits)
        are_known = np.ones(len(block), dtype=np.bool_)
        if self._bounds is not None:
            are_known = self._bounds.hold_near(near, block, limits)
        if self._small_parts is not None:
            are_known &= [not self._small_parts.has(points) for points in block]
        return near.within(limits), are_known

    def _sweep(self, heat: Heat, block: Sequence[SourcePoints], distances: FloatArray) -> None:
        """Write refined distances at the vertices of the triangles."""
        large = distances.size >= MIN_VERTICES_PER_THREAD
        n_threads = min(len(block), PROCESSORS) if large else 1
        self.sweeper.fill(distances, heat, block, n_threads=n_threads)
        self._hold(distances, block, n_threads)

    def fronts(self, heat: Heat, points: SourcePoints, around: SourcePoints) -> Fronts:
        """Return the fronts of one source set, with the vertices around it that they begin at."""
        if self._subdivision is not None:
            raise UnsupportedDomainError(
                "fronts with their directions are for triangles of the domain's own vertices; make "
                "a solver of the mesh of the subdivision"
            )
        swept = empty((1, len(heat.values)), np.float64)
        curvatures = np.empty_like(swept)
        self.sweeper.fill(swept, heat, [around], kappas=curvatures)
        distances = swept.copy()
        self._hold(distances, [points], 1)
        return Fronts(distances[0], swept[0], curvatures[0])

    def _hold(self, distances: FloatArray, block: Sequence[SourcePoints], n_threads: int) -> None:
        if self._small_parts is not None:
            self._small_parts.fill(distances, block)
        if self._bounds is not None:
            self._bounds.hold(distances, block, n_threads=n_threads)

    def prepare(self) -> None:
        """Prepare the data that all sources share."""
        self.sweeper.prepare()
        if self._bounds is not None:
            self._bounds.prepare()
