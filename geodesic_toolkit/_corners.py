"""The compiled preparation of refinement: triangles around vertices, and the curvature there."""

import math
from typing import Any

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

from geodesic_toolkit._compiled import kernel, part
from geodesic_toolkit._typing import BoolArray, FloatArray, IntArray

__all__ = [
    "CORNER",
    "CORNERS",
    "angle_defects",
    "curvatures",
    "gather",
    "star_curvatures",
    "tell_missed",
]

HELPERS = "a1564d29fd4d43f9"
"""Digest of what else is compiled into the kernels: Numba looks at this file only."""

CORNER = np.dtype(
    [
        ("a", np.uint32),
        ("b", np.uint32),
        ("to_a", np.float64),
        ("to_b", np.float64),
        ("edge", np.float64),
    ],
    align=True,
)
"""A triangle as one of its vertices sees it: the other two, how far they are, and how far apart.

Every length is there twice, so that a vertex finds all of its triangles in one piece of memory.
"""

MANY = 32
"""Corners of a vertex up to which they are sorted: it takes the square of their number."""

# One signature each, of arrays that are only read: those that may be written to fit as well.
FACES = types.Array(types.int64, 2, "C", readonly=True)
TABLE = types.Array(types.float64, 2, "C", readonly=True)
VALUES = types.Array(types.float64, 1, "C", readonly=True)
FLAGS = types.Array(types.boolean, 1, "C", readonly=True)
NUMBERS = types.Array(types.int64, 1, "C", readonly=True)
CORNERS = types.Array(numba.from_dtype(CORNER), 1, "C", readonly=True)


@part()
def _swap(one: Any, two: Any) -> None:
    """Let two corners change places."""
    one.a, two.a = two.a, one.a
    one.b, two.b = two.b, one.b
    one.to_a, two.to_a = two.to_a, one.to_a
    one.to_b, two.to_b = two.to_b, one.to_b
    one.edge, two.edge = two.edge, one.edge


@part()
def _go_round(corners: NDArray[Any]) -> None:
    """Sort the corners of a vertex so that each begins where the last one ended, if one does."""
    for c in range(1, len(corners) - 1):
        last = corners[c - 1].b
        for other in range(c, len(corners)):
            if corners[other].a == last:
                _swap(corners[c], corners[other])
                break


@kernel(
    types.void(
        FACES,
        TABLE,
        types.boolean,
        *(types.int64[::1],) * 4,
        numba.from_dtype(CORNER)[::1],
    )
)
def gather(  # noqa: PLR0917 - kernels take no keywords
    elements: IntArray,
    inverse_frames: FloatArray,
    stars: bool,
    starts: IntArray,
    ends: IntArray,
    free: IntArray,
    free_foreign: IntArray,
    corners: NDArray[Any],
) -> None:
    """Sort the corners of triangles by their vertices, and measure the edges.

    Vertex v has the corners ``starts[v] <= c < starts[v + 1]``, but where `stars` overlap its own
    star first, which ends before ``ends[v]``. They go round the vertex as far as they hang together
    (a front then finds what it has passed on one side and the rest on the other, which takes a
    fifth less time than any order), and are otherwise in the order of the elements.

    Parameters
    ----------
    elements : ndarray of shape (E, 3), int64
        An element (i, j, j) is a segment.
    inverse_frames : ndarray of shape (E, 3), float64
        As :attr:`geodesic_toolkit.gradient.ElementGradient.inverse_frames`.
    stars : bool
        Whether a triangle is part of the star of its first vertex only.
    starts : ndarray of shape (N + 1,), int64
        Zeros; written.
    ends : ndarray of shape (N,), int64
        Zeros; written.
    free, free_foreign : ndarray of shape (N,), int64
        To work in.
    corners : ndarray of shape (3 E,), CORNER
        Written.
    """
    n_vertices = len(ends)
    for e in range(len(elements)):
        foreign = stars and inverse_frames[e, 0] * inverse_frames[e, 2] != 0
        for c in range(3):
            starts[elements[e, c] + 1] += 1
            ends[elements[e, c]] += not (foreign and c > 0)
    for v in range(n_vertices):
        starts[v + 1] += starts[v]
        free[v] = starts[v]
        free_foreign[v] = ends[v] = starts[v] + ends[v]
        if ends[v] == starts[v]:  # no star of its own
            ends[v] = starts[v + 1]
    for e in range(len(elements)):
        i, j, k = elements[e, 0], elements[e, 1], elements[e, 2]
        p, q, r = inverse_frames[e, 0], inverse_frames[e, 1], inverse_frames[e, 2]
        # A hat function's gradient is 1 / height, and any two of them span 1 / (2 area).
        s = q + r
        at_i, at_j, at_k = math.sqrt(p * p + s * s), math.sqrt(p * p + q * q), abs(r)
        spanned = abs(p * r)
        if spanned > 0:
            jk, ki, ij = at_i / spanned, at_j / spanned, at_k / spanned
        else:
            length = 1 / max(at_i, at_j, at_k)
            jk = length if j != k else 0.0
            ki = length if k != i else 0.0
            ij = length if i != j else 0.0
        foreign = stars and spanned != 0
        for c, v, a, b, to_a, to_b, edge in (
            (0, i, j, k, ij, ki, jk),
            (1, j, k, i, jk, ij, ki),
            (2, k, i, j, ki, jk, ij),
        ):
            if foreign and c > 0:
                place = free_foreign[v]
                free_foreign[v] = place + 1
            else:
                place = free[v]
                free[v] = place + 1
            corner = corners[place]
            corner.a, corner.b = a, b
            corner.to_a, corner.to_b, corner.edge = to_a, to_b, edge
    for v in range(n_vertices):
        if ends[v] - starts[v] <= MANY:
            _go_round(corners[starts[v] : ends[v]])


def angle_defects(
    elements: IntArray, inverse_frames: FloatArray, boundary: BoolArray
) -> FloatArray:
    """Return what the (N,) angles about vertices lack of 2π, where the domain ends of π."""
    p, q, r = inverse_frames.T
    spanned = np.abs(p * r)
    # An angle is π minus what the other two hat gradients enclose. NumPy takes many at a time.
    first, second = np.arctan2(spanned, -q * r), np.arctan2(spanned, (q + r) * r)
    defect = np.where(boundary, math.pi, 2 * math.pi)
    _subtract_angles(elements, first, second, defect)
    return defect


@kernel(types.void(FACES, VALUES, VALUES, types.float64[::1]))
def _subtract_angles(
    elements: IntArray, first: FloatArray, second: FloatArray, defect: FloatArray
) -> None:
    """Subtract the angles of triangles, of which two are given, from what their vertices have."""
    for e in range(len(elements)):
        defect[elements[e, 0]] -= first[e]
        defect[elements[e, 1]] -= second[e]
        defect[elements[e, 2]] -= math.pi - first[e] - second[e]


def curvatures(  # noqa: PLR0917 - as its kernel
    elements: IntArray,
    measure: FloatArray,
    defects: FloatArray,
    starts: IntArray,
    corners: NDArray[Any],
    boundary: BoolArray,
    coarse: float,
) -> FloatArray:
    """Return the (N,) Gaussian curvature: angle defect over area, averaged over one-rings.

    Where K of a vertex, times its area, comes to `coarse` it counts for half; it is 0 where the
    domain ends, and where sheets meet. `starts` and `corners` are those of :func:`gather`.
    """
    count = len(boundary)
    own, around = np.zeros((count, 2)), np.zeros((count, 2))
    closed, seen = np.zeros(count, dtype=np.bool_), np.full(count, -1)
    _add_rings(elements, measure, defects, starts, corners, boundary, closed, seen, own, around)
    return _curvature(own, around, coarse)


def star_curvatures(
    elements: IntArray, inverse_frames: FloatArray, boundary: BoolArray, coarse: float
) -> FloatArray:
    """Return the same (N,) where triangles are stars: from the angles about their own centres.

    Parameters
    ----------
    elements : ndarray of shape (E, 3), int64
        The centre of the star first. A segment has no area.
    inverse_frames : ndarray of shape (E, 3), float64
    boundary : ndarray of shape (N,), bool
    coarse : float
    """
    own, around = np.zeros((len(boundary), 2)), np.zeros((len(boundary), 2))
    _add_stars(elements, inverse_frames, boundary, own, around)
    return _curvature(own, around, coarse)


def _curvature(own: FloatArray, around: FloatArray, coarse: float) -> FloatArray:
    """Return K from the defect and the area, (N, 2), of vertices and of what is around them."""
    mean = np.divide(around[:, 0], around[:, 1], out=np.zeros(len(own)), where=around[:, 1] > 0)
    spread = np.abs(mean) * own[:, 1] * 2 / math.sqrt(3)  # K h², of equilateral triangles
    return np.asarray(mean / (1 + spread / coarse))


@part()
def _all_the_way_round(corners: NDArray[Any], begin: int, end: int) -> bool:
    """Return whether each of the corners begins where the last one ended."""
    if begin == end:
        return False
    last, together = corners[end - 1].b, True
    for c in range(begin, end):
        together &= corners[c].a == last
        last = corners[c].b
    return together


@kernel(
    types.void(
        FACES, VALUES, VALUES, NUMBERS, CORNERS, FLAGS, types.boolean[::1], types.int64[::1],
        *(types.float64[:, ::1],) * 2,
    )
)  # fmt: skip
def _add_rings(  # noqa: PLR0917 - kernels take no keywords
    elements: IntArray,
    measure: FloatArray,
    defects: FloatArray,
    starts: IntArray,
    corners: NDArray[Any],
    boundary: BoolArray,
    closed: BoolArray,
    seen: IntArray,
    own: FloatArray,
    around: FloatArray,
) -> None:
    """Add the defect and the area of vertices to `own`, those of their rings to `around`.

    `closed`, (N,), is whether corners go all the way round, and `seen`, (N,), is -1 before.
    """
    for e in range(len(elements)):
        third = measure[e] / 3
        for c in range(3):
            own[elements[e, c], 1] += third
    for v in range(len(boundary)):
        begin, end = starts[v], starts[v + 1]
        neighbours = end - begin
        closed[v] = _all_the_way_round(corners, begin, end)
        if not closed[v] and not boundary[v]:
            neighbours = 0
            for c in range(begin, end):
                for other in (corners[c].a, corners[c].b):
                    neighbours += other != v and seen[other] != v
                    seen[other] = v
        # Where sheets meet there is no angle to fall short of: more faces than neighbours.
        flat = boundary[v] or end - begin > neighbours or own[v, 1] == 0
        own[v, 0] = 0.0 if flat else defects[v]
    for v in range(len(boundary)):
        count = float(starts[v + 1] - starts[v])
        twice = 2.0 if closed[v] else 1.0  # each neighbour is one's a and another's b
        defect, area = count * own[v, 0], count * own[v, 1]
        for c in range(starts[v], starts[v + 1]):
            a, b = corners[c].a, corners[c].b
            defect += twice * own[a, 0]
            area += twice * own[a, 1]
            if not closed[v]:
                defect += own[b, 0]
                area += own[b, 1]
        around[v, 0], around[v, 1] = defect, area


@kernel(types.void(FACES, TABLE, FLAGS, *(types.float64[:, ::1],) * 2))
def _add_stars(
    elements: IntArray,
    inverse_frames: FloatArray,
    boundary: BoolArray,
    own: FloatArray,
    around: FloatArray,
) -> None:
    """Add the defect and the area of the centres of stars to `own`, and to `around` their rims'."""
    for e in range(len(elements)):
        p, q, r = inverse_frames[e, 0], inverse_frames[e, 1], inverse_frames[e, 2]
        spanned = abs(p * r)
        if spanned > 0:
            own[elements[e, 0], 0] += math.atan2(spanned, -q * r)
            own[elements[e, 0], 1] += 1 / (6 * spanned)
    for v in range(len(boundary)):
        flat = boundary[v] or own[v, 1] == 0
        own[v, 0] = 0.0 if flat else 2 * math.pi - own[v, 0]
    for e in range(len(elements)):
        if inverse_frames[e, 0] * inverse_frames[e, 2] != 0:
            v, a, b = elements[e, 0], elements[e, 1], elements[e, 2]
            for i in range(2):
                around[v, i] += own[v, i] + own[a, i] + own[b, i]


@part()
def _among(corner: Any, others: NDArray[Any]) -> bool:
    """Return whether one of `others`, of the same vertex, is the same triangle."""
    a, b = corner.a, corner.b
    for c in range(len(others)):
        if (others[c].a == a and others[c].b == b) or (others[c].a == b and others[c].b == a):
            return True
    return False


@kernel(types.void(NUMBERS, types.int64[::1], numba.from_dtype(CORNER)[::1]))
def tell_missed(starts: IntArray, ends: IntArray, corners: NDArray[Any]) -> None:
    """Let vertices listen to triangles that both others have in their stars, but they have not.

    The star of a vertex whose normal is off has gaps, which those of its neighbours fill. What a
    single neighbour has in its star is as often a bridge.

    Parameters
    ----------
    starts, ends, corners
        As :func:`gather` writes them; the corners that are told move up, and `ends` with them.
    """
    for v in range(len(ends)):
        for c in range(ends[v], starts[v + 1]):
            if not _among(corners[c], corners[starts[v] : ends[v]]) and (
                _among(corners[c], corners[ends[v] : c])
                or _among(corners[c], corners[c + 1 : starts[v + 1]])
            ):
                _swap(corners[c], corners[ends[v]])
                ends[v] += 1
