"""The state of a page: sources, distances, a path, what is shown; without a browser."""

import json
import tempfile
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.domains import Domain, Located
from geodesic_toolkit.errors import InvalidOptionError, InvalidSourceError
from geodesic_toolkit.interop.conversion import as_domain
from geodesic_toolkit.io import write
from geodesic_toolkit.solver.solver import GeodesicSolver, Refine
from geodesic_toolkit.viz.live.picking import Picker
from geodesic_toolkit.viz.scene import Scene, make_scene

__all__ = ["Mode", "Place", "Session"]

MOST_SOLVERS = 3
"""Number of solvers kept, each with its factors: going back to one of them takes no time."""

MOST_PARTS = 8
"""Number of components, the largest, that can be hidden one by one."""

SCHEMA_VERSION = 1
"""Version of the JSON of the sources; raised if a key is removed or changes its meaning."""


class Mode(StrEnum):
    """The effect of a click."""

    SOURCE = "source"
    PATH = "path"
    MEASURE = "measure"


@dataclass(frozen=True)
class Place:
    """A place that was clicked.

    Attributes
    ----------
    vertices : ndarray of shape (C,), int64
        The corners of its face; or one point, where there are no faces.
    weights : ndarray of shape (C,), float64
        Not negative, with sum 1.
    """

    vertices: IntArray
    weights: FloatArray

    def of(self, values: FloatArray) -> Any:
        """Return the combination of values at the corners: of positions, or of distances."""
        used = self.weights > 0  # infinity is of the corners that count
        return self.weights[used] @ values[self.vertices[used]]


class Session:
    """A shape with sources that follow clicks.

    It is not safe to use from several threads at once.

    Parameters
    ----------
    shape : Domain, or whatever :class:`GeodesicSolver` takes
    positions : array-like of shape (N, 3) or (N, 2), optional
        Positions at which the vertices of a graph are drawn.
    sources : optional
        As :meth:`GeodesicSolver.distance` takes them, except for curves and offsets; by default
        one vertex.
    operator, mask, refine, time_factor : optional
        As for :class:`GeodesicSolver`; the last two may be changed on the page.
    name : str
        Name of the shape, for files.
    like : path, optional
        The file of the shape, whose other data a .ply keeps.

    Attributes
    ----------
    scene : Scene
        The shape in the coordinates of the page.
    sources : tuple of Place
    distances : ndarray of shape (N,)
    largest : float
        The largest distance of a vertex that is reached.
    n_unreached : int
        The number of vertices that no source reaches, apart from masked ones.
    masked : ndarray of shape (N,), bool
        True at masked vertices; they are shown without a value.
    parts : ndarray of shape (N,), int64
        The part of each vertex: 0 of the largest component, and so on; the last one has the rest.
        -1 of vertices without a face, and of masked ones.
    sizes : list of int
        The number of vertices of each part.
    hidden : frozenset of int
        The parts that are not shown.
    path : GeodesicPath, CloudPath, EdgePath or None
    measured : (Place, float) or None
        The place that was measured last, and its distance.
    """

    def __init__(
        self,
        shape: Any,
        *,
        positions: ArrayLike | None = None,
        sources: Any = None,
        operator: Any = "auto",
        mask: ArrayLike | None = None,
        refine: Refine = "auto",
        time_factor: float = 1.0,
        name: str = "shape",
        like: Path | None = None,
    ) -> None:
        self.domain: Domain = as_domain(shape)
        self.name, self._like, self._operator, self._mask = name, like, operator, mask
        nothing = np.full(self.domain.n_vertices, np.nan)
        self.scene: Scene = make_scene(self.domain, nothing, sources=[], positions=positions)
        self._picker = Picker(self.scene)
        self.mode = Mode.SOURCE
        self.time_factor = time_factor
        self.refine = refine
        self._solvers: dict[tuple[Any, float], GeodesicSolver] = {}
        self.hidden: frozenset[int] = frozenset()
        self.path: Any = None
        self.measured: tuple[Place, float] | None = None
        self._path_begins = False
        nowhere = np.zeros(self.domain.n_vertices, dtype=np.bool_)
        first = self.solver
        self._refined: Refine = "across" if first.method.across else True
        self.refine = self._refined if self.refined else False  # the choice of "auto"
        self._solvers = {(self.refine, time_factor): first}
        self._mask = first.mask  # a copy, with all points at the position of a masked one
        self.masked: BoolArray = nowhere if self._mask is None else self._mask
        passable = self.scene.present & ~self.masked
        self.parts, self.sizes = _parts(first.method.metric.components, passable)
        default = int(np.flatnonzero(passable)[0])
        located = first.locate(default if sources is None else sources)
        runs = zip(located.begins[:-1], located.begins[1:], strict=True)
        self._set_sources(tuple(Place(located.vertices[a:b], located.shares[a:b]) for a, b in runs))

    @property
    def solver(self) -> GeodesicSolver:
        """The solver with the options of now; made if it is not there yet."""
        options = (self.refine, self.time_factor)
        if options not in self._solvers:
            made = GeodesicSolver(
                self.domain,
                operator=self._operator,
                mask=self._mask,
                refine=self.refine,
                time_factor=self.time_factor,
            )
            self._solvers[options] = made
            while len(self._solvers) > MOST_SOLVERS:
                del self._solvers[next(iter(self._solvers))]
        return self._solvers[options]

    @property
    def refined(self) -> bool:
        """True if distances are those of fronts or of paths along edges, False for plain heat."""
        return bool(self.solver.method.refine or self.solver.method.across)

    @property
    def shown(self) -> BoolArray:
        """Mask of the vertices that are shown."""
        return self.scene.present & ~self.covered

    @property
    def covered(self) -> BoolArray:
        """Mask of the vertices of hidden parts."""
        is_hidden = np.zeros(MOST_PARTS + 2, dtype=np.bool_)  # the last for the vertices of no part
        is_hidden[list(self.hidden)] = True
        return np.asarray(is_hidden[self.parts])

    @property
    def limits(self) -> tuple[float, float]:
        """Ends of the colours: 0, and the largest distance of what is shown."""
        if not self.hidden:
            return 0.0, self.largest or 1.0
        seen = self.distances[self.shown & self._reached]
        return 0.0, float(seen.max(initial=0.0)) or 1.0

    # -- clicks ------------------------------------------------------------------------------------

    def pick(self, origin: ArrayLike, direction: ArrayLike) -> Place | None:
        """Return the place that a ray of the page meets first; None beside the shape."""
        hidden = self.covered if self.hidden else None
        start, ahead = (np.array(end, dtype=np.float64) for end in (origin, direction))
        found = self._picker.pick(start, ahead, hidden)
        return None if found is None else Place(*found)

    def click(self, place: Place, *, add: bool = False) -> None:
        """Do what a click at a place does in the present mode; `add` keeps the other sources.

        Raises
        ------
        GeodesicError
            A path to where none leads, or a source that is masked; the state is that of before.
        """
        if add or self.mode is not Mode.MEASURE:
            self._check_unmasked(place)
        if add:
            self._set_sources((*self.sources, place))
        elif self.mode is Mode.SOURCE:
            self._set_sources((place,))
        elif self.mode is Mode.MEASURE:
            self._measure(place)
        elif self._path_begins:
            self.path = self._path_to(place)
            self._path_begins = False
        else:
            self._set_sources((place,))
            self._path_begins = True

    def _check_unmasked(self, place: Place) -> None:
        masked = place.vertices[self.masked[place.vertices]]
        if len(masked):
            raise InvalidSourceError(
                f"vertex {masked[0]} is masked, so that no path begins or ends there; click where "
                "the shape has a distance"
            )

    def _path_to(self, place: Place) -> Any:
        from geodesic_toolkit.analysis.paths.mesh import geodesic_path  # imports much of SciPy

        return geodesic_path(
            self.solver, self._as_sources(self.sources), self._as_sources((place,))
        )

    def set_mode(self, mode: Mode | str) -> None:
        """Change what clicks do, to "source", "path" or "measure"; the next click begins a path.

        Raises
        ------
        InvalidOptionError
            Another mode.
        """
        if mode not in tuple(Mode):
            raise InvalidOptionError(f'mode must be "source", "path" or "measure", not {mode!r}')
        self.mode, self._path_begins = Mode(mode), False

    @property
    def waits_for_target(self) -> bool:
        """True if the next click is the second end of a path."""
        return self.mode is Mode.PATH and self._path_begins

    def _set_sources(self, sources: tuple[Place, ...]) -> None:
        self._set_distances(self.solver.distance(self._as_sources(sources)))
        self.sources, self.path, self.measured, self._path_begins = sources, None, None, False

    def _measure(self, place: Place) -> None:
        value = place.of(self.distances)
        if len(place.vertices) > 1:  # inside a face, where a source may be too
            value = self.solver.interpolate(
                self.distances, self._in_space(place), sources=self._as_sources(self.sources)
            )[0]
        self.measured = place, float(value)

    def _in_space(self, place: Place) -> FloatArray:
        return np.asarray(place.of(self.scene.points) * self.scene.radius + self.scene.centre)

    def _as_sources(self, places: tuple[Place, ...]) -> Any:
        """Return places as the solver takes them: a graph has vertices only."""
        width = max(len(place.vertices) for place in places)
        if width == 1:
            return np.array([place.vertices[0] for place in places])
        vertices = np.zeros((len(places), width), dtype=np.int64)
        weights = np.zeros((len(places), width))
        for row, place in enumerate(places):
            count = len(place.vertices)
            vertices[row] = place.vertices[0]  # repeated if there are fewer
            vertices[row, :count], weights[row, :count] = place.vertices, place.weights
        return Located(vertices, weights)

    def _set_distances(self, distances: FloatArray) -> None:
        self.distances = distances
        self._reached = np.isfinite(distances) & self.scene.present
        self.n_unreached = int((self.scene.present & ~self.masked).sum() - self._reached.sum())
        self.largest = float(distances.max(where=self._reached, initial=0.0))

    # -- options -----------------------------------------------------------------------------------

    def set_method(self, *, refine: bool, time_factor: float) -> None:
        """Compute the distances in another way.

        Raises
        ------
        GeodesicError
            Options that are refused, or a factor that needs too much memory; the state is that of
            before.
        """
        before = self.refine, self.time_factor
        try:
            self.refine = self._refined if refine else False
            self.time_factor = time_factor
            self._set_distances(self.solver.distance(self._as_sources(self.sources)))
        except BaseException:
            self.refine, self.time_factor = before
            raise
        if self.measured is not None:
            self._measure(self.measured[0])

    def hide(self, parts: frozenset[int]) -> None:
        """Hide parts, and show all others."""
        self.hidden = parts

    # -- files -------------------------------------------------------------------------------------

    def positions_of(self, places: tuple[Place, ...]) -> FloatArray:
        """Return the (P, 3) positions of places on the page."""
        return np.array([place.of(self.scene.points) for place in places]).reshape(-1, 3)

    def line(self) -> FloatArray | None:
        """Return the path as a polyline on the page, of shape (P, 3); None if there is none."""
        if self.path is None:
            return None
        if hasattr(self.path, "vertices"):  # along edges, also of graphs without positions
            return np.asarray(self.scene.points[self.path.vertices])
        return np.asarray((self.path.points - self.scene.centre) / self.scene.radius)

    def as_json(self) -> str:
        """Return the sources, and the path, as JSON."""
        content = {
            "schema_version": SCHEMA_VERSION,
            "shape": self.name,
            "n_vertices": self.domain.n_vertices,
            "refine": self.refined,
            "time_factor": self.time_factor,
            "sources": [self._described(place) for place in self.sources],
            "path_length": None if self.path is None else self.path.length,
        }
        return json.dumps(content, indent=2, allow_nan=False) + "\n"

    def _described(self, place: Place) -> dict[str, Any]:
        return {
            "vertices": place.vertices.tolist(),
            "weights": place.weights.tolist(),
            "position": self._in_space(place).tolist(),
        }

    def table(self) -> tuple[str, bytes]:
        """Return a file with the distances, and its name: a .ply; a .csv without positions."""
        suffix = ".ply" if self.domain.has("positions") else ".csv"
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, f"distances{suffix}")
            write(file, self.domain, self.distances, like=self._like)
            return f"{self.name}{suffix}", file.read_bytes()


def _parts(components: IntArray, present: BoolArray) -> tuple[IntArray, list[int]]:
    """Return the part of each vertex, and the number of vertices of each part."""
    names, sizes = np.unique(components[present], return_counts=True)
    order = np.argsort(-sizes, kind="stable")
    part_of = dict(zip(names[order].tolist(), range(len(names)), strict=True))
    parts = np.array([min(part_of.get(c, -1), MOST_PARTS) for c in np.unique(components).tolist()])
    parts = parts[np.unique(components, return_inverse=True)[1]]
    parts[~present] = -1
    return parts, np.bincount(parts[present]).tolist()
