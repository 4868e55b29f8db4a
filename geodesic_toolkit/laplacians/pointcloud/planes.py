"""The tangent planes of a cloud: its roughness and its normals."""

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.core.warning import warn
from geodesic_toolkit.errors import MissingDependencyError, NoisyCloudWarning, NormalsWarning
from geodesic_toolkit.laplacians.pointcloud.blades import (
    GROWTH_ON_SMOOTH_SURFACES,
    N_SAMPLES,
    NOISY_NEIGHBOURS,
    NORMAL_NEIGHBOURS,
    roughness_and_growth,
    where_blades,
)
from geodesic_toolkit.laplacians.pointcloud.crowds import Representatives
from geodesic_toolkit.laplacians.pointcloud.normals import (
    open3d_normals,
    pca_normals,
    roughness,
)
from geodesic_toolkit.laplacians.pointcloud.poles import pole_normals

__all__ = [
    "POLE_NEIGHBOURS",
    "is_noisy",
    "normals_of",
    "roughness_of_cloud",
    "roughness_of_sheets",
    "warn_of_noise",
]

MIN_ROUGHNESS_OF_NOISE = (0.15, 0.45)
"""Roughness above which points deviate from the surface by noise, if its growth is below the limit
that belongs to it in :data:`MAX_GROWTH_OF_NOISE`."""

MAX_GROWTH_OF_NOISE = (0.85, 0.92)
"""Growth of the roughness below which points deviate from the surface by noise. Growth rises again
in strong noise, in which planes of 12 neighbours are those of the noise: with noise of 0.9 spacings
roughness is 0.58 to 0.65 and growth 0.85 to 0.89, and neighbouring normals differ by 36 degrees if
they are estimated from 12 neighbours. With 30 the refined error on sheets, spheres and bumpy tori
of 4,000 to 16,000 points is 1.2 to 2.5 % instead of 2.4 to 4.9 %."""

MAX_ROUGHNESS_WITHOUT_WARNING = 0.5
"""Roughness of a cloud from which on there is a warning. Tuned on random spheres, sheets, a knot
and bumpy tori of 720 to 16,000 points, four sources each, noise of 0 to 1.2 spacings, along normals
or in all directions, at points farther than 10 spacings. Noise of 0.4, 0.5, 0.6, 0.8 and 1.2
spacings has a roughness of 0.34-0.45, 0.41-0.53, 0.47-0.59, 0.55-0.67 and 0.64-0.71; mean errors,
in the same order, of 0.4-4.9, 0.5-5.8, 0.9-6.9, 1.2-9.5 and 2.4-29 %; and largest ones at a single
point of 6-23, 6-29, 10-38, 15-50 and 27-89 %. Thirty clouds and vertices of meshes were held out:
three are above the limit, of 188, 313 and 451 vertices of coarse animals, with a roughness of 0.57
to 0.67 and mean errors of 5.6 to 12 %; the next, of scans, models and an airborne tile, have 0.35,
0.34 and 0.32, so that limits from 0.36 to 0.56 give the same result."""

POLE_NEIGHBOURS = 30
"""Neighbours among which the emptiest side of a point with an uncertain normal is searched."""


def roughness_of_cloud(points: FloatArray, thin: Representatives) -> tuple[float, float, BoolArray]:
    """Return the roughness of neighbourhoods, its growth with their width, and a mask of blades.

    The roughness is the deviation of points from the plane of their neighbourhood. A wider
    neighbourhood of a curved surface is rougher relative to its width, one of a noisy surface
    smoother. Measured, as the median ratio of both: spheres, meshes and fused scans 0.86 to 1.5;
    noise from a sixth of the spacing on, a raw object scan and a depth image 0.6 to 0.8. Clouds of
    too few points are taken for a surface, and so are planes.

    Roughness and growth are medians over the cloud; blades are found by region.
    """
    kept, count = thin.kept, len(points)
    blades = np.zeros(count, dtype=np.bool_)
    if len(kept) <= 4 * NOISY_NEIGHBOURS:
        return 0.0, GROWTH_ON_SMOOTH_SURFACES, blades
    chosen = _sampled(kept)
    near = thin.neighbours[chosen]
    rough, growth = (np.median(each) for each in roughness_and_growth(points, near)[::2])
    return float(rough), float(growth), where_blades(points, chosen, near)


def roughness_of_sheets(points: FloatArray, thin: Representatives, given: FloatArray) -> float:
    """Return the median roughness among neighbours whose given normals face the same side.

    Without such a choice the two sides of a thin sheet are taken for noise.

    Parameters
    ----------
    points : ndarray of shape (P, 3)
    thin : Representatives
    given : ndarray of shape (P, 3), float64
    """
    chosen = _sampled(thin.kept)
    near = thin.neighbours[chosen]
    turned = np.einsum("md,mkd->mk", given[chosen], given[near]) <= 0
    order = np.argsort(turned, axis=1, kind="stable")[:, :NORMAL_NEIGHBOURS]
    return float(np.median(roughness(points, np.take_along_axis(near, order, axis=1))))


def _sampled(kept: IntArray) -> IntArray:
    return kept[np.linspace(0, len(kept) - 1, min(N_SAMPLES, len(kept))).astype(np.int64)]


def is_noisy(rough: float, growth: float) -> bool:
    """Return True if a roughness, and its growth with the width, are those of noise."""
    limits = zip(MIN_ROUGHNESS_OF_NOISE, MAX_GROWTH_OF_NOISE, strict=True)
    return any(rough > least and growth < most for least, most in limits)


def warn_of_noise(rough: float) -> None:
    """Warn if the points of a cloud are farther off the planes of their neighbours than reliable.

    Parameters
    ----------
    rough : float
        Roughness of the points that are not on curves.
    """
    if rough <= MAX_ROUGHNESS_WITHOUT_WARNING:
        return
    warn(
        f"the points deviate from the planes of their {NORMAL_NEIGHBOURS} nearest neighbours by "
        f"{rough:.2f} of the width of these, and distances are reliable up to "
        f"{MAX_ROUGHNESS_WITHOUT_WARNING}: noise is half of the spacing or more, or the points are "
        "too few for the shape. Distances are several % off, and 10 to 50 % at single points. "
        "Smooth the points; or thin them by gt.thin(cloud, spacing), to a spacing of three times "
        "the noise, if the shape is much wider; or give more points, or a mesh",
        NoisyCloudWarning,
    )


def normals_of(
    points: FloatArray,
    thin: Representatives,
    noisy: BoolArray,
    *,
    given: FloatArray | None,
    estimator: str,
) -> tuple[FloatArray, str]:
    """Return a unit normal at every position, and the origin of the normals.

    Parameters
    ----------
    points : ndarray of shape (P, 3)
    thin : Representatives
    noisy : ndarray of shape (P,), bool
        Mask of positions at which normals are estimated from more neighbours.
    given : ndarray of shape (P, 3), optional
        Normals that are used as they are.
    estimator : {"auto", "open3d", "pca"}

    Returns
    -------
    normals : ndarray of shape (P, 3)
    origin : {"given", "open3d", "pca", "none"}
        "none" if there are less than three positions.
    """
    if given is not None:
        return given, "given"
    count = len(points)
    if count < 3:
        return np.tile([0.0, 0.0, 1.0], (count, 1)), "none"
    kept, near = points[thin.kept], thin.own
    noisy = noisy[thin.kept]
    normals, origin = _estimated(
        kept, near[:, : NOISY_NEIGHBOURS if noisy.all() else NORMAL_NEIGHBOURS], estimator
    )
    more = np.flatnonzero((noisy | (thin.reaches[thin.kept] > 0)) & ~noisy.all())
    normals[more] = pca_normals(kept, near[more], more)
    if not noisy.all():  # noise, too, makes neighbours steep
        poles = pole_normals(kept, near[:, :POLE_NEIGHBOURS], normals)
        normals = np.where(noisy[:, None], normals, poles)
    return normals[thin.nearest], origin


def _estimated(points: FloatArray, near: IntArray, estimator: str) -> tuple[FloatArray, str]:
    """Return normals from the given neighbours, and their origin."""
    # Open3D guesses from fewer than four points; three points have one plane for any estimator.
    if estimator != "pca" and len(points) > 3:
        try:
            normals = open3d_normals(points, near)
        except MissingDependencyError as error:
            if estimator == "open3d":
                raise
            warn(
                f"{error}; until then normals come from principal components, which "
                'PointCloudLaplacian(normals="pca") chooses without this warning',
                NormalsWarning,
            )
        else:
            return normals, "open3d"
    return pca_normals(points, near), "pca"
