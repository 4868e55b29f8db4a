"""The process of one library: it does what it is asked, a line of JSON in, a line of JSON out.

python -m measuring.worker LIBRARY MESH.npz

It starts with NumPy and the arrays, and with nothing of the library. Commands, each with its
answer:

    {"do": "start", "source": 0}       clocks of the import, of a build with one source, and of
                                       both; the mean distance and the linear solver
    {"do": "one", "sources": [...]}    clocks a source, each in a call of its own
    {"do": "each", "sources": [...]}   clocks a source, all in one call where there is one for that
    {"do": "memory", "source": 0, "small": MESH.npz}
                                       most bytes held while building and solving, above what was
                                       held after the same on a small mesh
    {"do": "limit"}                    the Poisson factor of this package: bytes, seconds of a solve
"""

import gc
import json
import os
import sys
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from measuring import clocks, libraries

ENOUGH = 0.2
"""Seconds of single sources after which their mean is taken."""

BLOCK = 16
"""Right-hand sides of a solve in a block."""

READ = 256 * 2**20
"""Bytes read to measure the speed of memory: several times what a cache holds."""


class Worker:
    """A library, a mesh, and what was built of it."""

    def __init__(self, library: str, mesh: str) -> None:
        self.library = library
        self.mesh = _arrays(mesh)
        self.ready: libraries.Ready | None = None

    def start(self, source: int) -> dict[str, Any]:
        """Clock what a user waits for in a new process: the import, then the first distance."""

        def build() -> np.ndarray:
            self.ready = libraries.build(self.library, *self.mesh)
            return self.ready.one(source)

        def import_and_build() -> tuple[Any, ...]:
            return (
                *clocks.clocked(lambda: libraries.load(self.library))[:1],
                *clocks.clocked(build),
            )

        start, (imported, built, distance) = clocks.timed(import_and_build)
        assert self.ready is not None
        return {
            "start": start,
            "import": imported,
            "build": built,
            "mean": float(np.mean(distance)),
            "solver": self.ready.solver,
        }

    def one(self, sources: list[int]) -> dict[str, Any]:
        """Clock calls of one source each, without a break: after other work short ones are slow."""
        ready = self.ready
        assert ready is not None

        def ask() -> int:
            asked, started = 0, time.perf_counter()
            while asked < len(sources) and time.perf_counter() - started < ENOUGH:
                ready.one(sources[asked])
                asked += 1
            return asked

        spent, asked = clocks.timed(ask)
        return {clock: seconds / asked for clock, seconds in spent.items()}

    def each(self, sources: list[int]) -> dict[str, Any]:
        assert self.ready is not None
        spent, _ = clocks.timed(lambda: self.ready.each(sources))
        return {clock: seconds / len(sources) for clock, seconds in spent.items()}

    def memory(self, source: int, small: str) -> dict[str, Any]:
        self._use(*_arrays(small), source=0)
        gc.collect()
        clocks.trim()
        before = clocks.resident()
        clocks.forget_peak()
        self._use(*self.mesh, source=source)
        return {"bytes": clocks.peak_resident() - before}

    def _use(self, vertices: np.ndarray, faces: np.ndarray, source: int) -> None:
        libraries.build(self.library, vertices, faces).one(source)

    def limit(self) -> dict[str, Any]:
        """Return the bytes of the factor of the Poisson system, and the seconds of a solve."""
        from scipy.sparse import csr_array, diags_array

        import geodesic_toolkit as gt

        solver = gt.GeodesicSolver(gt.TriangleMesh(*self.mesh), **libraries.options(self.library))
        metric, recipe = solver.method.metric, solver.method.poisson_solver
        ground = np.zeros(metric.n_vertices)
        ground[0] = metric.stiffness.diagonal()[0]
        matrix = csr_array(metric.stiffness + diags_array(ground))
        factor = recipe.factorize(matrix)
        columns = np.random.default_rng(0).standard_normal((metric.n_vertices, BLOCK))
        columns -= columns.mean(axis=0)
        (solve, block), speeds = zip(
            _solves(factor.solve, columns[:, 0]), _solves(factor.solve, columns), strict=True
        )
        return {
            "solver": type(recipe).__name__,
            "bytes": factor.nbytes,
            "factorize": clocks.timed(lambda: recipe.factorize(matrix))[0]["cpu"],
            "solve": solve,
            "block": block / BLOCK,
            "bandwidth": max(speeds),
        }


def _solves(solve: Callable[[np.ndarray], np.ndarray], right: np.ndarray) -> tuple[float, float]:
    """Return the median seconds of CPU of a solve, and the fastest that memory was read between.

    What is read in between puts the factor out of the cache.
    """
    from measuring.machine import reading

    other = np.ones(READ // 8)
    solve(right)
    seconds, speeds = [], []
    for _ in range(15):
        speeds.append(reading(other))
        seconds.append(clocks.timed(lambda: solve(right))[0]["cpu"])
    return float(np.median(seconds)), max(speeds)


def _arrays(path: str) -> tuple[np.ndarray, np.ndarray]:
    with np.load(path) as file:
        return file["vertices"], file["faces"]


def main() -> None:
    """Answer commands until there are no more."""
    warnings.simplefilter("ignore")  # of shapes: known
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    clocks.go_first()
    os.dup2(2, 1)  # output of libraries is not an answer
    worker = Worker(*sys.argv[1:])
    print(json.dumps({}), file=answers, flush=True)
    for line in sys.stdin:
        command = json.loads(line)
        answer = getattr(worker, command.pop("do"))(**command)
        print(json.dumps(answer), file=answers, flush=True)


if __name__ == "__main__":
    main()
