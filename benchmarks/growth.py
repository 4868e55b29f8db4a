"""Time and memory as shapes grow: spheres as meshes and as clouds, up to millions of vertices.

Every size is measured in a process of its own, which may run out of memory without harm to the
others. Errors are against the arc on the unit sphere, the antipode of the source among them.

python benchmarks/growth.py                                   everything, and a picture
python benchmarks/growth.py --mesh 10k,40k,160k --cloud 10k   some sizes; --cloud "" for none
python benchmarks/growth.py --write                           also into docs
"""

import argparse
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from measuring import shapes
from measuring.machine import machine, sentence
from measuring.processes import NoAnswerError, Process
from measuring.tables import STATIC, TABLES, gigabytes, load, markdown, save, seconds

RESULTS = TABLES / "growth.json"
PICTURE = STATIC / "growth.png"

MESHES = "10k,40k,160k,640k,2.5M,5M"
CLOUDS = "10k,40k,160k,640k,2M"

SMALL = 200_000
"""Vertices up to which the median of three processes is taken."""

STAGES = {"build": "build", "one": "one source", "ten": "ten sources"}
WARM_UP = 2562


# -- measuring -------------------------------------------------------------------------------------


def measure(kind: str, sizes: str, limit: float, folder: Path) -> list[dict[str, Any]]:
    """Return the figures of every size of one kind, in rising order."""
    found = []
    small = keep(folder / f"{kind}-warm-up.npz", kind, WARM_UP)[0]
    for n_wanted in sorted(shapes.count(size) for size in sizes.split(",") if size):
        path, n_vertices = keep(folder / f"{kind}.npz", kind, n_wanted)
        runs = [run(kind, small, path, limit) for _ in range(3 if n_vertices <= SMALL else 1)]
        figures = {"vertices": n_vertices, **middle(runs)}
        found.append(figures)
        print(f"    {kind} {figures}", flush=True)
    return found


def keep(path: Path, kind: str, n_vertices: int) -> tuple[str, int]:
    """Write the arrays of a sphere, and return where and how many points it has."""
    if kind == "cloud":
        points = shapes.sphere_cloud(n_vertices)
        np.savez(path, points=points)
        return str(path), len(points)
    vertices, faces = shapes.sphere(n_vertices)
    np.savez(path, vertices=vertices, faces=faces)
    return str(path), len(vertices)


def run(kind: str, small: str, path: str, limit: float) -> dict[str, Any]:
    """Return the stages that one process has finished, and why the next is missing."""
    stages: dict[str, Any] = {}
    process = Process("measuring.growing", kind, small, path)
    try:
        for _ in STAGES:
            answer = process.answer(limit)
            stages[answer.pop("stage")] = answer
    except NoAnswerError as failure:
        return stages | {"failure": str(failure)}
    process.close()
    return stages


def middle(runs: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the medians of runs; of those that failed, the first one."""
    for one in runs:
        if "failure" in one:
            return one
    return {
        stage: {
            name: float(np.median([one[stage][name] for one in runs]))
            if isinstance(value, float | int)
            else value
            for name, value in runs[0][stage].items()
        }
        for stage in STAGES
    }


# -- the table and the picture ---------------------------------------------------------------------


def table(results: dict[str, Any]) -> str:
    """Return the table of all sizes."""
    rows = []
    for kind in ("mesh", "cloud"):
        found = results.get(kind, [])
        rows += [[kind, f"{figures['vertices']:,}", *cells(figures)] for figures in found]
        rows += exponents(found, kind)
    columns = ["", "vertices", "solver", *STAGES.values(), "peak memory", "predicted", "error"]
    columns += ["at the antipode"]
    return markdown(columns, rows, sentence(results["machine"]).strip())


def cells(figures: dict[str, Any]) -> list[str]:
    """Return a row of the table, with a failure in place of a time."""
    failure = figures.get("failure", "-")
    build, one = figures.get("build", {}), figures.get("one", {})
    shown = []
    for stage in STAGES:
        known = stage in figures
        shown.append(seconds(figures[stage]["cpu"]) if known else failure)
        failure = failure if known else "-"
    peaks = [figures[stage]["peak"] for stage in STAGES if stage in figures]
    expected = build.get("predicted")
    return [
        build.get("solver", "-"),
        *shown,
        gigabytes(max(peaks)) if peaks else "-",
        gigabytes(expected) if expected else "-",
        f"{one['mean_error']:.2g} %" if one else "-",
        f"{one['antipode_error']:.2g} %" if one else "-",
    ]


def exponents(found: list[dict[str, Any]], kind: str) -> list[list[str]]:
    """Return a row of the exponents that fit best, where there are sizes enough."""
    fits = [fit(found, stage, "cpu") for stage in STAGES] + [fit(found, "ten", "peak")]
    if None in fits:
        return []
    return [[f"**{kind}**", "**exponent**", "", *(f"**{x:.2f}**" for x in fits), "", "", ""]]


def fit(found: list[dict[str, Any]], stage: str, figure: str) -> float | None:
    """Return p of the power ``vertices**p`` through a figure, by least squares of logarithms."""
    pairs = [(row["vertices"], row[stage][figure]) for row in found if stage in row]
    if len(pairs) < 3:
        return None
    sizes, values = np.log(np.array(pairs, dtype=float)).T
    return float(np.polyfit(sizes, values, 1)[0])


COLOURS = {"build": "#1f4e9c", "one": "#c8202f", "ten": "#2a8a4a"}
STYLES = {"mesh": ("-", "o"), "cloud": ("--", "s")}


def draw(results: dict[str, Any], path: Path) -> None:
    """Write the picture: time on the left, memory on the right, both axes logarithmic."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 4.6), dpi=140, facecolor="white")
    FigureCanvasAgg(figure)
    time_axes, memory_axes = figure.subplots(1, 2)
    for kind, (line, marker) in STYLES.items():
        found = results.get(kind, [])
        for stage, title in STAGES.items():
            draw_line(time_axes, found, stage, "cpu", f"{kind}, {title}", line, marker)
        draw_line(memory_axes, found, "ten", "peak", f"{kind}, measured", line, marker, scale=1e-9)
        draw_line(
            memory_axes, found, "build", "predicted", f"{kind}, predicted", line, "x", scale=1e-9
        )
    for axes, label in ((time_axes, "CPU time [s]"), (memory_axes, "memory [GB]")):
        axes.set(xscale="log", yscale="log")
        axes.set_xlabel("vertices", fontsize=9.5)
        axes.set_ylabel(label, fontsize=9.5)
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(color="#e6e6ea", linewidth=0.8)
        axes.set_axisbelow(True)
        axes.tick_params(labelsize=9)
        axes.legend(frameon=False, fontsize=8.5)
    time_axes.set_title("Time, and the power of the size it grows with", fontsize=11, loc="left")
    memory_axes.set_title("Peak memory over the imports", fontsize=11, loc="left")
    figure.tight_layout(w_pad=2.5)
    figure.savefig(path, format="png")


def draw_line(
    axes: Any,
    found: list[dict[str, Any]],
    stage: str,
    figure: str,
    label: str,
    line: str,
    marker: str,
    scale: float = 1.0,
) -> None:
    """Draw a figure against the size, with the exponent that fits it in the legend."""
    rows = [row for row in found if row.get(stage, {}).get(figure)]
    if not rows:
        return
    power = fit(rows, stage, figure)
    axes.plot(
        [row["vertices"] for row in rows],
        [scale * row[stage][figure] for row in rows],
        linestyle=line,
        marker=marker,
        markersize=4.5,
        linewidth=1.3,
        color="#8a8a92" if figure == "predicted" else COLOURS[stage],
        label=label + ("" if power is None else f": {power:.2f}"),
    )


# -- the command -----------------------------------------------------------------------------------


def main() -> None:
    """Run the benchmark of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--mesh", default=MESHES, metavar="SIZES", help=f"default: {MESHES}")
    parser.add_argument("--cloud", default=CLOUDS, metavar="SIZES", help=f"default: {CLOUDS}")
    parser.add_argument("--limit", type=float, default=1800.0, help="seconds a stage may take")
    parser.add_argument("--picture", type=Path, help="where to draw it, beside the documentation")
    parser.add_argument("--write", action="store_true", help="write into the documentation")
    arguments = parser.parse_args()
    results = load(RESULTS) if arguments.write else {}
    results["machine"] = machine()
    with tempfile.TemporaryDirectory() as folder:
        for kind in STYLES:
            sizes = getattr(arguments, kind)
            if sizes:
                results[kind] = measure(kind, sizes, arguments.limit, Path(folder))
            if arguments.write:
                save(RESULTS, results, {"growth": table(results)})
    if arguments.write:
        draw(results, PICTURE)
    if arguments.picture:
        draw(results, arguments.picture)
    print(f"\n{table(results)}")


if __name__ == "__main__":
    main()
