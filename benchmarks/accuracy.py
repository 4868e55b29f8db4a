"""Errors against exact polyhedral distances on real meshes, other libraries beside ours in one run.

python benchmarks/accuracy.py                    the four meshes of the first table
python benchmarks/accuracy.py --battery          all eleven, five sources each
python benchmarks/accuracy.py --write            also into docs/_tables
"""

import argparse
import warnings
from collections.abc import Callable
from pathlib import Path

import igl
import numpy as np
import potpourri3d as pp3d
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra

import geodesic_toolkit as gt

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"
TABLES = ROOT / "docs" / "_tables"

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

Method = Callable[[int], np.ndarray]


def methods(mesh: gt.TriangleMesh) -> dict[str, Method]:
    """Return each method on `mesh`, ready to be asked for a source."""
    vertices, faces = np.array(mesh.vertices), np.array(mesh.faces)
    ours = gt.GeodesicSolver(mesh)
    delaunay = gt.GeodesicSolver(mesh, operator=gt.CotanLaplacian(intrinsic_delaunay=True))
    averaged = gt.GeodesicSolver(mesh, boundary="average")
    plain = pp3d.MeshHeatMethodDistanceSolver(vertices, faces, use_robust=False)
    robust = pp3d.MeshHeatMethodDistanceSolver(vertices, faces, use_robust=True)
    libigl = igl.HeatGeodesicsData()
    igl.heat_geodesics_precompute(vertices, faces, libigl)
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    lengths = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    adjacency = coo_array((lengths, edges.T), shape=(len(vertices),) * 2).tocsr()
    return {
        "ours": ours.distance,
        "ours, intrinsic Delaunay": delaunay.distance,
        "ours, averaged boundary": averaged.distance,
        "potpourri3d": plain.compute_distance,
        "potpourri3d, robust": robust.compute_distance,
        "libigl heat": lambda s: igl.heat_geodesics_solve(libigl, np.array([s])),
        "edge Dijkstra": lambda s: dijkstra(adjacency, directed=False, indices=s),
    }


def compact(mesh: gt.TriangleMesh) -> gt.TriangleMesh:
    """Return the largest component alone: other libraries cannot say `inf`."""
    edges = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]]])
    graph = coo_array((np.ones(len(edges)), edges.T), shape=(mesh.n_vertices,) * 2)
    labels = connected_components(graph, directed=False)[1]
    keep = labels == np.bincount(labels[mesh.faces[:, 0]]).argmax()
    renumbered = np.cumsum(keep) - 1
    return gt.TriangleMesh(mesh.vertices[keep], renumbered[mesh.faces[keep[mesh.faces[:, 0]]]])


def spread_sources(mesh: gt.TriangleMesh, count: int) -> list[int]:
    """Return `count` sources, each the farthest from those before it."""
    solver = gt.GeodesicSolver(mesh)
    sources = [int(np.argmax(solver.distance(0)))]
    while len(sources) < count:
        sources.append(int(np.argmax(np.min(solver.distances(sources), axis=0))))
    return sources


def errors(distance: np.ndarray, exact: np.ndarray) -> tuple[float, float]:
    """Return the mean relative error and the largest error over the diameter, in per cent."""
    away = exact > 0
    relative = np.abs(distance - exact)[away] / exact[away]
    return 100 * float(relative.mean()), 100 * float(np.abs(distance - exact).max() / exact.max())


def table(meshes: dict[str, str], count: int | None) -> str:
    """Return the Markdown table of mean relative errors (and largest ones, of the diameter)."""
    results: dict[str, dict[str, np.ndarray]] = {}
    for name, file in meshes.items():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # polygons are triangulated: known
            mesh = compact(gt.read(DATA / file))
        sources = list(FIRST_SOURCES) if count is None else spread_sources(mesh, count)
        runs: dict[str, list[tuple[float, float]]] = {}
        ready = methods(mesh)
        for source in sources:
            exact = gt.exact_distance(mesh, source)
            for method, distance in ready.items():
                runs.setdefault(method, []).append(errors(distance(source), exact))
        results[name] = {method: np.mean(pairs, axis=0) for method, pairs in runs.items()}
        print(f"{name}: {mesh.n_vertices} vertices, sources {sources}", flush=True)
        for method, (mean, largest) in results[name].items():
            print(f"    {method:26s} mean {mean:6.3f} %   largest {largest:6.2f} %", flush=True)
    rows = [f"| mesh | {' | '.join(next(iter(results.values())))} |"]
    rows.append("|" + "---|" * (rows[0].count("|") - 1))
    for name, row in results.items():
        cells = [f"{mean:.2f} ({largest:.1f})" for mean, largest in row.values()]
        rows.append(f"| {name} | {' | '.join(cells)} |")
    average = [np.mean([row[method] for row in results.values()], axis=0) for method in ready]
    cells = [f"**{mean:.2f}** ({largest:.1f})" for mean, largest in average]
    rows.append(f"| **average** | {' | '.join(cells)} |")
    return "\n".join(rows) + "\n"


def main() -> None:
    """Run the benchmark of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--battery", action="store_true", help="eleven meshes, five sources each")
    parser.add_argument(
        "--write", action="store_true", help="write the table into the documentation"
    )
    arguments = parser.parse_args()
    text = table(BATTERY, 5) if arguments.battery else table(FIRST, None)
    print("\n" + text)
    if arguments.write:
        TABLES.mkdir(exist_ok=True)
        name = "accuracy_battery.md" if arguments.battery else "accuracy.md"
        (TABLES / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
