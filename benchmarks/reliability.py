"""Count the right answers of several libraries on every file of ../shared/data.

Each call, one library from one source, is a process of its own with a time limit: a crash or a hang
is recorded as an outcome. Sources are the middle vertices of every component of ten vertices or
more, and of the largest of each file. docs/reliability.md has the criteria of a right answer.

python benchmarks/reliability.py                     everything, about half an hour
python benchmarks/reliability.py bunny truck         files whose names hold one of these words
python benchmarks/reliability.py --limit 60          seconds a call may take
python benchmarks/reliability.py --write             also into docs/_tables
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"
TABLE = ROOT / "docs" / "_tables" / "reliability.md"

SMALLEST = 10
"""Vertices of a component from which on a distance is asked for."""

LARGE = 500
"""Vertices of a component from which on its error counts in the summary."""

NEIGHBOURS = 8
"""Edges of a cloud for Dijkstra's algorithm lead to that many nearest points."""


# -- the libraries, each called in a process of its own --------------------------------------------


def ours(shape: Any, source: int, **options: Any) -> np.ndarray:
    """Return the distance of this package; `shape` is a dictionary of arrays."""
    import geodesic_toolkit as gt

    faces = shape.get("faces")
    domain = (
        gt.PointCloud(shape["vertices"])
        if faces is None
        else gt.TriangleMesh(shape["vertices"], faces)
    )
    return gt.geodesic_distance(domain, source, **options)


def exact(shape: Any, source: int) -> np.ndarray:
    """Return the exact polyhedral distance, for meshes on which the algorithm works."""
    import geodesic_toolkit as gt

    return gt.exact_distance(gt.TriangleMesh(shape["vertices"], shape["faces"]), source)


def potpourri3d(shape: Any, source: int) -> np.ndarray:
    """Return potpourri3d's distance, on meshes with its robust option."""
    import potpourri3d as pp3d

    if shape.get("faces") is None:
        return pp3d.PointCloudHeatSolver(shape["vertices"]).compute_distance(source)
    solver = pp3d.MeshHeatMethodDistanceSolver(shape["vertices"], shape["faces"], use_robust=True)
    return solver.compute_distance(source)


def libigl(shape: Any, source: int) -> np.ndarray:
    """Return the distance of libigl's heat method."""
    import igl

    data = igl.HeatGeodesicsData()
    igl.heat_geodesics_precompute(shape["vertices"], shape["faces"], data)
    return igl.heat_geodesics_solve(data, np.array([source]))


def pymeshlab(shape: Any, source: int) -> np.ndarray:
    """Return MeshLab's distance: its front walks edges and unfolds a triangle at a time."""
    import pymeshlab as ml

    meshes = ml.MeshSet()
    meshes.add_mesh(ml.Mesh(vertex_matrix=shape["vertices"], face_matrix=shape["faces"]))
    meshes.compute_scalar_by_geodesic_distance_from_given_point_per_vertex(
        startpoint=shape["vertices"][source],
        maxdistance=ml.PureValue(1e3 * float(np.ptp(shape["vertices"], axis=0).max())),
    )
    return np.asarray(meshes.current_mesh().vertex_scalar_array())


Call = Callable[[Any, int], np.ndarray]

LIBRARIES: dict[str, Call] = {
    "ours": ours,
    "ours, plain heat": lambda shape, source: ours(shape, source, refine=False),
    "potpourri3d": potpourri3d,
    "libigl": libigl,
    "pymeshlab": pymeshlab,
}
"""By the name of the column."""

MESHES_ONLY = ("libigl", "pymeshlab")


def call(library: str, arrays: Path, source: int, answer: Path) -> None:
    """Run in the process of one call: write the answer, or its error, to a file."""
    function = {**LIBRARIES, "exact": exact}[library]
    shape = dict(np.load(arrays).items())
    started = time.perf_counter()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            distance = function(shape, source)
        except Exception as error:  # how a library fails is what is measured
            answer.with_suffix(".json").write_text(
                json.dumps({"error": f"{type(error).__name__}: {error}"})
            )
            return
    seconds = time.perf_counter() - started
    said = sorted({type(warning.message).__name__ for warning in caught})
    said = [name for name in said if name != "DeprecationWarning"]
    np.save(answer, np.asarray(distance, dtype=np.float64))
    answer.with_suffix(".json").write_text(json.dumps({"seconds": seconds, "warnings": said}))


# -- what is asked of an answer --------------------------------------------------------------------


@dataclass
class Shape:
    """A file as all libraries see it, with what answers are judged by."""

    name: str
    arrays: Path
    vertices: np.ndarray
    faces: np.ndarray | None
    labels: np.ndarray
    graph: csr_array

    def components(self) -> list[np.ndarray]:
        """Return the vertices of every component that is large enough, largest first."""
        sizes = np.bincount(self.labels)
        by_size = np.argsort(-sizes, kind="stable")
        chosen = [c for c in by_size if sizes[c] >= SMALLEST] or [by_size[0]]
        return [np.flatnonzero(self.labels == c) for c in chosen]


def load(path: Path, folder: Path) -> Shape:
    """Read a file with this package and put its arrays where the calls find them."""
    import geodesic_toolkit as gt

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # polygons are triangulated: known
        domain = gt.read(path)
    arrays = folder / f"{path.name}.npz"
    if isinstance(domain, gt.TriangleMesh):
        vertices, faces = np.array(domain.vertices), np.array(domain.faces)
        np.savez(arrays, vertices=vertices, faces=faces)
        ends = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        graph = as_graph(vertices, ends)
        return Shape(path.name, arrays, vertices, faces, components_of(graph), graph)
    points = np.array(domain.points)
    np.savez(arrays, vertices=points)
    metric = gt.operators["pointcloud"]().assemble(gt.PointCloud(points))
    graph = as_graph(points, nearest(points))
    return Shape(path.name, arrays, points, None, np.array(metric.components), graph)


def nearest(points: np.ndarray) -> np.ndarray:
    """Return edges from every point to its nearest neighbours and to its duplicates."""
    from scipy.spatial import cKDTree

    present = np.flatnonzero(np.isfinite(points).all(axis=1))
    places, first, place = np.unique(
        points[present], axis=0, return_index=True, return_inverse=True
    )
    count = min(NEIGHBOURS + 1, len(places))
    near = cKDTree(places).query(places, k=count)[1].reshape(len(places), count)
    spokes = np.column_stack([np.repeat(near[:, 0], count - 1), near[:, 1:].ravel()])
    ties = np.column_stack([first[place.ravel()], np.arange(len(present))])
    return present[np.concatenate([first[spokes], ties[ties[:, 0] != ties[:, 1]]])]


def as_graph(vertices: np.ndarray, ends: np.ndarray) -> csr_array:
    """Return the edge lengths as a symmetric matrix; edges of no length get a tiny one."""
    ends = np.unique(np.sort(ends, axis=1), axis=0)
    ends = ends[ends[:, 0] != ends[:, 1]]
    lengths = np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1)
    lengths = np.maximum(lengths, 1e-12 * lengths.mean())
    shape = (len(vertices), len(vertices))
    return csr_array(coo_array((lengths, ends.T), shape=shape))


def components_of(graph: csr_array) -> np.ndarray:
    return connected_components(graph, directed=False)[1]


@dataclass
class Outcome:
    """The outcome of one call."""

    fault: str | None
    error: float | None = None
    infinite_elsewhere: bool | None = None
    below: bool | None = None
    warnings: tuple[str, ...] = ()
    size: int = 0


def judge(shape: Shape, members: np.ndarray, distance: np.ndarray, walk: np.ndarray) -> Outcome:
    """Return what is wrong with an answer, if anything; `walk` is Dijkstra's distance."""
    source = members[len(members) // 2]
    if distance.shape != (len(shape.vertices),):
        return Outcome(f"{len(distance)} values for {len(shape.vertices)} vertices")
    own = distance[members]
    rows = shape.graph[members]
    spacing = float(rows.data.mean()) if rows.nnz else 0.0
    others = np.ones(len(distance), dtype=bool)
    others[members] = False
    infinite = bool(np.isinf(distance[others]).all()) if others.any() else None
    if not np.isfinite(own).all():
        return Outcome(f"{(~np.isfinite(own)).sum()} not finite", None, infinite)
    if (own < -1e-9 * spacing).any():
        return Outcome(f"{(own < -1e-9 * spacing).sum()} negative", None, infinite)
    straight = np.linalg.norm(shape.vertices[members] - shape.vertices[source], axis=1)
    low = own < 0.8 * straight - 2 * spacing
    high = own > 3 * walk[members] + 2 * spacing
    share = float((low | high).mean())
    if share > 0.01:
        return Outcome(f"{share:.0%} out of bounds ({low.mean():.0%} low)", None, infinite)
    return Outcome(None, None, infinite)


def below_straight(shape: Shape, members: np.ndarray, distance: np.ndarray) -> bool | None:
    """Return whether a vertex is nearer than the straight line, by more than rounding."""
    if distance.shape != (len(shape.vertices),) or not np.isfinite(distance[members]).all():
        return None
    source = members[len(members) // 2]
    straight = np.linalg.norm(shape.vertices[members] - shape.vertices[source], axis=1)
    return bool((distance[members] < straight - 1e-9 * straight.max()).any())


# -- running the calls -----------------------------------------------------------------------------


def ask(
    library: str, shape: Shape, source: int, limit: float, folder: Path
) -> tuple[np.ndarray | None, str, tuple[str, ...]]:
    """Return the answer of one call, or None and what happened, and the warnings on the way."""
    answer = folder / f"{shape.name}-{library.replace(', ', '-')}-{source}.npy"
    command = [sys.executable, __file__, "--call", library, str(shape.arrays), str(source)]
    try:
        done = subprocess.run(
            [*command, str(answer)], capture_output=True, timeout=limit, check=False
        )
    except subprocess.TimeoutExpired:
        return None, f"no answer in {limit:.0f} s", ()
    note = answer.with_suffix(".json")
    if not note.exists():
        return None, f"crash (exit status {done.returncode})", ()
    told = json.loads(note.read_text())
    if "error" in told:
        return None, told["error"], ()
    distance = np.load(answer)
    answer.unlink()
    return distance, "", tuple(told["warnings"])


def reference(
    shape: Shape, source: int, walk: np.ndarray, limit: float, folder: Path
) -> np.ndarray | None:
    """Return the exact distance if it lies between the straight line and the path along edges."""
    if shape.faces is None:
        return None
    found, _, _ = ask("exact", shape, source, limit, folder)
    if found is None:
        return None
    own = np.isfinite(walk)
    straight = np.linalg.norm(shape.vertices - shape.vertices[source], axis=1)
    slack = 1e-6 * walk[own].max()
    sound = (found[own] <= walk[own] + slack).all() and (found[own] >= straight[own] - slack).all()
    return found if sound else None


def examine(path: Path, limit: float, folder: Path, jobs: int) -> dict[str, list[Outcome]]:
    """Return the outcomes of every library on one file, one a component."""
    shape = load(path, folder)
    outcomes: dict[str, list[Outcome]] = {}
    for members in shape.components():
        source = int(members[len(members) // 2])
        walk = dijkstra(shape.graph, directed=False, indices=source)
        libraries = [x for x in LIBRARIES if shape.faces is not None or x not in MESHES_ONLY]
        with ThreadPoolExecutor(jobs) as pool:
            truth = pool.submit(reference, shape, source, walk, limit, folder)
            running = {x: pool.submit(ask, x, shape, source, limit, folder) for x in libraries}
        answers = {library: future.result() for library, future in running.items()}
        known = truth.result()
        for library, (distance, trouble, said) in answers.items():
            if distance is None:
                outcome = Outcome(trouble)
            else:
                outcome = judge(shape, members, distance, walk)
                outcome.below = below_straight(shape, members, distance)
                if known is not None and distance.shape == known.shape:
                    away = members[known[members] > 0]
                    relative = np.abs(distance[away] - known[away]) / known[away]
                    outcome.error = 100 * float(relative.mean())
                    limit_error = 5.0 if library == "ours" else np.inf
                    if outcome.fault is None and not outcome.error <= limit_error:
                        outcome.fault = f"{outcome.error:.1f} % off"
            outcome.warnings, outcome.size = said, len(members)
            outcomes.setdefault(library, []).append(outcome)
            print(
                f"{path.name:45s} {len(members):7d} {library:14s} "
                f"{'-' if outcome.error is None else f'{outcome.error:.2f} %':>9s} "
                f"{outcome.fault or 'right'}{' ' if said else ''}{', '.join(said)}",
                flush=True,
            )
    shape.arrays.unlink()
    return outcomes


# -- the table -------------------------------------------------------------------------------------


def cell(outcomes: list[Outcome] | None) -> str:
    """Return how many answers are right, their median error, and what is wrong with the others."""
    if not outcomes:
        return "-"
    right = [outcome for outcome in outcomes if outcome.fault is None]
    text = f"{len(right)}/{len(outcomes)}"
    errors = [outcome.error for outcome in right if outcome.error is not None]
    if errors:
        text += f", {np.median(errors):.2f} %"
    faults = sorted({outcome.fault for outcome in outcomes if outcome.fault is not None})
    if faults:
        text += f" ({faults[0][:60].replace('|', '/')}{', ...' if len(faults) > 1 else ''})"
    return text


def table(results: dict[str, dict[str, list[Outcome]]]) -> str:
    """Return the Markdown table of all files, and the summary beneath it."""
    names = list(LIBRARIES)
    rows = [f"| file | components | {' | '.join(names)} |", "|" + "---|" * (len(names) + 2)]
    for name, outcomes in results.items():
        cells = [cell(outcomes.get(library)) for library in names]
        count = len(next(iter(outcomes.values()), []))
        rows.append(f"| {name} | {count} | {' | '.join(cells)} |")
    every = {
        library: [o for outcomes in results.values() for o in outcomes.get(library, [])]
        for library in names
    }
    summary = {
        "right": lambda o: f"{sum(x.fault is None for x in o)} of {len(o)}",
        "`inf` where no source connects": lambda o: (
            f"{sum(x.infinite_elsewhere is True for x in o)} of "
            f"{sum(x.infinite_elsewhere is not None for x in o)}"
        ),
        "nothing below the straight line": lambda o: (
            f"{sum(x.below is False for x in o)} of {sum(x.below is not None for x in o)}"
        ),
        f"error, components of {LARGE} vertices or more: median": lambda o: quantile(o, 0.5),
        "... 90th percentile": lambda o: quantile(o, 0.9),
        "... largest": lambda o: quantile(o, 1.0),
    }
    rows += ["", f"| all files | {' | '.join(names)} |", "|" + "---|" * (len(names) + 1)]
    rows += [
        f"| {title} | {' | '.join(figure(every[library]) for library in names)} |"
        for title, figure in summary.items()
    ]
    return "\n".join(rows) + "\n"


def quantile(outcomes: list[Outcome], share: float) -> str:
    """Return a quantile of the errors over large components; no answer counts as infinitely bad."""
    compared = [outcome for outcome in outcomes if outcome.size >= LARGE]
    errors = [outcome.error for outcome in compared if outcome.error is not None]
    errors = [error for error in errors if np.isfinite(error)]
    return f"{np.quantile(errors, share):.2f} % of {len(errors)}" if errors else "-"


def main() -> None:
    """Run the benchmark of the command line."""
    if sys.argv[1:2] == ["--call"]:
        library, arrays, source, answer = sys.argv[2:]
        call(library, Path(arrays), int(source), Path(answer))
        return
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("words", nargs="*", help="parts of file names")
    parser.add_argument("--limit", type=float, default=300.0, help="seconds a call may take")
    parser.add_argument("--jobs", type=int, default=2, help="calls at once")
    parser.add_argument("--write", action="store_true", help="write the table into the docs")
    arguments = parser.parse_args()
    files = sorted((p for p in DATA.iterdir() if p.suffix != ".md"), key=lambda p: p.stat().st_size)
    if arguments.words:
        files = [path for path in files if any(word in path.name for word in arguments.words)]
    results = {}
    with tempfile.TemporaryDirectory() as folder:
        for path in files:
            results[path.name] = examine(path, arguments.limit, Path(folder), arguments.jobs)
            if arguments.write:
                TABLE.write_text(table(results), encoding="utf-8")
    print("\n" + table(results))


if __name__ == "__main__":
    main()
