"""The solver for one shape: domain, operator, heat method, sources of every kind."""

import threading
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodesic_toolkit.core.checks import check_nothing_masked
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.core.warning import warn
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.domains import Domain, PointCloud, TriangleMesh
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    SeamWarning,
    UnevenCloudWarning,
)
from geodesic_toolkit.geometry.seams import Seams, find_seams
from geodesic_toolkit.heat.method import Boundary, HeatMethod, Progress
from geodesic_toolkit.interop.conversion import as_domain, check_one_shape
from geodesic_toolkit.laplacians.base import LaplaceOperator
from geodesic_toolkit.linear.base import LinearSolver
from geodesic_toolkit.refinement.bounds import bounds_of
from geodesic_toolkit.refinement.choice import refinement_of
from geodesic_toolkit.refinement.polyhedra import MOST_FACES, small_parts_of
from geodesic_toolkit.refinement.wavefronts import made_of_triangles
from geodesic_toolkit.registry.catalog import resolve_operator, resolve_solvers
from geodesic_toolkit.solver.coarseness import Judge
from geodesic_toolkit.sources.locate import locate_sources
from geodesic_toolkit.sources.points import LEFT, SourcePoints

if TYPE_CHECKING:
    from geodesic_toolkit.solver.diagnosis import Diagnosis
    from geodesic_toolkit.solver.queries import Surface
    from geodesic_toolkit.sources.ground import Ground

__all__ = ["GeodesicSolver", "Refine", "check_solver"]

Refine: TypeAlias = bool | Literal["auto", "across"]

UNEVEN = 1.5
"""Scale of a part of a cloud, in mean lengths of its spokes, from which on plain heat is warned of.
Measured: scan lines, heaps and samples of surfaces have 1, vertices of CAD models and an airborne
tile up to 1.2; sweeps of spinning scanners 1.9 (16 beams) to 40, and then plain heat is 3 to 25 %
off."""

MOST_ROWS = 64
"""Source sets whose distances are held at once at most."""

BLOCK_ENTRIES = 2**24
"""Distances that are held at once: 128 MB, as long as one set has fewer."""


class GeodesicSolver:
    """Geodesic distances on one shape: factorises once, then answers many sources.

    Safe to use from several threads; pickles and copies (the factors are made again).

    Parameters
    ----------
    domain : Domain or object
        A TriangleMesh, PointCloud, Graph, a plugin's kind of domain, or whatever
        :func:`as_domain` takes: (vertices, faces), an object of trimesh, Open3D, networkx, ...
    *others
        Nothing: an error says so, where vertices and faces were given as two arguments.
    operator : str, class or instance
        The Laplace operator that measures distance; options travel on an instance. "auto" takes
        the one for the kind of domain, and on meshes flips edges where obtuse angles would do
        harm.
    diffusion : str, class or instance, optional
        Another operator on the same vertices for the heat to flow in.
    time : float, optional
        Time step t of the heat, in squared units of length.
    time_factor : float
        Time step in units of h², h the mean edge length of each connected part; where `time` is
        not given. On a mesh h is at least half of the root mean square edge of the surface.
    boundary : {"neumann", "dirichlet", "average"}
        Condition on the heat at boundaries.
    solver : str, class, instance or dict
        The linear solver, or ``{"heat": ..., "poisson": ...}``.
    refine : bool, "auto" or "across"
        True: sweep wavefronts over the triangles in the order of the heat, instead of solving the
        Poisson equation. That is several times more accurate on meshes and clouds, and exact at
        the sources. False: plain heat, the paper's own result, which is smooth. On a graph True is
        the shortest way along its edges, and False the distance across them of what it samples,
        by heat. "across" measures the latter by fronts that cross the triangles and quadrangles of
        a graph. "auto" refines wherever the elements are triangles, and on graphs that are made of
        lines, as trees and streets, or whose factor would take too long; lets fronts cross graphs
        whose corners leave no gaps, as grids, voxels, meshes and neighbour graphs; and `diagnosis`
        says why. Where `time`, `time_factor` or `diffusion` are given, heat is meant.
    mask : array-like of shape (N,), bool, optional
        True at vertices that paths may not cross: faces and edges that touch one do not conduct,
        and it reads ``inf`` itself. It needs no boundary of its own: what is left ends there.

    Attributes
    ----------
    domain : Domain
        What was given, converted where it was not a Domain.
    operator : LaplaceOperator
    method : HeatMethod

    Raises
    ------
    UnsupportedDomainError
        Something that is not a domain, or that the operator does not take.
    InvalidDomainError
        Something that would be one, but for what the message says.
    InvalidOptionError, PluginError
        An option outside its values; an operator or solver that is not to be had.
    SolverError, NotEnoughMemoryError
        The factorisation failed.

    References
    ----------
    K. Crane, C. Weischedel, M. Wardetzky, *Geodesics in Heat*, 2013,
    https://doi.org/10.1145/2516971.2516977

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> sphere = gt.testing.shapes.icosphere(3)
    >>> solver = gt.GeodesicSolver(sphere)
    >>> round(float(solver.distance(0).max()), 1)  # half way around: π
    3.1
    >>> solver.distances([0, 1, 2]).shape
    (3, 642)
    """

    def __init__(
        self,
        domain: Any,
        *others: Any,
        operator: str | type[LaplaceOperator] | LaplaceOperator = "auto",
        diffusion: str | type[LaplaceOperator] | LaplaceOperator | None = None,
        time: float | None = None,
        time_factor: float = 1.0,
        boundary: Boundary = "neumann",
        solver: str | type[LinearSolver] | LinearSolver | dict[str, Any] = "auto",
        refine: Refine = "auto",
        mask: ArrayLike | None = None,
    ) -> None:
        check_one_shape("GeodesicSolver", others)
        domain = as_domain(domain)
        self.domain = domain
        self.operator = resolve_operator(operator, domain)
        self.diffusion = None if diffusion is None else resolve_operator(diffusion, domain)
        self._mask: BoolArray | None = None
        self._whole: Discretization | None = None  # of a cloud, where a part of it is masked
        if mask is None:
            self.operator.check_domain(domain)
            metric = self.operator.assemble(domain)
        else:
            from geodesic_toolkit.solver.masks import as_mask, assembled_without, of_places, without

            self._mask = of_places(domain, as_mask(mask, domain.n_vertices))
            metric, self._whole = assembled_without(self.operator, domain, self._mask)
            domain = without(domain, self._mask)
        self._passable: Domain = domain
        self._reason = ""
        if not isinstance(refine, bool | np.bool_):
            heat_is_meant = time is not None or time_factor != 1.0 or diffusion is not None
            refine, self._reason = _refine_by_default(refine, metric, heat_is_meant)
        across = refine == "across"
        refined = False if refine == "across" else refine
        heat_solver, poisson_solver = resolve_solvers(solver, domain.n_vertices, refine=refined)
        self._seams = (
            find_seams(domain.vertices, domain.faces, metric.boundary)
            if isinstance(domain, TriangleMesh)
            else None
        )
        small_parts = small_parts_of(domain, metric.components) if refined else None
        if small_parts is not None:
            self._reason += f"; exact on parts of up to {MOST_FACES} faces"
        self.method = HeatMethod(
            metric,
            diffusion=(
                self.operator.diffusion(metric)
                if self.diffusion is None
                else self.diffusion.assemble(domain)
            ),
            time=time,
            time_factor=time_factor,
            boundary=boundary,
            heat_solver=heat_solver,
            poisson_solver=poisson_solver,
            refine=refined,
            across=across,
            bounds=bounds_of(domain, metric) if refined else None,
            small_parts=small_parts,
        ).prepare()
        self._diagnosis: Diagnosis | None = None
        self._unusual = _unusual(boundary, own_time=time is not None or time_factor != 1)
        self._forget()

    def _forget(self) -> None:
        """Start without what is made when it is first wanted, and belongs to one process."""
        self._ground: Ground | None = None
        self._surface: Surface | None = None
        self._judge: Judge | None = None
        self._lock = threading.Lock()

    def distance(self, sources: Any) -> FloatArray:
        """Return the geodesic distance of every vertex from one set of sources.

        Parameters
        ----------
        sources : int, array-like, SurfacePoint, sequence of them, Curve or OffsetSources
            Vertex indices; points in space, of shape (3,) or (P, 3), snapped to the nearest point
            of the surface; points inside faces; a polyline; or any of the first three with
            offsets. The vertices of a label are ``numpy.flatnonzero(labels == label)``.

        Returns
        -------
        ndarray of shape (N,), float64
            In the unit of the domain; ``inf`` where no source connects. Every source vertex reads
            exactly 0, or the offset that it starts with, and nothing less than the least of them.
            On a mesh refined distances are nowhere below the straight line to the nearest source,
            nor above the shortest way along edges; on a cloud not below that line.

        Raises
        ------
        InvalidSourceError
            No source, an index out of range, a point that is not finite, something else.

        Examples
        --------
        >>> import geodesic_toolkit as gt
        >>> square = gt.testing.shapes.grid(5)
        >>> gt.GeodesicSolver(square).distance([0.5, 0.5, 0.0])[12].round(3)
        np.float64(0.0)
        """
        places = self.locate(sources)
        self._warn_where_cut([places])
        return self._distance(places)

    def distances(
        self, source_sets: ArrayLike | Iterable[Any], *, progress: Progress | None = None
    ) -> FloatArray:
        """Return the geodesic distances from K sets of sources, solved in blocks.

        Parameters
        ----------
        source_sets : array-like of int, or iterable of what `distance` takes
            A one-dimensional array of integers means that many single sources.
        progress : callable, optional
            Called with the number of sets done and their total after each block.

        Returns
        -------
        ndarray of shape (K, N), float64
            One row a set.

        Raises
        ------
        InvalidSourceError
            As for `distance`, before any work; the message says which set.
        """
        sets = self.locate_sets(source_sets)
        self._warn_where_cut(sets)
        distances = self.method.distances(sets, progress=progress)
        self._warn_where_off(sets, distances)
        return distances

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
        linearly, within a few edges of a source after the straight line from it is taken off: the
        kink there comes out right. A face that touches a masked vertex is entered from its other
        corners, and not crossed. :meth:`interpolate` does this with distances that are at hand,
        :meth:`nearest_source` tells sources apart.

        The tree that finds triangles is built by the first call and kept. Millions of points are
        worked on in batches, which change nothing but the memory that it takes: beside the tree,
        the `points` and the result some 50 MB. Arrays of float32, and memory maps, are not copied.

        Parameters
        ----------
        points : array-like of shape (Q, 3) or (3,)
            In the unit of the domain.
        sources : int, array-like of int, array-like of float, SurfacePoint or sequence of them
            As for `distance`.
        reach : float, optional
            How far from the surface a point may lie, in that unit; two mean edge lengths by
            default.
        progress : callable, optional
            Called with the number of points done and their total after each batch.

        Returns
        -------
        ndarray of shape (Q,), float64
            In the unit of the domain; ``inf`` past the reach, where no source connects, and between
            vertices that are all masked.

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
        surface, queries = self._asked(points, reach)
        places = self.locate(sources)
        self._warn_where_cut([places])
        return surface.interpolate(
            self._distance(places), queries, reach=reach, sources=places, progress=progress
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
        """Return at any points what `distance` is there, as :meth:`query` does.

        Parameters
        ----------
        distance : array-like of shape (N,)
            At the vertices: what :meth:`distance` returned, or any other numbers.
        points : array-like of shape (Q, 3) or (3,)
        sources : optional
            Those of the distance, as it was given them: the kink around them then comes out right.
        reach, progress
            As for `query`.

        Returns
        -------
        ndarray of shape (Q,), float64
            ``inf`` past the reach, and where a corner that counts is.

        Raises
        ------
        UnsupportedDomainError, InvalidOptionError, InvalidSourceError
            As for `query`; another number of distances than vertices.

        Examples
        --------
        >>> import geodesic_toolkit as gt
        >>> solver = gt.GeodesicSolver(gt.testing.shapes.grid(21))
        >>> height = solver.domain.vertices @ [0.0, 1.0, 0.0]
        >>> solver.interpolate(height, [0.41, 0.33, 0.0]).round(2)
        array([0.33])
        """
        surface, queries = self._asked(points, reach)
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
        """Return which source is nearest to each of any points, and how far it is.

        For the vertices themselves :func:`geodesic_voronoi` says so. The distances of one source
        after the other are computed, so that it takes as long as as many calls of `distance`, and
        the memory of about 45 bytes a point.

        Parameters
        ----------
        points : array-like of shape (Q, 3) or (3,)
            On or near the mesh or cloud, in its unit.
        sources : array-like of int, or iterable of what `distance` takes
            As for `distances`: a one-dimensional array of integers means that many single sources,
            floats of shape (K, 3) that many points in space; each may also be a set.
        reach : float, optional
            As for `query`.
        progress : callable, optional
            Called with the number of sources done and their total, with none while the points are
            located, and after each block of sources.

        Returns
        -------
        labels : ndarray of shape (Q,), int64
            The position of the nearest source in the list, the first of those that are equally
            near; -1 where none connects, and past the reach.
        distances : ndarray of shape (Q,), float64
            What `query` gives for that source; ``inf`` where there is none.

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
        surface, queries = self._asked(points, reach)
        sets = self.locate_sets(sources)
        return surface.nearest(queries, sets, self.blocks, reach=reach, progress=progress)

    def blocks(self, source_sets: ArrayLike | Iterable[Any]) -> Iterator[FloatArray]:
        """Yield the distances from K sets of sources by blocks of rows that do not fill the memory.

        Parameters
        ----------
        source_sets : array-like of int, or iterable of what `distance` takes
            As for :meth:`distances`.

        Yields
        ------
        ndarray of shape (B, N), float64
            The next B of the K rows.

        Raises
        ------
        InvalidSourceError
            As for :meth:`distances`, before any work.

        Examples
        --------
        >>> import geodesic_toolkit as gt
        >>> solver = gt.GeodesicSolver(gt.testing.shapes.icosphere(2))
        >>> [block.shape for block in solver.blocks(range(100))]
        [(64, 162), (36, 162)]
        """
        sets = self.locate_sets(source_sets)
        self._warn_where_cut(sets)
        size = max(1, min(MOST_ROWS, BLOCK_ENTRIES // self.domain.n_vertices))
        for first in range(0, len(sets), size):
            some = sets[first : first + size]
            distances = self.method.distances(some)
            self._warn_where_off(some, distances)
            yield distances

    def _distance(self, places: SourcePoints) -> FloatArray:
        distance = self.method.distance(places)
        self._warn_where_off([places], [distance])
        return distance

    def _asked(self, points: ArrayLike, reach: float | None) -> tuple["Surface", NDArray[Any]]:
        """Return the surface and the points to find on it, all checked before any other work."""
        from geodesic_toolkit.solver.queries import as_points, check_reach, positions_of

        positions_of(self.domain)  # refuses a graph
        queries = as_points(points)
        check_reach(reach)
        return self.surface, queries

    @property
    def surface(self) -> "Surface":
        """The triangles that queries are answered on, in a tree: made when first asked for."""
        ground = self._kept_ground()
        with self._lock:
            if self._surface is None:
                from geodesic_toolkit.solver.queries import Surface

                # Feet are on all of it: in a face that the mask cuts, not on the rim of the rest.
                metric = self._whole or self.method.metric
                cut = self._mask is not None and (
                    self._whole is not None or isinstance(self.domain, TriangleMesh)
                )
                domain = self.domain if cut else self._passable
                self._surface = Surface(domain, metric, ground, mask=self._mask if cut else None)
            return self._surface

    def _kept_ground(self) -> "Ground | None":
        """Return where points in space snap to; None where vertices have no positions."""
        if not isinstance(self._passable, TriangleMesh | PointCloud):
            return None
        with self._lock:
            if self._ground is None:
                from geodesic_toolkit.sources.ground import Ground

                self._ground = Ground(self._passable)
            return self._ground

    def locate(self, sources: Any, name: str = "sources") -> SourcePoints:
        """Return where sources lie: as convex combinations of vertices, checked.

        What every method that takes `sources` does first; what it returns may be given to them
        again.

        Parameters
        ----------
        sources : int, array-like, SurfacePoint, sequence of them, Curve or OffsetSources
            As for :meth:`distance`.
        name : str
            What errors call them.

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
                self.domain, sources, name, passable=self._passable, ground=self._kept_ground()
            )
        if self._mask is not None:
            from geodesic_toolkit.solver.masks import check_unmasked

            check_unmasked(places, self._mask, name)
        return places

    def locate_sets(self, source_sets: Any) -> list[SourcePoints]:
        """Return where each of several sets of sources lies.

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
            As for :meth:`distances`; the message says which set.
        """
        if isinstance(source_sets, str | bytes) or not isinstance(source_sets, Iterable):
            raise InvalidSourceError(
                f"source sets must be a sequence of them, not {source_sets!r}; "
                "for one set use distance"
            )
        check_nothing_masked(source_sets, "source sets", InvalidSourceError, LEFT)
        sets = list(source_sets)
        if not sets:
            raise InvalidSourceError("there are no source sets; give at least one")
        return [
            self.locate(sources, f"source set {position}") for position, sources in enumerate(sets)
        ]

    def heat(self, sources: Any) -> FloatArray:
        """Return the heat u of step 1 as the solver gives it, of shape (N,).

        It underflows some 700 edges from the source; :meth:`log_heat` does not. Parameters and
        errors are those of :meth:`distance`.
        """
        return self.method.heat(self.locate(sources))

    def log_heat(self, sources: Any) -> FloatArray:
        """Return log u of step 1, of shape (N,), over an unlimited range; ``-inf`` where u = 0.

        Parameters and errors are those of :meth:`distance`.
        """
        return self.method.log_heat(self.locate(sources))

    @property
    def mask(self) -> BoolArray | None:
        """True at the vertices that paths may not cross, of shape (N,), or None."""
        return self._mask

    @property
    def seams(self) -> Seams | None:
        """Where a mesh is cut along edges of its boundary that lie upon each other, or None."""
        return self._seams

    @property
    def passable(self) -> Domain:
        """The domain without what touches a masked vertex: all of it where there is no mask."""
        return self._passable

    @property
    def diagnosis(self) -> "Diagnosis":
        """What the shape is like and what was done about it; computed on first use."""
        from geodesic_toolkit.solver.diagnosis import diagnose

        with self._lock:
            if self._diagnosis is None:
                self._diagnosis = diagnose(
                    self._passable, self.operator, self.method, self._reason, self._seams
                )
            return self._diagnosis

    def _warn_where_cut(self, sets: list[SourcePoints]) -> None:
        """Warn where a mesh is cut along seams, and say how far the first source set comes."""
        seams, mesh = self._seams, self._passable
        if seams is None or not isinstance(mesh, TriangleMesh):
            return
        metric = self.method.metric
        reached = np.isin(metric.components, sets[0].components(metric))
        used = mesh.used
        warn(
            f"{seams.finding}. The source reaches {np.count_nonzero(reached & used)} of "
            f"{np.count_nonzero(used)} vertices; {seams.cure}",
            SeamWarning,
        )

    def _warn_where_off(
        self, sets: list[SourcePoints], distances: FloatArray | list[FloatArray]
    ) -> None:
        """Warn where plain heat is far from the refined distance."""
        metric = self.method.metric
        if self.method.refine:
            return
        _warn_where_uneven(metric)
        if not (isinstance(self._passable, TriangleMesh) and made_of_triangles(metric)):
            return
        with self._lock:
            if self._judge is None:
                self._judge = Judge(self._passable, self.method, self._unusual)
        self._judge.judge(sets, distances)

    def __getstate__(self) -> dict[str, Any]:
        kept = {"_lock", "_ground", "_surface", "_judge"}
        return {name: value for name, value in self.__dict__.items() if name not in kept}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._forget()

    def __repr__(self) -> str:
        return (
            f"GeodesicSolver({self.domain!r}, operator={self.operator!r}, method={self.method!r})"
        )


def check_solver(solver: object, what: str) -> None:
    """Raise an `InvalidOptionError` where something else than a solver is given for `what`."""
    if not isinstance(solver, GeodesicSolver):
        raise InvalidOptionError(
            f"{what} needs a GeodesicSolver, not a {type(solver).__name__}; "
            "make one of the shape: GeodesicSolver(mesh)"
        )


def _refine_by_default(
    choice: Any, metric: Discretization, heat_is_meant: bool
) -> tuple[bool | Literal["across"], str]:
    """Return how "auto" refines, and why."""
    if isinstance(choice, str) and choice == "across":
        if metric.across_edges is None:
            raise InvalidOptionError('refine="across" is for graphs and the "uniform" operator')
        return "across", ""
    if not isinstance(choice, str) or choice != "auto":
        raise InvalidOptionError(
            f'refine must be True, False or "auto", or "across" on graphs, not {choice!r}'
        )
    return refinement_of(metric, heat_is_meant=heat_is_meant)


def _unusual(boundary: Boundary, *, own_time: bool) -> str:
    """Return what may make plain heat wrong on a mesh of any size, in words."""
    if boundary != "neumann":
        return f'with boundary="{boundary}"'
    return "with this time step" if own_time else ""


def _warn_where_uneven(metric: Discretization) -> None:
    """Warn where a cloud is sampled so unevenly that no time step is right all over it."""
    unevenness = metric.notes.get("unevenness", 1.0)
    if unevenness > UNEVEN:
        warn(
            f"the triangles that cover most of the cloud are {unevenness:.1f} times as large as "
            "most triangles are: heat that gets across them is blurred elsewhere, and plain heat "
            "can be 10 % off and more; use refine=True, or thin the cloud to one spacing",
            UnevenCloudWarning,
        )
