"""Logarithmic maps, transport, labels, means and cells along refined distances, beside potpourri3d.

python benchmarks/heat_family.py                    all rows of 3.5k vertices, and real meshes
python benchmarks/heat_family.py --large            also of 35k vertices
python benchmarks/heat_family.py --parts logs,far   some of the parts

Each row has a figure, its bound, and the figure of potpourri3d where that answers: of logarithmic
maps the best of its three strategies. Angles are means in degrees, lengths relative in per cent.
Times are CPU seconds in one process: only their ratios say something on a busy machine.
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

import numpy as np
import potpourri3d as pp3d
from heat_family_signed import REAL, along_great_circles, cpu, degrees, irregular_sphere
from measuring.figures import Row, parser, report
from measuring.shapes import DATA, referenced
from scipy.spatial import Delaunay

import geodesic_toolkit as gt

STRATEGIES = ("VectorHeat", "AffineLocal", "AffineAdaptive")
AXES = np.array([1.0, 0.8, 0.6])  # of the ellipsoid
REACH = 1.2  # of logarithms on the ellipsoid: far from its cut loci
FACE = "igltut__face.obj"
HEXAGON = 5 / (18 * np.sqrt(3))  # second moment of regular hexagons of area 1

# -- shapes with closed forms ----------------------------------------------------------------------


class Shape(NamedTuple):
    """A mesh, and the logarithms of its vertices about one of them where those are known."""

    mesh: gt.TriangleMesh
    source: int
    logarithms: np.ndarray
    good: np.ndarray


def sphere(n: int) -> Shape:
    mesh = irregular_sphere(n)
    logs = sphere_logs(mesh.vertices, n // 3)
    length = np.linalg.norm(logs, axis=1)
    return Shape(mesh, n // 3, logs, (length > 1e-9) & (length < 0.95 * np.pi))


def sphere_logs(points: np.ndarray, source: int) -> np.ndarray:
    """Return the logarithms of points of the unit sphere about one of them."""
    p = points[source]
    away = points - (points @ p)[:, None] * p
    sine = np.linalg.norm(away, axis=1)
    length = np.arctan2(sine, points @ p)
    return length[:, None] * np.divide(
        away, sine[:, None], out=np.zeros_like(away), where=sine[:, None] > 0
    )


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


def ellipsoid(n: int, source: int | None = None) -> Shape:
    """Return an ellipsoid, with logarithms of some thousand vertices by Newton's method."""
    round_, source = irregular_sphere(n), n // 3 if source is None else source
    points = round_.vertices * AXES
    near = np.flatnonzero(np.linalg.norm(points - points[source], axis=1) < REACH)
    near = np.random.default_rng(0).permutation(near[near != source])[:2000]
    normal = points[source] / AXES**2
    frame = np.linalg.svd(normal[None])[2][1:]
    chords = points[near] - points[source]
    flat = chords @ frame.T
    flat *= (np.linalg.norm(chords, axis=1) / np.linalg.norm(flat, axis=1))[:, None]
    for _ in range(15):
        ends, here, there = (
            shot(points[source], (flat + shift) @ frame) for shift in np.eye(3, 2, k=-1) * 1e-6
        )
        slopes = np.stack([here - ends, there - ends], axis=2) / 1e-6
        gaps = np.einsum("nij,ni->nj", slopes, points[near] - ends)
        move = np.linalg.solve(slopes.transpose(0, 2, 1) @ slopes, gaps[:, :, None])[:, :, 0]
        flat += np.clip(move, -0.1, 0.1)
    logs, good = np.zeros_like(points), np.zeros(n, dtype=bool)
    logs[near] = flat @ frame
    good[near] = np.linalg.norm(ends - points[near], axis=1) < 1e-8
    return Shape(gt.TriangleMesh(points, round_.faces), source, logs, good)


def shot(start: np.ndarray, vectors: np.ndarray, steps: int = 60) -> np.ndarray:
    """Return where geodesics of the ellipsoid end, by the method of Runge and Kutta."""

    def pull(x: np.ndarray, v: np.ndarray) -> np.ndarray:
        g = x / AXES**2
        share = (v * v / AXES**2).sum(axis=1) / (g * g).sum(axis=1)
        return -share[:, None] * g

    x, v, h = np.tile(start, (len(vectors), 1)), vectors.copy(), 1 / steps
    for _ in range(steps):
        a = pull(x, v)
        b = pull(x + h / 2 * v, v + h / 2 * a)
        c = pull(x + h / 2 * v + h * h / 4 * a, v + h / 2 * b)
        d = pull(x + h * v + h * h / 2 * b, v + h * c)
        x, v = x + h * v + h * h / 6 * (a + b + c), v + h / 6 * (a + 2 * b + 2 * c + d)
    return x


def plate_with_hole(n: int) -> Shape:
    """Return a square with a square hole, and logarithms by the shorter path around that."""
    side = round((n / 0.91) ** 0.5)
    low, high = (round(share * (side - 1)) / (side - 1) for share in (0.35, 0.65))
    grid = np.meshgrid(np.linspace(0, 1, side), np.linspace(0, 1, side))
    even, flat = np.stack(grid, axis=-1).reshape(-1, 2), shaken(*grid, 1 / side)
    off = np.abs(even - (low + high) / 2).max(axis=1) - (high - low) / 2
    flat = np.where((np.abs(off) < 0.1 / side)[:, None], even, flat)[off > -0.1 / side]
    faces = turned_up(flat, Delaunay(flat).simplices.astype(np.int64))
    middle = flat[faces].mean(axis=1)
    faces = faces[((middle < low) | (middle > high)).any(axis=1)]
    source = int(np.linalg.norm(flat - [0.2, 0.42], axis=1).argmin())
    logs, good = around_square(flat, flat[source], low, high)
    mesh = gt.TriangleMesh(np.pad(flat, ((0, 0), (0, 1))), faces)
    return Shape(mesh, source, np.pad(logs, ((0, 0), (0, 1))), good)


def around_square(
    points: np.ndarray, source: np.ndarray, low: float, high: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return logarithms in the plane without [low, high]^2, and where others are 2 % longer."""
    corners = np.array([[low, low], [high, low], [high, high], [low, high]])
    legs, direct = corners - source, points - source
    seen = ~is_blocked(source, corners, low, high)
    centre = corners.mean(axis=0) - source
    found = []
    for sign in (1, -1):  # the left way and the right way
        ours = seen & (sign * (legs[:, 1] * centre[0] - legs[:, 0] * centre[1]) > 0)
        reach, first = np.where(ours, np.linalg.norm(legs, axis=1), np.inf), legs.copy()
        for _, k, step in ((r, k, step) for r in range(3) for k in range(4) for step in (1, 3)):
            if reach[k] + high - low < reach[(k + step) % 4]:
                reach[(k + step) % 4], first[(k + step) % 4] = reach[k] + high - low, first[k]
        there = np.stack([np.linalg.norm(points - corner, axis=1) for corner in corners])
        hidden = np.stack([is_blocked(corner, points, low, high) for corner in corners])
        lengths = np.where(hidden, np.inf, reach[:, None] + there)
        leg = first[lengths.argmin(axis=0)]
        shortest = lengths.min(axis=0)[:, None]
        found.append((shortest, shortest * leg / np.linalg.norm(leg, axis=1)[:, None]))
    (left, by_left), (right, by_right) = found
    straight = ~is_blocked(source, points, low, high)[:, None]
    logs = np.where(straight, direct, np.where(left < right, by_left, by_right))
    is_clear = straight | (np.abs(left - right) > 0.02 * np.minimum(left, right))
    return logs, is_clear[:, 0] & direct.any(axis=1)


def is_blocked(tail: np.ndarray, heads: np.ndarray, low: float, high: float) -> np.ndarray:
    """Return the segments from a point that pass through the inside of a square."""
    with np.errstate(divide="ignore"):
        ends = (np.array([low + 1e-9, high - 1e-9])[:, None, None] - tail) / (heads - tail)
    enter, leave = ends.min(axis=0).max(axis=1), ends.max(axis=0).min(axis=1)
    return np.maximum(enter, 0) < np.minimum(leave, 1)


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


def log_rows(name: str, shape: Shape, angle: float, length: float | None = None) -> Iterator[Row]:
    """Yield the errors of the angles and lengths of a logarithmic map, with their bounds."""
    found = gt.log_map(gt.GeodesicSolver(shape.mesh), shape.source, refine=True)
    own = errors(found.vectors, shape)
    others = [errors(got, shape) for got in peers_logs(shape.mesh, shape.source)]
    best = [min(one) if others else "fails" for one in zip(*others, strict=True)] or ["fails"] * 2
    yield Row(f"log map, {name}: angle, degrees", own[0], angle, peer=best[0])
    yield Row(f"log map, {name}: length, %", own[1], length, peer=best[1])


def logs(sizes: list[int]) -> Iterator[Row]:
    for n in sizes:
        large = n > 10_000
        yield from log_rows(f"plane {n}", plane(n), 1e-3, 1e-3)
        shape, bounds = sphere(n), (0.006, 0.004) if large else (0.05, 0.03)
        yield from log_rows(f"sphere {n}", shape, *bounds)
        angle = 0.01 if large else 0.2
        yield from log_rows(f"cylinder {n}", cylinder(n), angle)
        for source in (n // 3, n // 2):
            yield from log_rows(f"ellipsoid {n}, vertex {source}", ellipsoid(n, source), angle)


def hole(_: list[int]) -> Iterator[Row]:
    shape = plate_with_hole(3300)
    yield from log_rows("plate with a hole", shape, 0.2)
    found = gt.log_map(gt.GeodesicSolver(shape.mesh), shape.source, refine=True)
    off = degrees(found.vectors, shape.logarithms)[shape.good]
    yield Row("log map, plate with a hole: largest angle, degrees", float(off.max()), 2.0)


def order(sizes: list[int]) -> Iterator[Row]:
    """Yield orders of mean errors within 2.5 of seven sources."""
    found = []
    counts = [4000, 16000, 64000] if max(sizes) > 10_000 else [4000, 16000]
    for n in counts:
        solver = gt.GeodesicSolver(irregular_sphere(n))
        sources = [n // 3, *np.random.default_rng(0).choice(n, 6, replace=False).tolist()]
        off = []
        for source in sources:
            want = sphere_logs(solver.domain.vertices, source)
            length = np.linalg.norm(want, axis=1)
            near = (length > 1e-9) & (length < 2.5)
            got = gt.log_map(solver, source, refine=True).vectors
            off.append(errors(got, Shape(solver.domain, source, want, near))[0])
        found.append(np.mean(off))
    steps = np.log2(np.array(found[:-1]) / found[1:])
    names = [f"{count // 1000}k" for count in counts]
    whole = f"log map, sphere {names[0]} to {names[-1]}: order of angles"
    yield Row(whole, float(steps.mean()), 1.8, at_least=True)
    if len(steps) > 1:
        for one, other, step in zip(names, names[1:], steps.tolist(), strict=False):
            yield Row(f"log map, sphere {one} to {other}: order of angles", step)


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
    cases = [(3500, 0.0, 0.05), (3500, 0.25, 2.5)]
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


class Compared(NamedTuple):
    """Errors of one logarithmic map: angles in degrees, and the mean of lengths."""

    angles: np.ndarray
    length: float
    peer: float


def compared(mesh: gt.TriangleMesh, sources: list[int]) -> Iterator[Compared]:
    """Yield errors against exact paths over the polyhedron, short of a common turn."""
    solver, n = gt.GeodesicSolver(mesh), mesh.n_vertices
    frame, rng = gt.tangent_frames(solver), np.random.default_rng(0)
    for source in sources:
        others = np.setdiff1d(np.arange(n), [source])
        targets = rng.choice(others, 60 if n < 10000 else 20, replace=False)
        want = exact_logs(solver, source, targets)
        found = gt.log_map(solver, source, refine=True)
        axes = np.stack([frame.x_axes[source], frame.y_axes[source]])
        peers = (logs[targets] @ axes.T @ [1, 1j] for logs in peers_logs(mesh, source))
        yield Compared(
            turned(found.coordinates[targets] @ [1, 1j], want),
            float(np.abs(found.distance[targets] / np.abs(want) - 1).mean()),
            min(float(turned(logs, want).mean()) for logs in peers),
        )


def real(_: list[int]) -> Iterator[Row]:
    found = []
    for name in REAL:
        if mesh := real_mesh(name):
            n = mesh.n_vertices
            found += compared(mesh, [n // 7, n // 2, 2 * n // 3])
    if found:
        mean = float(np.mean([each.angles.mean() for each in found]))
        median = float(np.median([np.median(each.angles) for each in found]))
        peer = float(np.mean([each.peer for each in found]))
        length = 100 * float(np.mean([each.length for each in found]))
        yield Row("log map, five meshes: mean angle, degrees", mean, 2.0, peer=peer)
        yield Row("log map, five meshes: median angle, degrees", median, 0.9)
        yield Row("log map, five meshes: length, %", length, 0.3)
    if mesh := real_mesh(FACE):
        for source in (mesh.n_vertices // 7, 2 * mesh.n_vertices // 3):
            (each,) = compared(mesh, [source])
            name = f"log map, face 26k, vertex {source}: mean angle, degrees"
            yield Row(name, float(each.angles.mean()), 0.3, peer=each.peer)


def real_mesh(name: str) -> gt.TriangleMesh | None:
    """Return a mesh of the shared data, or None and say so where that is not there."""
    if not (DATA / name).exists():
        print(f"{name}: not there")
        return None
    given = gt.read(DATA / name)
    return gt.TriangleMesh(*referenced(np.array(given.vertices), np.array(given.faces)))


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
    ours = cpu(partial(gt.log_map, solver, shape.source, refine=True), 9)
    other = pp3d.MeshVectorHeatSolver(shape.mesh.vertices, shape.mesh.faces)
    peer = min(cpu(partial(other.compute_log_map, shape.source, s), 9) for s in STRATEGIES[:2])
    yield Row(f"log map, sphere {n}: ms", 1e3 * ours, 40, peer=1e3 * peer)
    sites = np.random.default_rng(0).choice(n, 100, replace=False)
    few, more = (
        cpu(partial(gt.centroidal_voronoi, solver, sites, steps=steps, tolerance=0.0), 1)
        for steps in (1, 6)
    )
    yield Row(f"a step of 100 cells, sphere {n}: log maps", (more - few) / 5 / ours, 2.0)


PARTS: dict[str, Callable[[list[int]], Iterator[Row]]] = {
    "logs": logs,
    "hole": hole,
    "order": order,
    "transport": transport,
    "clouds": clouds,
    "far": far,
    "real": real,
    "means": means,
    "cost": cost,
}


def main() -> None:
    options = parser(__doc__)
    options.add_argument("--large", action="store_true", help="also 35,000 vertices")
    given = options.parse_args()
    sizes = [3500, 35000] if given.large else [3500]
    report({name: partial(part, sizes) for name, part in PARTS.items()}, given)


if __name__ == "__main__":
    main()
