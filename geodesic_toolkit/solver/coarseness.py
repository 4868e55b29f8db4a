"""A check of plain heat on a mesh against refined distances.

No length and no count tells: rings of 64 vertices read 7 % too much, grids of 100 vertices 6 %, and
cylinders of 128 can be right. The refined distance does, as its own error is several times smaller.
What is judged is the answer itself, with its boundary condition, its time step and all its sources:
from the rim of a square of 22 x 22 vertices plain heat is 6 % off, from one corner 1.5 %; with
``boundary="dirichlet"`` it reads 44 % too little on stretched triangles.
"""

import threading
from collections.abc import Iterable, Sequence

import numpy as np

from geodesic_toolkit.core.arrays import distinct
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.core.warning import collected_warnings, warn
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.errors import CoarseMeshWarning, NonPositiveHeatWarning
from geodesic_toolkit.heat.method import HeatMethod
from geodesic_toolkit.laplacians.cotan import CotanLaplacian
from geodesic_toolkit.linear.supernodal import Supernodal
from geodesic_toolkit.refinement.polyhedra import SmallParts, small_parts_of
from geodesic_toolkit.refinement.wavefronts import WavefrontSweeper
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["MAX_MEAN_DIFFERENCE", "MAX_VERTICES_OF_COARSE_PARTS", "Judge", "coarse_components"]

MAX_MEAN_DIFFERENCE = 0.04
"""Mean relative difference of plain heat and refined distance from which on a mesh is coarse.

Measured against exact distances from 1,735 sources on grids, strips, cylinders, rings, capsules,
boxes, cones, tori, spheres, random triangulations and parts of a truck. Of 1,121 sources with more
than 5 % of error all are found by any limit from 1 to 4.5 %, and all but 14 by 5 %; of 31 with less
than 1 % none is, by any of these. Half of the shapes were held out, and do not differ."""

MAX_VERTICES_OF_COARSE_PARTS = 2_000
"""Vertices of a part up to which it may be coarse: of those shapes none of more than 802 is more
than 5 % off, from one source in each part and with the options as they are unless given."""

N_JUDGED_SOURCE_SETS = 4
"""Source sets on each part of a mesh by which plain heat is judged: from others its error is much
the same, and to judge takes as long as to solve."""


class Judge:
    """Holds answers of plain heat on one mesh against refined distances, and warns.

    Safe to use from several threads.

    Parameters
    ----------
    mesh : TriangleMesh
    method : HeatMethod
        That does not refine, on the triangles of this mesh.
    unusual : str
        Which option departs from what it is unless given, in words, if one does: then parts of any
        size are judged.
    """

    def __init__(self, mesh: TriangleMesh, method: HeatMethod, unusual: str = "") -> None:
        self._method, self._metric = method, method.metric
        self._unusual = unusual
        self._small_parts = small_parts_of(mesh, method.metric.components)
        self._sizes = np.bincount(method.metric.components)
        self._sweeper: WavefrontSweeper | None = None
        self._lock = threading.Lock()
        self._errors: dict[int, list[float]] = {}  # from single sources, by part

    def judge(self, sets: Sequence[SourcePoints], distances: Iterable[FloatArray]) -> None:
        """Warn where distances (N,) from one of some source sets are off, once.

        Not where heat is not positive: the warning of that knows the cause.
        """
        left = N_JUDGED_SOURCE_SETS  # sets of several sources differ in what these do to each other
        for places, plain in zip(sets, distances, strict=True):
            if self._is_trusted(places):
                continue
            parts, counts = np.unique(places.components(self._metric), return_counts=True)
            several = bool((counts > 1).any())
            left -= several
            if several and left < 0:
                continue
            error, part = self._several(places, plain) if several else self._single(places, plain)
            if error > MAX_MEAN_DIFFERENCE:
                if not self._method.heat_report(places).harmful:
                    self._warn(error, part, int(counts[parts == part].sum()))
                return

    def _is_trusted(self, places: SourcePoints) -> bool:
        """Return whether there is but one source, on a large part: the usual case."""
        part = self._metric.components[places.vertices[0]]
        return (
            places.count == 1
            and not self._unusual
            and bool(self._sizes[part] > MAX_VERTICES_OF_COARSE_PARTS)
        )

    def _several(self, places: SourcePoints, plain: FloatArray) -> tuple[float, int]:
        found = self._found(places, plain)
        return max(((error, part) for part, error in found.items()), default=(0.0, 0))

    def _single(self, places: SourcePoints, plain: FloatArray) -> tuple[float, int]:
        parts = distinct(places.components(self._metric))
        own = self._sizes[parts]
        parts = parts[
            (own > 1) & (bool(self._unusual) | (own <= MAX_VERTICES_OF_COARSE_PARTS))
        ].tolist()
        with self._lock:
            if any(len(self._errors.get(part, ())) < N_JUDGED_SOURCE_SETS for part in parts):
                found = self._found(places, plain)
                for part in parts:
                    self._errors.setdefault(part, []).append(found.get(part, 0.0))
            return max(((max(self._errors[part]), part) for part in parts), default=(0.0, 0))

    def _found(self, places: SourcePoints, plain: FloatArray) -> dict[int, float]:
        if self._sweeper is None:
            self._sweeper = WavefrontSweeper(self._metric)
        error = _against_refined(self._sweeper, self._small_parts, places, plain)
        return _means(error, self._metric.components)

    def _warn(self, error: float, part: int, count: int) -> None:
        how = f" {self._unusual}" if self._unusual else ""
        how += f" from {count} sources" if count > 1 else ""
        faces = "" if self._unusual else ", or divide the faces"
        warn(
            f"plain heat{how} is {100 * error:.0f} % off in the mean on the part of the mesh that "
            f"a source lies on, which has {self._sizes[part]} vertices; use refine=True, or "
            f"exact_distance{faces}",
            CoarseMeshWarning,
        )


def _plain_heat_errors(
    mesh: TriangleMesh, components: IntArray, sources: IntArray
) -> dict[int, float]:
    """Return by how much plain heat from vertices is off in the mean, on each small part.

    Parameters
    ----------
    mesh : TriangleMesh
    components : ndarray of shape (N,), int64
        The connected part of each vertex.
    sources : ndarray of shape (P,), int64
        At most one in each part; what several do to each other is another matter.

    Returns
    -------
    dict of int to float
        By component, relative to the distance; without those that have no source, more than
        `MAX_VERTICES_OF_COARSE_PARTS` vertices, or but one.
    """
    sizes = np.bincount(components)
    small = sources[
        (sizes > 1)[components[sources]]
        & (sizes <= MAX_VERTICES_OF_COARSE_PARTS)[components[sources]]
    ]
    if not len(small):
        return {}
    wanted = np.zeros(len(sizes), dtype=np.bool_)
    wanted[components[small]] = True
    members = np.flatnonzero(wanted[components])
    number = np.zeros(len(components), dtype=np.int64)
    number[members] = np.arange(len(members))
    faces = mesh.faces[wanted[components[mesh.faces[:, 0]]]]
    local = TriangleMesh(mesh.vertices[members], number[faces])
    return _means(_errors(local, number[small]), components[members])


def _errors(mesh: TriangleMesh, sources: IntArray) -> FloatArray:
    """Return the relative error of plain heat at each vertex, (N,); NaN at sources."""
    metric = CotanLaplacian(intrinsic_delaunay="auto").assemble(mesh)
    direct = Supernodal()
    method = HeatMethod(metric, heat_solver=direct, poisson_solver=direct)
    places = SourcePoints.at_vertices(sources, mesh.n_vertices)
    with collected_warnings(NonPositiveHeatWarning):  # what comes of it is measured here
        plain = method.distance(places)
    return _against_refined(
        WavefrontSweeper(metric), small_parts_of(mesh, metric.components), places, plain
    )


def _against_refined(
    sweeper: WavefrontSweeper,
    small_parts: SmallParts | None,
    places: SourcePoints,
    plain: FloatArray,
) -> FloatArray:
    """Return the relative difference of plain heat and refined distance, (N,); NaN at sources."""
    refined = sweeper.distance(-plain, places)
    if small_parts is not None:
        small_parts.fill(refined[None], [places])
    error = np.full(len(plain), np.nan)
    away = np.isfinite(plain) & np.isfinite(refined) & (refined > 0)
    error[away] = np.abs(plain[away] / refined[away] - 1)
    return error


def _means(error: FloatArray, components: IntArray) -> dict[int, float]:
    """Return the mean of what is known of each part."""
    known = np.isfinite(error)
    total = np.bincount(components[known], error[known])
    count = np.bincount(components[known])
    return {int(k): float(total[k] / count[k]) for k in np.flatnonzero(count)}


def coarse_components(mesh: TriangleMesh, components: IntArray) -> int:
    """Return how many parts of a mesh are coarse: in the mean from three vertices of each."""
    sizes = np.bincount(components)
    order = np.argsort(components, kind="stable")
    begins = np.cumsum(sizes) - sizes
    probed: dict[int, list[float]] = {}
    for along in (0.0, 0.5, 1.0):
        probes = order[begins + (along * (sizes - 1)).astype(np.int64)]
        for part, error in _plain_heat_errors(mesh, components, probes).items():
            probed.setdefault(part, []).append(error)
    return sum(float(np.mean(errors)) > MAX_MEAN_DIFFERENCE for errors in probed.values())
