"""The libraries that are measured, all behind two functions; each imports its own package only."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

SOLVER = "ours, solver="
"""Columns of this package with another linear solver begin so."""

PEERS = ("potpourri3d", "libigl")
"""The faster of them is what ratios refer to."""

ROBUST = "potpourri3d, robust"


@dataclass
class Ready:
    """A shape prepared: distance from a source, from each of many; the linear solver if known."""

    one: Callable[[int], np.ndarray]
    each: Callable[[list[int]], Any]
    solver: str = ""


def build(library: str, vertices: np.ndarray, faces: np.ndarray) -> Ready:
    """Return `library` ready for sources on a mesh: what is timed as the build."""
    if library.startswith("ours"):
        return _ours(vertices, faces, **options(library))
    if library == "libigl":
        return _libigl(vertices, faces)
    return _potpourri3d(vertices, faces, robust=library == ROBUST)


def options(library: str) -> dict[str, Any]:
    """Return the options of `GeodesicSolver` that a column stands for."""
    if library.startswith(SOLVER):
        return {"solver": library.removeprefix(SOLVER)}
    return {"refine": True} if "refined" in library else {}


def load(library: str) -> None:
    """Import the package and nothing more."""
    if library.startswith("ours"):
        import geodesic_toolkit  # noqa: F401
    elif library == "libigl":
        import igl  # noqa: F401
    else:
        import potpourri3d  # noqa: F401


def warm_up(library: str, vertices: np.ndarray, faces: np.ndarray) -> None:
    """Load all kernels, and use the library once on a small mesh of the same kind."""
    if library.startswith("ours"):
        load_kernels()
    ready = build(library, vertices, faces)
    ready.one(0)
    ready.each([0, 1])


def load_kernels() -> None:
    """Load what this package compiles, or compile it where that is still to be done."""
    from geodesic_toolkit import _kernels

    _kernels.warm()


def componentwise_solvers() -> list[str]:
    """Return the installed linear solvers that can serve heat."""
    import geodesic_toolkit as gt

    names = []
    for name in gt.solvers:
        try:
            if gt.solvers[name].componentwise:
                names.append(name)
        except gt.errors.PluginError as error:
            print(f"{name} is left out: {error}")
    return names


def _ours(vertices: np.ndarray, faces: np.ndarray, **options: Any) -> Ready:
    import geodesic_toolkit as gt

    solver = gt.GeodesicSolver(gt.TriangleMesh(vertices, faces), **options)
    used = type(solver.method.heat_solver).__name__
    return Ready(solver.distance, solver.distances, used)


def _potpourri3d(vertices: np.ndarray, faces: np.ndarray, *, robust: bool) -> Ready:
    import potpourri3d as pp3d

    solver = pp3d.MeshHeatMethodDistanceSolver(vertices, faces, use_robust=robust)
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
