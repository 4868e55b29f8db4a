"""The triangles of all stars of a cloud, and the links between points without triangles."""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.laplacians.pointcloud.crowds import Representatives
from geodesic_toolkit.laplacians.pointcloud.curves import curve_links
from geodesic_toolkit.laplacians.pointcloud.neighbours import nearest_among
from geodesic_toolkit.laplacians.pointcloud.parts import CloudParts
from geodesic_toolkit.laplacians.pointcloud.stars import delaunay_stars, tie_breakers
from geodesic_toolkit.laplacians.pointcloud.tears import bridges

__all__ = ["Soup", "soup_of"]

N_FAR_NEIGHBOURS = (120, 400)
"""Neighbours of an open star of crowded points; the larger number is used if the star is still open
with the smaller one. Measured on sweeps of 32 beams on a street: refined distances err by 1.6 %
with 160, 1.4 % with 400."""

N_FAR_NEIGHBOURS_OF_SCANS = 1200
"""The same for scans, in which the last rings are hundreds of spacings of their points apart and
walls are nearer. Measured, refined, on a street between houses, with
:data:`MAX_REACHES_OF_FAR_STARS` of 8: with 16 beams at 0.1 and 0.2 degrees 0.17 and 0.23 % of error
among 800, 0.07 and 0.23 % among 1200."""

MIN_CROWDED_SHARE_OF_SCANS = 0.5
"""Minimum share of crowded points in a scan. Measured: sweeps of 16 beams have 0.7 to 0.9 and need
so many neighbours, other sweeps 0.2 to 0.4; vertices of meshes have 0 to 0.3, and there so many
neighbours are a limb: camelhead's distances err by 1.13 % with them, and by 0.94 % without."""

STARS_PER_BATCH = 5_000
"""Stars that are made at once with so many neighbours, which are not kept."""

MAX_REACHES_OF_FAR_STARS = 6.0
"""Diameter of the widest circle through a triangle of such a star, in reaches of the crowd. The
distance between scan lines grows up to threefold from one to the next, and a crowd between walls
reaches as far as these at most; the blind disc around a spinning scanner is 10 times as wide as its
next ring, or more. Measured on that street: 4, 6, 8 and 12 leave 1.9, 0.09, 0.07 and 0.07 % of
error with 16 beams at 0.1 degrees, and 2.2, 0.05, 0.05 and 0.05 % at 0.05 degrees (4 with 400
neighbours)."""

WEIGHT_OF_REPRESENTED_STARS = 1e-4
"""Weight of the stars of points that have another representative. They receive heat from the other
points, and have almost no effect on these: forty to one are less than a hundredth."""

MAX_RELATIVE_WIDTH_OF_LINKS = 100.0
"""Maximum width of a link relative to its length: its stiffness. Points a millionth of the spacing
apart are almost equal, and factors that have to distinguish them fail."""


@dataclass(frozen=True)
class Soup:
    """The triangles of all stars, and links to points without any; indices are of positions."""

    triangles: IntArray
    frames: FloatArray
    shares: FloatArray
    links: IntArray
    link_lengths: FloatArray
    spacing: float
    boundary: BoolArray

    @property
    def link_widths(self) -> FloatArray:
        """The widths of links: the spacing, but less for links that would be too stiff."""
        return np.minimum(self.spacing, MAX_RELATIVE_WIDTH_OF_LINKS * self.link_lengths)

    def parts(self, parts: IntArray) -> CloudParts:
        """Return the components, given the component (N,) of each position."""
        stars = (self.triangles, self.frames, self.shares)
        return CloudParts(*stars, self.links, self.link_lengths, parts)


def soup_of(
    points: FloatArray,
    normals: FloatArray,
    thin: Representatives,
    k: int,
    *,
    curved: BoolArray,
    smooth: BoolArray,
    oriented: bool,
) -> Soup:
    """Return the stars of all positions not on curves, and links of points without triangles.

    Parameters
    ----------
    points : ndarray of shape (N, 3)
    normals : ndarray of shape (N, 3)
    thin : Representatives
    k : int
        Initial number of neighbours of a star.
    curved : ndarray of shape (N,), bool
        Points of curves.
    smooth : ndarray of shape (N,), bool
        Points whose stars are made by stricter rules, as they are without noise.
    oriented : bool
        True if neighbours with an opposite normal are on another sheet.
    """
    count = len(points)
    neighbours = np.ascontiguousarray(thin.neighbours[:, : 2 * k])
    weights = tie_breakers(points, neighbours)
    star = partial(_stars_of, points, normals, smooth, k=k, oriented=oriented, weights=weights)
    triangles, frames, boundary = star(neighbours, np.arange(count))
    is_scan = np.count_nonzero(thin.reaches) > MIN_CROWDED_SHARE_OF_SCANS * count
    for far in (*N_FAR_NEIGHBOURS, N_FAR_NEIGHBOURS_OF_SCANS) if is_scan else N_FAR_NEIGHBOURS:
        queried = np.flatnonzero(boundary & (thin.reaches > 0))
        for begin in range(0, len(queried), STARS_PER_BATCH):
            some = queried[begin : begin + STARS_PER_BATCH]
            wide = nearest_among(points, thin.kept, some, min(far, len(thin.kept) - 1))
            reaches = MAX_REACHES_OF_FAR_STARS * thin.reaches[some]
            grown, grown_frames, boundary[some] = star(wide, some, reaches=reaches)
            stay = ~np.isin(triangles[:, 0], some)
            triangles = np.concatenate([triangles[stay], grown])
            frames = np.concatenate([frames[stay], grown_frames])
    order = np.argsort(triangles[:, 0], kind="stable")
    if curved.any():
        order = order[~curved[triangles[order]].any(axis=1)]
    triangles, frames = triangles[order], frames[order]
    alone = np.bincount(triangles.ravel(), minlength=count) == 0
    links = curve_links(points, neighbours, np.flatnonzero(alone))
    ends = np.bincount(links.ravel(), minlength=count) == 1
    boundary = np.where(alone, ends, boundary)
    edges = np.concatenate([triangles[:, :2], triangles[:, ::2], links, links[:, ::-1]])
    torn = (boundary | alone) & thin.is_kept
    across = bridges(
        points, normals, neighbours, edges, torn, oriented=oriented, curved=curved | alone
    )
    links = np.concatenate([links, across])
    steps = points[links[:, 1]] - points[links[:, 0]]
    lengths = np.sqrt(np.einsum("ed,ed->e", steps, steps))
    shares = np.where(thin.is_kept[triangles[:, 0]], 1.0, WEIGHT_OF_REPRESENTED_STARS)
    spokes = np.concatenate([frames[:, 0], np.hypot(frames[:, 1], frames[:, 2])])
    measured = spokes if len(spokes) else lengths
    spacing = (
        float(np.average(measured, weights=np.tile(shares, 2) if len(spokes) else None))
        if len(measured)
        else 0.0
    )
    return Soup(triangles, frames, shares, links, lengths, spacing, boundary)


def _stars_of(
    points: FloatArray,
    normals: FloatArray,
    smooth: BoolArray,
    neighbours: IntArray,
    centres: IntArray,
    *,
    reaches: FloatArray | None = None,
    **options: Any,
) -> tuple[IntArray, FloatArray, BoolArray]:
    """Return the stars of some points; those of smooth points are made by stricter rules."""
    is_open = np.zeros(len(centres), dtype=np.bool_)
    stars = []
    for strict in (True, False):
        rows = np.flatnonzero(smooth[centres] == strict)
        if len(rows) == 0:
            continue
        found = delaunay_stars(
            points,
            normals,
            neighbours if len(rows) == len(centres) else neighbours[rows],
            centres=centres[rows],
            reaches=None if reaches is None else reaches[rows],
            smooth=strict,
            **options,
        )
        stars.append(found[:2])
        is_open[rows] = found[2]
    triangles, frames = (np.concatenate(parts) for parts in zip(*stars, strict=True))
    return triangles, frames, is_open
