"""The tables of the page on performance, from the measurements of ``performance.py``."""

from collections.abc import Callable
from typing import Any

import numpy as np

from measuring import libraries
from measuring.machine import sentence
from measuring.tables import gigabytes, markdown, seconds

BATCH = 16
"""Sources that are asked for at once."""

MEASURES = {
    "start": ("import and first distance, by the clock", "wall"),
    "import": ("the import alone, by the clock", "wall"),
    "build": ("build and one source", "cpu"),
    "one": ("a further source, alone", "cpu"),
    "each": (f"a further source, in a batch of {BATCH}", "cpu"),
}
"""Measures of a round: title, and the clock that counts."""

PREPARED = ("build", "one", "each")
"""Measures that leave the import out."""

STARTS = {
    "potpourri3d as it comes / this package as it comes": (
        libraries.OURS,
        libraries.PEER_DEFAULT,
    ),
    "potpourri3d without `use_robust` / this package, plain heat": (libraries.PLAIN, "potpourri3d"),
}
"""The rows of new processes: a column of this package, and which other is set against it."""


def tables(results: dict[str, Any]) -> dict[str, str]:
    """Return every table that can be made of what was measured, the main one first."""
    made = {}
    if "rounds" in results:
        made["performance_start_up"] = start_up_table(results["rounds"])
        made["performance"] = ratio_table(results)
        made["performance_libraries"] = library_table(results)
        made["performance_seconds"] = seconds_table(results)
    if "limit" in results:
        made["performance_limit"] = limit_table(results["limit"])
    return made


def values(own: dict[str, Any], measure: str, clock: str | None = None) -> list[float]:
    """Return the values of the rounds, by default of the clock that counts."""
    if "failure" in own:
        return []
    return [run[clock or MEASURES[measure][1]] for run in own.get(measure, [])]


def median(own: dict[str, Any], measure: str, clock: str | None = None) -> float:
    """Return the median over the rounds, not a number where there are none."""
    known = values(own, measure, clock)
    return float(np.median(known)) if known else float("nan")


def faster_peer(times: dict[str, Any], measure: str) -> str | None:
    """Return the other library with the smaller median."""
    known = {peer: median(times.get(peer, {}), measure) for peer in libraries.PEERS}
    known = {peer: value for peer, value in known.items() if np.isfinite(value)}
    return min(known, key=known.__getitem__) if known else None


def against_peers(times: dict[str, Any], library: str, measure: str) -> str:
    """Return how often `library` fits into the faster of the peers."""
    peer = faster_peer(times, measure)
    return "-" if peer is None else against(times, library, peer, measure)


def against(times: dict[str, Any], library: str, peer: str, measure: str) -> str:
    """Return how often `library` fits into `peer`: the median of the rounds, and their range."""
    own, other = (values(times.get(name, {}), measure) for name in (library, peer))
    if not own or not other:
        return "-"
    ratios = [their / our for their, our in zip(other, own, strict=True)]
    return f"**{np.median(ratios):.2g}** ({min(ratios):.2g}-{max(ratios):.2g})"


def memory_against_peers(times: dict[str, Any], memory: dict[str, Any]) -> str:
    """Return how often our peak fits into that of the peer with the faster build."""
    peer = faster_peer(times, "build")
    peaks = {name: answer.get("bytes") for name, answer in memory.items()}
    if peer is None or not peaks.get(peer) or not peaks.get("ours"):
        return "-"
    return f"**{peaks[peer] / peaks['ours']:.2g}**"


def start_up_table(part: dict[str, Any]) -> str:
    """Return the table of import and first distance, by the clock."""
    sizes = part["sizes"]
    rows = [
        [title, *(against(own["libraries"], *pair, "start") for own in sizes.values())]
        for title, pair in STARTS.items()
    ]
    note = f"{said(sizes)} {sentence(part['machine'])}"
    return markdown(["", *headings(sizes)], rows, note)


def ratio_table(results: dict[str, Any]) -> str:
    """Return the table of this package against the faster of the peers, imports left out."""
    sizes = results["rounds"]["sizes"]
    memory = results.get("memory", {}).get("sizes", {})
    rows = [ratio_row(sizes, libraries.OURS, measure) for measure in PREPARED]
    if memory:
        cells = [
            memory_against_peers(own["libraries"], memory[size]["libraries"])
            if size in memory
            else "-"
            for size, own in sizes.items()
        ]
        rows.append(["peak memory", *cells])
    for measure in PREPARED:
        title, *cells = ratio_row(sizes, libraries.PLAIN, measure)
        rows.append([f"plain heat: {title}", *cells])
    note = f"{said(sizes)} {sentence(results['rounds']['machine'])}"
    return markdown(["", *headings(sizes)], rows, note)


def ratio_row(sizes: dict[str, Any], library: str, measure: str) -> list[str]:
    """Return the row of one measure of a column of this package."""
    cells = [against_peers(own["libraries"], library, measure) for own in sizes.values()]
    return [MEASURES[measure][0], *cells]


def headings(sizes: dict[str, Any]) -> list[str]:
    """Return the names of meshes with their vertices."""
    return [f"{own['mesh']}: {own['vertices']:,}" for own in sizes.values()]


def said(sizes: dict[str, Any]) -> str:
    """Return how many rounds there were."""
    counts = [f"{own['rounds']} at {size}" for size, own in sizes.items()]
    if len({own["rounds"] for own in sizes.values()}) == 1:
        return f"{next(iter(sizes.values()))['rounds']} rounds."
    return f"Rounds: {', '.join(counts)}."


def library_table(results: dict[str, Any]) -> str:
    """Return the table of every library against this package as it is."""

    def cell(own: dict[str, Any], measure: str, library: str) -> str:
        times = own["libraries"]
        if library not in times:
            return "-"
        ratio = median(times[library], measure) / median(times.get("ours", {}), measure)
        return f"{ratio:.2g}" if np.isfinite(ratio) else times[library].get("failure", "-")

    def memory_cell(own: dict[str, Any], _: str, library: str) -> str:
        answers = own["libraries"]
        if "bytes" not in answers.get(library, {}) or "bytes" not in answers.get("ours", {}):
            return answers.get(library, {}).get("failure", "-")
        return f"{answers[library]['bytes'] / answers['ours']['bytes']:.2g}"

    return long_table(results, cell, memory_cell, without=("ours",))


def seconds_table(results: dict[str, Any]) -> str:
    """Return the table of CPU times, and of the clock's in brackets."""

    def cell(own: dict[str, Any], measure: str, library: str) -> str:
        times = own["libraries"].get(library, {})
        cpu, wall = median(times, measure, "cpu"), median(times, measure, "wall")
        return f"{seconds(cpu)} ({seconds(wall)})" if np.isfinite(cpu) else "-"

    def memory_cell(own: dict[str, Any], _: str, library: str) -> str:
        answer = own["libraries"].get(library, {})
        return gigabytes(answer["bytes"]) if "bytes" in answer else answer.get("failure", "-")

    return long_table(results, cell, memory_cell)


Cell = Callable[[dict[str, Any], str, str], str]


def long_table(
    results: dict[str, Any], cell: Cell, memory_cell: Cell, without: tuple[str, ...] = ()
) -> str:
    """Return a table of a row for every measure and library."""
    sizes = results["rounds"]["sizes"]
    memory = results.get("memory", {}).get("sizes", {})
    names = list(dict.fromkeys(name for own in sizes.values() for name in own["libraries"]))
    names = [name for name in names if name not in without]
    rows = [
        [title if k == 0 else "", name, *(cell(own, measure, name) for own in sizes.values())]
        for measure, (title, _) in MEASURES.items()
        for k, name in enumerate(names)
    ]
    for k, name in enumerate(names if memory else []):
        cells = [memory_cell(memory[s], "", name) if s in memory else "-" for s in sizes]
        rows.append(["peak memory" if k == 0 else "", name, *cells])
    return markdown(["", "", *headings(sizes)], rows, "From the same run.", names=2)


def limit_table(part: dict[str, Any]) -> str:
    """Return the table of solves against the reading of their factors."""
    answers = [answer for own in part["sizes"].values() for answer in own["solvers"].values()]
    speed = max((answer.get("bandwidth", 0.0) for answer in answers), default=0.0)
    rows = []
    for own in part["sizes"].values():
        for name, answer in own["solvers"].items():
            mesh = f"{own['mesh']}: {own['vertices']:,}"
            rows.append([mesh, name, *limit_cells(answer, speed)])
    note = f"Memory is read at {speed / 1e9:.3g} GB/s. {sentence(part['machine'])}"
    columns = ["", "solver", "factorise", "factor", "to read it", "a solve", "ratio"]
    columns += [f"ratio in a block of {BATCH}"]
    return markdown(columns, rows, note, names=2)


def limit_cells(answer: dict[str, Any], bytes_a_second: float) -> list[str]:
    """Return the figures of one solver on one mesh."""
    if "failure" in answer:
        return [answer["failure"], *["-"] * 5]
    # LU holds two triangles and reads each once; of Cholesky's one is read twice.
    reads = 1 if answer["solver"] == "SuperLU" else 2
    least = reads * answer["bytes"] / bytes_a_second
    return [
        seconds(answer["factorize"]),
        gigabytes(answer["bytes"]),
        seconds(least),
        seconds(answer["solve"]),
        f"**{answer['solve'] / least:.2g}**",
        f"{answer['block'] / least:.2g}",
    ]
