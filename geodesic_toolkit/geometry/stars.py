"""Local Delaunay stars: the triangles that surround each point of a cloud in its tangent plane.

Invert the neighbours about the point, ``p -> p / |p|²``: circles through the point become lines, so
that the convex hull of the images has an edge for every empty circle, which is a Delaunay triangle.

The kernels are compiled by numba when they are imported for the first time, and cached.
"""

import math

import numpy as np
from numba import types

from geodesic_toolkit._compiled import kernel, part
from geodesic_toolkit._typing import BoolArray, FloatArray, IntArray

__all__ = ["delaunay_stars"]

HELPERS = "a1564d29fd4d43f9"
"""Digest of what else is compiled into the kernels: Numba looks at this file only."""

STEEP = math.sqrt(0.5)
"""Sine of 45°: a neighbour that is farther along the normal than along the surface lies on
another sheet. Measured on a U-shaped sheet with a gap of 4 spacings: 53° holds, 64° leaks."""

FLAT = 0.2
"""Sine of the elevation below which a neighbour of opposed normal is taken for one whose normal
was given the wrong sign; above it, for one of the other side of a thin sheet."""

FIRM = 10.0
"""How much a neighbour that stands off the sheet loses against those on it: it comes in as if it
were ``sqrt(1 + FIRM (rise² - FREE))`` times as far, rise being the sine of its elevation over the
mean of both tangent planes, which is 0 on a circle through both. Without it sheets half a spacing
apart are woven into one: the refined distance on camelhead's vertices errs by 1.2 % instead of
0.9 %."""

FREE = 0.1
"""Square of that sine up to which it loses nothing: 18°, which noise and creases come to."""

GROWN = 0.2
"""The same, of neighbours that come in where the nearest do not settle a star: on smooth clouds
they lie within 27° of the sheet, or not on it. A star at the rim of a hole looks far, and would
find the inside of the far wall: through such bridges all distances from one source were 2.5 % short
on the vertices of the Stanford bunny, which has five holes."""

THIN = 1e-6
"""Sine of the smallest angle of a triangle at the centre of its star."""

JITTER = 1e-8
"""How much points are told apart where four lie on a circle, in squared nearest distances: enough
to drown rounding, so that the stars of a square grid agree on its diagonals."""

CHUNK = 16384
"""Points whose stars are held in padded arrays at once."""

TABLE = types.Array(types.float64, 2, "C", readonly=True)
VALUES = types.Array(types.float64, 1, "C", readonly=True)
NUMBERS = types.Array(types.int64, 2, "C", readonly=True)


def delaunay_stars(
    points: FloatArray,
    normals: FloatArray,
    neighbours: IntArray,
    *,
    k: int,
    oriented: bool,
    smooth: bool,
) -> tuple[IntArray, FloatArray, BoolArray]:
    """Return the stars of all points as one triangle soup.

    The neighbours of a point are the k nearest that lie on its sheet (:data:`STEEP`; with oriented
    normals those that face the other way are left out too). A star is known to be Delaunay where
    the circle of every triangle lies in the ball of these neighbours; where one does not, all of
    `neighbours` are taken, beyond the first k of a smooth cloud only those that lie on the sheet
    (:data:`GROWN`), and triangles that even then reach past them are left out if they are obtuse:
    they bridge the outside of a boundary, or an empty place.

    A star is measured in the tangent plane of its centre: a neighbour keeps its direction there,
    but lies at its distance across the mean of both tangent planes. That is the chord of a circle
    through both with these normals, and noise along the normals does not lengthen it. Where a
    neighbour stands off that mean plane, one on the sheet is preferred to it (:data:`FIRM`).

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
        Distinct.
    normals : ndarray of shape (N, 3), float64
        Of length 1.
    neighbours : ndarray of shape (N, m), int64
        Nearest first, more than k if stars are to grow.
    k : int
        Neighbours to begin with.
    oriented : bool
        Whether the sign of a normal means something.
    smooth : bool
        Whether the points lie on the surface with hardly any noise.

    Returns
    -------
    triangles : ndarray of shape (E, 3), int64
        The centre of the star first; sorted by it.
    frames : ndarray of shape (E, 3), float64
        The planar frames ``(l, a, b)`` of the triangles, as in `geometry.triangles`.
    open : ndarray of shape (N,), bool
        Where the star does not surround its point.

    References
    ----------
    K. Q. Brown, *Voronoi diagrams from convex hulls*, Information Processing Letters 9, 1979,
    https://doi.org/10.1016/0020-0190(79)90074-7
    """
    points, normals = np.ascontiguousarray(points), np.ascontiguousarray(normals)
    neighbours = np.ascontiguousarray(neighbours)
    count, widest = neighbours.shape
    nearest = points[neighbours[:, 0]] - points
    weights = np.einsum("nd,nd->n", nearest, nearest) * JITTER
    weights *= np.random.default_rng(0).random(count)  # the same ones every time
    is_open = np.ones(count, dtype=np.bool_)
    planar, numbers = np.empty((2, widest, 2)), np.empty((2, widest), dtype=np.int64)
    hull = np.empty(2 * widest + 2, dtype=np.int64)
    triangles, frames = [], []
    for start in range(0, count, CHUNK):
        centres = np.arange(start, min(start + CHUNK, count))
        rims = np.empty((len(centres), widest, 2), dtype=np.int64)
        measures = np.empty((len(centres), widest, 3))
        sizes = np.zeros(len(centres), dtype=np.int64)
        _stars(
            points, normals, weights, neighbours, start, min(k, widest), oriented, smooth,
            rims, measures, sizes, is_open, planar, numbers, hull,
        )  # fmt: skip
        used = np.arange(widest) < sizes[:, None]
        triangles.append(np.column_stack([np.repeat(centres, sizes), rims[used]]))
        frames.append(measures[used])
    return np.concatenate(triangles), np.concatenate(frames), is_open


@part()
def _project(  # noqa: PLR0917 - kernels take no keywords
    points: FloatArray,
    normals: FloatArray,
    weights: FloatArray,
    neighbours: IntArray,
    centre: int,
    wanted: int,
    known: int,
    oriented: bool,
    place: FloatArray,
    image: FloatArray,
    index: IntArray,
) -> tuple[int, float, bool]:
    """Put the neighbours of one sheet into its tangent plane, and invert them.

    From the neighbour `known` on they are asked more strictly whether they lie on it.

    Returns their number, the radius of the ball that was searched, and whether it held all.
    """
    nx, ny, nz = normals[centre]
    sign = 1.0 if nz >= 0 else -1.0  # a tangent frame without a branch that could divide by 0:
    c = -1.0 / (sign + nz)  # Duff et al. 2017, https://jcgt.org/published/0006/01/01/
    d = nx * ny * c
    ux, uy, uz = 1.0 + sign * nx * nx * c, sign * d, -sign * nx
    vx, vy, vz = d, sign + ny * ny * c, -ny
    count = 0
    squared = 0.0
    for near in range(neighbours.shape[1]):
        if count == wanted:
            return count, math.sqrt(squared), False
        other = neighbours[centre, near]
        x = points[other, 0] - points[centre, 0]
        y = points[other, 1] - points[centre, 1]
        z = points[other, 2] - points[centre, 2]
        height = x * nx + y * ny + z * nz
        squared = x * x + y * y + z * z
        if height * height > STEEP * STEEP * squared:
            continue
        agreement = nx * normals[other, 0] + ny * normals[other, 1] + nz * normals[other, 2]
        if oriented and agreement < 0 and height * height > FLAT * FLAT * squared:
            continue
        turn = 1.0 if agreement >= 0 else -1.0
        mx = nx + turn * normals[other, 0]
        my = ny + turn * normals[other, 1]
        mz = nz + turn * normals[other, 2]
        rise = x * mx + y * my + z * mz
        off = rise * rise / (mx * mx + my * my + mz * mz)
        if near >= known and off > GROWN * squared:
            continue
        flat = squared - height * height
        chord = max(flat, squared - off)
        stretch = math.sqrt(chord / flat)
        place[count, 0] = stretch * (x * ux + y * uy + z * uz)
        place[count, 1] = stretch * (x * vx + y * vy + z * vz)
        farther = chord + FIRM * max(off - FREE * squared, 0.0)
        power = (farther + weights[centre] - weights[other]) / math.sqrt(farther / chord)
        image[count, 0] = place[count, 0] / power
        image[count, 1] = place[count, 1] / power
        index[count] = other
        count += 1
    return count, math.sqrt(squared), True


@part()
def _append(image: FloatArray, hull: IntArray, size: int, kept: int, item: int) -> int:
    """Add a point to a chain, after taking away those that it leaves inside."""
    while size > kept:
        a, b = hull[size - 2], hull[size - 1]
        turn = (image[b, 0] - image[a, 0]) * (image[item, 1] - image[a, 1])
        turn -= (image[b, 1] - image[a, 1]) * (image[item, 0] - image[a, 0])
        if turn > 0:
            break
        size -= 1
    hull[size] = item
    return size + 1


@part()
def _hull(image: FloatArray, count: int, hull: IntArray, order: IntArray) -> int:
    """Write the convex hull of the images, counter-clockwise, and return its size (Andrew 1979)."""
    for i in range(count):
        j = i
        while j > 0 and (
            image[order[j - 1], 0] > image[i, 0]
            or (image[order[j - 1], 0] == image[i, 0] and image[order[j - 1], 1] > image[i, 1])
        ):
            order[j] = order[j - 1]
            j -= 1
        order[j] = i
    size = 0
    for i in range(count):
        size = _append(image, hull, size, 1, order[i])
    lower = size
    for i in range(count - 2, -1, -1):
        size = _append(image, hull, size, lower, order[i])
    return size - 1


@part()
def _star(  # noqa: PLR0917 - kernels take no keywords
    place: FloatArray,
    index: IntArray,
    hull: IntArray,
    corners: int,
    radius: float,
    last: bool,
    rim: IntArray,
    measure: FloatArray,
) -> tuple[int, bool, bool]:
    """Write the triangles of a star.

    Returns their number, whether they surround the point, and whether all are known to be Delaunay.
    """
    size = 0
    closed = True
    certain = True
    for corner in range(corners):
        i, j = hull[corner], hull[(corner + 1) % corners]
        ax, ay, bx, by = place[i, 0], place[i, 1], place[j, 0], place[j, 1]
        cross = ax * by - ay * bx
        a, b = math.sqrt(ax * ax + ay * ay), math.sqrt(bx * bx + by * by)
        if cross <= THIN * a * b:
            closed = False
            continue
        c = math.sqrt((ax - bx) * (ax - bx) + (ay - by) * (ay - by))
        dot = ax * bx + ay * by
        diameter = a * b * c / cross  # of the circle through all three
        if diameter > radius:
            certain = False
            if last and (dot < 0 or a * a < dot or b * b < dot):
                closed = False
                continue
        rim[size, 0] = index[i]
        rim[size, 1] = index[j]
        measure[size, 0] = a
        measure[size, 1] = dot / a
        measure[size, 2] = cross / a
        size += 1
    return size, closed, certain


@kernel(
    types.void(
        TABLE,
        TABLE,
        VALUES,
        NUMBERS,
        types.int64,
        types.int64,
        types.boolean,
        types.boolean,
        types.int64[:, :, ::1],
        types.float64[:, :, ::1],
        types.int64[::1],
        types.boolean[::1],
        types.float64[:, :, ::1],
        types.int64[:, ::1],
        types.int64[::1],
    )
)
def _stars(  # noqa: PLR0917 - kernels take no keywords
    points: FloatArray,
    normals: FloatArray,
    weights: FloatArray,
    neighbours: IntArray,
    start: int,
    k: int,
    oriented: bool,
    smooth: bool,
    rims: IntArray,
    measures: FloatArray,
    sizes: IntArray,
    is_open: BoolArray,
    planar: FloatArray,
    numbers: IntArray,
    hull: IntArray,
) -> None:
    """Fill in the stars of the points from `start` on.

    There is room for the neighbours of a point: `planar` (2, m, 2), `numbers` (2, m), and `hull` of
    2 m + 2 numbers.
    """
    widest = neighbours.shape[1]
    place, image = planar[0], planar[1]
    index, order = numbers[0], numbers[1]
    for row in range(sizes.shape[0]):
        centre = start + row
        known = k if smooth else widest
        for wanted in (k, widest):
            count, radius, all_taken = _project(
                points, normals, weights, neighbours, centre, wanted, known, oriented,
                place, image, index,
            )  # fmt: skip
            if count < 2:
                break
            corners = _hull(image, count, hull, order)
            last = all_taken or wanted == widest
            sizes[row], closed, certain = _star(
                place, index, hull, corners, radius, last, rims[row], measures[row]
            )
            is_open[centre] = not closed
            if last or (closed and certain):
                break
