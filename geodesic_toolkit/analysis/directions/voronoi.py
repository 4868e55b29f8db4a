"""Centroidal Voronoi cells: sites spread evenly over a surface."""

from dataclasses import dataclass
from typing import Any, cast, final

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.analysis.directions.steps import Stepper
from geodesic_toolkit.analysis.directions.traced import Traced, trace
from geodesic_toolkit.core.frozen import FrozenArrays, freeze
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.errors import InvalidOptionError, InvalidSourceError, UnsupportedDomainError
from geodesic_toolkit.heat.method import Progress
from geodesic_toolkit.solver.solver import GeodesicSolver, check_solver
from geodesic_toolkit.sources.points import SourcePoints
from geodesic_toolkit.sources.surface_point import SurfacePoint

__all__ = ["CentroidalVoronoi", "centroidal_voronoi"]


@final
@dataclass(frozen=True, eq=False)
class CentroidalVoronoi(FrozenArrays):
    """Sites that are the centres of their own cells, or nearly.

    Attributes
    ----------
    sites : tuple of SurfacePoint
        P places; :meth:`GeodesicSolver.distance` takes them as sources.
    labels : ndarray of shape (N,), int64
        The nearest site of each vertex; -1 where none connects.
    energies : ndarray of shape (S,), float64
        Before each step, and of the result: the sum of squared distances from the nearest site,
        each times the area and the density of its vertex.
    """

    sites: tuple[SurfacePoint, ...]
    labels: IntArray
    energies: FloatArray

    def __post_init__(self) -> None:
        freeze(self.labels)
        freeze(self.energies)

    def __repr__(self) -> str:
        return f"CentroidalVoronoi({len(self.sites)} sites, energy {self.energies[-1]:.6g})"


def centroidal_voronoi(
    solver: GeodesicSolver,
    sites: Any,
    *,
    density: ArrayLike | None = None,
    steps: int = 100,
    tolerance: float = 1e-4,
    rng: np.random.Generator | None = None,
    progress: Progress | None = None,
) -> CentroidalVoronoi:
    """Move sites to the centres of their geodesic Voronoi cells, again and again.

    Lloyd's iteration: each site moves to the mean of the logarithms of its cell. One sweep gives
    the logarithmic maps of all cells, whatever their number.

    Parameters
    ----------
    solver : GeodesicSolver
        Of a mesh.
    sites : array-like, SurfacePoint, sequence of them, or int
        Their initial places, as :meth:`GeodesicSolver.distance` takes sources; or, with `rng`, the
        number of sites to draw among the vertices, by area and density.
    density : array-like of shape (N,), optional
        Factors of the areas of the vertices; not negative. Cells are small where it is large.
    steps : int
        Maximum number of steps.
    tolerance : float
        Relative decrease of the energy below which the iteration ends.
    rng : numpy.random.Generator, optional
    progress : callable, optional
        Called with the number of steps done and `steps` after each.

    Returns
    -------
    CentroidalVoronoi

    Raises
    ------
    InvalidOptionError
        Something else than a solver; an option outside its values.
    UnsupportedDomainError
        Something else than a mesh; a surface with one side.
    InvalidSourceError
        Not a site, or an argument that is not a place.

    References
    ----------
    S. Lloyd, *Least squares quantization in PCM*, 1982, https://doi.org/10.1109/TIT.1982.1056489

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> solver = gt.GeodesicSolver(gt.testing.shapes.icosphere(3))
    >>> cells = gt.centroidal_voronoi(solver, [0, 1, 2, 3, 4, 5])
    >>> bool(cells.energies[-1] < cells.energies[0])
    True
    """
    check_solver(solver, "centroidal_voronoi")
    mesh = solver.passable
    if not isinstance(mesh, TriangleMesh):
        raise UnsupportedDomainError(
            f"sites move over the faces of a mesh, and not over {a_kind_of(mesh)}"
        )
    if not (steps >= 0 and tolerance >= 0):
        raise InvalidOptionError(f"steps {steps} and tolerance {tolerance} must not be negative")
    mass = solver.method.metric.mass * _density(density, mesh.n_vertices)
    places = _first_sites(solver, sites, mass, rng)
    stepper = Stepper.of(mesh)
    numbers, weights = stepper.inside(places)
    traced = trace(solver, stepper.points(numbers, weights))
    energies = [_energy(traced, mass)]
    for step in range(1, steps + 1):
        vectors = _to_centres(traced, mass, len(numbers))
        others = stepper.moved(numbers, weights, vectors)
        there = trace(solver, stepper.points(*others))
        energy = _energy(there, mass)
        if not energy < energies[-1]:
            break
        (numbers, weights), traced = others, there
        energies.append(energy)
        if progress is not None:
            progress(step, steps)
        if energies[-2] - energy < tolerance * energy:
            break
    return CentroidalVoronoi(
        sites=_surface_points(solver, *stepper.as_given(numbers, weights)),
        labels=traced.labels,
        energies=np.array(energies),
    )


def _density(values: ArrayLike | None, count: int) -> FloatArray:
    if values is None:
        return np.ones(count)
    try:
        density = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidOptionError(f"density must be numbers: {error}") from error
    if density.shape != (count,) or not (np.isfinite(density) & (density >= 0)).all():
        raise InvalidOptionError(
            f"density must be a finite number for each of {count} vertices, not negative"
        )
    return density


def _first_sites(
    solver: GeodesicSolver, sites: Any, mass: FloatArray, rng: np.random.Generator | None
) -> SourcePoints:
    if rng is not None:
        candidates = int((mass > 0).sum())
        if isinstance(sites, bool) or not isinstance(sites, int | np.integer):
            raise InvalidOptionError(f"sites: with rng, how many of them, not {sites!r}")
        if not 1 <= sites <= candidates:
            raise InvalidOptionError(
                f"sites: between 1 and the {candidates} vertices that have weight, not {sites}"
            )
        sites = rng.choice(len(mass), int(sites), replace=False, p=mass / mass.sum())
    elif isinstance(sites, int | np.integer):
        raise InvalidOptionError(
            f"sites: with rng {sites} is the number of sites to draw; without it give places, such "
            f"as [{sites}] for one vertex"
        )
    places = solver.locate(sites, "sites")
    if places.front_curvatures is not None or places.delayed:
        raise InvalidSourceError("sites: cells have points for sites, not a curve or offsets")
    return places


def _energy(traced: Traced, mass: FloatArray) -> float:
    reached = traced.labels >= 0
    return float((mass[reached] * traced.distances[reached] ** 2).sum())


def _to_centres(traced: Traced, mass: FloatArray, count: int) -> FloatArray:
    """Return the mean logarithm of each cell as a vector in space, (P, 3)."""
    reached = traced.labels >= 0
    labels, own = traced.labels[reached], mass[reached]
    logarithms = own * traced.distances[reached] * np.exp(1j * traced.angles[reached])
    total = np.bincount(labels, own, count)
    pull = np.bincount(labels, logarithms.real, count) + 1j * np.bincount(
        labels, logarithms.imag, count
    )
    mean = np.divide(pull, total, out=np.zeros_like(pull), where=total > 0)
    pairs = np.column_stack([mean.real, mean.imag])
    return np.asarray(np.einsum("pa,pad->pd", pairs, traced.sources.axes))


def _surface_points(
    solver: GeodesicSolver, faces: IntArray, weights: FloatArray
) -> tuple[SurfacePoint, ...]:
    """Return points of the mesh as it was given, of which some faces may be masked."""
    if solver.mask is not None:
        whole = cast("TriangleMesh", solver.domain)
        faces = np.flatnonzero(~solver.mask[whole.faces].any(axis=1))[faces]
    return tuple(
        SurfacePoint(face, (a, b, c))
        for face, (a, b, c) in zip(faces.tolist(), weights.tolist(), strict=True)
    )
