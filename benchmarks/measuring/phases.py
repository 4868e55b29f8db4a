"""The process of one version: it clocks the phase of the method that it is asked for.

python -m measuring.phases MESH.npz SECONDS

The interpreter decides which version that is. It begins with a line of JSON, the level of x86-64
that was loaded; then the name of a phase is a line of JSON in, and its seconds of CPU are one out,
or why it has none. Phases of public calls are there in every version; others are where
it has a function of that name, those of single kernels in ``geodesic_toolkit._native``.
"""

import inspect
import json
import os
import sys
import time
import warnings
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

import geodesic_toolkit as gt
from measuring import clocks

LEAST = 3
"""Times that it is repeated at least, after one that is not clocked."""

BLOCK = 16
"""Right-hand sides, or sources, of a block."""

COMPACT = 20_000
"""Vertices from which on whole builds have compact factors, as they have by default."""

NEIGHBOURS = 12
"""Neighbours of a point that its star begins with."""

Work = Callable[[], Any]


class Phases:
    """The data of the phases, made when the first of them needs it.

    Every method that is not a property prepares a phase and returns what is to be clocked.
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        self.vertices, self.faces = vertices, faces

    # -- through public calls ----------------------------------------------------------------------

    def analysis(self) -> Work:
        return lambda: _analysis(gt.Supernodal(), self._matrix)

    def factor_whole(self) -> Work:
        factorize = _analysis(gt.Supernodal(), self._matrix)
        return lambda: factorize(self._matrix)

    def factor_compact(self) -> Work:
        factorize = _analysis(gt.Supernodal(compact=True), self._matrix)
        return lambda: factorize(self._matrix)

    def solve_column(self) -> Work:
        return lambda: self._factor.solve(self._columns[:, 0])

    def solve_sparse_column(self) -> Work:
        point = np.zeros(len(self.vertices))
        point[len(point) // 3] = 1.0
        return lambda: self._factor.solve(point)

    def solve_block(self) -> Work:
        return lambda: self._factor.solve(self._columns)

    def solve_compact_column(self) -> Work:
        factor = gt.Supernodal(compact=True).factorize(self._matrix)
        return lambda: factor.solve(self._columns[:, 0])

    def assembly(self) -> Work:
        return lambda: gt.CotanLaplacian().assemble(self._mesh())

    def assembly_flipped(self) -> Work:
        return lambda: gt.CotanLaplacian(intrinsic_delaunay=True).assemble(self._mesh())

    def assembly_of_cloud(self) -> Work:
        """Assemble points without normals: neighbours, poles and stars."""
        operator = gt.PointCloudLaplacian(normals="pca")
        return lambda: operator.assemble(gt.PointCloud(self.vertices))

    def build(self) -> Work:
        return lambda: self._solver(refine=False)

    def source(self) -> Work:
        solver = self._solver(refine=False)
        return lambda: solver.distance(1)

    def batch(self) -> Work:
        solver = self._solver(refine=False)
        return lambda: solver.distances(list(range(BLOCK)))

    def build_refined(self) -> Work:
        return lambda: self._solver(refine=True)

    def source_refined(self) -> Work:
        solver = self._solver(refine=True)
        return lambda: solver.distance(1)

    def batch_refined(self) -> Work:
        solver = self._solver(refine=True)
        return lambda: solver.distances(list(range(BLOCK)))

    # -- parts of them, under names that a version may have ----------------------------------------

    def flips(self) -> Work:
        from geodesic_toolkit.geometry.intrinsic import delaunay_triangles
        from geodesic_toolkit.geometry.triangles import lengths_from_inverse

        gradient = self._metric.gradient
        lengths = lengths_from_inverse(gradient.inverse_frames)
        return lambda: delaunay_triangles(gradient.elements, lengths)

    def load(self) -> Work:
        gradient = self._metric.gradient
        return _load_of(gradient, self._log_heat)

    def load_block(self) -> Work:
        gradient = self._metric.gradient
        heat = np.repeat(self._log_heat[:, None], BLOCK, axis=1)
        return _load_of(gradient, heat)

    def sweep(self) -> Work:
        from geodesic_toolkit.refinement.wavefronts import WavefrontSweeper
        from geodesic_toolkit.sources.points import SourcePoints

        sweeper = WavefrontSweeper(self._metric).prepare()
        if "points" not in inspect.signature(sweeper.distance).parameters:  # an older version
            return lambda: sweeper.distance(self._log_heat, np.array([0]), np.zeros(1))
        points = SourcePoints.at_vertices(np.array([0]), len(self._log_heat))
        return lambda: sweeper.distance(self._log_heat, points)

    def sweep_prepared(self) -> Work:
        from geodesic_toolkit.refinement.wavefronts import WavefrontSweeper

        return lambda: WavefrontSweeper(self._metric).prepare()

    def stars(self) -> Work:
        from geodesic_toolkit.laplacians.pointcloud.stars import delaunay_stars

        near, normals = self._neighbourhoods
        flags = {"k": NEIGHBOURS, "oriented": False, "smooth": True}
        return lambda: delaunay_stars(self.vertices, normals, near, **flags)

    def poles(self) -> Work:
        from geodesic_toolkit.laplacians.pointcloud.poles import pole_normals

        near, normals = self._neighbourhoods
        return lambda: pole_normals(self.vertices, near, normals)

    # -- single kernels ----------------------------------------------------------------------------

    def kernel_order(self) -> Work:
        native = _native()
        pattern = self._matrix.indptr, self._matrix.indices
        return lambda: native.minimum_degree(*pattern)

    def kernel_half_edges(self) -> Work:
        native, elements = _native(), self._metric.gradient.elements
        return lambda: native.sorted_half_edges(elements, len(self.vertices))

    def kernel_edge_sums(self) -> Work:
        native, triangles = _native(), self._metric.gradient
        sides = native.sorted_half_edges(triangles.elements, len(self.vertices))
        arrays = triangles.elements, sides, triangles.inverse_frames, triangles.measure
        return lambda: native.edge_sums(*arrays)

    # -- what they work on -------------------------------------------------------------------------

    def _mesh(self) -> gt.TriangleMesh:
        return gt.TriangleMesh(self.vertices, self.faces)

    def _solver(self, *, refine: bool) -> gt.GeodesicSolver:
        solver = gt.Supernodal(compact=len(self.vertices) >= COMPACT)
        return gt.GeodesicSolver(self._mesh(), solver=solver, refine=refine)

    @cached_property
    def _metric(self) -> Any:
        return gt.CotanLaplacian().assemble(self._mesh())

    @cached_property
    def _matrix(self) -> Any:
        """The stiffness, made positive definite."""
        from scipy.sparse import csr_array, diags_array

        stiffness = self._metric.stiffness
        matrix = csr_array(stiffness + diags_array(0.01 * stiffness.diagonal()))
        matrix.sort_indices()
        return matrix

    @cached_property
    def _factor(self) -> Any:
        return gt.Supernodal().factorize(self._matrix)

    @cached_property
    def _columns(self) -> np.ndarray:
        return np.random.default_rng(0).standard_normal((len(self.vertices), BLOCK))

    @cached_property
    def _log_heat(self) -> np.ndarray:
        return self._solver(refine=False).method.log_heat(0)

    @cached_property
    def _neighbourhoods(self) -> tuple[np.ndarray, np.ndarray]:
        """Neighbours, the nearest first, and normals."""
        from scipy.spatial import KDTree

        near = KDTree(self.vertices).query(self.vertices, 2 * NEIGHBOURS + 1)[1][:, 1:]
        corners = self.vertices[self.faces]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals = np.zeros_like(self.vertices)
        for corner in range(3):
            np.add.at(normals, self.faces[:, corner], across)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return np.ascontiguousarray(near, dtype=np.int64), normals


def _analysis(solver: gt.LinearSolver, pattern: Any) -> Callable[[Any], gt.Factor]:
    if hasattr(solver, "analyze"):  # an older version
        return solver.analyze(pattern)
    return solver.analyse(pattern).factorize


def _load_of(gradient: Any, log_heat: np.ndarray) -> Work:
    try:
        from geodesic_toolkit.discretization.heat import Heat
    except ImportError:  # an older version
        return lambda: gradient.descent_load(log_heat, logarithmic=True)
    heat = Heat.of_log(log_heat)
    return lambda: gradient.descent_load(heat)


def _native() -> Any:
    """Return the compiled kernels.

    Raises
    ------
    ImportError
        This version has none.
    """
    from geodesic_toolkit import _native

    return _native


NAMES = [name for name in vars(Phases) if name[0] != "_"]
"""The phases, in the order of their work."""


def fastest(work: Work, enough: float) -> float:
    """Return the seconds of CPU of the fastest of several calls, after one that is not clocked.

    The machine may be shared, so the others say more about its load. They go on for `enough`.
    Calls shorter than the clock is exact are clocked several at a time.
    """
    work()
    spent, _ = clocks.timed(work)
    times, together = [], max(1, int(2e-3 / max(spent["cpu"], 1e-6)))

    def repeat() -> None:
        for _ in range(together):
            work()

    started = time.perf_counter()
    while len(times) < LEAST or time.perf_counter() - started < enough:
        times.append(clocks.clocked(repeat)[0]["cpu"] / together)
    return min(times)


def compile_all() -> None:
    """Compile the kernels of a version that compiles them at run time."""
    try:
        from geodesic_toolkit import _kernels
    except ImportError:
        return
    _kernels.warm()


def level() -> int:
    """Return the level of x86-64 of the kernels, 0 where they have none."""
    try:
        return int(_native().LEVEL)
    except ImportError:
        return 0


def levels() -> list[int]:
    """Return the levels that are installed, and that this processor has."""
    from importlib.util import find_spec

    best = level()
    package = "geodesic_toolkit._native._level"
    return [number for number in range(2, best + 1) if find_spec(f"{package}{number}") is not None]


def main() -> None:
    """Answer the names of phases until there are no more."""
    warnings.simplefilter("ignore")  # of shapes: known
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # output of libraries is not an answer
    compile_all()
    mesh, enough = sys.argv[1:]
    with np.load(mesh) as file:
        phases = Phases(file["vertices"], file["faces"])
    print(
        json.dumps({"level": level(), "levels": levels(), "from": gt.__file__}),
        file=answers,
        flush=True,
    )
    for line in sys.stdin:
        try:
            work = getattr(phases, json.loads(line))()
            answer: dict[str, Any] = {"cpu": fastest(work, float(enough))}
        except (AttributeError, ImportError, TypeError, gt.errors.GeodesicError) as error:
            answer = {"failure": f"{type(error).__name__}: {error}"}
        print(json.dumps(answer), file=answers, flush=True)


if __name__ == "__main__":
    main()
