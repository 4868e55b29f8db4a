"""Loops and paths beside potpourri3d, in one run: their lengths and the CPU time of each.

python benchmarks/heat_family_curves.py            two meshes, 220 paths and 40 loops each
python benchmarks/heat_family_curves.py --few      a quarter of it

Real meshes come from ../shared/data, or the folder that GT_DATA names. A loop is laid along edges
through four random vertices. For a loop that contracts potpourri3d returns a curve that
goes there and back along an edge or two, or around a single vertex; ours is an error then.
"""

import argparse
import os
from pathlib import Path

import numpy as np
import potpourri3d as pp3d
from measuring.clocks import clocked
from measuring.tables import markdown

import geodesic_toolkit as gt
from geodesic_toolkit.errors import ContractibleLoopError

DATA = Path(os.environ.get("GT_DATA", Path(__file__).resolve().parents[2] / "shared" / "data"))
MESHES = ("igltut__3holes.off", "igltut__bunny.off")
SAME = 1e-9
"""Relative difference within which two lengths are the same."""


def length_of(points: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def our_loop(solver: gt.GeodesicSolver, stops: list[int]) -> float:
    """Return the length of our loop, 0 where it contracts."""
    try:
        return gt.geodesic_loop(solver, stops).length
    except ContractibleLoopError:
        return 0.0


def loops(mesh: gt.TriangleMesh, count: int) -> dict[str, float]:
    """Return how loops through four vertices compare."""
    peer = pp3d.EdgeFlipGeodesicSolver(np.array(mesh.vertices), np.array(mesh.faces))
    solver = gt.GeodesicSolver(mesh)
    rng = np.random.default_rng(1)
    rows = []
    for _ in range(count):
        stops = rng.choice(mesh.n_vertices, 4, replace=False).tolist()
        ours, own = clocked(lambda stops=stops: our_loop(solver, stops))
        theirs, line = clocked(lambda stops=stops: peer.find_geodesic_loop(stops))
        rows.append((own, length_of(line), 1e3 * ours["cpu"], 1e3 * theirs["cpu"]))
    own, other, ours_ms, theirs_ms = np.array(rows).T
    excess = own / other - 1
    return {
        "loops": count,
        "contracted": int((own == 0).sum()),
        "the same": int((abs(excess) <= SAME).sum()),
        "shorter": int((excess < -SAME).sum() - (own == 0).sum()),
        "longer": int((excess > SAME).sum()),
        "worst %": 100 * max(float(excess.max()), 0.0),
        "ms": float(np.median(ours_ms)),
        "ms most": float(ours_ms.max()),
        "ms pp3d": float(np.median(theirs_ms)),
    }


def paths(mesh: gt.TriangleMesh, count: int) -> dict[str, float]:
    """Return how far paths from one vertex are over the exact distance."""
    peer = pp3d.EdgeFlipGeodesicSolver(np.array(mesh.vertices), np.array(mesh.faces))
    solver = gt.GeodesicSolver(mesh)
    source = mesh.n_vertices // 3
    exact = gt.exact_distance(mesh, source)
    targets = np.random.default_rng(0).choice(mesh.n_vertices, count, replace=False).tolist()
    rows = []
    for target in targets:
        ours, path = clocked(lambda target=target: gt.geodesic_path(solver, source, target))
        theirs, line = clocked(lambda target=target: peer.find_geodesic_path(source, target))
        own, other = path.length / exact[target] - 1, length_of(line) / exact[target] - 1
        rows.append((100 * own, 100 * other, 1e3 * ours["cpu"], 1e3 * theirs["cpu"]))
    own, other, ours_ms, theirs_ms = np.array(rows).T
    return {
        "paths": count,
        "over exact, mean %": float(own.mean()),
        "most %": float(own.max()),
        "pp3d, mean %": float(other.mean()),
        "pp3d, most %": float(other.max()),
        "ms": float(np.median(ours_ms)),
        "ms pp3d": float(np.median(theirs_ms)),
    }


def paths_of_pairs(mesh: gt.TriangleMesh, count: int) -> dict[str, float]:
    """Return the time of paths between random vertices, and of a second path from each source."""
    peer = pp3d.EdgeFlipGeodesicSolver(np.array(mesh.vertices), np.array(mesh.faces))
    solver = gt.GeodesicSolver(mesh)
    gt.geodesic_path(solver, 0, 1)  # prepares the mesh
    rng = np.random.default_rng(3)
    rows = []
    for _ in range(count):
        a, b, c = rng.choice(mesh.n_vertices, 3, replace=False).tolist()
        first, path = clocked(lambda a=a, b=b: gt.geodesic_path(solver, a, b))
        second, _ = clocked(lambda a=a, c=c: gt.geodesic_path(solver, a, c))
        theirs, line = clocked(lambda a=a, b=b: peer.find_geodesic_path(a, b))
        times = (1e3 * each["cpu"] for each in (first, second, theirs))
        rows.append((path.length / length_of(line) - 1, *times))
    excess, pair_ms, same_ms, theirs_ms = np.array(rows).T
    return {
        "pairs": count,
        "the same": int((abs(excess) <= SAME).sum()),
        "shorter": int((excess < -SAME).sum()),
        "longer": int((excess > SAME).sum()),
        "ms": float(np.median(pair_ms)),
        "ms, source kept": float(np.median(same_ms)),
        "ms pp3d": float(np.median(theirs_ms)),
    }


def paths_via(mesh: gt.TriangleMesh, count: int) -> dict[str, float]:
    """Return how paths on the side of a third vertex compare."""
    peer = pp3d.EdgeFlipGeodesicSolver(np.array(mesh.vertices), np.array(mesh.faces))
    solver = gt.GeodesicSolver(mesh)
    rng = np.random.default_rng(2)
    rows = []
    for _ in range(count):
        a, via, b = rng.choice(mesh.n_vertices, 3, replace=False).tolist()
        ours, path = clocked(lambda a=a, via=via, b=b: gt.geodesic_path(solver, a, b, via=[via]))
        theirs, line = clocked(lambda a=a, via=via, b=b: peer.find_geodesic_path_poly([a, via, b]))
        rows.append((path.length / length_of(line) - 1, 1e3 * ours["cpu"], 1e3 * theirs["cpu"]))
    excess, ours_ms, theirs_ms = np.array(rows).T
    return {
        "paths via": count,
        "the same": int((abs(excess) <= SAME).sum()),
        "shorter": int((excess < -SAME).sum()),
        "longer": int((excess > SAME).sum()),
        "worst %": 100 * max(float(excess.max()), 0.0),
        "ms": float(np.median(ours_ms)),
        "ms pp3d": float(np.median(theirs_ms)),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--few", action="store_true", help="a quarter of the loops and paths")
    share = 4 if parser.parse_args().few else 1
    meshes = [gt.read(DATA / name) for name in MESHES]
    for compare, count, note in (
        (loops, 40, "Loops laid through four vertices each."),
        (paths, 60, "Lengths over the exact distance."),
        (paths_of_pairs, 120, "Paths between random vertices, and a second one from the source."),
        (paths_via, 40, "Paths laid over a third vertex."),
    ):
        found = [compare(mesh, count // share) for mesh in meshes]
        rows = [
            [name, *(f"{value:.4g}" for value in row.values())]
            for name, row in zip(MESHES, found, strict=True)
        ]
        print(markdown(["mesh", *found[0]], rows, note))


if __name__ == "__main__":
    main()
