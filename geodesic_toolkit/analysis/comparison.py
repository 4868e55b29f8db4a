"""Ways to compute distances on one shape, side by side: errors, symmetry, times, memory."""

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
"""Faces up to which the exact algorithm is the reference: half a minute."""

N_SYMMETRY_PROBES = 6
"""Vertices between which symmetry is measured."""


@dataclass(frozen=True, eq=False)
class Row:
    """The result of one variant.

    Attributes
    ----------
    variant : Variant
    distance : ndarray of shape (N,), or None
        None where it failed.
    mean, largest : float
        Mean and largest relative error over the vertices but the sources; NaN where it failed.
    of_diameter : float
        The largest error over the largest distance of the reference.
    asymmetry : float
        Mean of ``|d(i, j) - d(j, i)|`` over pairs of probes, over the largest distance.
    unreached : int
        Vertices with a distance in the reference and none here.
    build, per_source : float
        Seconds to build the solver, and for a further source in a block of probes.
    factor_bytes : int
        Memory of the factors.
    warnings : tuple of str
    failure : str or None
        Why there are no figures.
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
        """Return the figures and what they are of as plain objects, without the distances."""
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
        What the errors are measured against.
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
            There is none of that name.
        """
        for row in self.rows:
            if row.variant.name == name:
                return row
        names = ", ".join(repr(row.variant.name) for row in self.rows)
        raise InvalidOptionError(f"nothing was compared under the name {name!r}; there are {names}")

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
            There is none of that name, or it failed.
        """
        row = self.row(name)
        if row.distance is None:
            raise InvalidOptionError(f"{name!r} has no errors to show, as it failed: {row.failure}")
        return _relative_error(row.distance, self.reference)


def compare(
    domain: Any,
    sources: Any,
    *,
    variants: Sequence[Variant] | None = None,
    affordable_faces: int = AFFORDABLE_FACES,
    progress: Callable[[int, int], None] | None = None,
) -> Comparison:
    """Compute distances in many ways and measure each against the best reference there is.

    Parameters
    ----------
    domain : Domain or object
        What :func:`as_domain` takes.
    sources : int, array-like of int, array-like of float, SurfacePoint or sequence of them
        As :meth:`GeodesicSolver.distance` takes them; each is moved to the nearest vertex, as
        a graph and a cloud have no points between.
    variants : sequence of Variant, optional
        :func:`~geodesic_toolkit.variants_for` the domain by default.
    affordable_faces : int
        Up to so many faces of a mesh the reference is :func:`exact_distance`; of graphs it is the
        shortest path along edges; else the distance of the default, refined where there are
        triangles.
    progress : callable, optional
        Called with the number of variants done and their total after each.

    Returns
    -------
    Comparison

    Raises
    ------
    UnsupportedDomainError, InvalidDomainError, InvalidSourceError
        As for :class:`GeodesicSolver`. A variant that fails is a row that says so.

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
    places = locate_sources(shape, sources)
    vertices = np.unique(np.asarray(places.weights.argmax(axis=1)).ravel()).astype(np.int64)
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
            pass  # the search was given up: what is refined will do
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GeodesicWarning)  # its row has them
        solver = GeodesicSolver(domain)
        ways = solver.method.metric.along_edges
        if ways is not None:
            ends, late = np.array([0, len(sources)]), np.zeros(len(sources))
            return "shortest path along edges", ways.distances(ends, sources, late)[0]
        name = "refined distance" if solver.method.refine else "the default"
        return name, solver.distance(sources)


def _probes(reference: FloatArray) -> IntArray:
    """Return vertices that a source reaches, spread over their numbers."""
    reached = np.flatnonzero(np.isfinite(reference))
    positions = np.linspace(0, len(reached) - 1, min(N_SYMMETRY_PROBES, len(reached))).round()
    return reached[np.unique(positions.astype(np.int64))]


def _warm_up(kinds: set[type[Domain]]) -> None:
    """Compile and import what is done once a process, so that it is in nobody's time."""
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
    """Return ``|d - reference| / reference``: 0 at sources, NaN where one of them is not finite."""
    known = np.isfinite(distance) & np.isfinite(reference)
    relative = np.where(known, 0.0, np.nan)
    away = known & (reference > 0)
    relative[away] = np.abs(distance[away] - reference[away]) / reference[away]
    return relative


def _asymmetry(between: FloatArray) -> float:
    """Return the mean of ``|d(i, j) - d(j, i)|`` over the pairs with both."""
    rows, columns = np.triu_indices(len(between), 1)
    there, back = between[rows, columns], between[columns, rows]
    both = np.isfinite(there) & np.isfinite(back)
    return float(np.abs(there[both] - back[both]).mean()) if both.any() else 0.0


def _texts(caught: list[warnings.WarningMessage]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(str(warning.message) for warning in caught))


def _plain(value: object) -> object:
    return value if isinstance(value, bool | int | float | str | dict) else repr(value)
