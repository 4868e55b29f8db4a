"""Vectors in heat, the exponential map and signed distance, beside potpourri3d.

python benchmarks/heat_family_signed.py               rows of 3.5k vertices, and real meshes
python benchmarks/heat_family_signed.py --large       also of 35k vertices: two minutes
python benchmarks/heat_family_signed.py --parts real  some of the parts

Each row has a figure, its bound, and the figure of potpourri3d where that answers. Angles are in
degrees, distances relative in per cent beyond a mean edge. Times are CPU seconds, the least of some
runs, interleaved in one process: only their ratios say something on a busy machine.
"""

import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
import potpourri3d as pp3d
from measuring.figures import Parts, Row, parser, report
from measuring.shapes import DATA, referenced
from scipy.spatial import ConvexHull

import geodesic_toolkit as gt
from geodesic_toolkit.geometry.isolines import level_set
from geodesic_toolkit.vector_heat import VectorHeatMethod

REAL = (
    "igltut__bunny.off",
    "jacobson__spot.obj",
    "odedstein__koala_low_resolution.obj",
    "igltut__3holes.off",
    "igltut__camelhead.off",
)


# -- shapes with closed forms ----------------------------------------------------------------------


def irregular_sphere(n: int, seed: int = 1) -> gt.TriangleMesh:
    """Return random points of the unit sphere, moved apart a little, and their hull."""
    points = np.random.default_rng(seed).normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    for _ in range(3):
        hull = ConvexHull(points).simplices
        total, count = np.zeros_like(points), np.zeros(n)
        for one, other in ((0, 1), (1, 0), (1, 2), (2, 1), (2, 0), (0, 2)):
            np.add.at(total, hull[:, one], points[hull[:, other]])
            np.add.at(count, hull[:, one], 1)
        points = total / count[:, None]
        points /= np.linalg.norm(points, axis=1)[:, None]
    faces = ConvexHull(points).simplices.astype(np.int64)
    normals = np.cross(*(points[faces[:, c]] - points[faces[:, 0]] for c in (1, 2)))
    inward = np.einsum("fd,fd->f", normals, points[faces[:, 0]]) < 0
    return gt.TriangleMesh(points, np.where(inward[:, None], faces[:, ::-1], faces))


def along_great_circles(points: np.ndarray, source: int, vector: np.ndarray) -> np.ndarray:
    """Return a tangent vector of the unit sphere carried to all points."""
    p, cosine = points[source], np.clip(points @ points[source], -1, 1)
    away = points - cosine[:, None] * p
    sine = np.linalg.norm(away, axis=1)
    out = np.divide(away, sine[:, None], out=np.zeros_like(away), where=sine[:, None] > 0)
    side = np.cross(p, out)
    arrival = -sine[:, None] * p + cosine[:, None] * out
    moved = (out @ vector)[:, None] * arrival + (side @ vector)[:, None] * side
    moved[source] = vector
    return moved


def degrees(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the angles between rows of vectors."""
    sine = np.linalg.norm(np.cross(one, other), axis=1)
    return np.degrees(np.arctan2(sine, np.einsum("nd,nd->n", one, other)))


def cpu(work: Callable[[], Any], runs: int = 3) -> float:
    """Return the CPU seconds of the fastest of some runs."""
    best = np.inf
    for _ in range(runs):
        begun = time.process_time()
        work()
        best = min(best, time.process_time() - begun)
    return best


# -- parallel transport ----------------------------------------------------------------------------


def carried_by_peer(mesh: gt.TriangleMesh, source: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the x axis of a vertex of potpourri3d, and what it carries to all vertices."""
    solver = pp3d.MeshVectorHeatSolver(mesh.vertices, mesh.faces)
    x, y, _ = solver.get_tangent_frames()
    flat = solver.transport_tangent_vector(source, [1.0, 0.0])
    return x[source], flat[:, :1] * x + flat[:, 1:] * y


def carried(solver: gt.GeodesicSolver, source: int, vector: np.ndarray) -> np.ndarray:
    """Return a vector carried to all vertices by plain heat."""
    heat = solver.vector_heat
    return heat.frames.to_space(heat.transport(solver.locate(source), vector[None]))


def transport_rows(sizes: list[int]) -> Iterator[Row]:
    """Yield rows of plain parallel transport: spheres, plates, a tube, clouds."""
    for n in sizes:
        mesh = irregular_sphere(n)
        source = n // 3
        near = mesh.vertices @ mesh.vertices[source] > np.cos(0.95 * np.pi)
        vector, theirs = carried_by_peer(mesh, source)
        peer = degrees(theirs, along_great_circles(mesh.vertices, source, vector))[near].mean()
        for name, shape in (("sphere", mesh), ("cloud", gt.PointCloud(mesh.vertices))):
            solver = gt.GeodesicSolver(shape)
            own = solver.frames.x_axes[source]
            got = carried(solver, source, own)
            exact = along_great_circles(mesh.vertices, source, own)
            off = float(degrees(got, exact)[near].mean())
            yield Row(
                f"transport, {name} of {n}, degrees",
                off,
                peer if name == "sphere" else 1.0,
                peer=float(peer),
            )
    for shear in (0.0, 2.0, 4.0):
        plate = gt.testing.shapes.grid(60, shear=shear)
        solver = gt.GeodesicSolver(plate)
        source = 60 * 30 + 30
        got = carried(solver, source, np.array([1.0, 0, 0]))
        off = degrees(got, np.tile([1.0, 0, 0], (3600, 1)))
        vector, theirs = carried_by_peer(plate, source)
        peer = float(degrees(theirs, np.tile(vector, (3600, 1))).max())
        yield Row(
            f"transport, plate sheared by {shear:g}, largest, degrees",
            float(off.max()),
            1e-6,
            peer=peer,
        )
    tube = gt.testing.shapes.tube(1200, 48)
    x, y, _ = tube.vertices.T
    around = np.column_stack([-y, x, 0 * x]) / np.hypot(x, y)[:, None]
    off = degrees(carried(gt.GeodesicSolver(tube), 5, around[5]), around)
    _, theirs = carried_by_peer(tube, 5)
    lost = f"{100 * np.isnan(theirs).any(axis=1).mean():.0f}% NaN"
    yield Row("transport, tube of 1,200 rings, largest, degrees", float(off.max()), 1e-6, peer=lost)


def exponential_rows(sizes: list[int]) -> Iterator[Row]:
    """Yield rows of lines that are to arrive where exact great circles do."""
    for n in sizes:
        mesh = irregular_sphere(n)
        solver, source = gt.GeodesicSolver(mesh), n // 3
        targets = np.random.default_rng(0).choice(n, 500, replace=False)
        cosine = np.clip(mesh.vertices[targets] @ mesh.vertices[source], -1, 1)
        targets = targets[(cosine > -0.99) & (cosine < 0.9999)]
        reach = np.arccos(np.clip(mesh.vertices[targets] @ mesh.vertices[source], -1, 1))
        out = mesh.vertices[targets] - np.cos(reach)[:, None] * mesh.vertices[source]
        out *= (reach / np.sin(reach))[:, None]
        ends = gt.exp_map(solver, source, out).positions
        off = np.linalg.norm(ends - mesh.vertices[targets], axis=1) / reach
        yield Row(
            f"exp of exact logarithms, sphere of {n}, median %",
            100 * float(np.median(off)),
            0.2 if n < 10_000 else 0.04,
        )


# -- signed distance -------------------------------------------------------------------------------


def curves_at(mesh: gt.TriangleMesh, values: np.ndarray) -> list[gt.Curve]:
    """Return where values are 0, as curves with larger values on the left."""
    return [
        gt.Curve(
            [
                gt.SurfacePoint(face, tuple(weights))
                for face, weights in zip(chain.faces.tolist(), chain.weights.tolist(), strict=True)
            ],
            closed=chain.closed,
        )
        for chain in level_set(mesh.faces, values)
        if len(chain.faces) > 1
    ]


def for_peer(mesh: gt.TriangleMesh, curves: list[gt.Curve]) -> list[list[tuple[int, list[float]]]]:
    """Return curves as potpourri3d takes them: every crossing of an edge."""
    edges = pp3d.edges(mesh.vertices, mesh.faces)
    number = {(min(a, b), max(a, b)): k for k, (a, b) in enumerate(edges.tolist())}
    found = []
    for curve in curves:
        own = []
        for point in curve.points:
            corners = np.argsort(-np.array(point.barycentric))[:2]
            i, j = mesh.faces[point.face, corners]
            edge = number[min(i, j), max(i, j)]
            share = (
                point.barycentric[corners[1]]
                if edges[edge][1] == j
                else point.barycentric[corners[0]]
            )
            own.append((edge, [float(share)]))
        found.append([*own, own[0]] if curve.closed else own)
    return found


def signed_by_peer(
    mesh: gt.TriangleMesh, curves: list[gt.Curve], exact: np.ndarray
) -> np.ndarray | None:
    """Return the signed distance of potpourri3d by default, None where it fails."""
    try:
        theirs = pp3d.MeshSignedHeatSolver(mesh.vertices, mesh.faces).compute_distance(
            for_peer(mesh, curves)
        )
    except (RuntimeError, ValueError):  # as for several chains
        return None
    return theirs if np.median(theirs * exact) > 0 else -theirs


def beyond(distance: np.ndarray, exact: np.ndarray, spacing: float, where: Any = True) -> float:
    """Return the mean relative error in per cent beyond a mean edge."""
    away = (np.abs(exact) > spacing) & where
    return 100 * float((np.abs(distance - exact) / np.abs(exact))[away].mean())


def sphere_rows(sizes: list[int]) -> Iterator[Row]:
    """Yield rows of circles of latitude on spheres and clouds of their points, whole and broken."""
    for n in sizes:
        mesh = irregular_sphere(n)
        solver = gt.GeodesicSolver(mesh)
        spacing = solver.method.metric.spacing
        large = n > 10_000
        for latitude in (0.6, 1.2):
            exact = np.arccos(np.clip(mesh.vertices[:, 2], -1, 1)) - latitude
            curves = curves_at(mesh, exact)
            theirs = signed_by_peer(mesh, curves, exact)
            peer = "fails" if theirs is None else beyond(theirs, exact, spacing)
            name = f"signed, latitude {latitude} on a sphere of {n}"
            refined = gt.signed_distance(solver, curves)
            yield Row(
                f"{name}, refined, %",
                beyond(refined, exact, spacing),
                0.01 if large else 0.08,
                peer=peer,
            )
            plain = gt.signed_distance(solver, curves, refine=False)
            yield Row(
                f"{name}, plain, %",
                beyond(plain, exact, spacing),
                0.12 if large else 0.3,
                peer=peer,
            )
            wrong = (refined * exact < 0) & (np.abs(exact) > 0.2 * spacing)
            yield Row(f"{name}, wrong signs", float(wrong.sum()), 0)
        exact = np.arccos(np.clip(mesh.vertices[:, 2], -1, 1)) - 1.2
        turn = -np.radians(np.arange(0, 360, 60 * spacing / 2))
        ring = np.column_stack(
            [
                np.sin(1.2) * np.cos(turn),
                np.sin(1.2) * np.sin(turn),
                np.full(len(turn), np.cos(1.2)),
            ]
        )
        cloud = gt.GeodesicSolver(gt.PointCloud(mesh.vertices))
        distance = gt.signed_distance(cloud, gt.Curve(ring, closed=True))
        yield Row(
            f"signed, latitude 1.2 on a cloud of {n}, %",
            beyond(distance, exact, spacing),
            0.05 if large else 0.15,
        )
        if large:
            continue
        for kept, bound in (([(60, 120), (180, 240), (300, 360)], 3.3), ([(150, 360)], 10.0)):
            parts = []
            for begin, end in kept:
                turn = np.radians(np.linspace(begin, end, 200))[::-1]
                parts.append(
                    gt.Curve(
                        np.column_stack(
                            [
                                np.sin(1.2) * np.cos(turn),
                                np.sin(1.2) * np.sin(turn),
                                np.full(200, np.cos(1.2)),
                            ]
                        )
                    )
                )
            distance = gt.signed_distance(solver, parts)
            share = sum(end - begin for begin, end in kept) / 3.6
            yield Row(
                f"signed, {share:.0f} % of a circle in {len(kept)} on a sphere of {n}, %",
                beyond(distance, exact, spacing),
                bound,
            )


def real_rows() -> Iterator[Row]:
    """Yield rows of geodesic circles on real meshes, outside of which the distance is known."""
    figures = []
    for name in REAL:
        if not (DATA / name).exists():
            print(f"{DATA / name} is not there")
            continue
        shape = gt.read(DATA / name)
        mesh = gt.TriangleMesh(*referenced(shape.vertices, shape.faces))
        solver = gt.GeodesicSolver(mesh)
        spacing = solver.method.metric.spacing
        reach = gt.exact_distance(mesh, mesh.n_vertices // 5)
        for share in (0.3, 0.6):
            exact = reach - share * reach.max()
            curves = curves_at(mesh, exact)
            outside = exact > spacing
            theirs = signed_by_peer(mesh, curves, exact)
            peer = "fails" if theirs is None else beyond(theirs, exact, spacing, outside)
            for refine, bound in ((True, 0.7), (False, 4.0)):
                distance = gt.signed_distance(solver, curves, refine=refine)
                figure = beyond(distance, exact, spacing, outside)
                kind, short = "refined" if refine else "plain", name.partition("__")[2]
                yield Row(
                    f"signed, {short} at {share}, {kind}, %",
                    figure,
                    bound,
                    peer=peer,
                )
                if refine:
                    figures.append(figure)
    if figures:
        yield Row("signed, mean of these, refined, %", float(np.mean(figures)), 0.4)


# -- time ------------------------------------------------------------------------------------------


def cost_rows(mesh: gt.TriangleMesh) -> Iterator[Row]:
    """Yield the times of potpourri3d over ours, interleaved."""
    solver, n = gt.GeodesicSolver(mesh), mesh.n_vertices
    frames, axis = solver.frames, solver.frames.x_axes[5]
    factor = cpu(lambda: VectorHeatMethod(solver.method, frames, gt.Supernodal()).prepare())
    made = cpu(lambda: solver.operator.frames(mesh, solver.method.metric))
    peer = pp3d.MeshVectorHeatSolver(mesh.vertices, mesh.faces)
    first = cpu(lambda: peer.transport_tangent_vector(5, [1.0, 0.0]), runs=1)
    yield Row(
        f"first transport of {n}: potpourri3d over ours, with frames",
        first / (factor + made),
        6,
        at_least=True,
    )
    place = solver.locate(5)
    own = cpu(lambda: solver.vector_heat.transport(place, axis[None]), runs=7)
    theirs = cpu(lambda: peer.transport_tangent_vector(5, [1.0, 0.0]), runs=7)
    yield Row(f"further transport of {n}: potpourri3d over ours", theirs / own, 3, at_least=True)
    values = mesh.vertices @ np.array([0.2, 0.3, 0.9])
    curves = curves_at(mesh, values - np.median(values))
    signed = pp3d.MeshSignedHeatSolver(mesh.vertices, mesh.faces)
    crossings = for_peer(mesh, curves)
    signed.compute_distance(crossings, level_set_constraint="None")
    theirs = cpu(lambda: signed.compute_distance(crossings), runs=2)
    for refine in (False, True):
        gt.signed_distance(solver, curves, refine=refine)
        own = cpu(lambda refine=refine: gt.signed_distance(solver, curves, refine=refine))
        kind = "refined" if refine else "plain"
        yield Row(f"signed of {n}, {kind}: potpourri3d over ours", theirs / own, 10, at_least=True)


def large_cost_rows() -> Iterator[Row]:
    """Yield the times on a sphere and a scan of 35,000 vertices."""
    yield from cost_rows(irregular_sphere(35_000))
    scan = DATA / "jacobson__stanford-bunny.obj"
    if scan.exists():
        shape = gt.read(scan)
        yield from cost_rows(gt.TriangleMesh(*referenced(shape.vertices, shape.faces)))


def parts(*, large: bool) -> Parts:
    """Return all parts; with rows of 35,000 vertices if asked to."""
    sizes = [3_500, 35_000] if large else [3_500]
    found: dict[str, Callable[[], Iterator[Row]]] = {
        "transport": partial(transport_rows, sizes),
        "exponential": partial(exponential_rows, sizes),
        "spheres": partial(sphere_rows, sizes),
        "real": real_rows,
    }
    return found | {"cost": large_cost_rows} if large else found


def main() -> None:
    """Print the rows."""
    options = parser(__doc__)
    options.add_argument("--large", action="store_true", help="also 35,000 vertices")
    given = options.parse_args()
    report(parts(large=given.large), given)


if __name__ == "__main__":
    main()
