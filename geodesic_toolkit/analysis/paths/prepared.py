"""A mesh prepared for the paths of one solver."""

import threading
from collections import OrderedDict
from dataclasses import dataclass
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.analysis.paths.fronts import refined_distance
from geodesic_toolkit.analysis.paths.insertion import Insertion
from geodesic_toolkit.analysis.paths.metric.faces import FacesAround
from geodesic_toolkit.core.frozen import freeze
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.domains.measured import MeasuredFaces
from geodesic_toolkit.geometry.triangles import face_edge_lengths, proper_faces
from geodesic_toolkit.heat.method import HeatMethod
from geodesic_toolkit.laplacians.cotan import CotanLaplacian
from geodesic_toolkit.refinement.wavefronts import WavefrontSweeper
from geodesic_toolkit.solver.solver import GeodesicSolver
from geodesic_toolkit.sources.points import SourcePoints
from geodesic_toolkit.sources.subdivided import on_subdivision

__all__ = ["PreparedMesh", "ReachedFaces", "prepared_mesh"]

KEPT_DISTANCES = 4
"""Number of distances that are kept, those from the last places: paths are often found from one
place to many, or from each of several to the next."""


LENGTH_RATIO_OF_PATHS = 1.05
"""Length, in shortest paths, of the paths over vertices that are candidates (kMaxLengthRatio of
native/paths)."""


def prepared_mesh(solver: GeodesicSolver) -> "PreparedMesh":
    """Return what the paths of a solver of a mesh share; it is kept as long as the solver."""
    with _LOCK:
        prepared = _PREPARED.get(solver)
        if prepared is None:
            on = solver.method.metric.subdivision
            domain = solver.domain if on is None else on.mesh
            assert isinstance(domain, TriangleMesh | MeasuredFaces)  # the caller has checked
            prepared = _PREPARED[solver] = PreparedMesh(domain, solver.method, _sweeper(solver))
        return prepared


class PreparedMesh:
    """A mesh with the last distances on it, and its faces, prepared; shared by threads.

    Parameters
    ----------
    mesh : TriangleMesh or MeasuredFaces
    method : HeatMethod
    sweeper : WavefrontSweeper
        Refines distances if the method does not.
    """

    def __init__(
        self, mesh: TriangleMesh | MeasuredFaces, method: HeatMethod, sweeper: WavefrontSweeper
    ) -> None:
        self.mesh = mesh
        self._method, self._sweeper = method, sweeper
        self._lock = threading.Lock()
        self._distances: OrderedDict[tuple[bytes, ...], FloatArray] = OrderedDict()
        self._reached: ReachedFaces | None = None

    def distance(self, points: SourcePoints) -> FloatArray:
        """Return the refined distance (N,) from places, which is not to be changed."""
        key = tuple(
            array.tobytes()
            for array in (
                points.vertices,
                points.shares,
                points.begins,
                points.distances,
                points.starts,
                points.curvatures,
            )
        )
        with self._lock:
            if key in self._distances:
                self._distances.move_to_end(key)
                return self._distances[key]
        distance = freeze(refined_distance(self._method, self._sweeper, points))
        with self._lock:
            self._distances[key] = distance
            while len(self._distances) > KEPT_DISTANCES:
                self._distances.popitem(last=False)
        return distance

    def on_mesh(self, points: SourcePoints) -> SourcePoints:
        """Return places of the domain as places of the mesh."""
        on = self._method.metric.subdivision
        return points if on is None else on_subdivision(points, on)

    def near_path(self, goal: SourcePoints, distance: FloatArray) -> FloatArray:
        """Return the distance from a place (N,) where a path from there may run, ``inf`` elsewhere.

        It is swept where together with the other distance it is little longer than the path: at a
        tenth of the vertices. Corners of the faces that such paths cross are among them.

        Parameters
        ----------
        goal : SourcePoints
            One place of the mesh.
        distance : ndarray of shape (N,), float64
            From the sources of the path, finite at the place.
        """
        parts = self._method.small_parts
        of_domain = self._method.metric.subdivision is None
        if of_domain and parts is not None and parts.numbers[goal.first_vertices[0]] >= 0:
            return self.distance(goal)
        length = float(goal.shares @ distance[goal.vertices])
        latest = LENGTH_RATIO_OF_PATHS * length + self._widths - distance
        found = self._sweeper.distance_within(goal, latest)
        if of_domain and self._method.refine and self._method.bounds is not None:
            self._method.bounds.hold(found[None], [goal])
        return found

    @cached_property
    def _widths(self) -> FloatArray:
        """Twice the length of the longest edge at each vertex, (N,)."""
        longest, faces = np.zeros(self.mesh.n_vertices), self.mesh.faces
        lengths = _edge_lengths(self.mesh)
        for corner in range(3):
            beside = np.delete(lengths, corner, axis=1).max(axis=1)
            np.maximum.at(longest, faces[:, corner], beside)
        return 2 * longest

    def reached_by(self, distance: FloatArray) -> "ReachedFaces":
        """Return the faces on which a distance (N,) is finite."""
        finite = np.isfinite(distance)
        with self._lock:
            if self._reached is None or not np.array_equal(self._reached.vertices, finite):
                self._reached = ReachedFaces(self.mesh, finite)
            return self._reached


@dataclass(frozen=True, eq=False)
class ReachedFaces:
    """The proper faces of a mesh between vertices that are reached: not those of masked ones.

    Attributes
    ----------
    mesh : TriangleMesh or MeasuredFaces
    vertices : ndarray of shape (N,), bool
        True at those that are reached.
    """

    mesh: TriangleMesh | MeasuredFaces
    vertices: BoolArray

    @cached_property
    def numbers(self) -> IntArray:
        """The (G,) numbers of these faces in the mesh."""
        inside = self.vertices[self.mesh.faces].all(axis=1)
        return np.flatnonzero(proper_faces(self.mesh.faces) & inside)

    @cached_property
    def whole(self) -> Insertion:
        """These faces without a point inserted."""
        faces = self.mesh.faces[self.numbers]
        nothing = np.zeros(0, dtype=np.int64)
        return Insertion(_positions(self.mesh), faces, np.arange(len(faces)), nothing, [])

    @cached_property
    def surface(self) -> _native.Surface:
        """The same for the kernels."""
        return _native.Surface(np.ascontiguousarray(_positions(self.mesh)), self.whole.faces)

    @cached_property
    def measured(self) -> FacesAround:
        """The same with their lengths."""
        return FacesAround(self.whole.faces, _edge_lengths(self.mesh)[self.numbers])


def _edge_lengths(mesh: TriangleMesh | MeasuredFaces) -> FloatArray:
    """Return the lengths of the edges opposite the corners of faces, (F, 3)."""
    if isinstance(mesh, MeasuredFaces):
        return mesh.lengths
    return face_edge_lengths(mesh.vertices, mesh.faces)


def _positions(mesh: TriangleMesh | MeasuredFaces) -> FloatArray:
    """Return the vertices of a mesh; zeros where lengths are measured otherwise."""
    return mesh.vertices if isinstance(mesh, TriangleMesh) else np.zeros((mesh.n_vertices, 3))


_PREPARED: WeakKeyDictionary[GeodesicSolver, PreparedMesh] = WeakKeyDictionary()
_LOCK = threading.Lock()


def _sweeper(solver: GeodesicSolver) -> WavefrontSweeper:
    """Return the triangles of a solver, or those of its mesh if its metric has none."""
    metric, mesh = solver.method.metric, solver.passable
    gradient = metric.on_surface
    three = isinstance(gradient, ElementGradient) and gradient.elements.shape[1] == 3
    of_faces = isinstance(mesh, TriangleMesh | MeasuredFaces)
    if of_faces and metric.subdivision is None and not three:
        return WavefrontSweeper(CotanLaplacian().assemble(mesh))
    return solver.method.sweeper
