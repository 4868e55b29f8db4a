"""Normals of a cloud from neighbourhoods: by Open3D, or by our own principal components.

Everything that the core needs of Open3D for normals is here, imported on first use. Callers need
only the tangent plane, so the sign of a normal is arbitrary.
"""

import re

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.errors import MissingDependencyError

__all__ = ["missing_package", "open3d_normals", "pca_normals", "roughness"]

SYSTEM_PACKAGES = {
    "libusb-1.0.so": "libusb-1.0-0",
    "libEGL.so": "libegl1",
    "libGL.so": "libgl1",
    "libGLX": "libglx0",
    "libOpenGL.so": "libopengl0",
    "libgomp.so": "libgomp1",
    "libX11.so": "libx11-6",
    "libtbb.so": "libtbb12",
    "libgcc_s.so": "libgcc-s1",
    "libstdc++.so": "libstdc++6",
    "libc++.so": "libc++1",
    "libudev.so": "libudev1",
}
"""Debian's and Ubuntu's names of the system packages that hold the libraries Open3D loads."""

POINTS_PER_BATCH = 10_000
"""Points whose neighbourhoods are gathered at once."""


def pca_normals(
    points: FloatArray, neighbours: IntArray, centres: IntArray | None = None
) -> FloatArray:
    """Return the direction in which each point's neighbourhood extends least, of shape (M, 3).

    Parameters
    ----------
    points : ndarray of shape (N, 3)
    neighbours : ndarray of shape (M, k)
        The point itself is added.
    centres : ndarray of shape (M,), optional
        The points whose neighbours these are; all of them unless given.
    """
    own = np.arange(len(points)) if centres is None else centres
    normals = np.empty((len(own), 3))
    for begin in range(0, len(own), POINTS_PER_BATCH):
        some = slice(begin, begin + POINTS_PER_BATCH)
        normals[some] = np.linalg.eigh(_covariances(points, neighbours[some], own[some]))[1][
            :, :, 0
        ]
    return normals


def _covariances(points: FloatArray, neighbours: IntArray, own: IntArray) -> FloatArray:
    """Return the covariances (M, 3, 3) of points and their neighbours."""
    groups = points[np.column_stack([own, neighbours])]
    groups -= groups.mean(axis=1, keepdims=True)
    covariances: FloatArray = groups.transpose(0, 2, 1) @ groups / (neighbours.shape[1] + 1)
    return covariances


def roughness(points: FloatArray, neighbours: IntArray) -> FloatArray:
    """Return the deviation of neighbourhoods from their planes, relative to their width, (M,).

    Parameters
    ----------
    points : ndarray of shape (N, 3)
    neighbours : ndarray of shape (M, k)
    """
    groups = points[neighbours]
    groups -= groups.mean(axis=1, keepdims=True)
    spread = np.linalg.eigvalsh(groups.transpose(0, 2, 1) @ groups)
    off, width = np.maximum(spread[:, 0], 0.0), spread[:, 1]
    share: FloatArray = np.sqrt(np.divide(off, width, out=np.zeros_like(off), where=width > 0))
    return share


def open3d_normals(points: FloatArray, neighbours: IntArray) -> FloatArray:
    """Return Open3D's unit normals of every point and its neighbours, of shape (N, 3).

    Open3D receives the covariances, and does not search the neighbours again.

    Parameters
    ----------
    points : ndarray of shape (N, 3)
        Finite, distinct and at least four: Open3D crashes or guesses on other input.
    neighbours : ndarray of shape (N, k)
        The point itself is added.

    Raises
    ------
    MissingDependencyError
        Open3D cannot be imported; the message names the package that is missing.
    """
    try:
        import open3d  # heavy: two seconds, and a hundred shared libraries
    except (ImportError, OSError) as error:  # OSError: ctypes could not load one of them
        raise MissingDependencyError(
            f"Open3D cannot be imported ({error}); {missing_package(error)}"
        ) from error
    normals = np.empty((len(points), 3))
    for begin in range(0, len(points), POINTS_PER_BATCH):
        some = np.arange(begin, min(begin + POINTS_PER_BATCH, len(points)))
        covariances = _covariances(points, neighbours[some], some)
        cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points[some]))
        cloud.covariances = open3d.utility.Matrix3dVector(covariances)
        cloud.estimate_normals()
        normals[some] = np.asarray(cloud.normals)
    return normals


def missing_package(error: Exception) -> str:
    """Return the advice on what to install after a failed import of Open3D."""
    text = str(error)
    for library, package in SYSTEM_PACKAGES.items():
        if library in text:
            return f"the system package {package} is missing (apt-get install {package})"
    library_name = re.search(r"lib[\w+.-]+\.so[\w.]*", text)
    if library_name:
        return f"the system package that holds {library_name.group()} is missing"
    return "pip install open3d, where there are wheels for this Python and platform"
