"""Compare the time of every phase with that of another version of this package.

python benchmarks/regression.py --base v1.2          against a commit, branch or tag
python benchmarks/regression.py --base ~/old/bin/python
                                                     against what that interpreter has installed
python benchmarks/regression.py --base v1.2 --new HEAD
                                                     both newly installed, for every processor

A compiler can make an ordinary line 3 to 40 times as slow, and no test detects that. This script
does: a new process of each version runs the same phases, interleaved, round by round, on generated
meshes, and the CPU time of one is divided by that of the other. A ratio above 1 says that the new
version is faster. Where the median of the rounds is below the bound, the phase is named, and the
exit status is 1.

A commit is checked out into a temporary folder and installed there, with the NumPy and SciPy of
this interpreter, which takes some minutes and the network. The new version is that of this
interpreter; an editable installation has kernels for one processor only.

Kernels are compiled for several levels of x86-64, and each can go wrong by itself: all levels that
both versions have are measured. A base without compiled kernels is compared with the best one.

Phases that the base does not have are left out; they are listed. Those of public calls are always
there: analysis, factors, solves, assembly, build, source and batch. The others want the functions
for flips, the Poisson load, sweeps, stars and poles, or the compiled kernels, under the same names.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
from measuring import shapes
from measuring.machine import touch
from measuring.processes import NoAnswerError, Process
from measuring.tables import markdown, seconds

ROOT = Path(__file__).resolve().parents[1]

SIZES = "3k,35k"
BOUND = 0.7
ROUNDS = 5
SECONDS = 0.15

TOUCHED = 4000
"""Bytes a vertex that are touched before a process is asked for anything."""


@dataclass
class Phase:
    """The results of one phase in all rounds; times are pairs of base and new."""

    size: str
    level: int
    name: str
    times: list[tuple[float, float]] = field(default_factory=list)
    failure: str = ""

    @property
    def ratios(self) -> list[float]:
        return [base / new for base, new in self.times]

    @property
    def ratio(self) -> float:
        """The median; not a number where nothing was measured."""
        return float(np.median(self.ratios)) if self.times else float("nan")

    @property
    def place(self) -> str:
        return f"{self.name} at {self.size}" + (f", level {self.level}" if self.level else "")


# -- versions --------------------------------------------------------------------------------------


@contextmanager
def interpreter(choice: str) -> Iterator[str]:
    """Give the interpreter of a version: itself, or one that is made for a commit."""
    path = Path(choice).expanduser()
    if path.name.startswith("python"):
        if shutil.which(path) is None:
            raise SystemExit(f"there is no interpreter {choice}")
        yield str(path)
        return
    print(f"installing {choice} ...", flush=True)
    with tempfile.TemporaryDirectory(prefix="geodesic-") as folder:
        tree, environment = Path(folder) / "tree", Path(folder) / "environment"
        run("git", "-C", ROOT, "worktree", "add", "--detach", "--quiet", tree, choice)
        try:
            yield install(tree, environment)
        finally:
            run("git", "-C", ROOT, "worktree", "remove", "--force", tree)


def install(tree: Path, environment: Path) -> str:
    """Install a checkout into an environment of its own, and return its interpreter."""
    run(sys.executable, "-m", "venv", environment)
    python = environment / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    same = [f"{name}=={metadata.version(name)}" for name in ("numpy", "scipy")]
    run(python, "-m", "pip", "install", "--quiet", tree, *same)
    return str(python)


def run(*command: object) -> None:
    """Run a command, and end with what it says where it fails."""
    finished = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False)
    if finished.returncode:
        raise SystemExit(f"{' '.join(map(str, command))}\n{finished.stderr or finished.stdout}")


# -- measuring -------------------------------------------------------------------------------------


class Pair:
    """Two versions, and how they are asked."""

    def __init__(self, base: str, new: str, seconds: float, limit: float) -> None:
        self.pythons = (base, new)
        self.seconds, self.limit = str(seconds), limit

    def levels(self, mesh: str) -> list[int]:
        """Return the levels of x86-64 that both have, or 0 where the base has none."""
        found = []
        for name, python in zip(("base", "new"), self.pythons, strict=True):
            process, answer = self._started(python, mesh, 0)
            process.close()
            print(f"{name}: {answer['from']}, level {answer['level']} of {answer['levels']}")
            found.append(answer["levels"])
        base, new = found
        return [level for level in new if level in base] if base else [0]

    def measure(self, mesh: str, level: int, phases: list[Phase], base_first: bool) -> None:
        """Ask a new process of each version for all phases, and note their times."""
        processes = [self._started(python, mesh, level)[0] for python in self.pythons]
        order = (0, 1) if base_first else (1, 0)
        for phase in phases:
            if phase.failure:
                continue
            answers: dict[int, dict[str, Any]] = {}
            for k in order:
                try:
                    answers[k] = processes[k].ask(phase.name, self.limit)
                except NoAnswerError as failure:
                    raise NoAnswerError(f"{self.pythons[k]}, {phase.place}: {failure}") from None
            note(phase, answers[0], answers[1])
        for process in processes:
            process.close()

    def _started(self, python: str, mesh: str, level: int) -> tuple[Process, dict[str, Any]]:
        chosen = {"GEODESIC_TOOLKIT_LEVEL": str(level)} if level else {}
        process = Process("measuring.phases", mesh, self.seconds, python=python, **chosen)
        answer = process.answer(self.limit)
        if level and answer["level"] not in {0, level}:
            raise NoAnswerError(f"{python} has loaded level {answer['level']}, not {level}")
        return process, answer


def note(phase: Phase, base: dict[str, Any], new: dict[str, Any]) -> None:
    """Note what both versions have answered."""
    if "failure" in new:
        phase.failure = f"the new version fails: {new['failure']}"
    elif "failure" in base:
        phase.failure = f"the base has none: {base['failure']}"
    else:
        phase.times.append((base["cpu"], new["cpu"]))


def compare(pair: Pair, arguments: argparse.Namespace, folder: Path) -> list[Phase]:
    """Return every phase of every size and level."""
    found = []
    for size in arguments.sizes.split(","):
        mesh, n_vertices = keep(folder / f"{size}.npz", shapes.count(size))
        levels = arguments.levels or pair.levels(mesh)
        grid = {level: [Phase(size, level, name) for name in arguments.phases] for level in levels}
        for round_ in range(arguments.rounds):
            for level, phases in grid.items():
                touch(n_vertices * TOUCHED)
                pair.measure(mesh, level, phases, base_first=round_ % 2 == 0)
                print(f"    {size}, level {level or 'best'}, round {round_ + 1}", flush=True)
        found += [phase for phases in grid.values() for phase in phases]
    return found


def keep(path: Path, n_vertices: int) -> tuple[str, int]:
    """Write a mesh, and return where and how many vertices it has."""
    vertices, faces = bumpy(n_vertices)
    np.savez(path, vertices=vertices, faces=faces)
    return str(path), len(vertices)


def bumpy(n_vertices: int) -> shapes.Arrays:
    """Return a sphere with dents, drawn out: it has obtuse triangles, and edges to flip."""
    points, faces = shapes.sphere(n_vertices)
    height = 1 + 0.1 * np.sin(7 * points).prod(axis=1, keepdims=True)
    return np.ascontiguousarray(height * points * [1.0, 1.0, 2.5]), faces.astype(np.int64)


# -- the table -------------------------------------------------------------------------------------


def table(found: list[Phase], bound: float) -> str:
    """Return the ratios: a row for a phase, a column for a size and level."""
    places = list(dict.fromkeys((phase.size, phase.level) for phase in found))
    known = {(phase.size, phase.level, phase.name): phase for phase in found}
    names = list(dict.fromkeys(phase.name for phase in found if phase.times))
    headings = [f"{size}, level {level or 'best'}" for size, level in places]
    rows = [[name, *(cell(known[(*place, name)]) for place in places)] for name in names]
    note = f"CPU time of the base / of the new version, and that of the new one. Bound: {bound:g}."
    return markdown(["", *headings], rows, note)


def cell(phase: Phase) -> str:
    """Return a ratio, its range, and the time of the new version."""
    if not phase.times:
        return "-"
    own = seconds(float(np.median([new for _, new in phase.times])))
    return f"**{phase.ratio:.2f}** ({min(phase.ratios):.2f}-{max(phase.ratios):.2f}), {own}"


def complaints(found: list[Phase], bound: float) -> list[str]:
    """Return what has become slower, and what the new version cannot do."""
    slower = [
        f"{phase.place}: {phase.ratio:.2f} of the speed of the base, below {bound:g}"
        for phase in found
        if phase.ratio < bound
    ]
    failed = [f"{p.place}: {p.failure}" for p in found if p.failure.startswith("the new")]
    return slower + failed


def left_out(found: list[Phase]) -> list[str]:
    """Return what the base does not have, each phase once."""
    missing = {p.name: p.failure for p in found if p.failure.startswith("the base")}
    return [f"{name}: {why}" for name, why in missing.items()]


# -- the command -----------------------------------------------------------------------------------


def phase_names(chosen: str) -> list[str]:
    """Return the phases to measure.

    Raises
    ------
    ValueError
        There is none of that name.
    """
    from measuring.phases import NAMES

    wanted = [name for name in chosen.split(",") if name] or NAMES
    if unknown := set(wanted) - set(NAMES):
        raise ValueError(f"no such phase: {', '.join(sorted(unknown))}; there are {NAMES}")
    return wanted


def main() -> None:
    """Compare two versions, and end with status 1 where one phase has become slower."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--base", required=True, metavar="REV|PYTHON", help="the other version")
    parser.add_argument(
        "--new", default=sys.executable, metavar="REV|PYTHON", help="default: this interpreter"
    )
    parser.add_argument("--sizes", default=SIZES, help=f"vertices of the meshes; default: {SIZES}")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help=f"default: {ROUNDS}")
    parser.add_argument("--bound", type=float, default=BOUND, help=f"default: {BOUND}")
    parser.add_argument("--levels", default="", help="of x86-64: 2,3; default: all that both have")
    parser.add_argument("--phases", default="", help="some of them: factor_whole,solve_block")
    parser.add_argument(
        "--seconds", type=float, default=SECONDS, help=f"to repeat a phase; default: {SECONDS}"
    )
    parser.add_argument("--limit", type=float, default=600.0, help="seconds an answer may take")
    arguments = parser.parse_args()
    arguments.levels = [int(level) for level in arguments.levels.split(",") if level]
    try:
        arguments.phases = phase_names(arguments.phases)
    except ValueError as error:
        parser.error(str(error))
    with (
        interpreter(arguments.base) as base,
        interpreter(arguments.new) as new,
        tempfile.TemporaryDirectory() as folder,
    ):
        try:
            pair = Pair(base, new, arguments.seconds, arguments.limit)
            found = compare(pair, arguments, Path(folder))
        except NoAnswerError as failure:
            raise SystemExit(f"no answer: {failure}") from None
    print(f"\n{table(found, arguments.bound)}")
    for line in left_out(found):
        print(f"left out: {line}")
    worse = complaints(found, arguments.bound)
    for line in worse:
        print(f"SLOWER: {line}")
    sys.exit(1 if worse else 0)


if __name__ == "__main__":
    main()
