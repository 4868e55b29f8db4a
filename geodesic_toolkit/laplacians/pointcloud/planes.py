"""The tangent planes of a cloud: its roughness and its normals."""

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.core.warning import warn
from geodesic_toolkit.errors import MissingDependencyError, NormalsWarning
from geodesic_toolkit.laplacians.pointcloud.blades import (
    GROWTH_ON_SMOOTH_SURFACES,
    N_SAMPLES,
    NOISY_NEIGHBOURS,
    NORMAL_NEIGHBOURS,
    roughness_and_growth,
    where_blades,
)
from geodesic_toolkit.laplacians.pointcloud.crowds import Representatives
from geodesic_toolkit.laplacians.pointcloud.normals import open3d_normals, pca_normals
from geodesic_toolkit.laplacians.pointcloud.poles import pole_normals

__all__ = ["POLE_NEIGHBOURS", "normals_of", "roughness_of_cloud"]

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
    chosen = kept[np.linspace(0, len(kept) - 1, min(N_SAMPLES, len(kept))).astype(np.int64)]
    near = thin.neighbours[chosen]
    rough, growth = (np.median(each) for each in roughness_and_growth(points, near)[::2])
    return float(rough), float(growth), where_blades(points, chosen, near)


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
