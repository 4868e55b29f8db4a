"""Roughness of a cloud at two widths, and the blades that a scanner's noise stands in."""

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
"""Points that tell how noisy a cloud is."""

POINTS_OF_REGION = 25
"""As many of them tell it in one region."""

GROWTH_ON_SMOOTH_SURFACES = 1.58
"""Growth of the roughness of a smooth surface: neighbourhoods of 30 points are wider than those of
12 by that factor, and as much rougher."""

MIN_GROWTH_OF_BLADES = 3.0
"""Growth of the roughness from which on the nearest points are no sample of the surface. What a
ring of a scanner's noise spreads out lies on the cone of its beam, a flat blade across the ground,
and the next ones are on blades beside it: near a scanner on a slope growth is 20 to 40, and normals
from few neighbours are those of the blades. They are estimated as in noise."""

MIN_ROUGHNESS_OF_BLADES = 0.05
"""Roughness of the wider neighbourhoods from which on that matters. It is 0.12 to 0.23 there; rings
that are far apart, and are thinned, have 0.02. From 0.02 to 0.1 the same sweeps are right."""

MAX_COSINE_OF_LEANING_BLADES = 0.97
"""Cosine of the angle between planes from few and from more neighbours below which blades lean."""

MIN_MEAN_COSINE_OF_ONE_SIDE = 0.9
"""Mean cosine of the angles between the planes of a region from which on they lean one way. Those
on both sides of a crease do not."""

MAX_ROUGHNESS_OF_ROUNDING = 1e-3
"""Roughness up to which there is no noise to speak of, but rounding."""


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
    """Return which of all points, (N,), stand in blades: in regions where the chosen ones do.

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
