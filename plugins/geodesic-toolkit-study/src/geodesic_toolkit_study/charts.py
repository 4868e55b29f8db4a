"""Plots of numbers: matplotlib without pyplot, so without a display and without global state."""

from pathlib import Path
from typing import Any

import numpy as np

from geodesic_toolkit.core.atomic import replacing
from geodesic_toolkit.core.optional import require
from geodesic_toolkit_study.results import Results

__all__ = ["draw_charts"]

BLUE, RED, GREEN, GREY, GOLD = "#1f4e9c", "#c8202f", "#2a8a4a", "#8a8a92", "#c98a00"
COLOURS = (BLUE, RED, GREEN, GOLD, GREY)


def draw_charts(results: Results, folder: Path) -> list[str]:
    """Write the charts as PNG files into `folder`, and return their names."""
    charts = {
        "rings.png": _rings,
        "tolerances.png": _tolerances,
        "noise.png": _noise,
        "time_factors.png": _time_factors,
        "sizes.png": _sizes,
    }
    for name, draw in charts.items():
        sheet = _Sheet()
        draw(results, sheet)
        sheet.save(folder / name)
    return list(charts)


class _Sheet:
    """Two charts side by side."""

    def __init__(self) -> None:
        figures = require("matplotlib.figure", "viz", "Pictures need")
        canvases = require("matplotlib.backends.backend_agg", "viz", "Pictures need")
        self.figure = figures.Figure(figsize=(11.0, 4.4), dpi=140, facecolor="white")
        canvases.FigureCanvasAgg(self.figure)
        self.left, self.right = self.figure.subplots(1, 2)
        for axes in (self.left, self.right):
            axes.spines[["top", "right"]].set_visible(False)
            axes.grid(color="#e6e6ea", linewidth=0.8)
            axes.set_axisbelow(True)
            axes.tick_params(labelsize=9)

    def save(self, path: Path) -> None:
        """Write the sheet, whole or not at all."""
        for axes in (self.left, self.right):
            if axes.get_legend() is None and axes.get_legend_handles_labels()[0]:
                axes.legend(frameon=False, fontsize=8.5)
        self.figure.tight_layout(w_pad=2.5)
        with replacing(path) as temporary:
            self.figure.savefig(temporary, format="png")


def _label(axes: Any, title: str, x: str, y: str) -> None:
    axes.set_title(title, fontsize=11, loc="left")
    axes.set_xlabel(x, fontsize=9.5)
    axes.set_ylabel(y, fontsize=9.5)


def _rings(results: Results, sheet: _Sheet) -> None:
    """One ring a step; and the heat against the ring, by both solvers."""
    found = results.time_step
    for source, colour in zip(found.spread, COLOURS, strict=False):
        spread, ring = found.spread[source], found.rings[source]
        within = np.cumsum(np.bincount(ring[np.isfinite(ring)].astype(np.int64)))
        sheet.left.plot(
            np.arange(1, len(within) + 1),
            within,
            color=colour,
            linewidth=1.2,
            label=f"vertices within k − 1 edges of source {source}",
        )
        sheet.left.plot(
            np.arange(1, len(spread) + 1),
            spread,
            "o",
            color=colour,
            markersize=4.5,
            label=f"non-zero entries after step k, source {source}",
        )
    _label(
        sheet.left,
        "Conjugate gradients reach one ring a step",
        "step k",
        f"of {results.subject.mesh.n_vertices:,} vertices",
    )
    source = worst_source(results)
    ring = found.rings[source]
    iterate, direct = found.heats[source, "cg"], found.heats[source, "superlu"]
    parts = (
        (direct, direct > 0, BLUE, "direct"),
        (iterate, iterate > 0, RED, "CG, u > 0"),
        (-iterate, iterate < 0, GOLD, "CG, |u| where u < 0"),
    )
    for values, kind, colour, name in parts:
        shown = kind & np.isfinite(ring)
        sheet.right.semilogy(
            ring[shown], values[shown], ".", color=colour, markersize=2.5, alpha=0.5, label=name
        )
    steps = len(found.spread[source])
    if steps <= ring[np.isfinite(ring)].max():
        sheet.right.axvline(steps - 0.5, color=GREY, linewidth=1.0, linestyle="--")
        sheet.right.annotate(
            f"stopped after {steps} steps:\nbeyond, u = 0",
            (steps, 0.97),
            xycoords=("data", "axes fraction"),
            fontsize=8.5,
            color="#55555c",
            va="top",
        )
    sheet.right.legend(frameon=False, fontsize=8.5, loc="lower left", markerscale=4)
    _label(
        sheet.right,
        f"Heat of source {source} at t = h²",
        "edges from the source",
        "u",
    )


def worst_source(results: Results) -> int:
    """Return the source at which conjugate gradients leave most zeros."""
    rows = [row for row in results.time_step.heat_zeros if row["solver"] == "cg"]
    return int(max(rows, key=lambda row: row["zeros"])["source"])


def _tolerances(results: Results, sheet: _Sheet) -> None:
    for source, colour in zip(results.subject.sources, COLOURS, strict=False):
        rows = [row for row in results.time_step.tolerances if row["source"] == source]
        rtol = [row["rtol"] for row in rows]
        for key, style, name in (
            ("zeros", "o-", "u = 0"),
            ("non_positive", "^--", "u ≤ 0"),
        ):
            sheet.left.semilogx(
                rtol,
                [row[key] for row in rows],
                style,
                color=colour,
                markersize=4,
                linewidth=1.2,
                label=f"{name}, source {source}",
            )
        sheet.right.loglog(
            rtol,
            [row["mean_error"] for row in rows],
            "o-",
            color=colour,
            markersize=4,
            linewidth=1.2,
            label=f"conjugate gradients, source {source}",
        )
        direct = [
            row["mean_error"]
            for row in results.time_step.rows
            if (row["source"], row["time"], row["solver"]) == (source, "h^2", "superlu")
        ]
        sheet.right.axhline(
            direct[0], color=colour, linewidth=1.0, linestyle="--", label=f"direct, source {source}"
        )
    for axes in (sheet.left, sheet.right):
        axes.invert_xaxis()
    _label(sheet.left, "Vertices without heat, at t = h²", "relative tolerance", "vertices")
    _label(sheet.right, "Effect on the distance", "relative tolerance", "mean error [%]")
    _plain_numbers(sheet.right.yaxis)


def _noise(results: Results, sheet: _Sheet) -> None:
    rows = results.noise.rows
    keys = ("change_of_true", "error_across", "error_on_noisy")
    styles = ("s:", "o-", "^--")
    names = (
        "true distance: noisy against clean",
        "heat on the noisy mesh against the clean truth",
        "heat on the noisy mesh against its own truth",
    )
    for style, name in zip(styles, names, strict=True):
        sheet.right.plot([], [], style, color=GREY, markersize=4.5, linewidth=1.2, label=name)
    for source, colour in zip(results.subject.sources, COLOURS, strict=False):
        own = [row for row in rows if row["source"] == source]
        sigma = [100 * row["sigma_of_diagonal"] for row in own]
        for key, style in zip(keys, styles, strict=True):
            sheet.right.plot(
                sigma,
                [row[key] for row in own],
                style,
                color=colour,
                markersize=4.5,
                linewidth=1.2,
            )
        kept = [(s, row["rank_correlation_of_u"]) for s, row in zip(sigma, own, strict=True)]
        kept = [(s, value) for s, value in kept if value is not None]
        if kept:
            sheet.left.plot(
                *zip(*kept, strict=True),
                "o-",
                color=colour,
                markersize=4.5,
                linewidth=1.2,
                label=f"source {source}",
            )
    _label(
        sheet.left,
        "Order of the heat",
        "noise, sigma [% of the diagonal]",
        "rank correlation of u, noisy and clean",
    )
    _label(
        sheet.right,
        "Length: distances, and errors",
        "noise, sigma [% of the diagonal]",
        "mean relative difference [%]",
    )


def _time_factors(results: Results, sheet: _Sheet) -> None:
    rows = results.times.rows
    for source, colour in zip(results.subject.sources, COLOURS, strict=False):
        own = [row for row in rows if row["source"] == source]
        for axes, key, style, name in (
            (sheet.left, "mean_error", "o-", "source"),
            (sheet.right, "slope_error", "o-", "of |∇φ| from 1, source"),
            (sheet.right, "from_refined", "^--", "of φ from the refined one, source"),
        ):
            axes.loglog(
                [row["factor"] for row in own],
                [row[key] for row in own],
                style,
                color=colour,
                markersize=4,
                linewidth=1.2,
                label=f"{name} {source}",
            )
    for rule, marker in zip(results.times.rules[:-1], "DsPX", strict=True):
        sheet.left.plot(
            rule["factor"],
            rule["mean_error"],
            marker,
            color="black",
            markersize=7,
            markerfacecolor="white",
            linestyle="none",
            label=rule["rule"],
        )
    for axes in (sheet.left, sheet.right):
        axes.set_xscale("log", base=2)
        _plain_numbers(axes.yaxis)
    _label(sheet.left, "Error, and what rules choose", "t / h²", "mean error [%]")
    _label(
        sheet.right,
        "Error indicators without the exact distance",
        "t / h²",
        "mean deviation [%]",
    )


def _sizes(results: Results, sheet: _Sheet) -> None:
    surfaces = list(dict.fromkeys(row["surface"] for row in results.sizes))
    for surface, colour in zip(surfaces, COLOURS, strict=False):
        for refined, style in ((False, "o-"), (True, "^--")):
            rows = [
                row
                for row in results.sizes
                if (row["surface"], row["refined"]) == (surface, refined)
            ]
            sheet.left.loglog(
                [row["vertices"] for row in rows],
                [row["mean_error"] for row in rows],
                style,
                color=colour,
                markersize=4.5,
                linewidth=1.2,
                label=f"{surface}, {'refined' if refined else 'heat'}",
            )
    for refined, style in ((False, "o-"), (True, "^--")):
        rows = sorted(
            (row for row in results.sizes if row["refined"] == refined),
            key=lambda row: row["vertices"],
        )
        kind = "refined" if refined else "heat"
        for key, name, colour in (
            ("prepare_ms", "factorise once", GREY),
            ("solve_ms", "one source", GREEN),
        ):
            sheet.right.loglog(
                [row["vertices"] for row in rows],
                [row[key] for row in rows],
                style,
                color=colour,
                markersize=4.5,
                linewidth=1.2,
                label=f"{name}, {kind}",
            )
    _plain_numbers(sheet.left.yaxis)
    _label(sheet.left, "Error against size", "vertices", "mean error [%]")
    _label(sheet.right, "Cost against size", "vertices", "time [ms]")


def _plain_numbers(*axes: Any) -> None:
    """Write 0.5 and 20 on logarithmic axes, rather than powers of ten."""
    ticker = require("matplotlib.ticker", "viz", "Pictures need")
    for axis in axes:
        axis.set_major_formatter(ticker.FormatStrFormatter("%g"))
        axis.set_minor_locator(ticker.LogLocator(subs=(2.0, 5.0)))
        axis.set_minor_formatter(ticker.FormatStrFormatter("%g"))
