"""Time and memory beside other libraries, in new processes, for the page on performance.

A round is a new process of every library, one after the other. NumPy is imported and the mesh is in
memory when its clock starts; the library is not imported. The process runs the import and a first
distance, then further sources one by one, then sixteen at once. Libraries keep their defaults of
threads, options and buffers.

python benchmarks/performance.py                            everything, about half an hour
python benchmarks/performance.py --sizes 3.5k,35k           some of the sizes
python benchmarks/performance.py --rounds 21,9,5,1          one number for every size, or for each
python benchmarks/performance.py --generated                spheres instead of the shared data set
python benchmarks/performance.py --parts rounds,memory      of rounds, memory, limit
python benchmarks/performance.py --libraries "ours;libigl"  some of the columns
python benchmarks/performance.py --solvers superlu          this package by other solvers as well
python benchmarks/performance.py --write                    also into docs/_tables

Parts that are not measured keep the figures and the date of the run that measured them. Columns
whose package is not installed are left out, and named.
"""

import argparse
import importlib.util
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from measuring import libraries, shapes
from measuring.machine import machine, touch
from measuring.performance_tables import BATCH, MEASURES, tables
from measuring.processes import NoAnswerError, Process
from measuring.tables import TABLES, gigabytes, load, save, seconds

RESULTS = TABLES / "performance.json"

SIZES = "3.5k,35k,173k,557k"

ROUNDS = {10_000: 21, 100_000: 15, 300_000: 9}
"""Rounds up to so many vertices: a shared machine changes its pace while short ones last."""

LARGE_ROUNDS = 2
"""Rounds of more vertices: other libraries take a minute for a build."""

SMALL = 2562
"""Vertices of the sphere that comes before the mesh where memory is measured."""

HOPELESS = {f"{libraries.SOLVER}superlu": 300_000}
"""Vertices from which on a column is left out: SuperLU had no factor of 556,000 in nine minutes."""

FURTHER = 256
"""Single sources that are tried in a round, as time allows."""

TOUCHED = 4000
"""Bytes a vertex that are touched before each measurement; most libraries take less."""

PAUSE = 0.1
"""Seconds between two processes: threads of the last one wait busily for more work that long."""


class Setting:
    """Meshes on disk, and how they are to be measured."""

    def __init__(self, arguments: argparse.Namespace, folder: Path) -> None:
        self.limit: float = arguments.limit
        self.libraries: list[str] = arguments.libraries
        self.meshes: dict[str, dict[str, Any]] = {}
        self.small = self._keep(folder / "small.npz", shapes.sphere(SMALL))
        sizes = arguments.sizes.split(",")
        for size, rounds in zip(sizes, rounds_of(arguments.rounds, len(sizes)), strict=True):
            found = shapes.mesh_of_size(size, generated=arguments.generated)
            if found is not None:
                name, (vertices, faces) = found
                self.meshes[size] = {
                    "name": name,
                    "vertices": len(vertices),
                    "path": self._keep(folder / f"{size}.npz", (vertices, faces)),
                    "rounds": rounds or usual_rounds(len(vertices)),
                }

    @staticmethod
    def _keep(path: Path, arrays: shapes.Arrays) -> str:
        np.savez(path, vertices=arrays[0], faces=arrays[1])
        return str(path)

    def worker(self, library: str, size: str) -> Process:
        """Return a new process that is ready for commands, and has imported nothing for them."""
        if self.meshes[size]["vertices"] > HOPELESS.get(library, np.inf):
            raise NoAnswerError("takes more than nine minutes")
        process = Process("measuring.worker", library, self.meshes[size]["path"])
        process.answer(self.limit)
        return process


def rounds_of(text: str, n_sizes: int) -> list[int]:
    """Return the rounds of each size from one number or as many, 0 where they are the usual ones.

    Raises
    ------
    ValueError
        There are neither one number nor as many as sizes.
    """
    given = [int(word) for word in text.split(",") if word] or [0]
    if len(given) not in {1, n_sizes}:
        raise ValueError(f"--rounds has {len(given)} numbers for {n_sizes} sizes")
    return given if len(given) == n_sizes else given * n_sizes


def usual_rounds(n_vertices: int) -> int:
    """Return the default number of rounds of a mesh."""
    return next((count for most, count in ROUNDS.items() if n_vertices <= most), LARGE_ROUNDS)


# -- rounds ----------------------------------------------------------------------------------------


def measure_rounds(setting: Setting) -> dict[str, Any]:
    """Return every time of every library, size by size."""
    read_files(setting)
    found: dict[str, Any] = {}
    for size, mesh in setting.meshes.items():
        rng = np.random.default_rng(0)
        times: dict[str, Any] = {
            library: {measure: [] for measure in MEASURES} | {"means": []}
            for library in setting.libraries
        }
        for round_ in range(mesh["rounds"]):
            chosen = rng.choice(mesh["vertices"], 1 + FURTHER + BATCH).tolist()
            for library in turned(setting.libraries, round_):
                if "failure" not in times[library]:
                    take_turn(setting, library, size, chosen, times[library])
                    time.sleep(PAUSE)
            show_round(size, round_, times)
        found[size] = {
            "mesh": mesh["name"],
            "vertices": mesh["vertices"],
            "rounds": mesh["rounds"],
            "libraries": times,
        }
    return found


def read_files(setting: Setting) -> None:
    """Start every library once, so that none of its files has to come from the disk later."""
    for library in setting.libraries:
        for size in list(setting.meshes)[:1]:
            ask_once(setting, library, size, {"do": "start", "source": 0})


def turned(names: list[str], by: int) -> list[str]:
    """Return names beginning with another one each time: the first one has other caches."""
    start = by % max(len(names), 1)
    return names[start:] + names[:start]


def take_turn(
    setting: Setting, library: str, size: str, chosen: list[int], times: dict[str, Any]
) -> None:
    """Ask a new process of one library for everything; a library that fails is left out."""
    source, further, batch = chosen[0], chosen[1 : 1 + FURTHER], chosen[1 + FURTHER :]
    touched = setting.meshes[size]["vertices"] * TOUCHED
    try:
        worker = setting.worker(library, size)
        touch(touched)
        answer = worker.ask({"do": "start", "source": source}, setting.limit)
        for measure, sources in (("one", further), ("each", batch)):
            touch(touched)
            answer[measure] = worker.ask({"do": measure, "sources": sources}, setting.limit)
    except NoAnswerError as failure:
        print(f"    {library}: {failure}", flush=True)
        times["failure"] = str(failure)
        return
    worker.close()
    times["means"].append(answer["mean"])
    times["solver"] = answer["solver"]
    for measure in MEASURES:
        times[measure].append(answer[measure])


def show_round(size: str, round_: int, times: dict[str, Any]) -> None:
    """Print what a round has found."""
    for library, own in times.items():
        if len(own["each"]) > round_:
            cells = [
                f"{seconds(own[measure][round_][clock]):>8s}"
                for measure, (_, clock) in MEASURES.items()
            ]
            print(f"    {size:5s} round {round_ + 1} {library:24s} {'  '.join(cells)}", flush=True)
    known = [own["means"][round_] for own in times.values() if len(own["means"]) > round_]
    if known and max(known) > 1.1 * min(known):
        print(f"    {size}: the mean distances differ, from {min(known):.4g} to {max(known):.4g}")


# -- memory, limit ---------------------------------------------------------------------------------


def measure_memory(setting: Setting) -> dict[str, Any]:
    """Return the most bytes that each library holds above its imports, in a new process."""
    found: dict[str, Any] = {}
    for size, mesh in setting.meshes.items():
        found[size] = {"mesh": mesh["name"], "vertices": mesh["vertices"], "libraries": {}}
        for library in setting.libraries:
            command = {"do": "memory", "source": 0, "small": setting.small}
            answer = ask_once(setting, library, size, command)
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
            if library == libraries.PLAIN or library.startswith(libraries.SOLVER):
                answer = ask_once(setting, library, size, {"do": "limit"})
                name = library.removeprefix(libraries.SOLVER).replace(
                    libraries.PLAIN, "the default"
                )
                found["sizes"][size]["solvers"][name] = answer
                print(f"    {size:5s} limit {name} {answer}", flush=True)
    return found


def ask_once(setting: Setting, library: str, size: str, command: dict[str, Any]) -> dict[str, Any]:
    """Return the one answer of a new process, or why there is none."""
    try:
        worker = setting.worker(library, size)
        answer = worker.ask(command, setting.limit)
    except NoAnswerError as failure:
        return {"failure": str(failure)}
    worker.close()
    return answer


# -- the command -----------------------------------------------------------------------------------


def columns(chosen: str | None, solvers: str) -> list[str]:
    """Return the columns to measure, and say which of them have no package here."""
    names = chosen.split(";") if chosen else list(libraries.COLUMNS)
    names += [libraries.SOLVER + name for name in solvers.split(",") if name]
    kept = []
    for name in names:
        if importlib.util.find_spec(libraries.package(name)) is None:
            print(f"{name} is left out: {libraries.package(name)} is not installed")
        else:
            kept.append(name)
    return kept


def main() -> None:
    """Run the benchmark of the command line."""
    measures = {
        "rounds": lambda setting: {"sizes": measure_rounds(setting)},
        "memory": lambda setting: {"sizes": measure_memory(setting)},
        "limit": measure_limit,
    }
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--sizes", default=SIZES, help=f"of {SIZES}, or of spheres: 10k, 1M")
    parser.add_argument("--generated", action="store_true", help="spheres instead of real meshes")
    usual = ", ".join(f"{count} up to {most:,} vertices" for most, count in ROUNDS.items())
    parser.add_argument(
        "--rounds",
        default="",
        help=f"for all sizes, or for each of them; default: {usual}, then {LARGE_ROUNDS}",
    )
    parser.add_argument("--libraries", help=f"columns, of {'; '.join(libraries.COLUMNS)}")
    parser.add_argument("--solvers", default="", help="linear solvers to add as columns: superlu")
    parser.add_argument("--parts", default=",".join(measures), help=f"of {', '.join(measures)}")
    parser.add_argument("--limit", type=float, default=600.0, help="seconds an answer may take")
    parser.add_argument("--write", action="store_true", help="write the tables into the docs")
    arguments = parser.parse_args()
    wanted = arguments.parts.split(",")
    if unknown := set(wanted) - set(measures):
        parser.error(f"no such part: {', '.join(sorted(unknown))}")
    try:
        arguments.libraries = columns(arguments.libraries, arguments.solvers)
        rounds_of(arguments.rounds, len(arguments.sizes.split(",")))
    except KeyError as unknown:
        parser.error(f"no such library: {unknown}")
    except ValueError as error:
        parser.error(str(error))
    known = load(RESULTS) if arguments.write else {}
    results = {part: known[part] for part in measures if part in known}
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
