"""Time and memory beside other libraries, in one run: what the page on performance quotes.

Every library runs in a process of its own. The processes are asked in turn, round by round, for a
build with one source, for a further source, and for sixteen at once, on the same mesh. Peak memory
comes from fresh processes, as does the cost of a first call. Everything is measured on what
libraries do by themselves: threads, options and buffers are theirs.

python benchmarks/performance.py                            everything, about half an hour
python benchmarks/performance.py --sizes 3.5k,35k           some of the sizes
python benchmarks/performance.py --generated                spheres instead of the shared data set
python benchmarks/performance.py --parts rounds,start-up    rounds, memory, limit, start-up
python benchmarks/performance.py --libraries "ours;libigl"  some of the columns
python benchmarks/performance.py --write                    also into docs/_tables

Parts that are not measured keep the figures and the date of the run that measured them.
"""

import argparse
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from measuring import libraries, shapes
from measuring.clocks import timed
from measuring.machine import machine, touch
from measuring.performance_tables import BATCH, MEASURES, tables
from measuring.processes import NoAnswerError, Process, user_environment
from measuring.tables import TABLES, gigabytes, load, save, seconds

RESULTS = TABLES / "performance.json"

SIZES = "3.5k,35k,173k,557k"
PARTS = ("rounds", "memory", "limit", "start-up")

WARM_UP = 2562
"""Vertices of the sphere that every process sees first."""

LARGE = 300_000
"""Vertices from which on there are fewer rounds: other libraries take a minute for a build."""

SMALL = 10_000
"""Vertices up to which there are more rounds: a shared machine changes its pace while one lasts."""

HOPELESS = {f"{libraries.SOLVER}superlu": LARGE}
"""Vertices from which on a column is left out: SuperLU had no factor of 556,000 in nine minutes."""

START_UP = 200_000
"""Vertices up to which first calls are measured."""

FURTHER = 256
"""Single sources that are tried in a round, as time allows."""

TOUCHED = 4000
"""Bytes a vertex that are touched before each measurement; most libraries take less."""

PAUSE = 0.1
"""Seconds between two processes: threads of the last one wait busily for more work that long."""


# -- rounds ----------------------------------------------------------------------------------------


class Setting:
    """Meshes on disk, and how they are to be measured."""

    def __init__(self, arguments: argparse.Namespace, folder: Path) -> None:
        self.limit: float = arguments.limit
        self.rounds: int = arguments.rounds
        self.large_rounds: int = arguments.large_rounds
        self.small_rounds: int = arguments.small_rounds
        self.libraries: list[str] = arguments.libraries
        self.meshes: dict[str, dict[str, Any]] = {}
        self.warm_up = self._keep(folder / "warm-up.npz", shapes.sphere(WARM_UP))
        for size in arguments.sizes.split(","):
            found = shapes.mesh_of_size(size, generated=arguments.generated)
            if found is not None:
                name, (vertices, faces) = found
                path = self._keep(folder / f"{size}.npz", (vertices, faces))
                self.meshes[size] = {"name": name, "vertices": len(vertices), "path": path}

    @staticmethod
    def _keep(path: Path, arrays: shapes.Arrays) -> str:
        np.savez(path, vertices=arrays[0], faces=arrays[1])
        return str(path)

    def rounds_at(self, n_vertices: int) -> int:
        if n_vertices <= SMALL:
            return self.small_rounds
        return self.large_rounds if n_vertices > LARGE else self.rounds

    def worker(self, library: str, size: str) -> Process:
        """Return a process that is ready for commands."""
        if self.meshes[size]["vertices"] > HOPELESS.get(library, np.inf):
            raise NoAnswerError("takes more than nine minutes")
        process = Process("measuring.worker", library, self.warm_up, self.meshes[size]["path"])
        process.answer(self.limit)
        return process


def measure_rounds(setting: Setting) -> dict[str, Any]:
    """Return every time of every library, size by size."""
    found: dict[str, Any] = {}
    for size, mesh in setting.meshes.items():
        n_rounds = setting.rounds_at(mesh["vertices"])
        rng = np.random.default_rng(0)
        times: dict[str, Any] = {}
        with started(setting, size, times) as workers:
            for round_ in range(n_rounds):
                chosen = rng.choice(mesh["vertices"], 1 + FURTHER + BATCH, replace=False).tolist()
                # Whoever comes first has the caches to himself: not always the same one.
                order = list(workers)[round_ % max(len(workers), 1) :]
                for library in [*order, *(name for name in workers if name not in order)]:
                    turn(setting, workers, library, size, chosen, times[library])
                    time.sleep(PAUSE)
                show_round(size, round_, times)
        found[size] = {
            "mesh": mesh["name"],
            "vertices": mesh["vertices"],
            "rounds": n_rounds,
            "libraries": times,
        }
    return found


@contextmanager
def started(setting: Setting, size: str, times: dict[str, Any]) -> Iterator[dict[str, Process]]:
    """Give a process of each library, and end them all."""
    workers: dict[str, Process] = {}
    try:
        for library in setting.libraries:
            times[library] = {measure: [] for measure in MEASURES} | {"means": []}
            try:
                workers[library] = setting.worker(library, size)
            except NoAnswerError as failure:
                give_up(workers, library, times[library], failure)
        yield workers
    finally:
        for worker in workers.values():
            worker.close()


def turn(
    setting: Setting,
    workers: dict[str, Process],
    library: str,
    size: str,
    chosen: list[int],
    times: dict[str, Any],
) -> None:
    """Ask one library for everything, once."""
    source, further, batch = chosen[0], chosen[1 : 1 + FURTHER], chosen[1 + FURTHER :]
    commands = {
        "build": {"do": "build", "source": source},
        "one": {"do": "one", "sources": further},
        "each": {"do": "each", "sources": batch},
        "release": {"do": "release"},
    }
    try:
        for measure, command in commands.items():
            touch(setting.meshes[size]["vertices"] * TOUCHED)
            answer = workers[library].ask(command, setting.limit)
            if measure == "build":
                times["means"].append(answer.pop("mean"))
                times["solver"] = answer.pop("solver")
            if measure in MEASURES:
                times[measure].append(answer)
    except NoAnswerError as failure:
        give_up(workers, library, times, failure)


def give_up(
    workers: dict[str, Process], library: str, times: dict[str, Any], failure: NoAnswerError
) -> None:
    """Leave a library out from now on."""
    print(f"    {library}: {failure}", flush=True)
    workers.pop(library, None)
    times["failure"] = str(failure)


def show_round(size: str, round_: int, times: dict[str, Any]) -> None:
    """Print what a round has found."""
    for library, own in times.items():
        if len(own["each"]) > round_:
            cells = [f"{seconds(own[m][round_]['cpu']):>8s}" for m in MEASURES]
            print(f"    {size:5s} round {round_ + 1} {library:24s} {'  '.join(cells)}", flush=True)
    known = [own["means"][round_] for own in times.values() if len(own["means"]) > round_]
    if known and max(known) > 1.1 * min(known):
        print(f"    {size}: the mean distances differ, from {min(known):.4g} to {max(known):.4g}")


# -- memory, limit, start-up -----------------------------------------------------------------------


def measure_memory(setting: Setting) -> dict[str, Any]:
    """Return the most bytes that each library holds above its imports, in a fresh process."""
    found: dict[str, Any] = {}
    for size, mesh in setting.meshes.items():
        found[size] = {"mesh": mesh["name"], "vertices": mesh["vertices"], "libraries": {}}
        for library in setting.libraries:
            answer = ask_once(setting, library, size, {"do": "memory", "source": 0})
            found[size]["libraries"][library] = answer
            shown = gigabytes(answer["bytes"]) if "bytes" in answer else answer["failure"]
            print(f"    {size:5s} memory {library:24s} {shown}", flush=True)
    return found


def measure_limit(setting: Setting) -> dict[str, Any]:
    """Return the speed of memory, and of solves that have to read a factor from it."""
    found: dict[str, Any] = {"sizes": {}}
    for size, mesh in setting.meshes.items():
        found["sizes"][size] = {"mesh": mesh["name"], "vertices": mesh["vertices"], "solvers": {}}
        for library in setting.libraries:
            if library == "ours" or library.startswith(libraries.SOLVER):
                answer = ask_once(setting, library, size, {"do": "limit"})
                name = library.removeprefix(libraries.SOLVER).replace("ours", "the default")
                found["sizes"][size]["solvers"][name] = answer
                print(f"    {size:5s} limit {name} {answer}", flush=True)
    return found


def ask_once(setting: Setting, library: str, size: str, command: dict[str, Any]) -> dict[str, Any]:
    """Return the one answer of a fresh process, or why there is none."""
    try:
        worker = setting.worker(library, size)
        answer = worker.ask(command, setting.limit)
    except NoAnswerError as failure:
        return {"failure": str(failure)}
    worker.close()
    return answer


def measure_start_up(setting: Setting) -> dict[str, Any]:
    """Return what a fresh process pays, with the kernels compiled before and without."""
    found: dict[str, Any] = {"sizes": {}}
    for size in list(setting.meshes)[:1]:  # warming up compiles every kernel for those to come
        ask_once(setting, "ours", size, {"do": "release"})
    for size, mesh in setting.meshes.items():
        if mesh["vertices"] > START_UP:
            continue
        rows: dict[str, Any] = {}
        for library in setting.libraries:
            rows[library] = fresh_calls(setting, library, mesh["path"], None)
            if library.startswith("ours"):
                cold = f"{library}, nothing compiled"
                rows[cold] = fresh_calls(setting, library, mesh["path"], tempfile.mkdtemp)
        found["sizes"][size] = {"mesh": mesh["name"], "vertices": mesh["vertices"], "rows": rows}
        for row, calls in rows.items():
            print(f"    {size:5s} start-up {row:40s} {calls}", flush=True)
    found["warm"] = measure_warm_command()
    return found


def fresh_calls(
    setting: Setting, library: str, mesh: str, new_cache: Callable[[], str] | None
) -> dict[str, Any]:
    """Return the medians over processes; with `new_cache`, each finds an empty one of kernels."""
    calls = []
    for _ in range(3 if new_cache else 1 + max(setting.rounds, 3)):
        cache = new_cache() if new_cache else None
        try:
            calls.append(
                first_call(setting, library, mesh, {"NUMBA_CACHE_DIR": cache} if cache else {})
            )
        except NoAnswerError as failure:
            return {"failure": str(failure)}
        finally:
            if cache is not None:
                shutil.rmtree(cache)
    if not new_cache:
        calls = calls[1:]  # the first one reads files from disk
    return {
        stage: {
            clock: float(np.median([call[stage][clock] for call in calls]))
            for clock in ("cpu", "wall")
        }
        for stage in calls[0]
    }


def first_call(
    setting: Setting, library: str, mesh: str, environment: dict[str, str]
) -> dict[str, Any]:
    """Return the clocks of an import and a first distance in a process of their own."""
    process = Process("measuring.start_up", library, mesh, **environment)
    answer = process.answer(setting.limit)
    process.close()
    return answer


def measure_warm_command() -> dict[str, float] | None:
    """Return what compiling everything ahead costs, where this package has the command for it."""
    if "--warm" not in command_line("--help").stdout:
        return None
    cache = tempfile.mkdtemp()
    before = child_seconds()
    spent, finished = timed(lambda: command_line("--warm", NUMBA_CACHE_DIR=cache))
    shutil.rmtree(cache)
    if finished.returncode != 0:
        print(f"    doctor --warm failed: {finished.stderr.strip()}", flush=True)
        return None
    return {"cpu": child_seconds() - before, "wall": spent["wall"]}


def command_line(option: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run ``geodesic-toolkit doctor`` with an option."""
    return subprocess.run(
        [sys.executable, "-m", "geodesic_toolkit", "doctor", option],
        env=user_environment({"COLUMNS": "200", **environment}),
        capture_output=True,
        text=True,
        check=False,
    )


def child_seconds() -> float:
    """Return the CPU time of all processes started and ended so far."""
    import resource

    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


# -- the command -----------------------------------------------------------------------------------


def all_libraries() -> list[str]:
    """Return the columns: this package, its solvers, the others."""
    solvers = [libraries.SOLVER + name for name in libraries.componentwise_solvers()]
    return ["ours", "ours, refined", *solvers, *libraries.PEERS, libraries.ROBUST]


def main() -> None:
    """Run the benchmark of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--sizes", default=SIZES, help=f"of {SIZES}, or of spheres: 10k, 1M")
    parser.add_argument("--generated", action="store_true", help="spheres instead of real meshes")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--small-rounds", type=int, default=41, help=f"up to {SMALL:,} vertices")
    parser.add_argument("--large-rounds", type=int, default=3, help=f"from {LARGE:,} vertices on")
    parser.add_argument("--libraries", help="columns, separated by semicolons")
    parser.add_argument("--parts", default=",".join(PARTS), help=f"of {', '.join(PARTS)}")
    parser.add_argument("--limit", type=float, default=600.0, help="seconds a call may take")
    parser.add_argument("--write", action="store_true", help="write the tables into the docs")
    arguments = parser.parse_args()
    arguments.libraries = arguments.libraries.split(";") if arguments.libraries else all_libraries()
    measures = {
        "rounds": lambda setting: {"sizes": measure_rounds(setting)},
        "memory": lambda setting: {"sizes": measure_memory(setting)},
        "limit": measure_limit,
        "start-up": measure_start_up,
    }
    wanted = arguments.parts.split(",")
    if unknown := set(wanted) - set(measures):
        parser.error(f"no such part: {', '.join(sorted(unknown))}")
    results = load(RESULTS) if arguments.write else {}
    with tempfile.TemporaryDirectory() as folder:
        setting = Setting(arguments, Path(folder))
        for part in wanted:
            results[part] = {"machine": machine(), **measures[part](setting)}
            if arguments.write:
                save(RESULTS, results, {})  # the figures first: they took longest
                save(RESULTS, results, tables(results))
    for name, text in tables(results).items():
        print(f"\n{name}\n\n{text}")


if __name__ == "__main__":
    main()
