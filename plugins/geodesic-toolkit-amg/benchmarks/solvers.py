"""Every installed linear solver on the Poisson system of spheres: CPU time, memory, agreement.

    OPENBLAS_NUM_THREADS=1 python plugins/geodesic-toolkit-amg/benchmarks/solvers.py

writes a table in Markdown to stdout.
"""

import argparse
import time

import numpy as np

import geodesic_toolkit as gt

BLOCK = 4
"""Right-hand sides that are solved at once."""


def main() -> None:
    """Write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--levels", type=int, nargs="+", default=[6, 7])
    parser.add_argument("--solvers", nargs="+", default=["supernodal", "cholmod", "superlu", "amg"])
    arguments = parser.parse_args()
    print("| vertices | solver | set up | one | each of four | megabytes | distances differ by |")
    print("|---|---|---|---|---|---|---|")
    for level in arguments.levels:
        sphere = gt.testing.shapes.icosphere(level)
        rows = gt.CotanLaplacian().assemble(sphere).stiffness[1:][:, 1:]
        usual = gt.GeodesicSolver(sphere, refine=False).distance(0)
        for name in arguments.solvers:
            print(row(name, sphere, rows, usual), flush=True)


def row(name: str, sphere: gt.TriangleMesh, matrix: object, usual: np.ndarray) -> str:
    """Return one line of the table."""
    load = np.random.default_rng(0).standard_normal((sphere.n_vertices - 1, BLOCK))
    solver = gt.solvers[name]()
    times = [time.process_time()]
    factor = solver.factorize(matrix)
    times.append(time.process_time())
    factor.solve(load[:, 0])
    times.append(time.process_time())
    factor.solve(load)
    times.append(time.process_time())
    first, one, block = np.diff(times)
    ours = gt.GeodesicSolver(sphere, refine=False, solver=name).distance(0)
    return (
        f"| {sphere.n_vertices:,} | {name} | {first:.2f} s | {one:.3f} s | {block / BLOCK:.3f} s "
        f"| {factor.nbytes / 1e6:.0f} | {np.abs(ours - usual).max() / usual.max():.0e} |"
    )


if __name__ == "__main__":
    main()
