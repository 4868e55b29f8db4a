"""The libraries that are measured, all behind two functions; each imports its own package only.

A process that measures an import imports this module first: it imports nothing beyond the modules
of NumPy.
"""

import importlib
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

OURS = "ours"
"""The column of this package without a single option."""

PLAIN = "ours, plain heat"
"""The same without refinement."""

SOLVER = "ours, solver="
"""Columns of this package with another linear solver begin so."""

PEERS = ("potpourri3d", "libigl")
"""The faster of them is what ratios refer to."""

PEER_DEFAULT = "potpourri3d, as it comes"
"""potpourri3d without a single option: the robust one."""

COLUMNS = (OURS, PLAIN, *PEERS, PEER_DEFAULT)

PACKAGES = {"ours": "geodesic_toolkit", "potpourri3d": "potpourri3d", "libigl": "igl"}


class Ready(NamedTuple):
    """A shape prepared: distance from a source, from each of many; the linear solver if known."""

    one: Callable[[int], np.ndarray]
    each: Callable[[list[int]], Any]
    solver: str = ""


def package(library: str) -> str:
    """Return the name of the package that a column needs."""
    return PACKAGES[library.partition(",")[0]]


def build(library: str, vertices: np.ndarray, faces: np.ndarray) -> Ready:
    """Return `library` ready for sources on a mesh: what is timed as the build."""
    if library.startswith("ours"):
        return _ours(vertices, faces, **options(library))
    if library == "libigl":
        return _libigl(vertices, faces)
    return _potpourri3d(vertices, faces, **options(library))


def load(library: str) -> None:
    """Import what a build needs: this package imports its parts when their names are looked up."""
    module = importlib.import_module(package(library))
    if library.startswith("ours"):
        _ = module.GeodesicSolver, module.TriangleMesh


def options(library: str) -> dict[str, Any]:
    """Return the options of this package, or of potpourri3d, that a column stands for."""
    if library.startswith(SOLVER):
        return {"solver": library.removeprefix(SOLVER), "refine": False}
    known = {PLAIN: {"refine": False}}
    return known.get(library, {"use_robust": False} if library == "potpourri3d" else {})


def _ours(vertices: np.ndarray, faces: np.ndarray, **options: Any) -> Ready:
    import geodesic_toolkit as gt

    solver = gt.GeodesicSolver(gt.TriangleMesh(vertices, faces), **options)
    used = type(solver.method.heat_solver).__name__
    return Ready(solver.distance, solver.distances, used)


def _potpourri3d(vertices: np.ndarray, faces: np.ndarray, **options: Any) -> Ready:
    import potpourri3d as pp3d

    solver = pp3d.MeshHeatMethodDistanceSolver(vertices, faces, **options)
    return Ready(solver.compute_distance, one_by_one(solver.compute_distance))


def _libigl(vertices: np.ndarray, faces: np.ndarray) -> Ready:
    import igl

    data = igl.HeatGeodesicsData()
    igl.heat_geodesics_precompute(vertices, faces, data)

    def distance(source: int) -> np.ndarray:
        return igl.heat_geodesics_solve(data, np.array([source]))

    return Ready(distance, one_by_one(distance))


def one_by_one(distance: Callable[[int], np.ndarray]) -> Callable[[list[int]], list[np.ndarray]]:
    """Return many sources for a library that knows only one at a time."""
    return lambda sources: [distance(source) for source in sources]
