"""Polygons that are not convex, triangulated inside themselves.

A polygon is projected along its normal (Newell's: the sum of the cross products of its fan). Its
fan is kept if it covers exactly the polygon; a quadrangle has one other diagonal, and other
polygons are triangulated by manifold3d's ear clipping. That library was chosen over mapbox_earcut,
which drops corners that lie on a straight line, and so opens cracks towards the neighbours of a
polygon.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from geodesic_toolkit.core.optional import require
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray

__all__ = ["correct_fans"]

POLYGONS_PER_BLOCK = 1 << 18
"""Polygons that are checked at once, which limits memory."""

CROSS_PRODUCT_ROUNDING = 16 * np.finfo(np.float64).eps
"""Bound for rounding in a cross product, relative to the coordinates times the polygon's size."""

MAX_RELATIVE_HEIGHT_OF_PLANES = 1e-3
"""Maximum height over extent of a plane polygon. Only a plane polygon whose projected edges cross
does cross itself: edges of other polygons pass each other in space. Single precision leaves 1e-7; a
twisted sliver of a control mesh, for which both diagonals are equally good, has 9e-3."""

PAIRS_PER_BLOCK = 1 << 20
"""Pairs of edges that are tested for crossings at once."""


@dataclass(frozen=True)
class _Corners:
    """Polygons in space, corner after corner, with each polygon relative to its first corner."""

    points: FloatArray
    starts: IntArray
    sizes: IntArray
    noise: FloatArray  # of cross products, one per polygon

    @classmethod
    def of(cls, positions: FloatArray, sizes: IntArray) -> "_Corners":
        starts = np.cumsum(sizes) - sizes
        points = positions - np.repeat(positions[starts], sizes, axis=0)
        reach = np.maximum.reduceat(np.abs(points).max(axis=1), starts)
        magnitude = np.maximum.reduceat(np.abs(positions).max(axis=1), starts)
        return cls(points, starts, sizes, CROSS_PRODUCT_ROUNDING * reach * (magnitude + reach))

    def fans(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return the triangles of the fans: the polygon, and two edges from its first corner.

        There is one for each corner and the next corner; the first and the last are flat.
        """
        owner = np.repeat(np.arange(len(self.sizes)), self.sizes)
        after = np.arange(len(owner)) + 1
        ends = self.starts + self.sizes - 1
        after[ends] = self.starts
        return owner, self.points, self.points[after]

    def normals(self) -> FloatArray:
        """Return the unit normals; the normal of the largest triangle for polygons of zero area."""
        owner, here, there = self.fans()
        crosses = np.cross(here, there)
        normals = np.add.reduceat(crosses, self.starts)
        lengths = np.linalg.norm(normals, axis=1)
        for polygon in np.flatnonzero(lengths <= self.noise):
            own = crosses[owner == polygon]
            normals[polygon] = own[np.linalg.norm(own, axis=1).argmax()]
            lengths[polygon] = np.linalg.norm(normals[polygon])
        return normals / np.where(lengths > 0, lengths, 1.0)[:, None]

    def fan_fits(self) -> BoolArray:
        """Return a mask of the polygons that the fan of their first corner covers exactly.

        All triangles of the fan turn the same way, and their angles at that corner sum to 2π or
        less.
        """
        owner, here, there = self.fans()
        normals = self.normals()
        doubled = np.einsum("td,td->t", np.cross(here, there), normals[owner])
        turned = np.minimum.reduceat(doubled, self.starts) < -self.noise
        heights = [np.einsum("td,td->t", edge, normals[owner]) for edge in (here, there)]
        cosines = np.einsum("td,td->t", here, there) - heights[0] * heights[1]
        angles = np.add.reduceat(np.arctan2(np.maximum(doubled, 0.0), cosines), self.starts)
        return np.asarray(~turned & (angles <= 2 * np.pi * (1 + 1e-9)))


def correct_fans(
    vertices: FloatArray, sizes: IntArray, corners: IntArray, faces: IntArray
) -> list[int]:
    """Replace fans that are not inside their polygon, in place.

    Parameters
    ----------
    vertices : ndarray of shape (N, 3), float64
    sizes, corners : ndarray of int64
        Sizes and corners of polygons; polygons with vertices that are missing or not finite are
        skipped, because the mesh reports them.
    faces : ndarray of shape (F, 3), int64
        The fans of the polygons, which have ``max(size - 2, 0)`` triangles each.

    Returns
    -------
    list of int
        Plane polygons that cross themselves, whose triangles overlap.

    Raises
    ------
    MissingDependencyError
        A polygon of more than four corners is not convex, and manifold3d is not installed.
    """
    starts = np.cumsum(sizes) - sizes
    counts = np.maximum(sizes - 2, 0)
    firsts = np.cumsum(counts) - counts
    usable = np.asarray(np.isfinite(vertices).all(axis=1))
    crossing: list[int] = []
    several = np.flatnonzero(sizes > 3)
    for some in np.split(several, np.arange(POLYGONS_PER_BLOCK, len(several), POLYGONS_PER_BLOCK)):
        rows = np.repeat(starts[some], sizes[some]) + _counted(sizes[some])
        known = corners[rows]
        good = (known >= 0) & (known < len(vertices))
        good[good] = usable[known[good]]
        whole = _all_of(good, sizes[some])
        polygons = some[whole]
        if not len(polygons):
            continue
        positions = vertices[known[np.repeat(whole, sizes[some])]]
        for place in np.flatnonzero(~_Corners.of(positions, sizes[polygons]).fan_fits()):
            polygon = int(polygons[place])
            own = corners[starts[polygon] : starts[polygon] + sizes[polygon]]
            triangles, crosses = _split(vertices[own])
            faces[firsts[polygon] : firsts[polygon] + counts[polygon]] = own[triangles]
            if crosses:
                crossing.append(polygon)
    return crossing


def _counted(sizes: IntArray) -> IntArray:
    """Return the numbers 0, 1, ... within each group."""
    ends = np.cumsum(sizes)
    total = int(ends[-1]) if len(ends) else 0
    return np.arange(total) - np.repeat(ends - sizes, sizes)


def _all_of(flags: BoolArray, sizes: IntArray) -> BoolArray:
    if not len(sizes):
        return np.zeros(0, dtype=np.bool_)
    return np.asarray(np.logical_and.reduceat(flags, np.cumsum(sizes) - sizes))


def _split(polygon: FloatArray) -> tuple[IntArray, bool]:
    """Return triangles of one polygon whose fan does not fit, and True if it crosses itself."""
    n = len(polygon)
    corners = _Corners.of(polygon, np.array([n]))
    normal = corners.normals()[0]
    plane = (
        np.ptp(corners.points @ normal)
        <= MAX_RELATIVE_HEIGHT_OF_PLANES * np.ptp(corners.points, axis=0).max()
    )
    if n == 4:
        turned = _Corners.of(np.roll(polygon, -1, axis=0), np.array([4]))
        if turned.fan_fits()[0]:
            return np.array([[1, 2, 3], [1, 3, 0]]), False
        return np.array([[0, 1, 2], [0, 2, 3]]), bool(plane)
    noise = float(corners.noise[0])
    flat = corners.points @ _plane(normal).T
    triangles = np.asarray(_ear_clipping()([flat]), dtype=np.int64)
    a, b, c = (flat[triangles[:, k]] for k in range(3))
    overlaps = bool((_cross(b - a, c - a) < -noise).any())
    return triangles, bool(plane) and (overlaps or _crosses_itself(flat, noise))


def _plane(normal: FloatArray) -> FloatArray:
    """Return two unit vectors that make a right-handed frame with the normal."""
    first = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)])


def _cross(u: FloatArray, v: FloatArray) -> FloatArray:
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


def _crosses_itself(ring: FloatArray, noise: float) -> bool:
    """Return True if two edges of a plane polygon cross; edges that only touch do not.

    Only edges whose extents along x overlap are compared.
    """
    heads = np.roll(ring, -1, axis=0)
    low, high = np.minimum(ring[:, 0], heads[:, 0]), np.maximum(ring[:, 0], heads[:, 0])
    order = np.argsort(low, kind="stable")
    tail, head, low, high = ring[order], heads[order], low[order], high[order]
    following = np.searchsorted(low, high, side="right") - np.arange(len(low)) - 1
    edge = 0
    while edge < len(low):
        stop = edge + max(1, int(np.searchsorted(np.cumsum(following[edge:]), PAIRS_PER_BLOCK)))
        sizes = following[edge:stop]
        one = np.repeat(np.arange(edge, edge + len(sizes)), sizes)
        other = one + 1 + _counted(sizes)
        sides = (
            _cross(head[one] - tail[one], tail[other] - tail[one]),
            _cross(head[one] - tail[one], head[other] - tail[one]),
            _cross(head[other] - tail[other], tail[one] - tail[other]),
            _cross(head[other] - tail[other], head[one] - tail[other]),
        )
        clear = np.logical_and.reduce([np.abs(side) > noise for side in sides])
        if (clear & (sides[0] * sides[1] < 0) & (sides[2] * sides[3] < 0)).any():
            return True
        edge = stop
    return False


def _ear_clipping() -> Any:
    """Return manifold3d's triangulation of a list of rings, which keeps every corner."""
    return require("manifold3d", "io", "splitting polygons that are not convex needs").triangulate
