"""Location of sources on the shape of a solver."""

import threading
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from geodesic_toolkit.core.checks import check_nothing_masked
from geodesic_toolkit.core.types import BoolArray, IntArray
from geodesic_toolkit.domains import Domain
from geodesic_toolkit.errors import InvalidSourceError
from geodesic_toolkit.solver.assembly import Assembly
from geodesic_toolkit.sources.locate import locate_sources
from geodesic_toolkit.sources.points import ADVICE_ON_MASKED_SOURCES, SourcePoints

if TYPE_CHECKING:
    from geodesic_toolkit.sources.ground import Ground

__all__ = ["SourceLocator"]


class SourceLocator:
    """The parts of a solver, and the location of sources on its shape.

    Parameters
    ----------
    assembly : Assembly
    """

    def __init__(self, assembly: Assembly) -> None:
        self._assembly = assembly
        self._forget()

    def _forget(self) -> None:
        """Drop the lock and the ground, which are made on first use and belong to one process."""
        self._ground: Ground | None = None
        self._lock = threading.Lock()

    @property
    def domain(self) -> Domain:
        """The given shape, converted if it was not a Domain."""
        return self._assembly.domain

    @property
    def passable(self) -> Domain:
        """The domain without elements of masked vertices; all of it without a mask."""
        return self._assembly.passable

    @property
    def mask(self) -> BoolArray | None:
        """True at the vertices that paths may not cross, of shape (N,), or None."""
        return self._assembly.mask

    def locate(self, sources: Any, name: str = "sources") -> SourcePoints:
        """Return sources as checked convex combinations of vertices.

        Every method that takes `sources` calls this first, and also takes the result as sources.

        Parameters
        ----------
        sources : int, array-like, SurfacePoint, sequence of them, Curve or OffsetSources
            As for :meth:`distance`.
        name : str
            Name of the sources in errors.

        Returns
        -------
        SourcePoints

        Raises
        ------
        InvalidSourceError
            As for :meth:`distance`.

        Examples
        --------
        >>> import geodesic_toolkit as gt
        >>> solver = gt.GeodesicSolver(gt.testing.shapes.grid(3))
        >>> places = solver.locate([0.25, 0.25, 0.0])
        >>> places.vertices, places.shares
        (array([0, 4]), array([0.5, 0.5]))
        """
        if isinstance(sources, SourcePoints):  # located before
            places = sources
        else:
            places = locate_sources(
                self.domain, sources, name, passable=self.passable, ground=self._kept_ground()
            )
        if self.mask is not None:
            from geodesic_toolkit.solver.masks import check_unmasked

            check_unmasked(places, self.mask, name)
        return places

    def locate_sets(self, source_sets: Any) -> list[SourcePoints]:
        """Return several sets of sources as checked convex combinations of vertices.

        Parameters
        ----------
        source_sets : array-like of int, or iterable of what `distance` takes
            As for :meth:`distances`.

        Returns
        -------
        list of SourcePoints

        Raises
        ------
        InvalidSourceError
            As for :meth:`distances`; the message names the set.
        """
        if isinstance(source_sets, str | bytes) or not isinstance(source_sets, Iterable):
            raise InvalidSourceError(
                f"source sets must be a sequence of sets, not {source_sets!r}; "
                "for one set use distance"
            )
        check_nothing_masked(
            source_sets, "source sets", InvalidSourceError, ADVICE_ON_MASKED_SOURCES
        )
        sets = list(source_sets)
        if not sets:
            raise InvalidSourceError("there are no source sets; give at least one")
        return [
            self.locate(sources, f"source set {position}") for position, sources in enumerate(sets)
        ]

    @property
    def ground(self) -> "Ground | None":
        """The shape to which points in space snap; None if vertices have no positions."""
        return self._kept_ground()

    def _kept_ground(self) -> "Ground | None":
        """Return the shape to which points in space snap; None if vertices have no positions."""
        if not self.passable.has("positions"):
            return None
        with self._lock:
            if self._ground is None:
                from geodesic_toolkit.sources.ground import Ground

                self._ground = Ground(self.passable, self._stars())
            return self._ground

    def _stars(self) -> IntArray | None:
        """Return the triangles and links of the stars of a cloud, (E, 3); None without them."""
        if self.passable.has("triangles") or self.passable.has("closest"):
            return None
        gradient = self._assembly.method.metric.gradient
        elements: IntArray | None = getattr(gradient, "elements", None)
        return elements if elements is not None and elements.shape[1] == 3 else None

    def __getstate__(self) -> dict[str, Any]:
        made = {"_lock", "_ground", "_surface", "_frames", "_vector_heat"}
        return {name: value for name, value in self.__dict__.items() if name not in made}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._forget()
