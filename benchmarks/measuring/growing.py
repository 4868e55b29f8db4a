"""A fresh process for one size: a build, a source, ten sources. Prints a line of JSON for each.

python -m measuring.growing mesh|cloud WARM-UP.npz SHAPE.npz

Lines that were finished before memory ran out have been printed.
"""

import json
import sys
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

import geodesic_toolkit as gt
from measuring import clocks

SOURCES = 10


def domain(kind: str, path: str) -> Callable[[], Any]:
    """Return what makes the domain of the arrays in a file."""
    with np.load(path) as file:
        arrays = [file[name] for name in file.files]
    make = {"mesh": gt.TriangleMesh, "cloud": gt.PointCloud}[kind]
    return lambda: make(*arrays)


def points_of(shape: Any) -> np.ndarray:
    return np.asarray(shape.points if isinstance(shape, gt.PointCloud) else shape.vertices)


def errors(points: np.ndarray, source: int, distance: np.ndarray) -> dict[str, float]:
    """Return relative errors on the unit sphere, in per cent: their mean, and at the antipode."""
    start = points[source]
    apart = np.linalg.norm(points - start, axis=1)
    opposite = np.linalg.norm(points + start, axis=1)
    true = 2 * np.arctan2(apart, opposite)
    away = true > 0
    antipode = int(np.argmin(opposite))
    relative = 100 * np.abs(distance[away] - true[away]) / true[away]
    at_antipode = 100 * abs(distance[antipode] - true[antipode]) / true[antipode]
    return {"mean_error": float(relative.mean()), "antipode_error": float(at_antipode)}


def predicted(solver: gt.GeodesicSolver) -> float | None:
    """Return the bytes that the library expected to need, where it foresaw them."""
    expected = solver.method.expected_bytes
    if not expected:
        return None
    domain = solver.domain
    parts = (
        (domain.points,) if isinstance(domain, gt.PointCloud) else (domain.vertices, domain.faces)
    )
    return expected + sum(part.nbytes for part in parts)


def tell(stage: str, **found: Any) -> None:
    print(json.dumps({"stage": stage, **found}), flush=True)


def warm_up(kind: str, path: str) -> None:
    """Load the code that a shape of this kind needs."""
    gt.GeodesicSolver(domain(kind, path)()).distances([0, 1])


def main() -> None:
    """Measure one size."""
    kind, small, large = sys.argv[1:]
    warnings.simplefilter("ignore")
    clocks.go_first()
    warm_up(kind, small)
    make = domain(kind, large)
    before = clocks.resident()
    clocks.forget_peak()

    def peak() -> int:
        return clocks.peak_resident() - before

    spent, solver = clocks.timed(lambda: gt.GeodesicSolver(make()))
    tell(
        "build",
        **spent,
        peak=peak(),
        predicted=predicted(solver),
        solver=type(solver.method.heat_solver).__name__,
    )
    spent, distance = clocks.timed(lambda: solver.distance(0))
    tell("one", **spent, peak=peak(), **errors(points_of(solver.domain), 0, distance))
    n_vertices = solver.domain.n_vertices
    sources = np.random.default_rng(0).choice(n_vertices, SOURCES, replace=False)
    spent, _ = clocks.timed(lambda: solver.distances(sources))
    tell("ten", **spent, peak=peak())


if __name__ == "__main__":
    main()
