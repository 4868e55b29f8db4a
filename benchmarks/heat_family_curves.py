"""Loops and paths beside potpourri3d, in one run: their lengths and the CPU time of each.

python benchmarks/heat_family_curves.py                two meshes, 100 paths and 40 loops each
python benchmarks/heat_family_curves.py --few          a quarter of it
python benchmarks/heat_family_curves.py --parts loops  some of the parts

Real meshes come from ../shared/data, or the folder that GT_DATA names. A loop is laid along edges
through four random vertices. For a loop that contracts potpourri3d returns a curve that
goes there and back along an edge or two, or around a single vertex; ours is an error then.
"""

import os
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import potpourri3d as pp3d
from measuring.clocks import clocked
from measuring.figures import Row, parser, report

import geodesic_toolkit as gt
from geodesic_toolkit.errors import ContractibleLoopError

DATA = Path(os.environ.get("GT_DATA", Path(__file__).resolve().parents[2] / "shared" / "data"))
MESHES = ("igltut__3holes.off", "igltut__bunny.off")
SAME = 1e-9
"""Relative difference within which two lengths are the same."""

BOUNDS = {"longer": 0.0, "longest, % over": 100 * SAME}


def length_of(points: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def our_loop(solver: gt.GeodesicSolver, stops: list[int]) -> float:
    """Return the length of our loop, 0 where it contracts."""
    try:
        return gt.geodesic_loop(solver, stops).length
    except ContractibleLoopError:
        return 0.0


def compared(own: np.ndarray, other: np.ndarray) -> Iterator[tuple[str, float]]:
    """Yield how many of our lengths are the same, shorter and longer, and by how much at most."""
    excess = own / other - 1
    yield "the same", float((abs(excess) <= SAME).sum())
    yield "shorter", float(((excess < -SAME) & (own > 0)).sum())
    yield "longer", float((excess > SAME).sum())
    yield "longest, % over", 100 * max(float(excess.max()), 0.0)


def loops(mesh: gt.TriangleMesh, name: str, count: int) -> Iterator[Row]:
    """Yield how loops through four vertices compare."""
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
    what = f"{count} loops, {name}"
    yield Row(f"{what}: contracted", float((own == 0).sum()))
    for figure, value in compared(own, other):
        yield Row(f"{what}: {figure}", value, BOUNDS.get(figure))
    yield from times(what, ours_ms, theirs_ms)


def paths(mesh: gt.TriangleMesh, name: str, count: int) -> Iterator[Row]:
    """Yield how far paths from one vertex are over the exact distance."""
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
    what = f"{count} paths, {name}"
    yield Row(f"{what}: mean, % over exact", float(own.mean()), peer=float(other.mean()))
    yield Row(f"{what}: most, % over exact", float(own.max()), peer=float(other.max()))
    yield from times(what, ours_ms, theirs_ms, bound=1.0)


def paths_via(mesh: gt.TriangleMesh, name: str, count: int) -> Iterator[Row]:
    """Yield how paths on the side of a third vertex compare."""
    peer = pp3d.EdgeFlipGeodesicSolver(np.array(mesh.vertices), np.array(mesh.faces))
    solver = gt.GeodesicSolver(mesh)
    rng = np.random.default_rng(2)
    rows = []
    for _ in range(count):
        a, via, b = rng.choice(mesh.n_vertices, 3, replace=False).tolist()
        ours, path = clocked(lambda a=a, via=via, b=b: gt.geodesic_path(solver, a, b, via=[via]))
        theirs, line = clocked(lambda a=a, via=via, b=b: peer.find_geodesic_path_poly([a, via, b]))
        rows.append((path.length, length_of(line), 1e3 * ours["cpu"], 1e3 * theirs["cpu"]))
    own, other, ours_ms, theirs_ms = np.array(rows).T
    what = f"{count} paths via a vertex, {name}"
    for figure, value in compared(own, other):
        yield Row(f"{what}: {figure}", value, BOUNDS.get(figure))
    yield from times(what, ours_ms, theirs_ms)


def times(
    what: str, ours: np.ndarray, theirs: np.ndarray, bound: float | None = None
) -> Iterator[Row]:
    """Yield median CPU times."""
    yield Row(f"{what}: ms each", float(np.median(ours)), bound, peer=float(np.median(theirs)))


def on_meshes(compare: Callable[..., Iterator[Row]], count: int) -> Iterator[Row]:
    """Yield the rows of both meshes."""
    for file in MESHES:
        yield from compare(gt.read(DATA / file), Path(file).stem.partition("__")[2], count)


def main() -> None:
    options = parser(__doc__)
    options.add_argument("--few", action="store_true", help="a quarter of the loops and paths")
    given = options.parse_args()
    share = 4 if given.few else 1
    parts = {
        "loops": partial(on_meshes, loops, 40 // share),
        "paths": partial(on_meshes, paths, 60 // share),
        "via": partial(on_meshes, paths_via, 40 // share),
    }
    report(parts, given)


if __name__ == "__main__":
    main()
