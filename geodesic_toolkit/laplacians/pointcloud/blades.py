"""Roughness of a cloud at two widths, and the blades that the noise of a scanner forms."""

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.laplacians.pointcloud.neighbours import nearest_among, nearest_neighbours
from geodesic_toolkit.laplacians.pointcloud.normals import pca_normals, roughness

__all__ = [
    "GROWTH_ON_SMOOTH_SURFACES",
    "NOISY_NEIGHBOURS",
    "NORMAL_NEIGHBOURS",
    "N_SAMPLES",
    "roughness_and_growth",
    "where_blades",
]

NORMAL_NEIGHBOURS = 12
"""Neighbours that a normal is estimated from. Measured: more of them see the other leg of a
U-shaped sheet at a gap of 4 spacings from its corners."""

NOISY_NEIGHBOURS = 30
"""The same where the cloud is noisy. Measured on a sphere with noise of a third of the spacing:
refined distances err by 0.4-0.9 % instead of 1.3-1.4 %."""

N_SAMPLES = 2000
"""Sampled points from which the noise of a cloud is estimated."""

POINTS_OF_REGION = 25
"""Number of these samples from which the noise of one region is estimated."""

GROWTH_ON_SMOOTH_SURFACES = 1.58
"""Growth of the roughness of a smooth surface: neighbourhoods of 30 points are wider than those of
12 by this factor, and rougher by the same factor."""

MIN_GROWTH_OF_BLADES = 3.0
"""Minimum growth of the roughness at which the nearest points do not sample the surface. The noise
of a scanner's ring spreads along the cone of its beam, which is a flat blade across the ground, and
the next rings are blades beside it. Near a scanner on a slope the growth is 20 to 40, and normals
from few neighbours are those of the blades. They are estimated as in noise."""

MIN_ROUGHNESS_OF_BLADES = 0.05
"""Minimum roughness of the wider neighbourhoods in blades. It is 0.12 to 0.23 there; thinned rings
that are far apart have 0.02. Limits from 0.02 to 0.1 give correct results on the same sweeps."""

MAX_COSINE_OF_LEANING_BLADES = 0.97
"""Cosine of the angle between planes from few and from more neighbours below which blades lean."""

MIN_MEAN_COSINE_OF_ONE_SIDE = 0.9
"""Minimum mean cosine of the angles between the planes of a region that lean to one side. Planes on
both sides of a crease do not."""

MAX_ROUGHNESS_OF_ROUNDING = 1e-3
"""Roughness up to which the noise is only rounding."""


def roughness_and_growth(
    points: FloatArray, near: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the roughness of the nearest neighbours and of more of them, (M,), and its growth.

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
    near : ndarray of shape (M, k), int64
        Nearest first.
    """
    wide = near[:, :NOISY_NEIGHBOURS]
    rough, wide_rough = roughness(points, wide[:, :NORMAL_NEIGHBOURS]), roughness(points, wide)
    growth = np.full_like(rough, GROWTH_ON_SMOOTH_SURFACES)
    np.divide(wide_rough, rough, out=growth, where=rough > MAX_ROUGHNESS_OF_ROUNDING)
    return rough, wide_rough, growth


def where_blades(points: FloatArray, chosen: IntArray, near: IntArray) -> BoolArray:
    """Return a mask (N,) of the points in blades: in regions where the chosen points are.

    Parameters
    ----------
    points : ndarray of shape (N, 3), float64
        Distinct.
    chosen : ndarray of shape (M,), int64
        Ascending.
    near : ndarray of shape (M, k), int64
        Neighbours of the chosen points, nearest first.
    """
    none = np.zeros(len(points), dtype=np.bool_)
    if len(chosen) <= 2 * POINTS_OF_REGION:
        return none
    _, wide_rough, growth = roughness_and_growth(points, near)
    region = nearest_neighbours(points[chosen], POINTS_OF_REGION)
    found = np.median(wide_rough[region], axis=1) > MIN_ROUGHNESS_OF_BLADES
    found &= np.median(growth[region], axis=1) > MIN_GROWTH_OF_BLADES
    if not found.any():
        return none
    found &= _lean_one_way(points, chosen, near, region)
    nearest = nearest_among(points, chosen, np.arange(len(points)), 1)[:, 0]
    return np.asarray(found[np.searchsorted(chosen, nearest)])


def _lean_one_way(
    points: FloatArray, chosen: IntArray, near: IntArray, region: IntArray
) -> BoolArray:
    few = pca_normals(points, near[:, :NORMAL_NEIGHBOURS], chosen)
    more = pca_normals(points, near[:, :NOISY_NEIGHBOURS], chosen)
    leaning = np.abs(np.einsum("md,md->m", few, more))
    alike = np.abs(np.einsum("md,mrd->mr", few, few[region])).mean(axis=1)
    return np.asarray(
        (np.median(leaning[region], axis=1) < MAX_COSINE_OF_LEANING_BLADES)
        & (np.median(alike[region], axis=1) > MIN_MEAN_COSINE_OF_ONE_SIDE)
    )
