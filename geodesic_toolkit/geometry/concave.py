"""Polygons that are not convex, triangulated inside themselves.

A polygon is looked at along its normal (Newell's: the sum of the cross products of its fan). Its
fan is kept wherever the fan covers the polygon and nothing else; a quadrangle has one other
diagonal, and for the rest manifold3d clips ears. That library was chosen over mapbox_earcut, which
drops corners that lie on a straight line, and so opens cracks towards the neighbours of a polygon.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from geodesic_toolkit.core.optional import require
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray

__all__ = ["correct_fans"]

POLYGONS_PER_BLOCK = 1 << 18
"""Polygons that are looked at in one go, for the sake of memory."""

CROSS_PRODUCT_ROUNDING = 16 * np.finfo(np.float64).eps
"""Bound for rounding in a cross product, in units of the coordinates times the polygon's size."""

MAX_RELATIVE_HEIGHT_OF_PLANES = 1e-3
"""Height over extent up to which a polygon is plane, and so crosses itself where it seems to: edges
of others pass each other in space. Single precision leaves 1e-7; a twisted sliver of a control
mesh, whose two triangles are as good as any, has 9e-3."""

PAIRS_PER_BLOCK = 1 << 20
"""Pairs of edges that are tried for crossings in one go."""


@dataclass(frozen=True)
class _Corners:
    """Some polygons in space, corner after corner, each relative to its first corner."""

    places: FloatArray
    starts: IntArray
    sizes: IntArray
    noise: FloatArray  # of cross products, one a polygon

    @classmethod
    def of(cls, positions: FloatArray, sizes: IntArray) -> "_Corners":
        starts = np.cumsum(sizes) - sizes
        places = positions - np.repeat(positions[starts], sizes, axis=0)
        reach = np.maximum.reduceat(np.abs(places).max(axis=1), starts)
        magnitude = np.maximum.reduceat(np.abs(positions).max(axis=1), starts)
        return cls(places, starts, sizes, CROSS_PRODUCT_ROUNDING * reach * (magnitude + reach))

    def fans(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return the triangles of the fans: the polygon, and two edges from its first corner.

        There is one for each corner and the next; those at both ends are flat.
        """
        owner = np.repeat(np.arange(len(self.sizes)), self.sizes)
        after = np.arange(len(owner)) + 1
        ends = self.starts + self.sizes - 1
        after[ends] = self.starts
        return owner, self.places, self.places[after]

    def normals(self) -> FloatArray:
        """Return the unit normals; that of the largest triangle where a polygon has none."""
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
        """Return for each polygon whether the fan of its first corner covers it and no more.

        All its triangles turn the same way, and go round that corner at most once.
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
    """Replace the fans of polygons that are not within their polygon, in place.

    Parameters
    ----------
    vertices : ndarray of shape (N, 3), float64
    sizes, corners : ndarray of int64
        Polygons, as everywhere; those that refer to vertices that are not there or not finite are
        passed over, for the mesh to name.
    faces : ndarray of shape (F, 3), int64
        Their fans, which have ``max(size - 2, 0)`` triangles each.

    Returns
    -------
    list of int
        Plane polygons that cross themselves, whose triangles overlap.

    Raises
    ------
    MissingDependencyError
        There is one of more than four corners, and manifold3d is not installed.
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
    """Return 0, 1, ... for each of some groups."""
    ends = np.cumsum(sizes)
    total = int(ends[-1]) if len(ends) else 0
    return np.arange(total) - np.repeat(ends - sizes, sizes)


def _all_of(flags: BoolArray, sizes: IntArray) -> BoolArray:
    if not len(sizes):
        return np.zeros(0, dtype=np.bool_)
    return np.asarray(np.logical_and.reduceat(flags, np.cumsum(sizes) - sizes))


def _split(polygon: FloatArray) -> tuple[IntArray, bool]:
    """Return triangles of one polygon whose fan does not fit, and whether it crosses itself."""
    n = len(polygon)
    corners = _Corners.of(polygon, np.array([n]))
    normal = corners.normals()[0]
    plane = (
        np.ptp(corners.places @ normal)
        <= MAX_RELATIVE_HEIGHT_OF_PLANES * np.ptp(corners.places, axis=0).max()
    )
    if n == 4:
        turned = _Corners.of(np.roll(polygon, -1, axis=0), np.array([4]))
        if turned.fan_fits()[0]:
            return np.array([[1, 2, 3], [1, 3, 0]]), False
        return np.array([[0, 1, 2], [0, 2, 3]]), bool(plane)
    noise = float(corners.noise[0])
    flat = corners.places @ _plane(normal).T
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
    """Return whether two edges of a plane polygon cross; those that only touch do not.

    Only edges are compared whose extents along x overlap.
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
    """Return manifold3d's function from a list of rings to triangles, which keep every corner."""
    return require("manifold3d", "io", "splitting polygons that are not convex needs").triangulate
