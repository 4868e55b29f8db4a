"""A check of plain heat on a mesh against refined distances.

Lengths and counts cannot show that a mesh is too coarse: distances on rings of 64 vertices are 7 %
too long, on grids of 100 vertices 6 %, and on cylinders of 128 vertices they can be correct. The
refined distance can show it, as its own error is several times smaller. The check judges the result
itself, with its boundary condition, its time step and all its sources: from the rim of a square of
22 x 22 vertices plain heat is 6 % off, from one corner 1.5 %; with ``boundary="dirichlet"``
distances are 44 % too short on stretched triangles.
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
"""Mean relative difference of plain heat and refined distance above which a mesh is coarse.

Measured against exact distances from 1,735 sources on grids, strips, cylinders, rings, capsules,
boxes, cones, tori, spheres, random triangulations and parts of a truck. Of 1,121 sources with more
than 5 % of error all are found by any limit from 1 to 4.5 %, and all except 14 by 5 %; of 31 with
less than 1 % none is found by any of these limits. Half of the shapes were held out, with the same
results."""

MAX_VERTICES_OF_COARSE_PARTS = 2_000
"""Maximum number of vertices of a coarse component: of those shapes none with more than 802
vertices is more than 5 % off, from one source in each component and with default options."""

N_JUDGED_SOURCE_SETS = 4
"""Number of source sets on each component of a mesh by which plain heat is judged: its error from
other sets is similar, and a check takes as long as a solve."""


class Judge:
    """A comparison of plain heat on one mesh with refined distances, which warns.

    It is safe to use from several threads.

    Parameters
    ----------
    mesh : TriangleMesh
    method : HeatMethod
        A method without refinement, on the triangles of this mesh.
    unusual : str
        Description of an option that differs from its default, if one does: then components of any
        size are judged.
    """

    def __init__(self, mesh: TriangleMesh, method: HeatMethod, unusual: str = "") -> None:
        self._method, self._metric = method, method.metric
        self._unusual = unusual
        self._small_parts = small_parts_of(mesh, method.metric.components)
        self._sizes = np.bincount(method.metric.components)
        self._sweeper: WavefrontSweeper | None = None
        self._lock = threading.Lock()
        self._errors: dict[int, list[float]] = {}  # from single sources, by component

    def judge(self, sets: Sequence[SourcePoints], distances: Iterable[FloatArray]) -> None:
        """Warn once if distances (N,) from one of some source sets are inaccurate.

        There is not a second warning if heat is not positive, because that one names the cause.
        """
        left = N_JUDGED_SOURCE_SETS  # sets of several sources differ in their interaction
        for located, plain in zip(sets, distances, strict=True):
            if self._is_trusted(located):
                continue
            parts, counts = np.unique(located.components(self._metric), return_counts=True)
            several = bool((counts > 1).any())
            left -= several
            if several and left < 0:
                continue
            error, part = self._several(located, plain) if several else self._single(located, plain)
            if error > MAX_MEAN_DIFFERENCE:
                if not self._method.heat_report(located).harmful:
                    self._warn(error, part, int(counts[parts == part].sum()))
                return

    def _is_trusted(self, located: SourcePoints) -> bool:
        """Return True for a single source on a large component: the usual case."""
        part = self._metric.components[located.vertices[0]]
        return (
            located.count == 1
            and not self._unusual
            and bool(self._sizes[part] > MAX_VERTICES_OF_COARSE_PARTS)
        )

    def _several(self, located: SourcePoints, plain: FloatArray) -> tuple[float, int]:
        found = self._found(located, plain)
        return max(((error, part) for part, error in found.items()), default=(0.0, 0))

    def _single(self, located: SourcePoints, plain: FloatArray) -> tuple[float, int]:
        parts = distinct(located.components(self._metric))
        own = self._sizes[parts]
        parts = parts[
            (own > 1) & (bool(self._unusual) | (own <= MAX_VERTICES_OF_COARSE_PARTS))
        ].tolist()
        with self._lock:
            if any(len(self._errors.get(part, ())) < N_JUDGED_SOURCE_SETS for part in parts):
                found = self._found(located, plain)
                for part in parts:
                    self._errors.setdefault(part, []).append(found.get(part, 0.0))
            return max(((max(self._errors[part]), part) for part in parts), default=(0.0, 0))

    def _found(self, located: SourcePoints, plain: FloatArray) -> dict[int, float]:
        if self._sweeper is None:
            self._sweeper = WavefrontSweeper(self._metric)
        error = _against_refined(self._sweeper, self._small_parts, located, plain)
        return _means(error, self._metric.components)

    def _warn(self, error: float, part: int, count: int) -> None:
        conditions = f" {self._unusual}" if self._unusual else ""
        conditions += f" from {count} sources" if count > 1 else ""
        faces = "" if self._unusual else ", or divide the faces"
        warn(
            f"plain heat{conditions} is {100 * error:.0f} % off on average on the component of a "
            f"source, which has {self._sizes[part]} vertices; use refine=True, or "
            f"exact_distance{faces}",
            CoarseMeshWarning,
        )


def _plain_heat_errors(
    mesh: TriangleMesh, components: IntArray, sources: IntArray
) -> dict[int, float]:
    """Return the mean relative error of plain heat from vertices, on each small component.

    Parameters
    ----------
    mesh : TriangleMesh
    components : ndarray of shape (N,), int64
        The component of each vertex.
    sources : ndarray of shape (P,), int64
        At most one in each component; the interaction of several is not measured.

    Returns
    -------
    dict of int to float
        By component; without components that have no source, more than
        `MAX_VERTICES_OF_COARSE_PARTS` vertices, or only one.
    """
    sizes = np.bincount(components)
    small = sources[
        (sizes > 1)[components[sources]]
        & (sizes <= MAX_VERTICES_OF_COARSE_PARTS)[components[sources]]
    ]
    if not len(small):
        return {}
    chosen = np.zeros(len(sizes), dtype=np.bool_)
    chosen[components[small]] = True
    members = np.flatnonzero(chosen[components])
    number = np.zeros(len(components), dtype=np.int64)
    number[members] = np.arange(len(members))
    faces = mesh.faces[chosen[components[mesh.faces[:, 0]]]]
    local = TriangleMesh(mesh.vertices[members], number[faces])
    return _means(_errors(local, number[small]), components[members])


def _errors(mesh: TriangleMesh, sources: IntArray) -> FloatArray:
    """Return the relative error of plain heat at each vertex, (N,); NaN at sources."""
    metric = CotanLaplacian(intrinsic_delaunay="auto").assemble(mesh)
    direct = Supernodal()
    method = HeatMethod(metric, heat_solver=direct, poisson_solver=direct)
    located = SourcePoints.at_vertices(sources, mesh.n_vertices)
    with collected_warnings(NonPositiveHeatWarning):  # its effect is measured here
        plain = method.distance(located)
    return _against_refined(
        WavefrontSweeper(metric), small_parts_of(mesh, metric.components), located, plain
    )


def _against_refined(
    sweeper: WavefrontSweeper,
    small_parts: SmallParts | None,
    located: SourcePoints,
    plain: FloatArray,
) -> FloatArray:
    """Return the relative difference of plain heat and refined distance, (N,); NaN at sources."""
    refined = sweeper.distance(-plain, located)
    if small_parts is not None:
        small_parts.fill(refined[None], [located])
    error = np.full(len(plain), np.nan)
    away = np.isfinite(plain) & np.isfinite(refined) & (refined > 0)
    error[away] = np.abs(plain[away] / refined[away] - 1)
    return error


def _means(error: FloatArray, components: IntArray) -> dict[int, float]:
    """Return the mean of the known errors of each component."""
    known = np.isfinite(error)
    total = np.bincount(components[known], error[known])
    count = np.bincount(components[known])
    return {int(k): float(total[k] / count[k]) for k in np.flatnonzero(count)}


def coarse_components(mesh: TriangleMesh, components: IntArray) -> int:
    """Return the number of coarse components of a mesh, by the mean from three vertices of each."""
    sizes = np.bincount(components)
    order = np.argsort(components, kind="stable")
    begins = np.cumsum(sizes) - sizes
    probed: dict[int, list[float]] = {}
    for along in (0.0, 0.5, 1.0):
        probes = order[begins + (along * (sizes - 1)).astype(np.int64)]
        for part, error in _plain_heat_errors(mesh, components, probes).items():
            probed.setdefault(part, []).append(error)
    return sum(float(np.mean(errors)) > MAX_MEAN_DIFFERENCE for errors in probed.values())
