"""Distances of samples beside Isomap's, against closed forms: mean error and CPU time.

    python plugins/geodesic-toolkit-knn/benchmarks/compare.py [--samples 1000 10000 100000]

writes a table in Markdown to stdout. Isomap's distances are Dijkstra's on scikit-learn's graph of
the same number of neighbours.
"""

import argparse
import time
from collections.abc import Callable

import numpy as np
from scipy.sparse.csgraph import dijkstra
from sklearn.neighbors import kneighbors_graph

import geodesic_toolkit as gt
from geodesic_toolkit_knn import KNNGraph
from geodesic_toolkit_knn.neighbours import FloatArray

K = 20
"""Neighbours, for both."""

SOURCES = 3

Shape = tuple[FloatArray, Callable[[int], FloatArray]]
"""Samples, and the distances of all from one of them."""


def flat(points: FloatArray, parameters: FloatArray) -> Shape:
    """Return samples whose space is a convex part of a Euclidean one, rolled up."""
    return points, lambda source: np.linalg.norm(parameters - parameters[source], axis=1)


def roll(count: int, rng: np.random.Generator) -> Shape:
    """Return samples of a Swiss roll."""
    angle, height = 1.5 * np.pi * (1 + 2 * rng.random(count)), 21 * rng.random(count)
    arc = (angle * np.sqrt(1 + angle**2) + np.arcsinh(angle)) / 2
    points = np.column_stack([angle * np.cos(angle), height, angle * np.sin(angle)])
    return flat(points, np.column_stack([arc, height]))


def s_curve(count: int, rng: np.random.Generator) -> Shape:
    """Return samples of an S-curve."""
    angle, height = 3 * np.pi * (rng.random(count) - 0.5), 2 * rng.random(count)
    points = np.column_stack([np.sin(angle), height, np.sign(angle) * (np.cos(angle) - 1)])
    return flat(points, np.column_stack([angle, height]))


def torus(count: int, rng: np.random.Generator) -> Shape:
    """Return samples of the flat torus in four dimensions."""
    angles = 2 * np.pi * rng.random((count, 2))
    points = np.concatenate([np.cos(angles), np.sin(angles)], axis=1)

    def distance(source: int) -> FloatArray:
        steps = np.abs(angles - angles[source])
        return np.linalg.norm(np.minimum(steps, 2 * np.pi - steps), axis=1)

    return points, distance


def sphere(count: int, rng: np.random.Generator) -> Shape:
    """Return samples of the unit sphere."""
    points = rng.standard_normal((count, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return points, lambda source: np.arccos(np.clip(points @ points[source], -1, 1))


def helix(count: int, rng: np.random.Generator) -> Shape:
    """Return samples of three turns of a helix."""
    angle = 6 * np.pi * rng.random(count)
    points = np.column_stack([np.cos(angle), np.sin(angle), angle / 4])
    return flat(points, angle[:, None] * np.sqrt(1 + 1 / 16))


def cube(dimension: int) -> Callable[[int, np.random.Generator], Shape]:
    """Return what samples the unit cube of a dimension."""

    def sampled(count: int, rng: np.random.Generator) -> Shape:
        parameters = rng.random((count, dimension))
        return flat(parameters, parameters)

    return sampled


def in_ten_dimensions(
    shape: Callable[[int, np.random.Generator], Shape], noise: float
) -> Callable[[int, np.random.Generator], Shape]:
    """Return a shape turned at random in ten dimensions, with noise in each of them.

    The noise is in mean distances to the nearest other sample.
    """

    def sampled(count: int, rng: np.random.Generator) -> Shape:
        points, distance = shape(count, rng)
        wide = np.zeros((count, 10))
        wide[:, : points.shape[1]] = points
        turned = wide @ np.linalg.qr(rng.standard_normal((10, 10)))[0]
        nearest = kneighbors_graph(points, 1, mode="distance").data.mean()
        return turned + noise * nearest * rng.standard_normal(turned.shape), distance

    return sampled


SHAPES: dict[str, Callable[[int, np.random.Generator], Shape]] = {
    "Swiss roll": roll,
    "Swiss roll in 10 dimensions, noise 0.2": in_ten_dimensions(roll, 0.2),
    "S-curve": s_curve,
    "S-curve in 10 dimensions, noise 0.2": in_ten_dimensions(s_curve, 0.2),
    "flat torus in 4 dimensions": torus,
    "flat torus in 10 dimensions, noise 0.4": in_ten_dimensions(torus, 0.4),
    "sphere": sphere,
    "helix": helix,
    "helix in 10 dimensions, noise 1": in_ten_dimensions(helix, 1.0),
    "cube of 3 dimensions": cube(3),
    "cube of 3 in 10 dimensions, noise 0.1": in_ten_dimensions(cube(3), 0.1),
    "cube of 4 dimensions": cube(4),
    "cube of 5 dimensions": cube(5),
    "cube of 10 dimensions": cube(10),
}


def main() -> None:
    """Write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, nargs="+", default=[1_000, 10_000, 100_000])
    parser.add_argument("--shapes", nargs="+", choices=SHAPES, default=list(SHAPES))
    arguments = parser.parse_args()
    print("| samples of | number | way | error | Isomap's | set up | a source | Isomap's |")
    print("|---|---|---|---|---|---|---|---|")
    for name in arguments.shapes:
        for count in arguments.samples:
            print(row(name, *SHAPES[name](count, np.random.default_rng(0))), flush=True)


def row(name: str, points: FloatArray, distance: Callable[[int], FloatArray]) -> str:
    """Return one line of the table: errors, and CPU seconds."""
    sources = list(np.random.default_rng(1).choice(len(points), SOURCES, replace=False))
    truth = [distance(source) for source in sources]
    begin = time.process_time()
    solver = gt.GeodesicSolver(KNNGraph(points, k=K))
    solver.distance(0)  # factors and corners are made when first needed
    ready = time.process_time()
    ours = [solver.distance(source) for source in sources]
    done = time.process_time()
    graph = kneighbors_graph(points, K, mode="distance")
    known = time.process_time()
    isomap = [dijkstra(graph, directed=False, indices=source) for source in sources]
    end = time.process_time()
    diagnosis = solver.diagnosis
    notes = diagnosis.notes
    way = notes["way"] if notes["way"] != "graph" else f"graph: {diagnosis.reason[:40]}"
    return (
        f"| {name} | {len(points):,} | {way} | {error(ours, truth)} | {error(isomap, truth)} "
        f"| {ready - begin:.2f} s | {(done - ready) / SOURCES:.3f} s "
        f"| {known - done:.2f} + {(end - known) / SOURCES:.3f} s |"
    )


def error(found: list[FloatArray], truth: list[FloatArray]) -> str:
    """Return the mean relative error, with how many are infinite."""
    relative = np.concatenate(
        [np.abs(f - t)[t > 0] / t[t > 0] for f, t in zip(found, truth, strict=True)]
    )
    lost = int(np.isinf(relative).sum())
    mean = relative[np.isfinite(relative)].mean()
    return f"{mean:.2%}" + (f", {lost} infinite" if lost else "")


if __name__ == "__main__":
    main()
