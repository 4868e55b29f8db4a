"""Measure all pairs of a sphere by ``matrix``: uninterrupted, and interrupted and resumed.

Each command is a process of its own, interrupted as by Ctrl-C. Stores are compared file by file.

python benchmarks/many_sources.py                 10,242 vertices, float32, zarr
python benchmarks/many_sources.py --level 4       2,562
python benchmarks/many_sources.py --write         also into docs
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from measuring.machine import machine, sentence
from measuring.tables import TABLES, gigabytes, markdown, save, seconds

import geodesic_toolkit as gt

RESULTS = TABLES / "many_sources.json"

HEADINGS = ["", "CPU", "clock", "peak memory", "rows done"]


def command(path: Path, out: Path, options: list[str], *, until: float = 1.0) -> dict[str, Any]:
    """Run the command, up to a share of the tasks, and return what it took and its exit status."""
    words = [sys.executable, "-m", "geodesic_toolkit", "matrix", str(path), "--output", str(out)]
    begin = time.perf_counter()
    process = subprocess.Popen([*words, "--float32", *options], stdout=subprocess.DEVNULL)
    done = out.with_name(f"{out.name}.partial") / "done"
    while until < 1 and process.poll() is None and share(done) < until:
        time.sleep(0.02)
    if until < 1:
        process.send_signal(signal.SIGINT)
    _, status, usage = os.wait4(process.pid, 0)
    return {
        "status": os.waitstatus_to_exitcode(status),
        "clock": time.perf_counter() - begin,
        "cpu": usage.ru_utime + usage.ru_stime,
        "memory": 1024 * usage.ru_maxrss,
        "done": share(done) if until < 1 else 1.0,
    }


def share(done: Path) -> float:
    """Return how much of a matrix is on disk."""
    marks = done.read_bytes() if done.exists() else b""
    return sum(marks) / len(marks) if marks else 0.0


def contents(store: Path) -> dict[str, bytes]:
    """Return every file of a store."""
    files = sorted(path for path in store.rglob("*") if path.is_file())
    return {str(path.relative_to(store)): path.read_bytes() for path in files}


def write_off(path: Path, mesh: gt.TriangleMesh) -> Path:
    """Write a mesh with all digits."""
    with path.open("w", encoding="ascii") as file:
        file.write(f"OFF\n{mesh.n_vertices} {mesh.n_faces} 0\n")
        file.writelines(" ".join(map(repr, row)) + "\n" for row in mesh.vertices.tolist())
        file.writelines(f"3 {a} {b} {c}\n" for a, b, c in mesh.faces.tolist())
    return path


def measure(level: int, options: list[str], folder: Path) -> dict[str, Any]:
    """Return the figures of all runs, and whether they ended in the same bytes."""
    mesh = gt.testing.shapes.icosphere(level)
    path = write_off(folder / "sphere.off", mesh)
    whole, resumed, shared = (folder / f"{name}.zarr" for name in ("whole", "resumed", "shared"))
    runs = {"uninterrupted": command(path, whole, options)}
    runs["interrupted"] = command(path, resumed, options, until=0.5)
    runs["resumed"] = command(path, resumed, options)
    runs["uninterrupted, two workers"] = command(path, shared, [*options, "--workers", "2"])
    expected = contents(whole)
    return {
        "vertices": mesh.n_vertices,
        "options": " ".join(options),
        "runs": runs,
        "bytes": sum(map(len, expected.values())),
        "same": contents(resumed) == expected and contents(shared) == expected,
        "error": error(mesh, whole),
        "machine": machine(),
    }


def error(mesh: gt.TriangleMesh, store: Path) -> float:
    """Return the mean relative error of some rows against the arc on the unit sphere."""
    import zarr

    rows = np.linspace(0, mesh.n_vertices - 1, 16).astype(int)
    found = zarr.open_array(store, mode="r").oindex[rows, slice(None)]
    arcs = np.arccos(np.clip(mesh.vertices[rows] @ mesh.vertices.T, -1, 1))
    away = arcs > 1e-6
    return float((np.abs(found - arcs)[away] / arcs[away]).mean())


def table(found: dict[str, Any]) -> str:
    """Return the figures as Markdown."""
    rows = [
        [
            name,
            seconds(run["cpu"]),
            seconds(run["clock"]),
            gigabytes(run["memory"]),
            f"{run['done']:.0%}",
        ]
        for name, run in found["runs"].items()
    ]
    bytes_ = "the same" if found["same"] else "**different**"
    note = (
        f"{found['vertices']:,} x {found['vertices']:,} distances, {gigabytes(found['bytes'])} of "
        f"compressed float32 (`{found['options']}`); all three stores hold {bytes_} bytes. Mean "
        f"error against the arc: {100 * found['error']:.2g} %. {sentence(found['machine']).strip()}"
    )
    return markdown(HEADINGS, rows, note)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--level", type=int, default=5, help="subdivisions of the icosahedron")
    parser.add_argument("--solver", default="auto", help="linear solver")
    parser.add_argument("--write", action="store_true", help="write the table into docs")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = measure(arguments.level, ["--solver", arguments.solver], Path(folder))
    print(table(found))
    if arguments.write:
        save(RESULTS, found, {"many_sources": table(found)})


if __name__ == "__main__":
    main()
