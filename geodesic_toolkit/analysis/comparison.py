"""Comparison of variants on one shape: errors, symmetry, times, memory."""

import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from geodesic_toolkit.analysis.variants import DEFAULT, Variant, variants_for
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains import Domain, PointCloud, TriangleMesh
from geodesic_toolkit.errors import (
    GeodesicError,
    GeodesicWarning,
    InvalidOptionError,
    SolverError,
)
from geodesic_toolkit.exact import exact_distance
from geodesic_toolkit.interop.conversion import as_domain
from geodesic_toolkit.solver.solver import GeodesicSolver
from geodesic_toolkit.sources.locate import locate_sources

__all__ = ["Comparison", "Row", "compare"]

AFFORDABLE_FACES = 60_000
"""Faces up to which the exact algorithm is the reference (about half a minute)."""

N_SYMMETRY_PROBES = 6
"""Vertices between which symmetry is measured."""


@dataclass(frozen=True, eq=False)
class Row:
    """The result of one variant.

    Attributes
    ----------
    variant : Variant
    distance : ndarray of shape (N,), or None
        None if the variant failed.
    mean, largest : float
        Mean and largest relative error over all vertices but the sources; NaN if it failed.
    of_diameter : float
        The largest error, divided by the largest distance of the reference.
    asymmetry : float
        Mean of ``|d(i, j) - d(j, i)|`` over pairs of probes, divided by the largest distance.
    unreached : int
        Number of vertices that have a distance in the reference but not here.
    build, per_source : float
        Seconds to build the solver, and for each further source in a block of probes.
    factor_bytes : int
        Memory of the factors.
    warnings : tuple of str
    failure : str or None
        The reason why there are no figures.
    """

    variant: Variant
    distance: FloatArray | None
    mean: float
    largest: float
    of_diameter: float
    asymmetry: float
    unreached: int
    build: float
    per_source: float
    factor_bytes: int
    warnings: tuple[str, ...] = ()
    failure: str | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return the figures and the variant as plain objects, without the distances."""
        kept = {
            item.name: getattr(self, item.name)
            for item in fields(self)
            if item.name not in ("variant", "distance")
        }
        options = {name: _plain(value) for name, value in self.variant.options.items()}
        return {
            "name": self.variant.name,
            "group": self.variant.group,
            "options": options,
            **kept,
        }


@dataclass(frozen=True, eq=False)
class Comparison:
    """Variants on one shape, from one set of sources.

    Attributes
    ----------
    domain : Domain
    sources : ndarray of shape (S,), int64
        Vertices.
    reference_name : str
        Name of the distances against which errors are measured.
    reference : ndarray of shape (N,), float64
    rows : tuple of Row
        The default first.
    """

    domain: Domain
    sources: IntArray
    reference_name: str
    reference: FloatArray
    rows: tuple[Row, ...]

    def row(self, name: str) -> Row:
        """Return the row of a variant by its name.

        Parameters
        ----------
        name : str

        Returns
        -------
        Row

        Raises
        ------
        InvalidOptionError
            There is not a variant of that name.
        """
        for row in self.rows:
            if row.variant.name == name:
                return row
        names = ", ".join(repr(row.variant.name) for row in self.rows)
        raise InvalidOptionError(f"there is not a variant {name!r}; those compared are {names}")

    def error(self, name: str = DEFAULT) -> FloatArray:
        """Return the relative error of a variant at every vertex: 0 at sources, NaN where unknown.

        Parameters
        ----------
        name : str

        Returns
        -------
        ndarray of shape (N,), float64

        Raises
        ------
        InvalidOptionError
            There is not a variant of that name, or it failed.
        """
        row = self.row(name)
        if row.distance is None:
            raise InvalidOptionError(f"{name!r} failed and has no errors to show: {row.failure}")
        return _relative_error(row.distance, self.reference)


def compare(
    domain: Any,
    sources: Any,
    *,
    variants: Sequence[Variant] | None = None,
    affordable_faces: int = AFFORDABLE_FACES,
    progress: Callable[[int, int], None] | None = None,
) -> Comparison:
    """Compute distances with several variants and compare each with the best reference.

    Parameters
    ----------
    domain : Domain or object
        A domain, or an object that :func:`as_domain` accepts.
    sources : int, array-like of int, array-like of float, SurfacePoint or sequence of them
        As for :meth:`GeodesicSolver.distance`; each is moved to the nearest vertex, because
        graphs and clouds have no points between vertices.
    variants : sequence of Variant, optional
        :func:`~geodesic_toolkit.variants_for` the domain by default.
    affordable_faces : int
        For a mesh with at most this many faces the reference is :func:`exact_distance`. For a graph
        it is the shortest path along edges; otherwise it is the distance of the default, refined if
        there are triangles.
    progress : callable, optional
        Called with the number of variants done and their total after each.

    Returns
    -------
    Comparison

    Raises
    ------
    UnsupportedDomainError, InvalidDomainError, InvalidSourceError
        As for :class:`GeodesicSolver`. The row of a variant that fails has the reason.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit.analysis.comparison import compare
    >>> comparison = compare(gt.testing.shapes.icosphere(3), 0)
    >>> comparison.reference_name
    'exact polyhedral distance'
    >>> comparison.row("auto").mean < comparison.row("plain heat").mean / 5
    True
    """
    shape = as_domain(domain)
    located = locate_sources(shape, sources)
    vertices = np.unique(np.asarray(located.weights.argmax(axis=1)).ravel()).astype(np.int64)
    name, reference = _reference(shape, vertices, affordable_faces)
    probes = _probes(reference)
    chosen = variants_for(shape) if variants is None else list(variants)
    _warm_up({type(item.domain or shape) for item in chosen})
    rows = []
    for done, variant in enumerate(chosen, start=1):
        rows.append(_row(shape, variant, vertices, reference, probes))
        if progress is not None:
            progress(done, len(chosen))
    return Comparison(shape, vertices, name, reference, tuple(rows))


def _reference(domain: Domain, sources: IntArray, affordable: int) -> tuple[str, FloatArray]:
    if isinstance(domain, TriangleMesh) and domain.n_faces <= affordable:
        try:
            return "exact polyhedral distance", exact_distance(domain, sources)
        except SolverError:
            pass  # the search was given up; the refined distance replaces it
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GeodesicWarning)  # the row of the default has them
        solver = GeodesicSolver(domain)
        graph = solver.method.metric.along_edges
        if graph is not None:
            ends, offsets = np.array([0, len(sources)]), np.zeros(len(sources))
            return "shortest path along edges", graph.distances(ends, sources, offsets)[0]
        name = "refined distance" if solver.method.refine else "the default"
        return name, solver.distance(sources)


def _probes(reference: FloatArray) -> IntArray:
    """Return vertices that a source reaches, spread evenly over the indices."""
    reached = np.flatnonzero(np.isfinite(reference))
    positions = np.linspace(0, len(reached) - 1, min(N_SYMMETRY_PROBES, len(reached))).round()
    return reached[np.unique(positions.astype(np.int64))]


def _warm_up(kinds: set[type[Domain]]) -> None:
    """Compile and import what a process needs once, so that no variant's time includes it."""
    row = np.arange(5.0)
    points = np.array([[x, y, 0.0] for y in row for x in row])
    corners = np.array([x + 5 * y for y in range(4) for x in range(4)])
    lower = np.column_stack([corners, corners + 1, corners + 6])
    square = np.vstack([lower, np.column_stack([corners, corners + 6, corners + 5])])
    GeodesicSolver(TriangleMesh(points, square)).distance(0)
    if PointCloud in kinds:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", GeodesicWarning)
            GeodesicSolver(PointCloud(points)).distance(0)


def _row(
    domain: Domain, variant: Variant, sources: IntArray, reference: FloatArray, probes: IntArray
) -> Row:
    own = domain if variant.domain is None else variant.domain
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GeodesicWarning)
        try:
            start = time.perf_counter()
            solver = GeodesicSolver(own, **variant.options)
            built = time.perf_counter()
            between = solver.distances(probes)
            asked = time.perf_counter()
            distance = solver.distance(sources)
        except GeodesicError as error:
            nothing = (np.nan,) * 4
            return Row(variant, None, *nothing, 0, np.nan, np.nan, 0, _texts(caught), str(error))
    relative = _relative_error(distance, reference)
    known = np.isfinite(relative) & (reference > 0)
    farthest = float(reference[np.isfinite(reference)].max()) or 1.0
    return Row(
        variant,
        distance,
        mean=float(relative[known].mean()) if known.any() else np.nan,
        largest=float(relative[known].max()) if known.any() else np.nan,
        of_diameter=float((relative * reference)[known].max()) / farthest
        if known.any()
        else np.nan,
        asymmetry=_asymmetry(between[:, probes]) / farthest,
        unreached=int((np.isfinite(reference) & ~np.isfinite(distance)).sum()),
        build=built - start,
        per_source=(asked - built) / len(probes),
        factor_bytes=solver.method.nbytes,
        warnings=_texts(caught),
    )


def _relative_error(distance: FloatArray, reference: FloatArray) -> FloatArray:
    """Return ``|d - reference| / reference``: 0 at sources, NaN if one of them is not finite."""
    known = np.isfinite(distance) & np.isfinite(reference)
    relative = np.where(known, 0.0, np.nan)
    away = known & (reference > 0)
    relative[away] = np.abs(distance[away] - reference[away]) / reference[away]
    return relative


def _asymmetry(between: FloatArray) -> float:
    """Return the mean of ``|d(i, j) - d(j, i)|`` over pairs that have both."""
    rows, columns = np.triu_indices(len(between), 1)
    there, back = between[rows, columns], between[columns, rows]
    both = np.isfinite(there) & np.isfinite(back)
    return float(np.abs(there[both] - back[both]).mean()) if both.any() else 0.0


def _texts(caught: list[warnings.WarningMessage]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(str(warning.message) for warning in caught))


def _plain(value: object) -> object:
    return value if isinstance(value, bool | int | float | str | dict) else repr(value)
