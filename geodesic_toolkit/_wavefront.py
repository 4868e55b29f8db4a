"""The compiled sweeps of :mod:`geodesic_toolkit.refine`.

A front of distance passes over the triangles. Every vertex it has reached holds its distance d and
the geodesic curvature κ of the front there: 1/r for a circle of radius r that spreads, 0 for a
straight front, negative for one that converges. At a source κ is infinite.
"""

import math
from typing import Any

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

from geodesic_toolkit._corners import CORNERS
from geodesic_toolkit._typing import BoolArray, IntArray

__all__ = ["VERTEX", "sweep"]

VERTEX = np.dtype(
    [
        ("distance", np.float64),
        ("kappa", np.float64),
        ("curvature", np.float64),
        ("rank", np.int64),
    ]
)
"""What a vertex knows: d and κ of the front there, K of the surface, and its place in the order."""

DISAGREEMENT = 0.5
"""Difference of κ at the two ends of an edge, times its length, above which they did not see the
same front; the front is then taken for a circle about the source."""

STRAIGHT = 1e-6
"""Least curvature of a front, times edge length: below it circles lose their last digits."""

WORD = 8
"""Flags that are looked at together."""

options = {"cache": True, "nogil": True, "error_model": "numpy"}
kernel = numba.njit(**options)
NUMBERS = types.Array(types.int64, 1, "C", readonly=True)


@kernel  # type: ignore[untyped-decorator]
def _along(kappa: float, step: float, curvature: float) -> float:
    """Return κ one straight `step` further on a surface of Gaussian curvature K.

    The Riccati equation κ' = -κ² - K, split: exact on the plane, then the kick of K.
    """
    if kappa == math.inf:
        return 1 / step
    widened = 1 + kappa * step
    planar = kappa / widened if widened > 1e-9 else 1 / (1e-9 * step)
    return planar - curvature * step


@kernel  # type: ignore[untyped-decorator]
def _on_edge(kappa_a: float, kappa_b: float, edge: float, mean_distance: float) -> float:
    """Return κ of the front where it crosses an edge, from κ at its ends.

    Of two circles the mean radius (with the mean curvature already the first ring about a source
    would be wrong, and with it the order of the method).
    """
    if math.isinf(kappa_a) or math.isinf(kappa_b):
        return 1 / mean_distance
    if abs(kappa_a - kappa_b) * edge > DISAGREEMENT:
        return 1 / mean_distance
    if kappa_a * kappa_b > 0:
        return 2 * kappa_a * kappa_b / (kappa_a + kappa_b)
    return (kappa_a + kappa_b) / 2


@kernel  # type: ignore[untyped-decorator]
def _across(  # noqa: PLR0917 - kernels take no keywords
    d_a: float, d_b: float, kappa: float, edge: float, c_x: float, c_y: float
) -> tuple[float, float, float]:
    """Return what reaches corner c of a triangle through its edge ab.

    In the plane, with a at the origin, b at (edge, 0) and c at (c_x, c_y), the front on the edge is
    a circle of curvature κ whose centre lies below, or above if it converges. The ray through c is
    at a right angle to it.

    Returns
    -------
    distance : float
        Of c; infinite if its ray does not cross the edge.
    kappa : float
        Of the front at c, on a flat surface.
    step : float
        How far the ray has come since the front left the edge's mean distance.
    """
    nothing = (math.inf, 0.0, 0.0)
    if abs(kappa) * edge < STRAIGHT:
        kappa = STRAIGHT / edge
    sign = 1.0 if kappa > 0 else -1.0
    radius = sign / kappa
    mean_distance = (d_a + d_b) / 2
    radius_a = radius + sign * (d_a - mean_distance)
    radius_b = radius + sign * (d_b - mean_distance)
    if radius_a < 0 or radius_b < 0 or radius_a + radius_b < edge:
        return nothing
    centre_x = (radius_a**2 - radius_b**2 + edge**2) / (2 * edge)
    below = radius_a**2 - centre_x**2
    if below < 0:
        return nothing
    centre_y = -sign * math.sqrt(below)
    rise = sign * (c_y - centre_y)
    if rise <= 1e-9 * radius:
        return nothing
    crossing = c_x - (c_x - centre_x) * c_y / (c_y - centre_y)
    if crossing < 0 or crossing > edge:
        return nothing
    radius_c = math.sqrt((c_x - centre_x) ** 2 + (c_y - centre_y) ** 2)
    step = sign * (radius_c - radius)
    return mean_distance + step, sign / max(radius_c, 1e-12 * edge), step


@numba.njit(  # type: ignore[untyped-decorator]
    types.int64(
        NUMBERS,
        NUMBERS,
        NUMBERS,
        CORNERS,
        numba.from_dtype(VERTEX)[::1],
        types.boolean[::1],
        types.uint64[::1],
        types.float64,
        types.int64,
    ),
    **options,
)
def sweep(  # noqa: PLR0917 - kernels take no keywords
    order: IntArray,
    starts: IntArray,
    ends: IntArray,
    corners: NDArray[Any],
    vertices: NDArray[Any],
    pending: BoolArray,
    words: NDArray[np.uint64],
    tolerance: float,
    returns: int,
) -> int:
    """Visit the pending vertices in `order` once; return how many got a better distance.

    Vertex v takes its distance from the corners ``starts[v] <= c < ends[v]`` of
    :func:`geodesic_toolkit._corners.gather`. Whoever may gain from a vertex that improved is
    pending: whoever lies farther, and across an obtuse angle also who lies nearer. Where one of
    them comes earlier in the order, the sweep returns to it at once, before what it will improve
    spreads; but only so many times.

    Parameters
    ----------
    order : ndarray of shape (N,), int64
    starts, ends, corners
        As :func:`geodesic_toolkit._corners.gather` writes them.
    vertices : ndarray of shape (N,), VERTEX
        Distance and κ are changed in place.
    pending : ndarray of shape (M,), bool
        By rank; M is a multiple of :data:`WORD`, not less than N. Changed in place.
    words : ndarray of shape (M / WORD,), uint64
        The same memory.
    tolerance : float
        Improvement below which a vertex is left as it is.
    returns : int
    """
    improved, rank, count = 0, 0, len(pending)
    while True:
        while rank % WORD and not pending[rank]:
            rank += 1
        if rank % WORD == 0:
            word = rank // WORD
            while word < len(words) and words[word] == 0:
                word += 1
            rank = word * WORD
            if rank == count:
                return improved
            while not pending[rank]:
                rank += 1
        pending[rank] = False
        v = order[rank]
        rank += 1
        d_v, bend_v = vertices[v].distance, vertices[v].curvature
        best, best_kappa = d_v, vertices[v].kappa
        for c in range(starts[v], ends[v]):
            corner = corners[c]
            a, b = vertices[corner.a], vertices[corner.b]
            d_a, d_b = a.distance, b.distance
            if d_a >= best and d_b >= best:
                continue
            if d_a + corner.to_a < best:
                best = d_a + corner.to_a
                best_kappa = _along(a.kappa, corner.to_a, (a.curvature + bend_v) / 2)
            if d_b + corner.to_b < best:
                best = d_b + corner.to_b
                best_kappa = _along(b.kappa, corner.to_b, (b.curvature + bend_v) / 2)
            if not abs(d_a - d_b) < corner.edge:  # also where one of them has not been reached
                continue
            front = _on_edge(a.kappa, b.kappa, corner.edge, (d_a + d_b) / 2)
            through, planar, step = _across(d_a, d_b, front, corner.edge, corner.x, corner.y)
            if min(d_a, d_b) <= through < best:
                best = through
                best_kappa = planar - (a.curvature + b.curvature + bend_v) / 3 * step
        if not best < d_v - tolerance:
            continue
        vertices[v].distance, vertices[v].kappa = best, best_kappa
        improved += 1
        earliest = rank
        for c in range(starts[v], starts[v + 1]):
            corner = corners[c]
            a, b = vertices[corner.a], vertices[corner.b]
            if a.distance > best or corner.x < 0:
                pending[a.rank] = True
                earliest = min(earliest, a.rank)
            if b.distance > best or corner.x > corner.edge:
                pending[b.rank] = True
                earliest = min(earliest, b.rank)
        if earliest < rank and returns > 0:
            rank = earliest
            returns -= 1
