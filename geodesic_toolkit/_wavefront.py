"""The compiled sweeps of :mod:`geodesic_toolkit.refine`.

A front of distance passes over the triangles. Every vertex it has reached holds its distance d and
the geodesic curvature κ of the front there: 1/r for a circle of radius r that spreads, 0 for a
straight front, negative for one that converges. At a source κ is infinite.
"""

import math

import numba

from geodesic_toolkit._typing import BoolArray, FloatArray, IntArray

__all__ = ["sweep"]

DISAGREEMENT = 0.5
"""Difference of κ at the two ends of an edge, times its length, above which they did not see the
same front; the front is then taken for a circle about the source."""

STRAIGHT = 1e-6
"""Least curvature of a front, times edge length: below it circles lose their last digits."""

kernel = numba.njit(cache=True, nogil=True, error_model="numpy")


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


@kernel  # type: ignore[untyped-decorator]
def sweep(  # noqa: PLR0917 - kernels take no keywords
    order: IntArray,
    starts: IntArray,
    ends: IntArray,
    others: IntArray,
    shapes: FloatArray,
    curvature: FloatArray,
    distance: FloatArray,
    kappa: FloatArray,
    pending: BoolArray,
    tolerance: float,
) -> int:
    """Visit the pending vertices in `order` once; return how many got a better distance.

    Corner p of the triangles around vertex v, ``starts[v] <= p < starts[v + 1]``, has the other
    two vertices ``others[p] = (a, b)`` and the measures ``shapes[p] = (|va|, |vb|, |ab|, x, y)``,
    where (x, y) is v in the plane with a at the origin and b on the first axis. The vertex takes
    its distance from those before ``ends[v]``. `distance`, `kappa` and `pending` are changed in
    place: whoever may gain from a vertex that improved is pending. That is whoever lies farther,
    and across an obtuse angle also who lies nearer.
    """
    improved = 0
    for vertex in order:
        if not pending[vertex]:
            continue
        pending[vertex] = False
        best, best_kappa = distance[vertex], kappa[vertex]
        for p in range(starts[vertex], ends[vertex]):
            a, b = others[p, 0], others[p, 1]
            to_a, to_b, edge = shapes[p, 0], shapes[p, 1], shapes[p, 2]
            d_a, d_b = distance[a], distance[b]
            if d_a >= best and d_b >= best:
                continue
            if d_a + to_a < best:
                best = d_a + to_a
                best_kappa = _along(kappa[a], to_a, (curvature[a] + curvature[vertex]) / 2)
            if d_b + to_b < best:
                best = d_b + to_b
                best_kappa = _along(kappa[b], to_b, (curvature[b] + curvature[vertex]) / 2)
            if not abs(d_a - d_b) < edge:  # also where one of them has not been reached
                continue
            front = _on_edge(kappa[a], kappa[b], edge, (d_a + d_b) / 2)
            through, planar, step = _across(d_a, d_b, front, edge, shapes[p, 3], shapes[p, 4])
            if min(d_a, d_b) <= through < best:
                best = through
                best_kappa = planar - (curvature[a] + curvature[b] + curvature[vertex]) / 3 * step
        if best < distance[vertex] - tolerance:
            distance[vertex], kappa[vertex] = best, best_kappa
            improved += 1
            for p in range(starts[vertex], starts[vertex + 1]):
                a, b = others[p, 0], others[p, 1]
                a2, b2, edge2 = shapes[p, 0] ** 2, shapes[p, 1] ** 2, shapes[p, 2] ** 2
                pending[a] |= distance[a] > best or a2 + edge2 < b2
                pending[b] |= distance[b] > best or b2 + edge2 < a2
    return improved
