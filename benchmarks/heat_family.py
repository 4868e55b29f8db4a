"""Logarithmic maps, transport, labels, means and cells along refined distances, beside potpourri3d.

python benchmarks/heat_family.py                    all rows of 3.5k vertices, and real meshes
python benchmarks/heat_family.py --large            also of 35k vertices
python benchmarks/heat_family.py --parts logs,far   some of the parts

Each row has a figure, its bound, and the figure of potpourri3d where that answers: of logarithmic
maps the best of its three strategies. Angles are means in degrees, lengths relative in per cent.
Times are CPU seconds in one process: only their ratios say something on a busy machine.
"""

import argparse
from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

import numpy as np
import potpourri3d as pp3d
from heat_family_signed import REAL, Row, along_great_circles, cpu, degrees, irregular_sphere
from measuring.shapes import DATA, referenced
from scipy.spatial import Delaunay

import geodesic_toolkit as gt

STRATEGIES = ("VectorHeat", "AffineLocal", "AffineAdaptive")
HEXAGON = 5 / (18 * np.sqrt(3))  # second moment of regular hexagons of area 1

# -- shapes with closed forms ----------------------------------------------------------------------


class Shape(NamedTuple):
    """A mesh, and the logarithms of its vertices about one of them where those are unique."""

    mesh: gt.TriangleMesh
    source: int
    logarithms: np.ndarray
    good: np.ndarray


def sphere(n: int) -> Shape:
    mesh = irregular_sphere(n)
    p, points = mesh.vertices[n // 3], mesh.vertices
    away = points - (points @ p)[:, None] * p
    sine = np.linalg.norm(away, axis=1)
    length = np.arctan2(sine, points @ p)
    logs = length[:, None] * np.divide(
        away, sine[:, None], out=np.zeros_like(away), where=sine[:, None] > 0
    )
    return Shape(mesh, n // 3, logs, (length > 1e-9) & (length < 0.95 * np.pi))


def plane(n: int) -> Shape:
    side = round(n**0.5)
    flat = shaken(*np.meshgrid(np.linspace(0, 1, side), np.linspace(0, 1, side)), 1 / side)
    points = np.column_stack([flat, np.zeros(len(flat))])
    mesh = gt.TriangleMesh(points, turned_up(flat, Delaunay(flat).simplices.astype(np.int64)))
    source = len(flat) // 3
    logs = points - points[source]
    return Shape(mesh, source, logs, np.linalg.norm(logs, axis=1) > 0)


def cylinder(n: int) -> Shape:
    height = 3.0
    step = np.sqrt(2 * np.pi * height / n)
    around, up = round(2 * np.pi / step), round(height / step)
    turns = np.arange(around) * 2 * np.pi / around
    flat = shaken(*np.meshgrid(turns, np.linspace(0, height, up)), step)
    copies = np.concatenate([flat + np.array([turn, 0]) for turn in (-2 * np.pi, 0, 2 * np.pi)])
    faces = turned_up(copies, Delaunay(copies).simplices.astype(np.int64))
    middle = copies[faces].mean(axis=1)[:, 0]
    faces = faces[(middle >= 0) & (middle < 2 * np.pi)] % len(flat)
    t = flat[:, 0]
    mesh = gt.TriangleMesh(np.column_stack([np.cos(t), np.sin(t), flat[:, 1]]), faces)
    source = len(flat) // 3
    turn = (t - t[source] + np.pi) % (2 * np.pi) - np.pi
    axis = np.array([-np.sin(t[source]), np.cos(t[source]), 0.0])
    logs = turn[:, None] * axis + (flat[:, 1] - flat[source, 1])[:, None] * [0.0, 0.0, 1.0]
    return Shape(mesh, source, logs, (np.abs(turn) < 0.95 * np.pi) & logs.any(axis=1))


def shaken(x: np.ndarray, y: np.ndarray, step: float) -> np.ndarray:
    """Return points of a grid, those in the upper and lower row where they were."""
    flat = np.column_stack([x.ravel(), y.ravel()])
    inside = (flat > flat.min(axis=0)).all(axis=1) & (flat < flat.max(axis=0)).all(axis=1)
    shake = np.random.default_rng(1).uniform(-0.35, 0.35, flat.shape) * step
    return np.where(inside[:, None], flat + shake, flat)


def turned_up(flat: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return triangles counterclockwise, without those of no area."""
    a, b, c = (flat[faces[:, i]] for i in range(3))
    areas = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    faces = np.where(areas[:, None] < 0, faces[:, ::-1], faces)
    return faces[np.abs(areas) > 1e-9 * np.abs(areas).max()]


# -- parts -----------------------------------------------------------------------------------------


def peers_logs(mesh: gt.TriangleMesh, source: int) -> Iterator[np.ndarray]:
    """Yield the logarithms (N, 3) of the other library by each of its strategies that answers."""
    solver = pp3d.MeshVectorHeatSolver(mesh.vertices, mesh.faces)
    x, y, _ = solver.get_tangent_frames()
    for strategy in STRATEGIES:
        try:
            logs = solver.compute_log_map(source, strategy)
        except RuntimeError:
            continue
        yield logs[:, :1] * x[source] + logs[:, 1:] * y[source]


def errors(got: np.ndarray, shape: Shape) -> tuple[float, float]:
    want, got = shape.logarithms[shape.good], got[shape.good]
    length = np.linalg.norm(want, axis=1)
    off = np.abs(np.linalg.norm(got, axis=1) / length - 1)
    return float(degrees(got, want).mean()), float(100 * off.mean())


def logs(sizes: list[int]) -> Iterator[Row]:
    bounds = {
        "plane": {3500: (1e-3, 1e-3), 35000: (1e-3, 1e-3)},
        "sphere": {3500: (0.05, 0.03), 35000: (0.006, 0.004)},
        "cylinder": {3500: (0.2, 0.03), 35000: (0.01, 0.004)},
    }
    for make in (plane, sphere, cylinder):
        for n in sizes:
            shape = make(n)
            solver = gt.GeodesicSolver(shape.mesh)
            found = gt.log_map(solver, shape.source, refine=True)
            angle, length = errors(found.vectors, shape)
            others = [errors(got, shape) for got in peers_logs(shape.mesh, shape.source)]
            name = f"log map, {make.__name__} {n}"
            most = bounds[make.__name__][n]
            yield Row(f"{name}: angle", angle, most[0], peer=min(a for a, _ in others))
            yield Row(f"{name}: length", length, most[1], peer=min(r for _, r in others))


def order(_: list[int]) -> Iterator[Row]:
    off = []
    for n in (4000, 16000):
        shape = sphere(n)
        found = gt.log_map(gt.GeodesicSolver(shape.mesh), shape.source, refine=True)
        near = shape._replace(good=shape.good & (np.linalg.norm(shape.logarithms, axis=1) < 2.5))
        off.append(errors(found.vectors, near)[0])
    yield Row(
        "log map, sphere 4k to 16k: order of angles", float(np.log2(off[0] / off[1])), 1.8, True
    )


def transport(sizes: list[int]) -> Iterator[Row]:
    for n in sizes:
        shape = sphere(n)
        mesh, source = shape.mesh, shape.source
        solver = gt.GeodesicSolver(mesh)
        vector = gt.tangent_frames(solver).x_axes[source]
        want = along_great_circles(mesh.vertices, source, vector)
        got = gt.parallel_transport(solver, source, vector, refine=True)
        other = pp3d.MeshVectorHeatSolver(mesh.vertices, mesh.faces)
        x, y, _ = other.get_tangent_frames()
        there = other.transport_tangent_vector(source, [vector @ x[source], vector @ y[source]])
        peer = degrees(there[:, :1] * x + there[:, 1:] * y, want)[shape.good].mean()
        bound = 0.1 if n < 10000 else 0.02
        off = degrees(got, want)[shape.good].mean()
        yield Row(f"transport, sphere {n}", float(off), bound, peer=float(peer))
        yield from _cells(solver, n)


def _cells(solver: gt.GeodesicSolver, n: int) -> Iterator[Row]:
    mesh = solver.domain
    rng = np.random.default_rng(3)
    sites = rng.choice(n, 10, replace=False)
    vectors = gt.tangent_frames(solver).x_axes[sites]
    nearest = (mesh.vertices @ mesh.vertices[sites].T).argmax(axis=1)
    got = gt.parallel_transport(solver, sites, vectors, refine=True)
    want = np.zeros_like(got)
    for k, site in enumerate(sites):
        own = nearest == k
        want[own] = along_great_circles(mesh.vertices, site, vectors[k])[own]
    bound = 0.7 if n < 10000 else 0.35
    wide = 100 * float((degrees(got, want) > 10).mean())
    yield Row(f"transport of ten, sphere {n}: % over 10 degrees", wide, bound)
    labels = gt.extend(solver, sites, np.arange(10), refine=True)
    wrong = 100 * float((labels != nearest).mean())
    yield Row(f"labels, sphere {n}: % wrong", wrong, 0.3)


def clouds(sizes: list[int]) -> Iterator[Row]:
    cases = [(3500, 0.0, 0.05), (3500, 0.25, 4.0)]
    if 35000 in sizes:
        cases += [(35000, 0.0, 0.4), (35000, 0.26, 2.5)]
    for n, noise, bound in cases:
        shape = sphere(n)
        rng = np.random.default_rng(0)
        height = 1 + noise * np.sqrt(4 * np.pi / n) * rng.normal(size=(n, 1))
        points = shape.mesh.vertices * height
        found = gt.log_map(gt.GeodesicSolver(gt.PointCloud(points)), shape.source, refine=True)
        other = pp3d.PointCloudHeatSolver(points)
        x, y, _ = other.get_tangent_frames()
        there = other.compute_log_map(shape.source)
        theirs = there[:, :1] * x[shape.source] + there[:, 1:] * y[shape.source]
        yield Row(
            f"log map, cloud of a sphere {n}, noise {noise}",
            in_plane(found.vectors, found.frame, shape),
            bound,
            peer=in_plane(theirs, np.stack([x[shape.source], y[shape.source]]), shape),
        )


def in_plane(got: np.ndarray, frame: np.ndarray, shape: Shape) -> float:
    """Return the mean angle between logarithms as they lie in a tangent plane."""
    turn = (got @ frame.T @ [1, 1j]) / (shape.logarithms @ frame.T @ [1, 1j] + ~shape.good)
    return float(np.degrees(np.abs(np.angle(turn[shape.good]))).mean())


def far(_: list[int]) -> Iterator[Row]:
    rings, around = 1200, 48
    turn = 2 * np.pi * np.arange(around) / around
    radius = 1 / (2 * np.sin(np.pi / around))
    height = np.repeat(np.arange(rings, dtype=float), around)
    points = np.column_stack(
        [np.tile(radius * np.cos(turn), rings), np.tile(radius * np.sin(turn), rings), height]
    )
    cells = np.arange(rings * around).reshape(rings, around)
    a, b = cells[:-1].ravel(), np.roll(cells[:-1], -1, axis=1).ravel()
    c, d = cells[1:].ravel(), np.roll(cells[1:], -1, axis=1).ravel()
    faces = np.concatenate([np.column_stack([a, b, d]), np.column_stack([a, d, c])])
    found = gt.log_map(gt.GeodesicSolver(gt.TriangleMesh(points, faces)), 5, refine=True)
    along = (np.tile(np.arange(around), rings) - 5 + around / 2) % around - around / 2
    flat = along + 1j * height
    last = (height > 900) & (np.abs(along) < 0.95 * around / 2)
    off = (found.coordinates @ [1, 1j])[last] / flat[last]
    off /= (found.coordinates @ [1, 1j])[around + 5] / flat[around + 5]
    yield Row(
        "log map, tube, rings 900 to 1200",
        float(np.degrees(np.abs(np.angle(off))).mean()),
        0.01,
        peer="NaN",
    )


def real(_: list[int]) -> Iterator[Row]:
    """Logarithms against exact paths over the polyhedron, short of a common turn."""
    means, medians, lengths, theirs = [], [], [], []
    for name in REAL:
        if not (DATA / name).exists():
            print(f"{name}: not there")
            continue
        given = gt.read(DATA / name)
        mesh = gt.TriangleMesh(*referenced(np.array(given.vertices), np.array(given.faces)))
        solver, n = gt.GeodesicSolver(mesh), mesh.n_vertices
        rng = np.random.default_rng(0)
        for source in (n // 7, n // 2, 2 * n // 3):
            others = np.setdiff1d(np.arange(n), [source])
            targets = rng.choice(others, 60 if n < 10000 else 20, replace=False)
            want = exact_logs(solver, source, targets)
            found = gt.log_map(solver, source, refine=True)
            off = turned(found.coordinates[targets] @ [1, 1j], want)
            means.append(off.mean())
            medians.append(np.median(off))
            lengths.append(np.abs(found.distance[targets] / np.abs(want) - 1).mean())
            frame = gt.tangent_frames(solver)
            axes = np.stack([frame.x_axes[source], frame.y_axes[source]])
            best = [
                turned(g[targets] @ axes.T @ [1, 1j], want).mean() for g in peers_logs(mesh, source)
            ]
            theirs.append(min(best))
    if not means:
        return
    yield Row("log map, five meshes: mean", float(np.mean(means)), 2.0, peer=float(np.mean(theirs)))
    yield Row("log map, five meshes: median", float(np.median(medians)), 0.9)
    yield Row("log map, five meshes: length in %", 100 * float(np.mean(lengths)), 0.3)


def exact_logs(solver: gt.GeodesicSolver, source: int, targets: np.ndarray) -> np.ndarray:
    """Return lengths and directions at a vertex of shortest paths, in the frame of the solver."""
    mesh, frames = solver.domain, gt.tangent_frames(solver)
    places, faces = mesh.vertices, mesh.faces
    around = faces[(faces == source).any(axis=1)]
    rolled = np.array([np.roll(face, -int(np.flatnonzero(face == source)[0])) for face in around])
    following = {int(face[1]): face for face in rolled}
    heads = {int(face[2]) for face in rolled}
    start = next((int(f[1]) for f in rolled if int(f[1]) not in heads), int(rolled[0][1]))
    angle = lambda u, v: np.arctan2(np.linalg.norm(np.cross(u, v)), u @ v)  # noqa: E731
    before, total, at = {}, 0.0, start
    while at in following and at not in before:
        face = following[at]
        before[at] = total
        total += angle(places[face[1]] - places[source], places[face[2]] - places[source])
        at = int(face[2])
    scale = 2 * np.pi / total if at == start else 1.0
    edge = places[start] - places[source]
    turn = np.arctan2(edge @ frames.y_axes[source], edge @ frames.x_axes[source])
    logs = np.empty(len(targets), dtype=complex)
    for k, target in enumerate(targets):
        path = gt.geodesic_path(solver, int(source), int(target))
        step = path.points[1] - path.points[0]
        off = [
            angle(places[f[1]] - places[source], step)
            + angle(step, places[f[2]] - places[source])
            - angle(places[f[1]] - places[source], places[f[2]] - places[source])
            for f in rolled
        ]
        face = rolled[int(np.argmin(off))]
        within = angle(places[face[1]] - places[source], step)
        logs[k] = path.length * np.exp(1j * (turn + scale * (before[int(face[1])] + within)))
    return logs


def turned(got: np.ndarray, want: np.ndarray) -> np.ndarray:
    """Return angles in degrees between logarithms, short of their common turn."""
    turn = np.angle(got / want)
    common = np.median(turn)
    for _ in range(5):
        common += np.median(np.angle(np.exp(1j * (turn - common))))
    return np.degrees(np.abs(np.angle(np.exp(1j * (turn - common)))))


def means(_: list[int]) -> Iterator[Row]:
    mesh = irregular_sphere(3500)
    solver = gt.GeodesicSolver(mesh)
    rng = np.random.default_rng(5)
    sites = rng.choice(np.flatnonzero(mesh.vertices[:, 2] > 0.55), 8, replace=False)
    for power, bound in ((2, 0.01), (1, 0.02)):
        at = mesh.vertices[sites].mean(axis=0)
        at /= np.linalg.norm(at)
        for _ in range(300):
            d = np.arccos(np.clip(mesh.vertices[sites] @ at, -1, 1))
            away = mesh.vertices[sites] - (mesh.vertices[sites] @ at)[:, None] * at
            away /= np.maximum(np.linalg.norm(away, axis=1), 1e-12)[:, None]
            pull = np.ones(8) if power == 2 else 1 / np.maximum(d, 1e-12)
            move = pull @ (away * d[:, None]) / pull.sum()
            at = at + move
            at /= np.linalg.norm(at)
        found = gt.geodesic_mean(solver, sites, power=power).position
        off = np.arccos(min(1.0, found @ at / np.linalg.norm(found))) / solver.method.metric.spacing
        yield Row(f"mean of power {power}, sphere 3500: edge lengths off", float(off), bound)
    cells = gt.centroidal_voronoi(solver, 50, rng=np.random.default_rng(1))
    energy = cells.energies[-1] / (HEXAGON * (4 * np.pi) ** 2 / 50)
    yield Row("cells of 50 sites, sphere 3500: of the hexagonal bound", float(energy), 1.05)


def cost(sizes: list[int]) -> Iterator[Row]:
    n = max(sizes)
    shape = sphere(n)
    solver = gt.GeodesicSolver(shape.mesh)
    ours = cpu(partial(gt.log_map, solver, shape.source, refine=True))
    other = pp3d.MeshVectorHeatSolver(shape.mesh.vertices, shape.mesh.faces)
    peer = min(cpu(partial(other.compute_log_map, shape.source, s)) for s in STRATEGIES[:2])
    yield Row(f"log map, sphere {n}: seconds", ours, 0.04, peer=peer)
    sites = np.random.default_rng(0).choice(n, 100, replace=False)
    few, more = (
        cpu(partial(gt.centroidal_voronoi, solver, sites, steps=steps, tolerance=0.0), 1)
        for steps in (1, 6)
    )
    yield Row(f"a step of 100 cells, sphere {n}: log maps", (more - few) / 5 / ours, 2.0)


PARTS: dict[str, Callable[[list[int]], Iterator[Row]]] = {
    "logs": logs,
    "order": order,
    "transport": transport,
    "clouds": clouds,
    "far": far,
    "real": real,
    "means": means,
    "cost": cost,
}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--large", action="store_true")
    parser.add_argument("--parts", default=",".join(PARTS))
    options = parser.parse_args()
    sizes = [3500, 35000] if options.large else [3500]
    for part in options.parts.split(","):
        for row in PARTS[part](sizes):
            print(row, flush=True)


if __name__ == "__main__":
    main()
