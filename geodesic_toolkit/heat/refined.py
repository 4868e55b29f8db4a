"""The refined step, in place of steps 2 and 3: fronts in the order of the heat, and bounds."""

from collections.abc import Sequence

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.heat import Heat
from geodesic_toolkit.heat.blocks import MIN_VERTICES_PER_THREAD, PROCESSORS
from geodesic_toolkit.refinement.bounds import DistanceBounds
from geodesic_toolkit.refinement.polyhedra import SmallParts
from geodesic_toolkit.refinement.wavefronts import WavefrontSweeper
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["RefinedStep"]


class RefinedStep:
    """Fronts swept over triangles, exact distances on small parts, and bounds.

    Parameters
    ----------
    metric : Discretization
        A metric made of triangles.
    small_parts : SmallParts, optional
        Components whose refined distances are replaced by exact ones.
    bounds : DistanceBounds, optional
        Bounds that distances are limited to.
    """

    def __init__(
        self,
        metric: Discretization,
        small_parts: SmallParts | None,
        bounds: DistanceBounds | None,
    ) -> None:
        self._sweeper = WavefrontSweeper(metric)
        self._small_parts, self._bounds = small_parts, bounds

    def distances(self, heat: Heat, block: Sequence[SourcePoints], distances: FloatArray) -> None:
        """Write refined distances, (K, N); the sweeps of a block share the processors."""
        large = distances.size >= MIN_VERTICES_PER_THREAD
        n_threads = min(len(block), PROCESSORS) if large else 1
        self._sweeper.fill(distances, heat, block, n_threads=n_threads)
        if self._small_parts is not None:
            self._small_parts.fill(distances, block)
        if self._bounds is not None:
            self._bounds.hold(distances, block, n_threads=n_threads)

    def prepare(self) -> None:
        """Prepare the data that all sources share."""
        self._sweeper.prepare()
        if self._bounds is not None:
            self._bounds.prepare()
