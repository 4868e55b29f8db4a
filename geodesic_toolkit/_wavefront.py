"""The compiled sweeps of :mod:`geodesic_toolkit.refine`.

A front of distance passes over the triangles. Every vertex it has reached holds its distance d and
the geodesic curvature κ of the front there: 1/r for a circle of radius r that spreads, 0 for a
straight front, negative for one that converges. At a source κ is infinite.
"""

import math
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from geodesic_toolkit._compiled import kernel, part
from geodesic_toolkit._corners import CORNERS
from geodesic_toolkit._typing import BoolArray, IntArray

__all__ = ["VERTEX", "sweep"]

HELPERS = "94cbc8df0a17a069"
"""Digest of what else is compiled into the kernels: Numba looks at this file only."""

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

AHEAD = 12
"""Vertices between the one that is visited and the one whose neighbours are fetched from memory.
Its corners have been as many before, and where they are as many before that."""

LINE = 64
"""Bytes that memory gives at a time."""

WORD = 8
"""Flags that are looked at together."""

NUMBERS = types.Array(types.int64, 1, "C", readonly=True)


@intrinsic  # type: ignore[untyped-decorator]
def _fetch(_context: Any, array: Any, _index: Any) -> Any:
    """Bring an element of an array into the cache; nothing waits for it."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        byte, number = ir.IntType(8).as_pointer(), ir.IntType(32)
        form = ir.FunctionType(ir.VoidType(), [byte, number, number, number])
        prefetch = builder.module.declare_intrinsic("llvm.prefetch", [byte], form)
        place = builder.bitcast(builder.gep(data, [arguments[1]]), byte)
        builder.call(prefetch, [place, number(0), number(3), number(1)])  # to read, keep, data
        return context.get_dummy_value()

    return types.void(array, types.int64), code


@part()
def _along(kappa: float, step: float, curvature: float) -> float:
    """Return κ one straight `step` further on a surface of Gaussian curvature K.

    The Riccati equation κ' = -κ² - K, split: exact on the plane, then the kick of K.
    """
    if kappa == math.inf:
        return 1 / step
    widened = 1 + kappa * step
    planar = kappa / widened if widened > 1e-9 else 1 / (1e-9 * step)
    return planar - curvature * step


@part()
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


@part()
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
    centre_x = (radius_a * radius_a - radius_b * radius_b + edge * edge) / (2 * edge)
    below = radius_a * radius_a - centre_x * centre_x
    if below < 0:
        return nothing
    centre_y = -sign * math.sqrt(below)
    rise = sign * (c_y - centre_y)
    if rise <= 1e-9 * radius:
        return nothing
    crossing = c_x - (c_x - centre_x) * c_y / (c_y - centre_y)
    if crossing < 0 or crossing > edge:
        return nothing
    x, y = c_x - centre_x, c_y - centre_y
    radius_c = math.sqrt(x * x + y * y)
    step = sign * (radius_c - radius)
    return mean_distance + step, sign / max(radius_c, 1e-12 * edge), step


@part()
def _may_gain(  # noqa: PLR0917 - kernels take no keywords
    d: float, d_a: float, d_b: float, edge: float, to_a: float, twice: float
) -> bool:
    """Return whether a corner at distance d may get less through the edge ab of its triangle.

    At x on the edge, between 0 and `edge`, the front is not sooner than ``d_a - x`` and ``d_b -
    edge + x``, and then has the way to the corner before it: least where both are equal. `twice` is
    2 `edge` times the place of the corner along the edge.
    """
    if not abs(d_a - d_b) < edge or min(d_a, d_b) >= d:  # also where one has not been reached
        return False
    x, left = (edge + d_a - d_b) / 2, d - (d_a + d_b - edge) / 2
    return left > 0 and edge * (left * left - to_a * to_a - x * x) + x * twice > 0


@part(inline=True)
def _through(  # noqa: PLR0917 - kernels take no keywords
    limit: float, a: Any, b: Any, edge: float, to_a: float, to_b: float
) -> tuple[float, float, float]:
    """Return what reaches a corner through the opposite edge, if that is less than `limit`.

    `a` and `b` are the records of the edge's ends, `to_a` and `to_b` their distances from the
    corner. What is returned is that of `_across`, or infinite.
    """
    nothing = (math.inf, 0.0, 0.0)
    d_a, d_b = a.distance, b.distance
    twice = edge * edge + (to_a - to_b) * (to_a + to_b)
    if not _may_gain(limit, d_a, d_b, edge, to_a, twice):  # saves two thirds of all crossings
        return nothing
    x = twice / (2 * edge)
    y = math.sqrt(max(to_a * to_a - x * x, 0.0))
    front = _on_edge(a.kappa, b.kappa, edge, (d_a + d_b) / 2)
    found = _across(d_a, d_b, front, edge, x, y)
    return found if min(d_a, d_b) <= found[0] < limit else nothing


@part(inline=True)
def _nearest(  # noqa: PLR0917 - kernels take no keywords
    vertices: NDArray[Any],
    corners: NDArray[Any],
    reflex: BoolArray,
    v: int,
    start: int,
    end: int,
    enough: float,
) -> tuple[float, float]:
    """Return distance and κ that the corners of vertex v have for it, `enough` if none has less.

    First along the edges, which costs little and leaves few triangles that may do better.
    """
    along, via = enough, -1
    for c in range(start, end):
        corner = corners[c]
        by_a = vertices[corner.a].distance + corner.to_a
        by_b = vertices[corner.b].distance + corner.to_b
        if by_a < along:
            along, via = by_a, 2 * c
        if by_b < along:
            along, via = by_b, 2 * c + 1
    best, kappa, bend = along, 0.0, vertices[v].curvature
    for c in range(start, end):
        corner = corners[c]
        a, b = vertices[corner.a], vertices[corner.b]
        through, planar, step = _through(best, a, b, corner.edge, corner.to_a, corner.to_b)
        if through < best:
            best = through
            kappa = planar - (a.curvature + b.curvature + bend) / 3 * step
    if best == along and via >= 0:
        corner = corners[via // 2]
        near, step = (corner.b, corner.to_b) if via % 2 else (corner.a, corner.to_a)
        if reflex[near]:  # about a corner of the boundary: the front is a circle about it
            kappa = 1 / step
        else:
            kappa = _along(vertices[near].kappa, step, (vertices[near].curvature + bend) / 2)
    return best, kappa


@part(inline=True)
def _gains(  # noqa: PLR0917 - kernels take no keywords
    near: Any, v: Any, other: Any, to_v: float, to_other: float, edge: float, tolerance: float
) -> bool:
    """Return whether the vertex `near` gains from v, in their triangle with the vertex `other`.

    `to_v` and `to_other` are their distances from `near`, `edge` lies between the two.
    """
    limit = near.distance - tolerance
    if limit > v.distance + to_v:
        return True
    return bool(_through(limit, v, other, edge, to_v, to_other)[0] < limit)


@part()
def _look_ahead(  # noqa: PLR0917 - kernels take no keywords
    order: IntArray,
    rank: int,
    starts: IntArray,
    ends: IntArray,
    corners: NDArray[Any],
    vertices: NDArray[Any],
) -> None:
    """Fetch what vertices will need: the order of the heat is none that memory could foresee.

    Of one the place of its corners, of one before it these, and of one before that its neighbours.
    """
    if rank + 3 * AHEAD >= len(order):
        return
    last, later, soon = order[rank + 3 * AHEAD], order[rank + 2 * AHEAD], order[rank + AHEAD]
    _fetch(starts, last)
    _fetch(ends, last)
    _fetch(vertices, later)
    for c in range(starts[later], ends[later], LINE // corners.itemsize):
        _fetch(corners, c)
    _fetch(corners, ends[later] - 1)
    for c in range(starts[soon], ends[soon]):
        _fetch(vertices, np.int64(corners[c].a))


@kernel(
    types.int64(
        NUMBERS,
        NUMBERS,
        NUMBERS,
        CORNERS,
        types.Array(types.boolean, 1, "C", readonly=True),
        numba.from_dtype(VERTEX)[::1],
        types.boolean[::1],
        types.uint64[::1],
        types.float64,
        types.int64,
    )
)
def sweep(  # noqa: PLR0917 - kernels take no keywords
    order: IntArray,
    starts: IntArray,
    ends: IntArray,
    corners: NDArray[Any],
    reflex: BoolArray,
    vertices: NDArray[Any],
    pending: BoolArray,
    words: NDArray[np.uint64],
    tolerance: float,
    returns: int,
) -> int:
    """Visit the pending vertices in `order` once; return how many got a better distance.

    Vertex v takes its distance from the corners ``starts[v] <= c < ends[v]`` of
    :func:`geodesic_toolkit._corners.gather`. Whoever gains from a vertex that improved is pending.
    Where one of them comes earlier in the order, the sweep returns to it at once, before what it
    will improve spreads; but only so many times.

    Parameters
    ----------
    order : ndarray of shape (N,), int64
    starts, ends, corners
        As :func:`geodesic_toolkit._corners.gather` writes them.
    vertices : ndarray of shape (N,), VERTEX
        Distance and κ are changed in place.
    pending : ndarray of shape (M,), bool
        By rank, and true at N, where the sweep ends; M > N is a multiple of :data:`WORD`. Changed
        in place.
    words : ndarray of shape (M / WORD,), uint64
        The same memory.
    tolerance : float
        Improvement below which a vertex is left as it is.
    returns : int
        How often it may go back.
    """
    improved, rank, count = 0, 0, len(order)
    while True:
        while not pending[rank]:
            rank += WORD if rank % WORD == 0 and words[rank // WORD] == 0 else 1
        if rank == count:
            return improved
        pending[rank] = False
        v = order[rank]
        rank += 1
        _look_ahead(order, rank, starts, ends, corners, vertices)
        enough = vertices[v].distance - tolerance
        best, kappa = _nearest(vertices, corners, reflex, v, starts[v], ends[v], enough)
        if not best < enough:
            continue
        vertices[v].distance, vertices[v].kappa = best, kappa
        improved += 1
        reached, earliest = vertices[v], rank
        for c in range(starts[v], starts[v + 1]):
            corner = corners[c]
            a, b, edge = vertices[corner.a], vertices[corner.b], corner.edge
            to_a, to_b = corner.to_a, corner.to_b
            # Who is pending already needs no look: if he comes earlier, this vertex made him so.
            if not pending[a.rank] and _gains(a, reached, b, to_a, edge, to_b, tolerance):
                pending[a.rank] = True
                earliest = min(earliest, a.rank)
            if not pending[b.rank] and _gains(b, reached, a, to_b, edge, to_a, tolerance):
                pending[b.rank] = True
                earliest = min(earliest, b.rank)
        if earliest < rank and returns > 0:
            rank = earliest
            returns -= 1
