"""Iterations, time and memory of each process, for one, two and four of them, as a table.

    python processes.py --mpiexec /usr/bin/mpiexec

The system is that of plain heat distances on an irregular torus. The processes may be more than the
processors: memory and iterations are then as they would be, and times are not.
"""

import argparse
import subprocess
import sys
import time

import numpy as np

import geodesic_toolkit as gt
from geodesic_toolkit_petsc import PETSc, peak_memory

SIZES = ((264, 132), (584, 292), (1058, 529))
COUNTS = (1, 2, 4)
HEADINGS = (
    *("vertices", "processes", "preconditioner", "iterations", "set up", "distance"),
    *("differs by", "megabytes of each process"),
)


def measure(n: int, m: int, preconditioner: str) -> None:
    """Print one row, on process 0; the others help."""
    solver = PETSc(preconditioner=preconditioner)
    if not solver.leads():
        return
    before = peak_memory()
    mesh = gt.testing.shapes.bumpy_torus(n, m, rng=np.random.default_rng(0))
    began = time.perf_counter()
    petsc = gt.GeodesicSolver(mesh, solver=solver, refine=False)
    ready = time.perf_counter()
    distance = petsc.distance(0)
    done = time.perf_counter()
    peaks = [(peak - own) / 1e6 for peak, own in zip(peak_memory(), before, strict=True)]
    factor = petsc.method._poisson.factor()  # noqa: SLF001 - a benchmark
    direct = gt.GeodesicSolver(mesh, solver=gt.Supernodal(compact=False), refine=False).distance(0)
    row = (
        f"{mesh.n_vertices:,}",
        len(peaks),
        preconditioner,
        factor.iterations[0],
        f"{ready - began:.1f} s",
        f"{done - ready:.1f} s",
        f"{np.abs(distance - direct).max() / direct.max():.0e}",
        ", ".join(f"{peak:.0f}" for peak in peaks),
    )
    print("|", " | ".join(map(str, row)), "|", flush=True)


def main() -> None:
    """Start each measurement in a job of its own."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--mpiexec", default="mpiexec")
    parser.add_argument("--options", default="", help="options of mpiexec")
    parser.add_argument(
        "--one", nargs=3, help="rows, columns and preconditioner of one measurement"
    )
    arguments = parser.parse_args()
    if arguments.one is not None:
        n, m, preconditioner = arguments.one
        measure(int(n), int(m), preconditioner)
        return
    print("|", " | ".join(HEADINGS), "|")
    print("|" + "---|" * len(HEADINGS), flush=True)
    for n, m in SIZES:
        for preconditioner in ("hypre", "gamg"):
            for count in COUNTS:
                command = [arguments.mpiexec, *arguments.options.split(), "-n", str(count)]
                command += [sys.executable, __file__, "--one", str(n), str(m), preconditioner]
                subprocess.run(command, check=True)


if __name__ == "__main__":
    main()
