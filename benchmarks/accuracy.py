"""Errors against exact polyhedral distances on real meshes, other libraries beside ours in one run.

python benchmarks/accuracy.py                    the four meshes of the first table
python benchmarks/accuracy.py --battery          all eleven, five sources each, and symmetry
python benchmarks/accuracy.py --choices          the options of plain heat over the battery
python benchmarks/accuracy.py --spheres          the order of convergence on spheres
python benchmarks/accuracy.py --trust            correlation of the eikonal residual with the error
python benchmarks/accuracy.py ... --write        also into docs/_tables

Exact distances are kept in the system's folder for temporary files: those of the whole battery take
a quarter of an hour.
"""

import argparse
import hashlib
import tempfile
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import igl
import numpy as np
import potpourri3d as pp3d
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.stats import spearmanr

import geodesic_toolkit as gt
from geodesic_toolkit.analysis.residual import mean_eikonal_residual

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"
TABLES = ROOT / "docs" / "_tables"
CACHE = Path(tempfile.gettempdir()) / "geodesic-toolkit-exact"

FIRST = {
    "bunny": "igltut__bunny.off",
    "spot": "jacobson__spot.obj",
    "koala": "odedstein__koala_low_resolution.obj",
    "3holes": "igltut__3holes.off",
}
BATTERY = FIRST | {
    "camelhead": "igltut__camelhead.off",
    "horse": "igltut__horse_quad.obj",
    "fox": "geomcentral__fox.ply",
    "sphere": "odedstein__sphere.obj",
    "face": "igltut__face.obj",
    "armadillo": "igltut__armadillo.obj",
    "stanford-bunny": "jacobson__stanford-bunny.obj",
}
FIRST_SOURCES = (500, 2000)
PAIRS = 100

Method = Callable[[int], np.ndarray]


# -- meshes, sources, the reference ----------------------------------------------------------------


def meshes(files: dict[str, str], count: int | None) -> Iterator[tuple[str, gt.TriangleMesh, list]]:
    """Yield each mesh with its name and sources."""
    for name, file in files.items():
        mesh = compact(gt.read(DATA / file))
        sources = list(FIRST_SOURCES) if count is None else spread_sources(mesh, count)
        print(f"{name}: {mesh.n_vertices} vertices, sources {sources}", flush=True)
        yield name, mesh, sources


def compact(mesh: gt.TriangleMesh) -> gt.TriangleMesh:
    """Return the largest component alone: other libraries cannot say `inf`."""
    edges = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]]])
    graph = coo_array((np.ones(len(edges)), edges.T), shape=(mesh.n_vertices,) * 2)
    labels = connected_components(graph, directed=False)[1]
    keep = labels == np.bincount(labels[mesh.faces[:, 0]]).argmax()
    renumbered = np.cumsum(keep) - 1
    return gt.TriangleMesh(mesh.vertices[keep], renumbered[mesh.faces[keep[mesh.faces[:, 0]]]])


def spread_sources(mesh: gt.TriangleMesh, count: int) -> list[int]:
    """Return `count` sources, each the farthest from those before it by plain heat.

    Not by the default, so that tables of two versions have the same sources.
    """
    return gt.farthest_point_sampling(gt.GeodesicSolver(mesh, refine=False), count).tolist()


def exact(mesh: gt.TriangleMesh, source: int) -> np.ndarray:
    """Return exact distances, from the cache where they are there."""
    shape = hashlib.sha256(mesh.vertices.tobytes() + mesh.faces.tobytes()).hexdigest()[:16]
    path = CACHE / f"{shape}-{source}.npy"
    if not path.exists():
        CACHE.mkdir(exist_ok=True)
        np.save(path, gt.exact_distance(mesh, source))
    return np.load(path)


def errors(distance: np.ndarray, reference: np.ndarray) -> tuple[float, float]:
    """Return the mean relative error and the largest error over the diameter, in per cent."""
    away = reference > 0
    difference = np.abs(distance - reference)
    relative = difference[away] / reference[away]
    return 100 * float(relative.mean()), 100 * float(difference.max() / reference.max())


# -- methods ---------------------------------------------------------------------------------------


def methods(mesh: gt.TriangleMesh) -> dict[str, Method]:
    """Return each method on `mesh`, ready to be asked for a source."""
    vertices, faces = np.array(mesh.vertices), np.array(mesh.faces)
    ours, heat = gt.GeodesicSolver(mesh), gt.GeodesicSolver(mesh, refine=False)
    flipped = gt.CotanLaplacian(intrinsic_delaunay=True)
    delaunay = gt.GeodesicSolver(mesh, operator=flipped, refine=False)
    cloud = gt.GeodesicSolver(gt.PointCloud(vertices))
    plain = pp3d.MeshHeatMethodDistanceSolver(vertices, faces, use_robust=False)
    robust = pp3d.MeshHeatMethodDistanceSolver(vertices, faces, use_robust=True)
    marching = pp3d.MeshFastMarchingDistanceSolver(vertices, faces)
    libigl = igl.HeatGeodesicsData()
    igl.heat_geodesics_precompute(vertices, faces, libigl)
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    lengths = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    adjacency = coo_array((lengths, edges.T), shape=(len(vertices),) * 2).tocsr()
    return {
        "the default": ours.distance,
        "cloud": cloud.distance,
        "plain heat": heat.distance,
        "plain heat, intrinsic Delaunay": delaunay.distance,
        "potpourri3d": plain.compute_distance,
        "potpourri3d, robust": robust.compute_distance,
        "potpourri3d, fast marching": lambda s: marching.compute_distance([[(s, [])]]),
        "libigl heat": lambda s: igl.heat_geodesics_solve(libigl, np.array([s])),
        "edge Dijkstra": lambda s: dijkstra(adjacency, directed=False, indices=s),
    }


def asymmetry(mesh: gt.TriangleMesh) -> float:
    """Return the mean of |d(i, j) - d(j, i)| in per cent of the largest distance."""
    solver = gt.GeodesicSolver(mesh)
    rng = np.random.default_rng(0)
    pairs = np.array([rng.choice(mesh.n_vertices, 2, replace=False) for _ in range(PAIRS)])
    between, largest = np.empty((PAIRS, 2)), 0.0
    for start in range(0, PAIRS, 16):  # in blocks: rows are long
        block = pairs[start : start + 16]
        there, back = solver.distances(block[:, 0]), solver.distances(block[:, 1])
        rows = np.arange(len(block))
        between[start : start + 16] = np.column_stack(
            [there[rows, block[:, 1]], back[rows, block[:, 0]]]
        )
        largest = max(largest, there.max(), back.max())
    return 100 * float(np.abs(between[:, 0] - between[:, 1]).mean() / largest)


def side_by_side(files: dict[str, str], count: int | None) -> str:
    """Return the table of mean relative errors (and largest ones, of the diameter)."""
    results: dict[str, dict[str, np.ndarray]] = {}
    symmetry: dict[str, float] = {}
    for name, mesh, sources in meshes(files, count):
        ready = methods(mesh)
        runs: dict[str, list[tuple[float, float]]] = {method: [] for method in ready}
        for source in sources:
            reference = exact(mesh, source)
            for method, distance in ready.items():
                runs[method].append(errors(distance(source), reference))
        results[name] = {method: np.mean(pairs, axis=0) for method, pairs in runs.items()}
        symmetry[name] = asymmetry(mesh)
        for method, (mean, largest) in results[name].items():
            print(f"    {method:26s} mean {mean:6.3f} %   largest {largest:6.2f} %", flush=True)
        print(f"    asymmetry                  mean {symmetry[name]:6.3f} %", flush=True)
    names = list(next(iter(results.values())))
    rows = []
    for name, row in results.items():
        cells = [f"{mean:.3g} ({largest:.2g})" for mean, largest in row.values()]
        rows.append([name, *cells, f"{symmetry[name]:.2g}"])
    average = [np.mean([row[method] for row in results.values()], axis=0) for method in names]
    cells = [f"**{mean:.3g}** ({largest:.2g})" for mean, largest in average]
    rows.append(["**average**", *cells, f"{np.mean(list(symmetry.values())):.2g}"])
    return markdown(["mesh", *names, "asymmetry"], rows)


# -- the options of plain heat ---------------------------------------------------------------------

CHOICES: dict[str, dict] = {
    "plain heat": {},
    "time factor 0.25": {"time_factor": 0.25},
    "time factor 0.5": {"time_factor": 0.5},
    "time factor 0.8": {"time_factor": 0.8},
    "time factor 2": {"time_factor": 2.0},
    "time factor 4": {"time_factor": 4.0},
    "direction of ∇log u": {},
    "boundary average": {"boundary": "average"},
    "boundary dirichlet": {"boundary": "dirichlet"},
}


def along_log_heat(solver: gt.GeodesicSolver, source: int) -> np.ndarray:
    """Return the distance whose directions are those of ∇log u instead of ∇u."""
    method = solver.method
    gradient = method.metric.gradient
    slope = (gradient.matrix @ method.log_heat(source)).reshape(len(gradient.elements), -1)
    length = np.linalg.norm(slope, axis=1, keepdims=True)
    potential = method.integrate(-slope / np.where(length > 0, length, 1.0))
    return potential - potential[source]


def choices() -> str:
    """Return the table of the options of plain heat."""
    results: dict[str, list[float]] = {}
    for name, mesh, sources in meshes(BATTERY, 5):
        references = [exact(mesh, source) for source in sources]
        results[name] = []
        closed = not gt.GeodesicSolver(mesh).method.metric.boundary.any()
        for choice, options in CHOICES.items():
            if closed and "boundary" in options:  # no boundary: no difference
                results[name].append(results[name][0])
                continue
            solver = gt.GeodesicSolver(mesh, refine=False, **options)
            if "log" in choice:
                found = [along_log_heat(solver, source) for source in sources]
            else:
                found = list(solver.distances(sources))
            pairs = zip(found, references, strict=True)
            results[name].append(float(np.mean([errors(d, e)[0] for d, e in pairs])))
        print("   ", dict(zip(CHOICES, np.round(results[name], 3), strict=True)), flush=True)
    rows = [[name, *(f"{mean:.3g}" for mean in row)] for name, row in results.items()]
    average = np.mean(list(results.values()), axis=0)
    rows.append(["**average**", *(f"**{mean:.3g}**" for mean in average)])
    return markdown(["mesh", *CHOICES], rows)


# -- spheres, trust --------------------------------------------------------------------------------


def spheres() -> str:
    """Return the table of errors against the smooth sphere, with the order fitted to them."""
    rows, steps, means = [], [], []
    for level in (3, 4, 5, 6):
        mesh = gt.testing.shapes.icosphere(level)
        default, plain = gt.GeodesicSolver(mesh), gt.GeodesicSolver(mesh, refine=False)
        found: dict[str, list[float]] = {
            "the default": [],
            "plain heat": [],
            "exact on the polyhedron": [],
        }
        for source in (0, 200, 641):
            chord = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)
            smooth = 2 * np.arcsin(np.clip(chord / 2, 0, 1))
            found["the default"].append(errors(default.distance(source), smooth)[0])
            found["plain heat"].append(errors(plain.distance(source), smooth)[0])
            if level < 6:
                polyhedral = errors(exact(mesh, source), smooth)[0]
                found["exact on the polyhedron"].append(polyhedral)
        row = [float(np.mean(values)) if values else np.nan for values in found.values()]
        rows.append([str(mesh.n_vertices), *("-" if np.isnan(x) else f"{x:.4f}" for x in row)])
        steps.append(plain.method.metric.spacing)
        means.append(row)
        print(rows[-1], flush=True)
    orders = []
    for column in np.array(means).T:
        known = np.isfinite(column)
        orders.append(np.polyfit(np.log(np.array(steps)[known]), np.log(column[known]), 1)[0])
    rows.append(["**order**", *(f"**{order:.2f}**" for order in orders)])
    return markdown(["vertices", *found], rows)


def trust() -> str:
    """Return Spearman's correlation of the mean eikonal residual with the mean relative error."""
    kinds: dict[str, dict] = {"the default": {}, "plain heat": {"refine": False}}
    residuals: dict[str, list[float]] = {kind: [] for kind in kinds}
    true: dict[str, list[float]] = {kind: [] for kind in kinds}
    for _, mesh, sources in meshes(BATTERY, 5):
        for kind, measured in residuals.items():
            solver = gt.GeodesicSolver(mesh, **kinds[kind])
            for source in sources:
                distance = solver.distance(source)
                measured.append(mean_eikonal_residual(solver, distance))
                true[kind].append(errors(distance, exact(mesh, source))[0])
    residuals["both"] = residuals["the default"] + residuals["plain heat"]
    true["both"] = true["the default"] + true["plain heat"]
    rows = []
    for kind, found in residuals.items():
        means = np.array(found).reshape(-1, 5).mean(axis=1), np.reshape(true[kind], (-1, 5))
        by_mesh = spearmanr(means[0], means[1].mean(axis=1)).statistic
        rows.append([kind, f"{spearmanr(found, true[kind]).statistic:.2f}", f"{by_mesh:.2f}"])
    return markdown(["distances", "each source", "mean of each mesh"], rows)


# -- the command -----------------------------------------------------------------------------------


def markdown(headings: list[str], rows: list[list[str]]) -> str:
    """Return a table in Markdown."""
    lines = [headings, ["---"] * len(headings), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines) + "\n"


def main() -> None:
    """Run the benchmark of the command line."""
    tables: dict[str, tuple[Callable[[], str], str]] = {
        "battery": (lambda: side_by_side(BATTERY, 5), "eleven meshes, five sources each"),
        "choices": (choices, "options of plain heat"),
        "spheres": (spheres, "order of convergence on spheres"),
        "trust": (trust, "residual against error"),
    }
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    for name, (_, meaning) in tables.items():
        parser.add_argument(f"--{name}", action="store_true", help=meaning)
    parser.add_argument(
        "--write", action="store_true", help="write the tables into the documentation"
    )
    arguments = parser.parse_args()
    wanted = [name for name in tables if getattr(arguments, name)]
    warnings.simplefilter("ignore", gt.errors.GeodesicWarning)  # polygons, obtuse triangles: known
    for name in wanted or [""]:
        text = tables[name][0]() if name else side_by_side(FIRST, None)
        print("\n" + text, flush=True)
        if arguments.write:
            TABLES.mkdir(exist_ok=True)
            file = f"accuracy_{name}.md" if name else "accuracy.md"
            (TABLES / file).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
