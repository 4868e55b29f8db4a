"""Conclusions in words: every sentence follows from the numbers of the given mesh."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from geodesic_toolkit_study.beyond import REFINED
from geodesic_toolkit_study.results import TIMES, Results
from geodesic_toolkit_study.time_step import RTOL

__all__ = [
    "on_noise",
    "on_operators",
    "on_sizes",
    "on_the_discretization",
    "on_the_solver",
    "on_the_step",
    "on_times",
]


def on_the_solver(results: Results) -> list[str]:
    """Say what conjugate gradients do to the heat at t = h²."""
    found, points = results.time_step, []
    for row in _where(found.rows, time="h^2", solver="cg"):
        source = row["source"]
        (direct,) = _where(found.rows, time="h^2", solver="superlu", source=source)
        ring = found.rings[source]
        steps = row["iterations"]
        beyond = int((np.isfinite(ring) & (ring >= steps)).sum())
        reached = int(np.isfinite(ring).sum())
        points.append(
            f"Source {source}: conjugate gradients stopped at their tolerance of {RTOL:g} after "
            f"{steps} steps, and left **{row['zeros']:,} of {reached:,}** vertices at exactly 0. "
            f"{beyond:,} vertices are {steps} edges or more from the source"
            + (
                ": the very same ones, which no step had reached."
                if beyond == row["zeros"]
                else "; no step had reached them."
            )
            + f" The direct solver leaves {_count(direct['zeros'], 'zero')}. The mean error of "
            f"the distance is {row['mean_error']:.1f} % against {direct['mean_error']:.2f} %."
        )
    harmed = [row for row in _where(found.rows, time="h^2", solver="cg") if row["zeros"]]
    points.append(
        "The flat far part is therefore no property of t = h²: it is where the iteration never "
        "came. The gradient of 0 is 0, so there X = 0 and the distance stays nearly flat."
        if harmed
        else "On this mesh the iteration came all the way before it stopped, so nothing is flat: "
        "the mesh has fewer rings than the iteration had steps. On a larger one it would be."
    )
    return points


def on_the_step(results: Results) -> list[str]:
    """Compare the three time steps, solved directly."""
    rows = _where(results.time_step.rows, solver="superlu")
    errors = {time: _mean(_where(rows, time=time)) for time in results.subject.times}
    best = min(errors, key=lambda time: errors[time])
    shown = ", ".join(f"{value:.2f} % at t = {TIMES[time]}" for time, value in errors.items())
    points = [f"Solved directly, the mean error is {shown}: least at t = {TIMES[best]}."]
    h = results.subject.h
    points.append(
        f"t = h is not a step of its own: t is an area and h a length, so what it means depends on "
        f"the unit of the file. Here h = {h:.4g}, which makes t = h the same as {1 / h:.4g} h², "
        f"and t = 1 as {1 / h**2:.4g} h². In another unit these would be other factors."
    )
    tolerances = results.time_step.tolerances
    loosest, tightest = tolerances[0]["rtol"], tolerances[-1]["rtol"]
    steps = "; ".join(
        f"from {own[0]['iterations']} to {own[-1]['iterations']} at source {source}"
        for source in results.subject.sources
        for own in [_where(tolerances, source=source)]
    )
    zeros = [row["rtol"] for row in tolerances if row["zeros"]]
    left = max(row["non_positive"] for row in _where(tolerances, rtol=tightest))
    points.append(
        f"As the tolerance goes from {loosest:g} to {tightest:g}, the steps grow {steps}. "
        + (f"Zeros are left down to {min(zeros):g}; " if zeros else "No tolerance leaves zeros; ")
        + f"at {tightest:g}, {_count(left, 'value')} "
        + ("is" if left == 1 else "are")
        + " not positive. The tolerance is relative to the right-hand side as a whole, and says "
        "nothing of a single small value."
    )
    return points


def on_noise(results: Results) -> list[str]:
    """Say what noise does to the heat and to the distances."""
    rows = results.noise.rows
    strongest = max(row["sigma_of_diagonal"] for row in rows)
    worst = _where(rows, sigma_of_diagonal=strongest)
    ranks = [row["rank_correlation_of_u"] for row in worst]
    known = [rank for rank in ranks if rank is not None]
    points = []
    if known:
        points.append(
            f"At the strongest noise, sigma = {100 * strongest:g} % of the diagonal "
            f"({worst[0]['sigma_of_edge']:.2f} mean edge lengths), the rank correlation of u with "
            f"that of the clean mesh is still {min(known):.4f} or more: "
            + (
                "the order of the values stays nearly the same."
                if min(known) > 0.95
                else "the order of the values suffers as well."
            )
        )
    heat, true = _mean(worst, "change_of_distance"), _mean(worst, "change_of_true")
    growth = worst[0]["edge_growth"]
    points.append(
        f"The distances do change, by {heat:.1f} % on average. "
        + ("Most of that is not the method's doing: " if true > 0.5 * heat else "")
        + f"the true distances on the noisy mesh are {true:.1f} % from those on the clean one"
        + (
            f", as its edges have become {growth:.0f} % longer. Noise makes every way longer."
            if growth > 0
            else "."
        )
    )
    weakest = _where(rows, sigma_of_diagonal=min(row["sigma_of_diagonal"] for row in rows))
    before, after, auto = (
        _mean(weakest, "error_on_noisy"),
        _mean(worst, "error_on_noisy"),
        _mean(worst, "error_of_auto"),
    )
    points.append(
        f"Against the truth of the noisy mesh itself, the error goes from {before:.2f} % at the "
        f"weakest noise to {after:.2f} % at the strongest. The operator that the library chooses "
        f"by itself has {auto:.2f} % there: it flips edges where many angles are obtuse, as noise "
        "makes them, which keeps the heat positive "
        + (
            "and pays here."
            if auto < after
            else "but costs accuracy where plain heat is positive anyway, as here."
            if not any(row["non_positive"] for row in worst)
            else "but does not pay here."
            if auto > after
            else "and changes nothing here."
        )
    )
    return points


def on_the_discretization(results: Results) -> list[str]:
    """Compare what the heat flows in."""
    rows = results.discretizations.rows

    def error(diffusion: str, time: str) -> float:
        return _mean(_where(rows, diffusion=diffusion, time=time))

    voronoi, thirds = (error(f"cotan, {kind} areas", "h") for kind in ("Voronoi", "barycentric"))
    uniform, at_one = (error("uniform, identity mass", time) for time in ("h", "1"))
    spread = max(
        row["decades_of_u"] for row in _where(rows, diffusion="uniform, identity mass", time="h")
    )
    h, gap = results.subject.h, abs(voronoi - thirds)
    areas = f"Voronoi and barycentric areas give {voronoi:.2f} % and {thirds:.2f} % at t = h: " + (
        "the choice has almost no effect."
        if gap < 0.1 * max(voronoi, thirds)
        else "the choice matters on this mesh."
    )
    edges = (
        f"The uniform Laplacian with identity mass gives {uniform:.1f} % at t = h and "
        f"{at_one:.1f} % at t = 1. It has no unit of length: its t counts squared edges. "
    )
    if h < 0.2:
        edges += (
            f"So t = h = {h:.3g} is a tiny time step: u falls by a factor of about 1/t = "
            f"{1 / h:.0f} with every ring, {spread:.0f} decades in all, and depends on the number "
            "of the ring rather than on a length. "
        )
    edges += (
        "At t = 1, which is to it what t = h² is to the cotangent Laplacian, it is "
        + ("better, but " if at_one < uniform else "no better; ")
        + "lengths of edges and angles of faces are unknown to it still."
    )
    usual = error("cotan, barycentric areas", "h^2")
    return [areas, edges, f"The cotangent Laplacian at t = h² has {usual:.2f} %."]


def on_operators(results: Results) -> list[str]:
    """Compare the operators of the library."""
    rows = results.beyond.rows
    exact = {results.subject.reference(source) for source in results.subject.sources} == {"exact"}
    names = [
        name
        for name in dict.fromkeys(row["method"] for row in rows)
        if exact or name != REFINED  # it would be measured against itself
    ]
    errors = {name: _mean(_where(rows, method=name)) for name in names}
    ordered = sorted(errors, key=lambda name: errors[name])
    heat = errors["heat"]
    points = [
        "From the most accurate on: "
        + ", ".join(f"{name} {errors[name]:.2f} %" for name in ordered)
        + "."
    ]
    refined = errors.get(REFINED, 0.0)
    if refined > 0:
        points.append(
            f"Sweeping wavefronts over the triangles in the order of the heat divides its error "
            f"by {heat / refined:.1f}: the heat knows well in which order the vertices are "
            "reached, and the sweep measures how far they are."
        )
    if "graph of the edges" in errors:
        along = errors["shortest path along edges"]
        points.append(
            f"A graph of the edges alone reaches {errors['graph of the edges']:.1f} "
            f"% by heat; the shortest path along the same edges is {along:.1f} % off"
            + (", because it cannot cut corners." if along > errors["graph of the edges"] else ".")
        )
    points += [f"Left out: {name}, because {why}" for name, why in results.beyond.left_out.items()]
    return points


def on_times(results: Results) -> list[str]:
    """Say how well a time step can be chosen without knowing the truth."""
    *rules, best = results.times.rules
    shown = "; ".join(
        f"{rule['rule']}: t = {rule['factor']:.3g} h², {rule['mean_error']:.2f} %" for rule in rules
    )
    usual, chosen = rules[0], min(rules, key=lambda rule: rule["mean_error"])
    choices = (
        f"Knowing the truth one would take t = {best['factor']:g} h² and have "
        f"{best['mean_error']:.2f} %. Rules that do not know it: {shown}."
    )
    return [
        choices,
        f"The best of these rules here is the {chosen['rule']}. The paper's h² costs "
        f"{usual['mean_error'] - best['mean_error']:.2f} percentage points against the best and "
        "needs no sweep; "
        + (
            "tuning t is not worth while."
            if usual["mean_error"] < 1.5 * best["mean_error"]
            else "on this mesh, looking for a better t is worth while."
        ),
    ]


def on_sizes(results: Results) -> list[str]:
    """Say how errors fall and costs grow with the size of the mesh."""
    points = []
    for surface in dict.fromkeys(row["surface"] for row in results.sizes):
        for refined in (False, True):
            rows = _where(results.sizes, surface=surface, refined=refined)
            known = [row for row in rows if row["mean_error"] > 0]
            if len(known) < 2:
                continue
            errors = np.array([row["mean_error"] for row in known])
            sizes = np.log([row["vertices"] for row in known])
            shown = ", ".join(f"{row['mean_error']:.3g} % at {row['vertices']:,}" for row in known)
            if (np.diff(errors) < 0).all():
                order = -2 * np.polyfit(sizes, np.log(errors), 1)[0]
                trend = f"it falls with the power {order:.1f} of the edge length"
            else:
                trend = "it does not fall steadily"
            kind = "refined" if refined else "heat"
            points.append(f"{surface}, {kind}: {shown} vertices; {trend}.")
    points.append(
        "On the sphere the truth is that of the smooth surface. Subdividing the mesh itself keeps "
        "its polyhedron, whose curvature is in the old vertices only: triangles "
        "keep their angles, and a sweep that takes the surface for smooth gains less."
    )
    return points


def _where(rows: Iterable[dict[str, Any]], **wanted: Any) -> list[dict[str, Any]]:
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def _mean(rows: list[dict[str, Any]], key: str = "mean_error") -> float:
    return float(np.mean([row[key] for row in rows])) if rows else float("nan")


def _count(number: int, one: str, many: str | None = None) -> str:
    return f"{number:,} {one if number == 1 else many or one + 's'}" if number else f"no {one}"
