"""Signed distance in a volume around a surface that may have holes."""

from dataclasses import dataclass
from typing import Any, final

import numpy as np
from scipy.fft import dctn, idctn
from scipy.ndimage import map_coordinates
from scipy.spatial import cKDTree

from geodesic_toolkit.core.frozen import FrozenArrays, freeze
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains import Domain, PointCloud, TriangleMesh
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.interop.conversion import as_domain
from geodesic_toolkit.laplacians.pointcloud.operator import PointCloudLaplacian
from geodesic_toolkit.linear.memory import require_memory

__all__ = ["VolumeDistance", "signed_distance_volume"]

NEIGHBOURS = 64
"""Samples whose normals add up at a place: the next ones weigh less than a thousandth there."""

MARGIN = 0.15
"""Space around the surface, as a share of its longest side."""

AT_ONCE = 50_000
"""Places whose samples are gathered together."""

BYTES = 40.0
"""Memory that each cell of the grid takes at the most."""


@final
@dataclass(frozen=True, eq=False)
class VolumeDistance(FrozenArrays):
    """A signed distance at the cells of a regular grid.

    Attributes
    ----------
    values : ndarray of shape (X, Y, Z), float64
        Positive where the normals of the surface point to.
    origin : ndarray of shape (3,), float64
        The place of ``values[0, 0, 0]``.
    spacing : float
        How far neighbours are apart; ``values[i, j, k]`` is at ``origin + spacing * (i, j, k)``.
    """

    values: FloatArray
    origin: FloatArray
    spacing: float

    def __post_init__(self) -> None:
        freeze(self.values)
        freeze(self.origin)


def signed_distance_volume(surface: Any, *, resolution: int = 64) -> VolumeDistance:
    """Return the signed distance from a surface at the cells of a grid around it.

    The surface may have holes, cuts and parts that do not meet: the normals of samples diffuse
    through space, and their directions are integrated. In flat space the diffused normals are sums
    over samples, of which only ratios count, so that they have an unlimited range and no system is
    factorised; the integration is a cosine transform.

    Parameters
    ----------
    surface : TriangleMesh, PointCloud or object
        Faces turned alike, or points with normals; whatever :func:`as_domain` takes.
    resolution : int
        Cells along the longest side of the surface, 4 or more.

    Returns
    -------
    VolumeDistance
        In the unit of the surface.

    Raises
    ------
    UnsupportedDomainError
        Something else than a mesh or a cloud, a cloud without normals, a surface without extent.
    InvalidOptionError
        A resolution that is not a whole number of 4 or more.
    NotEnoughMemoryError
        The grid would not fit.

    References
    ----------
    N. Feng, K. Crane, *A Heat Method for Generalized Signed Distance*, 2024,
    https://doi.org/10.1145/3658220

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> volume = gt.signed_distance_volume(gt.testing.shapes.icosphere(2), resolution=16)
    >>> middle = tuple(size // 2 for size in volume.values.shape)
    >>> bool(-1.1 < volume.values[middle] < -0.8)  # one below the surface, within a cell
    True
    """
    domain = as_domain(surface)
    whole = isinstance(resolution, int | np.integer) and not isinstance(resolution, bool)
    if not whole or resolution < 4:
        raise InvalidOptionError(
            f"resolution must be a whole number of 4 or more, not {resolution!r}"
        )
    low, high = _box(domain)
    side = float((high - low).max())
    if not side > 0:
        raise UnsupportedDomainError("the surface is a single place: it has no sides")
    spacing = side / int(resolution)
    margin = np.ceil(MARGIN * resolution)
    shape = tuple((np.ceil((high - low) / spacing) + 1 + 2 * margin).astype(int).tolist())
    require_memory(BYTES * float(np.prod(shape)), f"a grid of {shape} cells")
    origin = low - margin * spacing
    points, normals = _samples(domain, spacing / 2)
    if not len(points):
        raise UnsupportedDomainError("the surface has no area, and with that no sides")
    values = _integrated(points, normals, origin, spacing, shape)
    on = map_coordinates(values, ((points - origin) / spacing).T, order=1)
    area = np.linalg.norm(normals, axis=1)
    return VolumeDistance(values - (on * area).sum() / area.sum(), origin, spacing)


def _box(domain: Domain) -> tuple[FloatArray, FloatArray]:
    """Return the corners of the box around a mesh or a cloud with normals."""
    if isinstance(domain, TriangleMesh):
        used = domain.vertices[domain.faces].reshape(-1, 3)
    elif isinstance(domain, PointCloud) and domain.normals is not None:
        used = domain.points[domain.present]
    else:
        lacking = " without normals" if isinstance(domain, PointCloud) else ""
        raise UnsupportedDomainError(
            f"{a_kind_of(domain)}{lacking} has no sides; a signed distance in a volume needs "
            "the faces of a mesh, or points with normals"
        )
    return used.min(axis=0), used.max(axis=0)


def _samples(domain: Domain, step: float) -> tuple[FloatArray, FloatArray]:
    """Return points of a surface and their normals, as long as the area around each."""
    if isinstance(domain, PointCloud):
        assert domain.normals is not None  # checked before
        area = PointCloudLaplacian().assemble(domain).mass
        present = np.flatnonzero(domain.present & (area > 0))
        return domain.points[present], area[present, None] * domain.normals[present]
    assert isinstance(domain, TriangleMesh)  # for the type checker; checked before
    corners = domain.vertices[domain.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    size = np.sqrt(np.linalg.norm(normals, axis=1))
    corners, normals, size = (table[size > 0] for table in (corners, normals, size))
    parts = np.maximum(np.ceil(size / step), 1).astype(int)
    points, vectors = [np.zeros((0, 3))], [np.zeros((0, 3))]
    for count in np.unique(parts).tolist():  # each side is divided into so many parts
        own = parts == count
        for weights in _centres(count):
            points.append(np.einsum("c,fcd->fd", weights, corners[own]))
            vectors.append(normals[own] / count**2)
    return np.concatenate(points), np.concatenate(vectors)


def _centres(count: int) -> FloatArray:
    """Return the centres of the parts of a triangle, in barycentric coordinates, (count², 3)."""
    i, j = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    upright, inverted = i + j < count, i + j < count - 1
    first = np.concatenate([i[upright] + 1 / 3, i[inverted] + 2 / 3]) / count
    second = np.concatenate([j[upright] + 1 / 3, j[inverted] + 2 / 3]) / count
    return np.column_stack([1 - first - second, first, second])


def _integrated(
    points: FloatArray,
    normals: FloatArray,
    origin: FloatArray,
    spacing: float,
    shape: tuple[int, ...],
) -> FloatArray:
    """Return φ on a grid whose gradient has length 1 and the direction of diffused normals."""
    tree = cKDTree(points)
    divergence = np.zeros(shape)
    for axis in range(3):
        faces = [size - (k == axis) for k, size in enumerate(shape)]
        flux = np.empty(int(np.prod(faces)))
        for begin in range(0, len(flux), AT_ONCE):
            some = np.arange(begin, min(begin + AT_ONCE, len(flux)))
            cells = np.stack(np.unravel_index(some, faces), axis=1) + 0.5 * np.eye(3)[axis]
            flux[some] = _direction(tree, normals, origin + spacing * cells, spacing)[:, axis]
        flux = flux.reshape(faces) / spacing
        lower, upper = ([slice(None)] * 3 for _ in range(2))
        lower[axis], upper[axis] = slice(None, -1), slice(1, None)
        divergence[tuple(lower)] += flux
        divergence[tuple(upper)] -= flux
    symbol = np.zeros(shape)
    for axis, size in enumerate(shape):
        wave = (2 * np.cos(np.pi * np.arange(size) / size) - 2) / spacing**2
        symbol += wave.reshape([-1 if k == axis else 1 for k in range(3)])
    symbol[0, 0, 0] = 1.0
    waves = dctn(divergence, norm="ortho") / symbol
    waves[0, 0, 0] = 0.0
    return np.asarray(idctn(waves, norm="ortho"))


def _direction(
    tree: cKDTree, normals: FloatArray, places: FloatArray, spacing: float
) -> FloatArray:
    """Return the directions of normals that have diffused for the time spacing², (Q, 3)."""
    count = min(NEIGHBOURS, len(normals))
    reach, near = (np.asarray(found).reshape(-1, count) for found in tree.query(places, k=count))
    weights = np.exp(-(reach - reach[:, :1]) / spacing) / np.maximum(reach, 1e-3 * spacing)
    vectors = np.einsum("qk,qkd->qd", weights, normals[near])
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0))
