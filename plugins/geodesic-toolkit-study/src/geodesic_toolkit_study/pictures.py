"""Pictures of fields on the surface, set side by side."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit.core.atomic import replacing
from geodesic_toolkit.core.optional import require
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.viz import plot
from geodesic_toolkit.viz.colours import INK
from geodesic_toolkit_study.beyond import REFINED
from geodesic_toolkit_study.charts import worst_source
from geodesic_toolkit_study.noise import LEVELS
from geodesic_toolkit_study.results import TIMES, Results
from geodesic_toolkit_study.time_step import RTOL

__all__ = ["draw_pictures"]

CELL = (800, 450)

TITLE = 44
"""Pixels above each picture for its title, in type that is still legible on half a page."""

USUAL = "cotan, barycentric areas"
"""The diffusion shown at t = h² too; with other areas it looks the same."""

SOLVERS = {"cg": f"CG, rtol {RTOL:.0e}".replace("e-0", "e-"), "superlu": "direct solver"}


@dataclass(frozen=True, kw_only=True)
class _Cell:
    mesh: TriangleMesh
    values: FloatArray
    source: int
    title: str
    label: str
    cmap: str = "viridis"
    limits: tuple[float, float] | None = None
    isolines: int = 14

    def draw(self) -> NDArray[np.uint8]:
        options: dict[str, Any] = {"cmap": self.cmap, "isolines": self.isolines}
        return plot(
            self.mesh,
            self.values,
            sources=[self.source],
            label=self.label,
            limits=self.limits,
            size=CELL,
            **options,
        )


def draw_pictures(results: Results, folder: Path) -> list[str]:
    """Write the pictures as PNG files into `folder`, and return their names."""
    sheets = {
        "distance.png": _distance(results),
        **{
            f"time_step_{source}.png": _time_step(results, source)
            for source in results.subject.sources
        },
        "heat.png": _heat(results),
        "noise_heat.png": _noise(results),
        "discretizations.png": _discretizations(results),
        "error_maps.png": _error_maps(results),
    }
    for name, rows in sheets.items():
        _save(_sheet(rows), folder / name)
    return list(sheets)


def _sheet(rows: list[list[_Cell]]) -> NDArray[np.uint8]:
    """Return the pictures in rows, each below its title, on white."""
    width, height = CELL[0], CELL[1] + TITLE
    page = np.full((height * len(rows), width * max(map(len, rows)), 3), 255, dtype=np.uint8)
    figures = require("matplotlib.figure", "viz", "Pictures need")
    canvases = require("matplotlib.backends.backend_agg", "viz", "Pictures need")
    figure = figures.Figure(figsize=(page.shape[1] / 100, page.shape[0] / 100), dpi=100)
    canvas = canvases.FigureCanvasAgg(figure)
    for i, row in enumerate(rows):
        for j, cell in enumerate(row):
            top = i * height + TITLE
            page[top : top + CELL[1], j * width : (j + 1) * width] = cell.draw()
            x, y = (j + 0.5) * width / page.shape[1], 1 - (top - 0.4 * TITLE) / page.shape[0]
            style = {"ha": "center", "va": "center", "fontsize": 13.5, "color": INK}
            figure.text(x, y, cell.title, parse_math=False, **style)
    figure.figimage(page, 0, 0, origin="upper")
    canvas.draw()
    return np.array(canvas.buffer_rgba(), dtype=np.uint8)[:, :, :3].copy()


def _distance(results: Results) -> list[list[_Cell]]:
    """The best distance that there is, from the first source."""
    subject = results.subject
    source = subject.sources[0]
    return [
        [
            _Cell(
                mesh=subject.mesh,
                values=results.beyond.distances[REFINED, source],
                source=source,
                title=f"{subject.name}: geodesic distance from vertex {source}",
                label="distance",
                isolines=20,
            )
        ]
    ]


def _time_step(results: Results, source: int) -> list[list[_Cell]]:
    """The first experiments' figures: normalised distances in brg, beside what they should be."""
    rows = []
    for time, shown in TIMES.items():
        row = []
        for solver, named in SOLVERS.items():
            figures = next(
                row
                for row in results.time_step.rows
                if (row["source"], row["time"], row["solver"]) == (source, time, solver)
            )
            zeros = f", {figures['zeros']:,} zeros in u" if figures["zeros"] else ""
            row.append(
                _Cell(
                    mesh=results.subject.mesh,
                    values=_normalised(results.time_step.distances[source, time, solver]),
                    source=source,
                    title=f"t = {shown}, {named}: mean error {figures['mean_error']:.1f} %{zeros}",
                    label="distance / largest",
                    cmap="brg",
                    limits=(0.0, 1.0),
                )
            )
        rows.append(row)
    return rows


def _heat(results: Results) -> list[list[_Cell]]:
    """Return cells with the heat of conjugate gradients, and the rings that they reached."""
    source, subject = worst_source(results), results.subject
    ring = results.time_step.rings[source]
    steps = len(results.time_step.spread[source])
    heats = [results.time_step.heats[source, solver] for solver in SOLVERS]
    logs = [np.log10(heat, out=np.full_like(heat, np.nan), where=heat > 0) for heat in heats]
    low, high = _range(logs[1])
    cells = [
        _Cell(
            mesh=subject.mesh,
            values=np.where(ring < steps, ring, np.nan),
            source=source,
            title=f"rings 0 to {steps - 1}: within reach of {steps} steps",
            label="edges from the source",
            cmap="cividis",
        )
    ]
    for log_heat, name in zip(logs, SOLVERS.values(), strict=True):
        missing = int(np.isnan(log_heat[subject.reached(source)]).sum())
        grey = f"; grey: u ≤ 0 at {missing:,} vertices" if missing else ""
        cells.append(
            _Cell(
                mesh=subject.mesh,
                values=log_heat,
                source=source,
                title=f"log₁₀ u, {name}{grey}",
                label="log₁₀ u",
                limits=(low, high),
            )
        )
    return [[cell] for cell in cells]


def _noise(results: Results) -> list[list[_Cell]]:
    """Heat and distance from the first source, on the clean mesh and on noisy ones."""
    found, source = results.noise, results.subject.sources[0]
    rows = []
    for level in (0.0, *LEVELS):
        mesh = found.subjects[level].mesh if level else results.subject.mesh
        shown = f"noise {100 * level:g} % of the diagonal" if level else "no noise"
        log_heat = found.log_heats[level, source] / np.log(10)
        common: dict[str, Any] = {"mesh": mesh, "source": source}
        rows.append(
            [
                _Cell(
                    values=_finite(log_heat - log_heat[np.isfinite(log_heat)].max()),
                    title=f"log₁₀ u, {shown}",
                    label="log₁₀ (u / largest)",
                    **common,
                ),
                _Cell(
                    values=found.distances[level, source],
                    title=f"distance, {shown}",
                    label="distance",
                    **common,
                ),
            ]
        )
    return rows


def _discretizations(results: Results) -> list[list[_Cell]]:
    """Return cells with the heat of each diffusion, and the signed error of its distance."""
    found, source = results.discretizations, results.subject.sources[0]
    true = results.subject.true(source)
    off = [
        np.abs(_signed(field, true)) for (*_, of), field in found.distances.items() if of == source
    ]
    limit = max(float(np.nanquantile(np.concatenate(off), 0.98)), 0.1)
    rows = []
    for diffusion, time, of in found.heats:
        if of != source or (time == "h^2" and diffusion != USUAL):
            continue
        figures = next(
            row
            for row in found.rows
            if (row["diffusion"], row["time"], row["source"]) == (diffusion, time, source)
        )
        common: dict[str, Any] = {"mesh": results.subject.mesh, "source": source}
        rows.append(
            [
                _Cell(
                    values=_finite(found.heats[diffusion, time, source]),
                    title=f"log₁₀ u, {diffusion}, t = {TIMES[time]}",
                    label="log₁₀ (u / largest)",
                    **common,
                ),
                _error_map(
                    found.distances[diffusion, time, source],
                    true,
                    title=f"error, {diffusion}, t = {TIMES[time]}: mean "
                    f"{figures['mean_error']:.1f} %",
                    limit=limit,
                    **common,
                ),
            ]
        )
    return rows


def _error_maps(results: Results) -> list[list[_Cell]]:
    """Signed errors of every method, in one scale: that of plain heat."""
    subject, source = results.subject, results.subject.sources[0]
    true = subject.true(source)
    first = (source, "h^2", "cg")
    maps = {f"heat by {SOLVERS['cg']}": results.time_step.distances[first]} | {
        name: distance for (name, of), distance in results.beyond.distances.items() if of == source
    }
    heat = _signed(results.beyond.distances["heat", source], true)
    limit = max(float(np.nanmax(np.abs(heat))), 0.1) if np.isfinite(heat).any() else 1.0
    cells = [
        _error_map(
            distance,
            true,
            mesh=subject.mesh,
            source=source,
            title=f"{name}: mean error {subject.error(distance, source)['mean']:.2f} %",
            limit=limit,
        )
        for name, distance in maps.items()
    ]
    return [cells[start : start + 2] for start in range(0, len(cells), 2)]


def _error_map(
    distance: FloatArray,
    true: FloatArray,
    *,
    mesh: TriangleMesh,
    source: int,
    title: str,
    limit: float,
) -> _Cell:
    return _Cell(
        mesh=mesh,
        values=_signed(distance, true),
        source=source,
        title=title,
        label="error [% of the largest distance]",
        cmap="RdBu_r",
        limits=(-limit, limit),
        isolines=0,
    )


def _signed(distance: FloatArray, true: FloatArray) -> FloatArray:
    """Return the error in per cent of the largest true distance, NaN where there is none."""
    both = np.isfinite(distance) & np.isfinite(true)
    scale = true[both].max() if both.any() and true[both].max() > 0 else 1.0
    error: FloatArray = np.full(len(true), np.nan)
    error[both] = 100 * (distance[both] - true[both]) / scale
    return error


def _normalised(distance: FloatArray) -> FloatArray:
    """Return the distance moved and scaled to [0, 1], NaN where it is not finite."""
    values = _finite(distance)
    low, high = _range(values)
    return (values - low) / (high - low)


def _range(values: FloatArray) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    return (low, high) if high > low else (low, low + 1.0)


def _finite(values: FloatArray) -> FloatArray:
    """Return the values with NaN for what is not finite."""
    return np.where(np.isfinite(values), values, np.nan)


def _save(page: NDArray[np.uint8], path: Path) -> None:
    from PIL import Image

    with replacing(path) as temporary:
        Image.fromarray(page).save(temporary, format="PNG", optimize=True)
