"""`thin`: choose fewer points of a cloud, and carry distances at them back to all points."""

import numbers
import threading
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.checks import real_numbers
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains import PointCloud
from geodesic_toolkit.errors import (
    InvalidOptionError,
    InvalidSourceError,
    UnsupportedDomainError,
)
from geodesic_toolkit.heat.method import Progress
from geodesic_toolkit.interop.conversion import as_domain
from geodesic_toolkit.solver.queries import Surface
from geodesic_toolkit.solver.solver import GeodesicSolver
from geodesic_toolkit.sources.points import as_vertices

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

__all__ = ["Thinned", "thin"]

MIN_RELATIVE_SPACING = 2.0**-40
"""Smallest plausible spacing, relative to the cloud's size; a smaller one has another unit."""

POINTS_PER_BATCH = 1_000_000
"""Number of points per query."""


@final
@dataclass(frozen=True, eq=False, kw_only=True)
class Thinned:
    """A cloud with fewer points, and its relation to the full cloud: the result of :func:`thin`.

    Attributes
    ----------
    cloud : PointCloud
        The M points that were kept, with their normals if there are any.
    index : ndarray of shape (M,), int64, read-only
        Indices of these points among the N points of `full`, ascending: ``cloud.points`` equals
        ``full.points[index]``.
    full : PointCloud
        The cloud that was thinned.
    spacing : float
    """

    cloud: PointCloud
    index: IntArray
    full: PointCloud
    spacing: float
    _made: dict[str, Surface] = field(init=False, default_factory=dict, repr=False)
    _lock: Any = field(init=False, default_factory=threading.Lock, repr=False)

    def vertices_of(self, points: ArrayLike) -> IntArray:
        """Return the indices in `cloud` of some points of `full`.

        Parameters
        ----------
        points : int or array-like of int
            Indices of the full cloud.

        Returns
        -------
        ndarray of shape (P,), int64

        Raises
        ------
        InvalidSourceError
            An index out of range, or a point that was not kept.
        """
        wanted = as_vertices(points, self.full.n_vertices, "points")
        positions = np.searchsorted(self.index, wanted)
        kept = self.index[np.minimum(positions, len(self.index) - 1)] == wanted
        if not kept.all():
            lost = int(wanted[~kept][0])
            raise InvalidSourceError(
                f"point {lost} was not kept: thin with keep=[{lost}], or give its position instead"
            )
        return positions

    def carry_back(
        self,
        distance: ArrayLike,
        solver: GeodesicSolver | None = None,
        *,
        sources: Any = None,
        progress: Progress | None = None,
    ) -> FloatArray:
        """Return distances at all points, given those at the points that were kept.

        A kept point keeps its distance. Any other point is projected onto the triangles of the
        thinned cloud, within the spacing, and has the :meth:`GeodesicSolver.interpolate` there.

        Parameters
        ----------
        distance : array-like of shape (M,) or (K, M)
            At the points of `cloud`.
        solver : GeodesicSolver, optional
            A solver of `cloud`, whose triangles and tree are used. Otherwise those of
            :class:`PointCloudLaplacian` are made, once.
        sources : optional
            The sources of a single distance field; the distances close to them are then more
            accurate.
        progress : callable, optional
            Called with the number of points done and their total after each batch, for each field.

        Returns
        -------
        ndarray of shape (N,) or (K, N), float64
            ``inf`` if a point is missing, if no triangle is within the spacing, and if
            the triangle has no distance.

        Raises
        ------
        InvalidOptionError
            Distances of another shape, a solver of another cloud, sources without their solver.
        InvalidSourceError
            As for :meth:`GeodesicSolver.distance`.
        """
        values = real_numbers(distance, "distance")
        if values.ndim not in {1, 2} or values.shape[-1] != self.cloud.n_vertices:
            raise InvalidOptionError(
                f"distance must have shape ({self.cloud.n_vertices},), one number for each point "
                f"that was kept, or rows of these, not {values.shape}"
            )
        surface = self._surface(solver)
        located = None
        if sources is not None:
            if solver is None:
                raise InvalidOptionError("sources need their solver: give solver= too")
            located = solver.locate(sources)
        other = self.full.present.copy()
        other[self.index] = False
        rest = np.flatnonzero(other)
        points = self.full.points[rest]
        result = np.full((*values.shape[:-1], self.full.n_vertices), np.inf)
        for row, whole in zip(np.atleast_2d(values), np.atleast_2d(result), strict=True):
            whole[rest] = surface.interpolate(
                row, points, reach=self.spacing, sources=located, progress=progress
            )
            whole[self.index] = row
        return result

    def _surface(self, solver: GeodesicSolver | None) -> Surface:
        if solver is not None:
            if solver.domain is not self.cloud:
                raise InvalidOptionError(
                    f"the solver is of another shape, {solver.domain!r}, than the thinned cloud, "
                    f"{self.cloud!r}: make it with GeodesicSolver(thinned.cloud)"
                )
            return solver.surface
        with self._lock:
            if "surface" not in self._made:
                from geodesic_toolkit.laplacians.pointcloud.operator import PointCloudLaplacian

                metric = PointCloudLaplacian().assemble(self.cloud)
                self._made["surface"] = Surface(self.cloud, metric)
            return self._made["surface"]

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name[0] != "_"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state, _made={}, _lock=threading.Lock())


def thin(cloud: Any, spacing: float, *, keep: ArrayLike | None = None) -> Thinned:
    """Return a cloud with points `spacing` apart, and their relation to the full cloud.

    Points are chosen by Poisson disk sampling: no two are closer than the spacing, and every point
    of the cloud has a chosen one within it. Chosen points do not move: nothing is averaged. The
    result is deterministic.

    A cloud denser than the accuracy requires wastes time and memory: half the spacing means four
    times the points. Sheets of a shape that are closer than one or two spacings cannot be
    distinguished after thinning.

    Parameters
    ----------
    cloud : PointCloud or object
        A cloud, or an object that :func:`as_domain` makes one of. Missing points are not chosen.
    spacing : float
        In the unit of the cloud.
    keep : int or array-like of int, optional
        Points that always stay, such as sources, however close to each other.

    Returns
    -------
    Thinned

    Raises
    ------
    UnsupportedDomainError
        The object is not a cloud.
    InvalidOptionError
        A spacing that is not positive, not finite, larger than the cloud, or vanishingly small.
    InvalidSourceError
        A point to keep that does not exist or is missing.

    References
    ----------
    R. L. Cook, *Stochastic sampling in computer graphics*, 1986,
    https://doi.org/10.1145/7529.8927

    Examples
    --------
    >>> import numpy as np
    >>> import geodesic_toolkit as gt
    >>> points = np.random.default_rng(0).uniform(size=(20_000, 3)) * [1, 1, 0]
    >>> thinned = gt.thin(gt.PointCloud(points), 0.05, keep=0)
    >>> thinned.cloud.n_vertices < 400
    True
    >>> solver = gt.GeodesicSolver(thinned.cloud)
    >>> source = thinned.vertices_of(0)
    >>> distance = thinned.carry_back(solver.distance(source), solver, sources=source)
    >>> error = np.abs(distance - np.linalg.norm(points - points[0], axis=1))
    >>> bool(error.mean() < 0.003), bool(error.max() < 0.05)  # the largest are at the rim
    (True, True)
    """
    full = as_domain(cloud)
    if not isinstance(full, PointCloud):
        raise UnsupportedDomainError(
            f"thin takes a PointCloud, not {a_kind_of(full)}; to coarsen a mesh, decimate it "
            "with the library that made it"
        )
    points = full.points[full.present]
    step = _checked(spacing, points)
    stay = _kept(full, keep)
    place = np.cumsum(full.present) - 1  # position of each point among those present
    index = np.flatnonzero(full.present)[_disks(points, step, place[stay])]
    index.sort()
    index.flags.writeable = False
    normals = None if full.normals is None else full.normals[index]
    kept = PointCloud(full.points[index], normals)
    return Thinned(cloud=kept, index=index, full=full, spacing=step)


def _checked(spacing: object, points: FloatArray) -> float:
    """Return the spacing as a number, or raise if it is not usable."""
    if isinstance(spacing, bool) or not isinstance(spacing, numbers.Real):
        raise InvalidOptionError(f"spacing must be a length, not {spacing!r}")
    step = float(spacing)
    if not (np.isfinite(step) and step > 0):
        raise InvalidOptionError(f"spacing must be positive and finite, not {step}")
    size = float((points.max(axis=0) - points.min(axis=0)).max())
    if size > 0 and not MIN_RELATIVE_SPACING * size < step < size:
        raise InvalidOptionError(
            f"spacing {step:g} of a cloud whose size is {size:g} leaves "
            f"{'nothing of its shape' if step >= size else 'all points'}; are the units the same?"
        )
    return step


def _kept(full: PointCloud, keep: ArrayLike | None) -> IntArray:
    if keep is None:
        return np.empty(0, dtype=np.int64)
    stay = np.unique(as_vertices(keep, full.n_vertices, "keep"))
    if not full.present[stay].all():
        missing = int(stay[~full.present[stay]][0])
        raise InvalidSourceError(f"keep: point {missing} of the cloud is missing (not finite)")
    return stay


def _disks(points: FloatArray, spacing: float, stay: IntArray) -> IntArray:
    """Return points no two of which are closer than the spacing, except those that stay.

    The set is maximal: no further point could be added.
    """
    from scipy.spatial import cKDTree

    rng = np.random.default_rng(0)
    low = points.min(axis=0)
    chosen = [stay]
    left = np.arange(len(points))
    if len(stay):
        left = left[_free(points, left, cKDTree(points[stay]), spacing)]
    while len(left):
        # One random point per small cell bounds the number of close pairs. Later rounds, usually
        # few, add points that still fit.
        some = left[_one_a_cell(points[left] - low, spacing / 2, rng)]
        some = some[_apart(points[some], spacing, rng)]
        chosen.append(some)
        left = left[_free(points, left, cKDTree(points[some]), spacing)]
    return np.concatenate(chosen)


def _free(points: FloatArray, rows: IntArray, taken: "cKDTree", spacing: float) -> IntArray:
    """Return the positions of the rows whose points are farther than the spacing from `taken`."""
    found = []
    for start in range(0, len(rows), POINTS_PER_BATCH):
        some = points[rows[start : start + POINTS_PER_BATCH]]
        far = np.isinf(taken.query(some, distance_upper_bound=spacing)[0])
        found.append(start + np.flatnonzero(far))
    return np.concatenate(found)


def _one_a_cell(points: FloatArray, size: float, rng: np.random.Generator) -> IntArray:
    """Return the position of one random point in each cell of a grid."""
    cells = np.floor(points / size).astype(np.int64)
    drawn = rng.permutation(len(points))
    order = drawn[np.lexsort(cells[drawn].T)]
    ordered = cells[order]
    new = np.ones(len(order), dtype=np.bool_)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    return np.asarray(order[new])


def _apart(points: FloatArray, spacing: float, rng: np.random.Generator) -> IntArray:
    """Return the positions of points no two of which are closer than the spacing, by Luby's method.

    In each round, a point is chosen if its random priority precedes those of all points that are
    too close to it; those are then excluded.
    """
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(np.nextafter(spacing, 0), output_type="ndarray")
    priority = rng.permutation(len(points))
    undecided = np.ones(len(points), dtype=np.bool_)
    chosen = np.zeros(len(points), dtype=np.bool_)
    while len(pairs):
        first = priority[pairs[:, 0]] < priority[pairs[:, 1]]
        beaten = np.zeros(len(points), dtype=np.bool_)
        beaten[np.where(first, pairs[:, 1], pairs[:, 0])] = True
        won = undecided & ~beaten
        out = np.zeros(len(points), dtype=np.bool_)
        out[pairs[won[pairs[:, 0]], 1]] = True
        out[pairs[won[pairs[:, 1]], 0]] = True
        chosen |= won
        undecided &= ~won & ~out
        pairs = pairs[undecided[pairs].all(axis=1)]
    return np.flatnonzero(chosen | undecided)
