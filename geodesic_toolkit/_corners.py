"""The compiled preparation of refinement: triangles around vertices, and the curvature there."""

import math
from typing import Any

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

from geodesic_toolkit._typing import BoolArray, FloatArray, IntArray

__all__ = ["CORNER", "CORNERS", "curvatures", "gather"]

CORNER = np.dtype([("a", np.uint32), ("b", np.uint32), ("at", np.uint32)])
"""A triangle as one of its vertices sees it: the other two, and the number of the corner, 3 e + c.

Twelve bytes, and the edge lengths apart: what is not there need not be read, nor be written first.
"""

# One signature each, of arrays that are only read: those that may be written to fit as well.
kernel = numba.njit
options = {"cache": True, "nogil": True, "error_model": "numpy"}
FACES = types.Array(types.int64, 2, "C", readonly=True)
TABLE = types.Array(types.float64, 2, "C", readonly=True)
VALUES = types.Array(types.float64, 1, "C", readonly=True)
FLAGS = types.Array(types.boolean, 1, "C", readonly=True)
NUMBERS = types.Array(types.int64, 1, "C", readonly=True)
CORNERS = types.Array(numba.from_dtype(CORNER), 1, "C", readonly=True)


@kernel(  # type: ignore[untyped-decorator]
    types.void(
        FACES,
        TABLE,
        types.boolean,
        types.int64[::1],
        types.int64[::1],
        numba.from_dtype(CORNER)[::1],
        types.float64[:, ::1],
    ),
    **options,
)
def gather(  # noqa: PLR0917 - kernels take no keywords
    elements: IntArray,
    inverse_frames: FloatArray,
    stars: bool,
    starts: IntArray,
    ends: IntArray,
    corners: NDArray[Any],
    lengths: FloatArray,
) -> None:
    """Sort the corners of triangles by their vertices, and measure the edges.

    Vertex v has the corners ``starts[v] <= c < starts[v + 1]``, in the order of the elements, but
    where `stars` overlap its own star first, which ends before ``ends[v]``.

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
    corners : ndarray of shape (3 E,), CORNER
        Written.
    lengths : ndarray of shape (E, 3), float64
        Opposite each corner; written.
    """
    n_vertices = len(ends)
    for e in range(len(elements)):
        foreign = stars and inverse_frames[e, 0] * inverse_frames[e, 2] != 0
        for c in range(3):
            starts[elements[e, c] + 1] += 1
            ends[elements[e, c]] += not (foreign and c > 0)
    free, free_foreign = np.empty(n_vertices, np.int64), np.empty(n_vertices, np.int64)
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
        at_i, at_j, at_k = math.sqrt(p * p + (q + r) ** 2), math.sqrt(p * p + q * q), abs(r)
        spanned = abs(p * r)
        if spanned > 0:
            lengths[e, 0], lengths[e, 1] = at_i / spanned, at_j / spanned
            lengths[e, 2] = at_k / spanned
        else:
            length = 1 / max(at_i, at_j, at_k)
            lengths[e, 0] = length if j != k else 0.0
            lengths[e, 1] = length if k != i else 0.0
            lengths[e, 2] = length if i != j else 0.0
        foreign = stars and spanned != 0
        for c, v, a, b in ((0, i, j, k), (1, j, k, i), (2, k, i, j)):
            if foreign and c > 0:
                place = free_foreign[v]
                free_foreign[v] = place + 1
            else:
                place = free[v]
                free[v] = place + 1
            corner = corners[place]
            corner.a, corner.b, corner.at = a, b, 3 * e + c


@kernel(  # type: ignore[untyped-decorator]
    types.float64[::1](FACES, TABLE, VALUES, NUMBERS, CORNERS, FLAGS, types.float64), **options
)
def curvatures(  # noqa: PLR0917 - kernels take no keywords
    elements: IntArray,
    inverse_frames: FloatArray,
    measure: FloatArray,
    starts: IntArray,
    corners: NDArray[Any],
    boundary: BoolArray,
    coarse: float,
) -> FloatArray:
    """Return the (N,) Gaussian curvature: angle defect over area, averaged over one-rings.

    Where K of a vertex, times its area, comes to `coarse` it counts for half; it is 0 where the
    domain ends, and where sheets meet. `starts` and `corners` are those of :func:`gather`.
    """
    n_vertices = len(boundary)
    own = np.zeros((n_vertices, 2))  # the angle or its defect, and the area
    for e in range(len(elements)):
        p, q, r = inverse_frames[e, 0], inverse_frames[e, 1], inverse_frames[e, 2]
        # An angle is π minus what the other two hat gradients enclose.
        spanned = abs(p * r)
        at_i, at_j = math.atan2(spanned, -q * r), math.atan2(spanned, (q + r) * r)
        third = measure[e] / 3
        for c, angle in ((0, at_i), (1, at_j), (2, math.pi - at_i - at_j)):
            own[elements[e, c], 0] += angle
            own[elements[e, c], 1] += third
    seen = np.full(n_vertices, -1)
    for v in range(n_vertices):
        neighbours = 0
        for c in range(starts[v], starts[v + 1]):
            for other in (corners[c].a, corners[c].b):
                neighbours += other != v and seen[other] != v
                seen[other] = v
        # Where sheets meet there is no angle to fall short of: more faces than neighbours.
        flat = boundary[v] or starts[v + 1] - starts[v] > neighbours or own[v, 1] == 0
        own[v, 0] = 0.0 if flat else 2 * math.pi - own[v, 0]
    curvature = np.zeros(n_vertices)
    for v in range(n_vertices):
        defect, area = 0.0, 0.0
        for c in range(starts[v], starts[v + 1]):
            a, b = corners[c].a, corners[c].b
            defect += own[v, 0] + own[a, 0] + own[b, 0]
            area += own[v, 1] + own[a, 1] + own[b, 1]
        if area > 0:
            mean = defect / area
            spread = abs(mean) * own[v, 1] * 2 / math.sqrt(3)  # K h², of equilateral triangles
            curvature[v] = mean / (1 + spread / coarse)
    return curvature
