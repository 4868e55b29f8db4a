"""Clouds as sensors write them, by casting rays: sweeps, scan lines, repeated passes, walls.

python benchmarks/sensors.py           all of it: five minutes
python benchmarks/sensors.py --write   also into docs/_tables

Errors are relative to the shortest path over the ground, in per cent, from 2 m or 2 spacings on.
Only points within sight of the source count, so that blind discs and shadows block no path.
"""

import argparse
import warnings
from collections.abc import Iterator

import numpy as np
import potpourri3d as pp3d
from measuring.tables import TABLES, markdown

import geodesic_toolkit as gt

BEAMS = {16: (-15, 15), 32: (-25, 15), 64: (-24.8, 2), 128: (-25, 15)}
AZIMUTHS = {16: (0.1, 0.2, 0.4), 32: (0.1, 0.2, 0.4), 64: (0.2, 0.4), 128: (0.4,)}
HOUSES = [((-50, 7, -1), (50, 8, 6)), ((-50, -8, -1), (50, -7, 6))]
BOXES = [((9, 3.5, 0), (13.3, 5.3, 1.5)), ((-15, 3.4, 0), (-10.8, 5.2, 1.4))]
NOISE = 0.02
NOTE = "Noise of 2 cm in range; the source is 8 m ahead of the scanner."
Case = tuple[str, np.ndarray, int, np.ndarray]


def sweep(beams: int, azimuth: float, slope: float, boxes: list) -> tuple[np.ndarray, np.ndarray]:
    """Return the points that a scanner 1.8 m over ground writes, and which are of the ground."""
    down, turn = np.meshgrid(
        np.radians(np.linspace(*BEAMS[beams], beams)), np.radians(np.arange(0, 360, azimuth))
    )
    down, turn = down.ravel(), turn.ravel()
    flat = np.cos(down)
    rays = np.column_stack([flat * np.cos(turn), flat * np.sin(turn), np.sin(down)])
    start = np.array([0, 0, 1.8])
    with np.errstate(divide="ignore", invalid="ignore"):
        ground = 1.8 / (slope * rays[:, 0] - rays[:, 2])
        hits = [np.where((ground > 0) & (ground < 60), ground, np.inf)]
        for low, high in boxes:
            one, other = (np.array(low) - start) / rays, (np.array(high) - start) / rays
            near, far = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
            hits.append(np.where((near < far) & (near > 0), near, np.inf))
    reach = np.min(hits, axis=0)
    seen = np.isfinite(reach)
    reach = reach[seen] + NOISE * np.random.default_rng(0).normal(size=seen.sum())
    return start + reach[:, None] * rays[seen], np.argmin(hits, axis=0)[seen] == 0


def sweeps() -> Iterator[Case]:
    """Yield sweeps with a source ahead; points in its direction have a known distance."""
    for name, slope, boxes in (
        ("flat", 0.0, []),
        ("slope", 0.15, []),
        ("street", 0.0, HOUSES + BOXES),
    ):
        for beams, azimuths in AZIMUTHS.items():
            for azimuth in azimuths:
                points, ground = sweep(beams, azimuth, slope, boxes)
                source = int(np.argmin(np.linalg.norm(points - [8, -1, 8 * slope], axis=1)))
                true = np.linalg.norm(points - points[source], axis=1)
                turn = np.arctan2(points[:, 1], points[:, 0])
                beside = np.abs(turn - turn[source]) > 0.3
                behind_box = (points[:, 1] > 1.5) & (name == "street")
                true[~ground | beside | behind_box | (true < 2)] = np.nan
                yield f"{name}, {beams} beams, {azimuth}°", points, source, true


def scan_lines() -> Iterator[Case]:
    """Yield lines that are 1 to 50 times as far apart as their points."""
    rng = np.random.default_rng(0)
    for ratio in (1, 2, 5, 10, 20, 50):
        lines = 24
        along, across = np.meshgrid(np.arange(lines * ratio) / ratio, np.arange(lines))
        along = along + rng.uniform(0, 1, (lines, 1))
        points = np.column_stack([along.ravel(), across.ravel(), np.zeros(along.size)])
        points[:, 0] += rng.uniform(-0.1, 0.1, len(points)) / ratio
        source = len(points) // 3 + 12 * ratio
        true = np.linalg.norm(points - points[source], axis=1)
        true[(true < 2) | (points[:, 0] < 3) | (points[:, 0] > lines - 3)] = np.nan
        yield f"scan lines, {ratio} times as far apart", points, source, true


def passes() -> Iterator[Case]:
    """Yield a sphere that was hit many times."""
    i = np.arange(1500) + 0.5
    polar, turn = np.arccos(1 - 2 * i / 1500), np.pi * (1 + 5**0.5) * i
    ball = np.column_stack([np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar)])
    ball = np.column_stack([ball, np.cos(polar)])
    for shake in (1e-3, 1e-2, 1e-1):
        for times in (1, 2, 5, 10, 20, 40):
            rng = np.random.default_rng(0)
            true = np.tile(np.arccos(np.clip(ball @ ball[0], -1, 1)), times)
            true[true < 0.3] = np.nan
            noise = shake * np.sqrt(4 * np.pi / 1500) * rng.normal(size=(1500 * times, 3))
            yield f"{times} passes, {shake} spacings", np.tile(ball, (times, 1)) + noise, 0, true


def row(case: Case) -> list[str]:
    """Return what was reached, and the errors: refined, of plain heat, of potpourri3d."""
    name, points, source, true = case
    cells = [name, f"{len(points):,}"]
    for refine in (True, False):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            distance = gt.GeodesicSolver(gt.PointCloud(points), refine=refine).distance(source)
        if refine:
            cells.append(f"{100 * np.isfinite(distance).mean():.1f} %")
        cells.append(error(distance, true) + (" (warned)" if caught else ""))
    try:
        theirs = pp3d.PointCloudHeatSolver(points).compute_distance(source)
        cells.append(error(theirs, true))
    except RuntimeError as failure:  # of clouds with points that it leaves out
        print(f"potpourri3d: {failure}")
        cells.append("fails")
    print(" | ".join(cells), flush=True)
    return cells


def error(distance: np.ndarray, true: np.ndarray) -> str:
    """Return the mean relative error where both are known."""
    known = np.isfinite(true) & np.isfinite(distance)
    if not known.any():
        return "-"
    return f"{100 * np.mean(np.abs(distance - true)[known] / true[known]):.2g} %"


def main() -> None:
    """Measure, print, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="write the table into docs/_tables")
    arguments = parser.parse_args()
    rows = [row(case) for cases in (sweeps, scan_lines, passes) for case in cases()]
    table = markdown(["", "points", "reached", "refined", "plain heat", "potpourri3d"], rows, NOTE)
    if arguments.write:
        (TABLES / "sensors.md").write_text(table, encoding="utf-8")


if __name__ == "__main__":
    main()
