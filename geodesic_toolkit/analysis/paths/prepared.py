"""A mesh prepared for paths: what those of one solver share."""

import threading
from collections import OrderedDict
from dataclasses import dataclass
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.analysis.paths.fronts import refined_distance
from geodesic_toolkit.analysis.paths.insertion import Insertion
from geodesic_toolkit.core.frozen import freeze
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.geometry.triangles import proper_faces
from geodesic_toolkit.heat.method import HeatMethod
from geodesic_toolkit.laplacians.cotan import CotanLaplacian
from geodesic_toolkit.refinement.wavefronts import WavefrontSweeper
from geodesic_toolkit.solver.solver import GeodesicSolver
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["PreparedMesh", "ReachedFaces", "prepared_mesh"]

KEPT_DISTANCES = 4
"""Number of distances that are kept, those from the last places: paths are often found from one
place to many, or from each of several to the next."""


def prepared_mesh(solver: GeodesicSolver) -> "PreparedMesh":
    """Return what the paths of a solver of a mesh share; it is kept as long as the solver."""
    with _LOCK:
        prepared = _PREPARED.get(solver)
        if prepared is None:
            on = solver.method.metric.subdivision
            domain = solver.domain if on is None else on.mesh
            assert isinstance(domain, TriangleMesh)  # for the type checker; the caller has checked
            sweeper = WavefrontSweeper(_with_triangles(solver))
            prepared = _PREPARED[solver] = PreparedMesh(domain, solver.method, sweeper)
        return prepared


class PreparedMesh:
    """A mesh with the last distances on it, and its faces, prepared; shared by threads.

    Parameters
    ----------
    mesh : TriangleMesh
    method : HeatMethod
    sweeper : WavefrontSweeper
        Refines distances if the method does not.
    """

    def __init__(self, mesh: TriangleMesh, method: HeatMethod, sweeper: WavefrontSweeper) -> None:
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
    mesh : TriangleMesh
    vertices : ndarray of shape (N,), bool
        True at those that are reached.
    """

    mesh: TriangleMesh
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
        return Insertion(self.mesh.vertices, faces, np.arange(len(faces)), nothing, [])

    @cached_property
    def surface(self) -> _native.Surface:
        """The same for the kernels."""
        return _native.Surface(np.ascontiguousarray(self.mesh.vertices), self.whole.faces)


_PREPARED: WeakKeyDictionary[GeodesicSolver, PreparedMesh] = WeakKeyDictionary()
_LOCK = threading.Lock()


def _with_triangles(solver: GeodesicSolver) -> Discretization:
    """Return the metric of a solver, or that of its mesh if the solver's has no triangles."""
    metric, mesh = solver.method.metric, solver.passable
    if metric.subdivision is not None:
        return metric.subdivision.metric
    gradient = metric.on_surface
    three = isinstance(gradient, ElementGradient) and gradient.elements.shape[1] == 3
    if isinstance(mesh, TriangleMesh) and not three:
        return CotanLaplacian().assemble(mesh)
    return metric
