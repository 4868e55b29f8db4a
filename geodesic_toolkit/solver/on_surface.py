"""Distances at any points on or near a surface, from those of its vertices."""

import abc
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike, NDArray

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains import positions_of
from geodesic_toolkit.heat.method import Progress
from geodesic_toolkit.solver.locating import SourceLocator

if TYPE_CHECKING:
    from geodesic_toolkit.solver.queries import Surface

__all__ = ["SurfaceSolver"]


class SurfaceSolver(SourceLocator, abc.ABC):
    """Distances at points of a surface, for any solver of the distances at its vertices."""

    def _forget(self) -> None:
        super()._forget()
        self._surface: Surface | None = None

    @abc.abstractmethod
    def distance(self, sources: Any) -> FloatArray:
        """Return the geodesic distance of every vertex from one set of sources, (N,)."""

    @abc.abstractmethod
    def blocks(self, source_sets: ArrayLike | Iterable[Any]) -> Iterator[FloatArray]:
        """Yield the distances from K sets of sources by blocks of rows."""

    def query(
        self,
        points: ArrayLike,
        sources: Any,
        *,
        reach: float | None = None,
        progress: Progress | None = None,
    ) -> FloatArray:
        """Return the geodesic distance at any points on or near a mesh or a cloud.

        A point has the distance of the closest point of the surface: of the mesh, or of the local
        triangles of the cloud. Inside a triangle the distance of the corners is interpolated
        linearly; within a few edges of a source, the excess over the straight line from it is
        interpolated instead, which preserves the kink there. A face that touches a masked vertex is
        entered from its other corners, and not crossed. :meth:`interpolate` does this with given
        distances, :meth:`nearest_source` distinguishes sources.

        The tree that finds triangles is built by the first call and kept. Millions of points are
        processed in batches, which do not change the result and limit the memory: in addition to
        the tree, the `points` and the result it takes some 50 MB. Arrays of float32, and memory
        maps, are not copied.

        Parameters
        ----------
        points : array-like of shape (Q, 3) or (3,)
            In the unit of the domain.
        sources : int, array-like of int, array-like of float, SurfacePoint or sequence of them
            As for `distance`.
        reach : float, optional
            Maximum distance of a point from the surface, in that unit; two mean edge lengths by
            default.
        progress : callable, optional
            Called with the number of points done and their total after each batch.

        Returns
        -------
        ndarray of shape (Q,), float64
            In the unit of the domain; ``inf`` past the reach, at points that are not connected to a
            source, and between vertices that are all masked.

        Raises
        ------
        UnsupportedDomainError
            A graph, which has no positions, or a cloud whose operator makes no triangles.
        InvalidOptionError
            Points that are not finite or not of that shape; a reach that is not positive.
        InvalidSourceError
            As for `distance`.

        Examples
        --------
        >>> import geodesic_toolkit as gt
        >>> solver = gt.GeodesicSolver(gt.testing.shapes.grid(21))
        >>> solver.query([[0.41, 0.0, 0.02], [0.4, 0.0, 5.0]], 0).round(2)
        array([0.41,  inf])
        """
        surface, queries = self._checked_query(points, reach)
        places = self.locate(sources)
        return surface.interpolate(
            self.distance(places), queries, reach=reach, sources=places, progress=progress
        )

    def interpolate(
        self,
        distance: ArrayLike,
        points: ArrayLike,
        *,
        sources: Any = None,
        reach: float | None = None,
        progress: Progress | None = None,
    ) -> FloatArray:
        """Return `distance` interpolated at any points, as :meth:`query` does.

        Parameters
        ----------
        distance : array-like of shape (N,)
            Values at the vertices: a result of :meth:`distance`, or any other numbers.
        points : array-like of shape (Q, 3) or (3,)
        sources : optional
            The sources of the distance, which preserves the kink around them.
        reach, progress
            As for `query`.

        Returns
        -------
        ndarray of shape (Q,), float64
            ``inf`` past the reach, and if a corner with a weight is.

        Raises
        ------
        UnsupportedDomainError, InvalidOptionError, InvalidSourceError
            As for `query`; a number of distances that is not that of the vertices.

        Examples
        --------
        >>> import geodesic_toolkit as gt
        >>> solver = gt.GeodesicSolver(gt.testing.shapes.grid(21))
        >>> height = solver.domain.vertices @ [0.0, 1.0, 0.0]
        >>> solver.interpolate(height, [0.41, 0.33, 0.0]).round(2)
        array([0.33])
        """
        surface, queries = self._checked_query(points, reach)
        places = None if sources is None else self.locate(sources)
        return surface.interpolate(
            distance, queries, reach=reach, sources=places, progress=progress
        )

    def nearest_source(
        self,
        points: ArrayLike,
        sources: ArrayLike | Iterable[Any],
        *,
        reach: float | None = None,
        progress: Progress | None = None,
    ) -> tuple[IntArray, FloatArray]:
        """Return the index of the nearest source of any points, and its distance.

        For vertices use :func:`geodesic_voronoi`. Distances are computed from one source after the
        other, which takes as long as that many calls of `distance`, and about 45 bytes of memory
        for each point.

        Parameters
        ----------
        points : array-like of shape (Q, 3) or (3,)
            On or near the mesh or cloud, in its unit.
        sources : array-like of int, or iterable of what `distance` takes
            As for `distances`: a one-dimensional array of K integers means K single sources, floats
            of shape (K, 3) mean K points in space; each may also be a set.
        reach : float, optional
            As for `query`.
        progress : callable, optional
            Called with the number of finished sources and their total: with 0 while points are
            located, and after each block of sources.

        Returns
        -------
        labels : ndarray of shape (Q,), int64
            The position of the nearest source in the list, the first of equally near ones; -1 for
            points that are not connected to a source, and past the reach.
        distances : ndarray of shape (Q,), float64
            The result of `query` for that source; ``inf`` without a source.

        Raises
        ------
        UnsupportedDomainError, InvalidOptionError
            As for `query`.
        InvalidSourceError
            As for `distances`, before any work.

        Examples
        --------
        >>> import geodesic_toolkit as gt
        >>> solver = gt.GeodesicSolver(gt.testing.shapes.grid(21))
        >>> corners = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]]
        >>> labels, distances = solver.nearest_source([[0.1, 0.0, 0.0], [0.9, 1.0, 0.0]], corners)
        >>> labels, distances.round(3)
        (array([0, 1]), array([0.1, 0.1]))
        """
        surface, queries = self._checked_query(points, reach)
        sets = self.locate_sets(sources)
        return surface.nearest(queries, sets, self.blocks, reach=reach, progress=progress)

    def _checked_query(
        self, points: ArrayLike, reach: float | None
    ) -> tuple["Surface", NDArray[Any]]:
        """Return the surface and the points to find on it, all checked before any other work."""
        from geodesic_toolkit.solver.queries import as_points, check_reach

        positions_of(self.domain)  # raises for a graph
        queries = as_points(points)
        check_reach(reach)
        return self.surface, queries

    @property
    def surface(self) -> "Surface":
        """The triangles that queries use, in a tree; made on first use."""
        ground = self._kept_ground()
        with self._lock:
            if self._surface is None:
                from geodesic_toolkit.solver.queries import Surface
                from geodesic_toolkit.sources.ground import lies_in_triangles

                # Feet lie on the whole shape: in a face that the mask cuts, not on the rim of the
                # rest.
                whole, mask = self._assembly.whole, self.mask
                metric = whole or self._assembly.method.metric
                cut = mask is not None and (whole is not None or lies_in_triangles(self.domain))
                domain = self.domain if cut else self.passable
                self._surface = Surface(domain, metric, ground, mask=mask if cut else None)
            return self._surface
