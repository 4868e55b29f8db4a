"""The solver of one shape: domain, operator, heat method, sources of every kind."""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.near import NearRows
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.errors import InvalidOptionError
from geodesic_toolkit.geometry.seams import Seams
from geodesic_toolkit.heat.method import Boundary, Progress
from geodesic_toolkit.interop.conversion import as_domain, check_one_shape
from geodesic_toolkit.solver.assembly import Operator, Refine, Solver, assembled
from geodesic_toolkit.solver.complaints import Complaints
from geodesic_toolkit.solver.tangents import TangentSolver

if TYPE_CHECKING:
    from geodesic_toolkit.solver.diagnosis import Diagnosis

__all__ = ["GeodesicSolver", "Refine", "check_solver"]

MOST_ROWS = 64
"""Maximum number of source sets whose distances are kept at once."""

BLOCK_ENTRIES = 2**24
"""Number of distances that are kept at once: 128 MB, unless one set has more."""


class GeodesicSolver(TangentSolver):
    """Geodesic distances on one shape: factorises once, then answers many sources.

    It is safe to use from several threads, and can be pickled and copied (factors are made again).

    Parameters
    ----------
    domain : Domain or object
        A TriangleMesh, PointCloud, Graph, a plugin's kind of domain, or any object that
        :func:`as_domain` takes: (vertices, faces), an object of trimesh, Open3D, networkx, ...
    *others
        Not used: an error explains how to pass vertices and faces, if they are two arguments.
    operator : str, class or instance
        The Laplace operator that measures distance; an instance carries its options. "auto" takes
        the operator for the kind of domain, and on meshes flips edges if obtuse angles would cause
        errors.
    diffusion : str, class or instance, optional
        Another operator on the same vertices, for the heat flow.
    time : float, optional
        Time step t of the heat, in squared units of length.
    time_factor : float
        Time step in units of h², h the mean edge length of each component, if `time` is not given.
        On a mesh h is at least half of the root mean square edge of the surface.
    boundary : {"neumann", "dirichlet", "average"}
        Condition on the heat at boundaries.
    solver : str, class, instance or dict
        The linear solver, or ``{"heat": ..., "poisson": ...}``.
    refine : bool, "auto" or "across"
        True: sweep wavefronts over the triangles in the order of the heat, instead of solving the
        Poisson equation. That is several times more accurate on meshes and clouds, and exact at
        the sources. False: plain heat, the paper's own result, which is smooth. On a graph True is
        the shortest path along its edges, and False the distance on the sampled space across the
        edges, by heat. "across" measures the latter by fronts that cross the triangles and
        quadrangles of a graph. "auto" refines if the elements are triangles, and on graphs that are
        made of lines, as trees and streets; it lets fronts cross graphs whose corners do not leave
        gaps, as grids, voxels, meshes and neighbour graphs, and uses heat on others, unless its
        factor would take too long.
        `diagnosis` has the reason. On graphs "auto" uses heat if `time`, `time_factor` or
        `diffusion` are given; refined distances use only the order of the heat.
    mask : array-like of shape (N,), bool, optional
        True at vertices that paths may not cross: faces and edges that touch one are removed, and
        its distance is ``inf``. The rest of the shape has a boundary there.

    Attributes
    ----------
    operator : LaplaceOperator
    diffusion : LaplaceOperator or None
        The operator of the heat, if a different one was given.
    method : HeatMethod

    Raises
    ------
    UnsupportedDomainError
        An object that is not a domain, or a domain that the operator does not take.
    InvalidDomainError
        Invalid arrays of a domain; the message names the fault.
    InvalidOptionError, PluginError
        An option outside its values; an operator or solver that is not available.
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
        operator: Operator = "auto",
        diffusion: Operator | None = None,
        time: float | None = None,
        time_factor: float = 1.0,
        boundary: Boundary = "neumann",
        solver: Solver = "auto",
        refine: Refine = "auto",
        mask: ArrayLike | None = None,
    ) -> None:
        check_one_shape("GeodesicSolver", others)
        made = assembled(
            as_domain(domain),
            operator=operator,
            diffusion=diffusion,
            time=time,
            time_factor=time_factor,
            boundary=boundary,
            solver=solver,
            refine=refine,
            mask=mask,
        )
        super().__init__(made)
        self.operator, self.diffusion, self.method = made.operator, made.diffusion, made.method
        self._complaints = Complaints(made)
        self._diagnosis: Diagnosis | None = None

    def distance(self, sources: Any) -> FloatArray:
        """Return the geodesic distance of every vertex from one set of sources.

        Parameters
        ----------
        sources : int, array-like, SurfacePoint, sequence of them, Located, Curve or OffsetSources
            Vertex indices; points in space, of shape (3,) or (P, 3), snapped to the nearest place
            of the surface, on a cloud of the triangles of its stars; points inside faces, or other
            elements; a polyline; or any of these except a polyline, with offsets. The vertices of a
            label are ``numpy.flatnonzero(labels == label)``.

        Returns
        -------
        ndarray of shape (N,), float64
            In the unit of the domain; ``inf`` at vertices that are not connected to a source. The
            distance at a source vertex is exactly 0, or its offset, and distances are never below
            the smallest of these. On a mesh refined distances are never below the straight line to
            the nearest source, nor above the shortest path along edges; on a cloud not below that
            line.

        Raises
        ------
        InvalidSourceError
            An empty set, an index out of range, a point that is not finite, or another object.

        Examples
        --------
        >>> import geodesic_toolkit as gt
        >>> square = gt.testing.shapes.grid(5)
        >>> gt.GeodesicSolver(square).distance([0.5, 0.5, 0.0])[12].round(3)
        np.float64(0.0)
        """
        places = self.locate(sources)
        self._complaints.warn_where_cut([places])
        distance = self.method.distance(places)
        self._complaints.warn_where_off([places], [distance])
        return distance

    def distances(
        self, source_sets: ArrayLike | Iterable[Any], *, progress: Progress | None = None
    ) -> FloatArray:
        """Return the geodesic distances from K sets of sources, solved in blocks.

        Parameters
        ----------
        source_sets : array-like of int, or iterable of what `distance` takes
            A one-dimensional array of integers means that many single sources.
        progress : callable, optional
            Called with the number of finished sets and their total after each block.

        Returns
        -------
        ndarray of shape (K, N), float64
            One row for each set.

        Raises
        ------
        InvalidSourceError
            As for `distance`, before any work; the message names the set.
        """
        sets = self.locate_sets(source_sets)
        self._complaints.warn_where_cut(sets)
        distances = self.method.distances(sets, progress=progress)
        self._complaints.warn_where_off(sets, distances)
        return distances

    def blocks(self, source_sets: ArrayLike | Iterable[Any]) -> Iterator[FloatArray]:
        """Yield the distances from K sets of sources in blocks of rows of limited size.

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
        self._complaints.warn_where_cut(sets)
        size = max(1, min(MOST_ROWS, BLOCK_ENTRIES // self.domain.n_vertices))
        for first in range(0, len(sets), size):
            some = sets[first : first + size]
            distances = self.method.distances(some)
            self._complaints.warn_where_off(some, distances)
            yield distances

    def near(self, source_sets: ArrayLike | Iterable[Any], limits: ArrayLike) -> NearRows:
        """Return the distances from K sets of sources to the vertices up to a limit for each.

        They have the bits of those of :meth:`distances`, and cost less where limits are small: see
        :func:`distance_matrix`, whose `max_distance` is one limit for all.

        Parameters
        ----------
        source_sets : array-like of int, or iterable of what `distance` takes
            As for :meth:`distances`.
        limits : float or array-like of shape (K,)
            In the unit of the domain; ``inf`` gives all vertices that are connected.

        Returns
        -------
        NearRows
            ``begins`` (K + 1,), ``vertices`` (nnz,) and ``distances`` (nnz,): those of set k are
            ``vertices[begins[k]:begins[k + 1]]``, which ascend.

        Raises
        ------
        InvalidSourceError
            As for :meth:`distances`, before any work.
        InvalidOptionError
            Limits that are not numbers, or not one for each set.

        Examples
        --------
        >>> import geodesic_toolkit as gt
        >>> solver = gt.GeodesicSolver(gt.testing.shapes.icosphere(3))
        >>> near = solver.near([0, 1], limits=0.1)
        >>> near.begins.tolist(), near.vertices.tolist()
        ([0, 1, 2], [0, 1])
        """
        sets = self.locate_sets(source_sets)
        each = _limits(limits, len(sets))
        self._complaints.warn_where_cut(sets)
        if not self.method.refine and self.method.flows:  # the heat of all vertices, with warnings
            parts, begin = [], 0
            for block in self.blocks(sets):
                end = begin + len(block)
                parts.append(NearRows.of_table(block, each[begin:end]))
                begin = end
            return NearRows.together(parts)
        found = self.method.near(sets, each)
        finite = np.isfinite(found.distances)
        return found if finite.all() else found.within(np.minimum(each, np.finfo(float).max))

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
    def seams(self) -> Seams | None:
        """The seams of a mesh, which are coinciding boundary edges, or None."""
        return self._assembly.seams

    @property
    def diagnosis(self) -> "Diagnosis":
        """The diagnosis of the shape; computed on first use."""
        from geodesic_toolkit.solver.diagnosis import diagnose

        with self._lock:
            if self._diagnosis is None:
                made = self._assembly
                self._diagnosis = diagnose(
                    made.passable, made.operator, made.method, made.reason, made.seams
                )
            return self._diagnosis

    def __repr__(self) -> str:
        return (
            f"GeodesicSolver({self.domain!r}, operator={self.operator!r}, method={self.method!r})"
        )


def _limits(limits: ArrayLike, n_sets: int) -> FloatArray:
    """Return a limit for each source set, (K,)."""
    try:
        each = np.asarray(limits, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidOptionError(f"limits must be numbers, not {limits!r}") from error
    if each.shape not in ((), (n_sets,)):
        raise InvalidOptionError(
            f"limits must be one number, or one for each of {n_sets} source sets, not of shape "
            f"{each.shape}"
        )
    wrong = np.flatnonzero(np.isnan(each))
    if len(wrong):
        raise InvalidOptionError(f"limit {wrong[0]} is not a number")
    return np.ascontiguousarray(np.broadcast_to(each, n_sets))


def check_solver(solver: object, what: str) -> None:
    """Raise an `InvalidOptionError` if the argument for `what` is not a solver."""
    if not isinstance(solver, GeodesicSolver):
        raise InvalidOptionError(
            f"{what} needs a GeodesicSolver, not {a_kind_of(solver)}; "
            "make one for the shape: GeodesicSolver(mesh)"
        )
