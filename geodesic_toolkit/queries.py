"""Distance at any points on or near a mesh or a cloud, from the distance of its vertices."""

import numbers
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit._typing import FloatArray, IntArray
from geodesic_toolkit.discretization import Discretization
from geodesic_toolkit.domains import Domain, TriangleMesh, known_positions
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.geometry.closest import TriangleTree, closest_points
from geodesic_toolkit.geometry.triangles import proper_faces
from geodesic_toolkit.gradient import ElementGradient
from geodesic_toolkit.source_points import SourcePoints

__all__ = ["as_points", "interpolate", "positions_of"]

REACH = 2.0
"""Mean edge lengths from the surface within which a point has a distance, unless told otherwise."""

NEAR = 2.0
"""Mean edge lengths around a source in which the straight line is the better guide; it fades out
over as many again."""

BATCH = 100_000
"""Points that are worked on at once: some 50 MB."""


def interpolate(
    domain: Domain,
    discretization: Discretization,
    distance: ArrayLike,
    points: ArrayLike,
    *,
    reach: float | None = None,
    sources: SourcePoints | None = None,
) -> FloatArray:
    """Return the distance at points on or near a surface.

    A point has the distance of its foot, the closest point of the surface: of the mesh, or of the
    local triangles of the cloud. Inside a triangle the distance of the corners is interpolated
    linearly. The distance has a kink at a source, which no linear function has; where the sources
    are known, what is interpolated near one is by how much the distance exceeds the straight line
    from it.

    Parameters
    ----------
    domain : Domain
        A TriangleMesh or a PointCloud.
    discretization : Discretization
        That of `domain`: its spacing and, for a cloud, its triangles are used.
    distance : array-like of shape (N,)
        At the vertices; ``inf`` where there is none.
    points : array-like of shape (Q, 3) or (3,)
        In the unit of the domain.
    reach : float, optional
        How far from its foot a point may lie, in that unit; by default :data:`REACH` times the
        mean edge length.
    sources : SourcePoints, optional
        Where `distance` was measured from.

    Returns
    -------
    ndarray of shape (Q,), float64
        ``inf`` past the reach, and where a corner that counts has no distance.

    Raises
    ------
    UnsupportedDomainError
        A domain without positions, or a cloud whose operator makes no triangles.
    InvalidOptionError
        Points that are not finite or not of that shape, another number of distances than vertices,
        a reach that is not positive.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> from geodesic_toolkit.queries import interpolate
    >>> square = gt.testing.shapes.grid(3)
    >>> discretization = gt.CotanLaplacian().assemble(square)
    >>> interpolate(square, discretization, square.vertices[:, 0], [[0.3, 0.2, 0.1], [0, 9, 0]])
    array([0.3, inf])
    """
    queries = as_points(points)
    values = np.asarray(distance, dtype=np.float64)
    if values.shape != (domain.n_vertices,):
        raise InvalidOptionError(
            f"distance must have shape ({domain.n_vertices},), one number a vertex, "
            f"not {values.shape}"
        )
    limit = _limit(reach, discretization.spacing)
    positions, faces = positions_of(domain), _triangles(domain, discretization)
    result = np.full(len(queries), np.inf)
    if len(faces) == 0:  # every face is degenerate, or all points are one: no surface to stand on
        return result
    tree = TriangleTree(positions, faces)
    low, high = positions[faces].min(axis=(0, 1)), positions[faces].max(axis=(0, 1))
    near = ((queries >= low - limit) & (queries <= high + limit)).all(axis=1)
    starts = None if sources is None else sources.weights @ positions
    candidates = np.flatnonzero(near)
    for start in range(0, len(candidates), BATCH):
        chosen = candidates[start : start + BATCH]
        face, weights = tree.closest(queries[chosen])
        corners = faces[face]
        feet = np.einsum("qc,qcd->qd", weights, positions[corners])
        found = _mean(weights, values[corners])
        if starts is not None:
            found += _kink(
                weights, positions[corners], feet, starts, found / discretization.spacing
            )
        with np.errstate(over="ignore"):  # infinitely far is far enough
            found[_length(queries[chosen] - feet) > limit] = np.inf
        result[chosen] = found
    return result


def as_points(points: Any) -> FloatArray:
    """Return points in space as an array of shape (Q, 3).

    Raises
    ------
    InvalidOptionError
        Another shape, no numbers, or a row that is not finite.
    """
    try:
        array = np.asarray(points)
    except (ValueError, TypeError) as error:
        raise InvalidOptionError(f"points cannot be read as an array: {error}") from error
    if array.dtype.kind not in "iuf":
        raise InvalidOptionError(f"points must hold real numbers, not dtype {array.dtype}")
    if array.shape[-1:] != (3,) or array.ndim > 2:
        raise InvalidOptionError(f"points must have shape (Q, 3) or (3,), not {array.shape}")
    table = np.atleast_2d(array).astype(np.float64)
    finite = np.isfinite(table).all(axis=1)
    if not finite.all():
        bad = int(finite.argmin())
        raise InvalidOptionError(
            f"point {bad} of the points is not finite: {table[bad].tolist()}; leave it out"
        )
    return table


def _limit(reach: float | None, spacing: float) -> float:
    if reach is None:
        return REACH * spacing
    if isinstance(reach, bool) or not isinstance(reach, numbers.Real) or not reach > 0:
        raise InvalidOptionError(f"reach must be a positive length, not {reach!r}")
    return float(reach)


def positions_of(domain: Domain) -> FloatArray:
    """Return the positions of the vertices, of shape (N, 3); NaN for missing points of a cloud.

    Raises
    ------
    UnsupportedDomainError
        There are none: a graph.
    """
    positions = known_positions(domain)
    if positions is None:
        raise UnsupportedDomainError(
            f"a {type(domain).__name__} has no positions: its distances are at its vertices alone"
        )
    return positions


def _triangles(domain: Domain, discretization: Discretization) -> IntArray:
    """Return the triangles of the surface, each once."""
    if isinstance(domain, TriangleMesh):
        return domain.faces[proper_faces(domain.faces)]
    gradient = discretization.gradient
    if not isinstance(gradient, ElementGradient) or gradient.elements.shape[1] != 3:
        raise UnsupportedDomainError(
            f"{gradient!r} has no triangles to interpolate in; queries on a cloud need an operator "
            "that makes some, such as PointCloudLaplacian"
        )
    # The stars of neighbours share triangles; a link (i, j, j) between two points is a segment.
    ordered = np.sort(gradient.elements, axis=1)
    ordered = ordered[np.lexsort(ordered.T)]
    new = np.ones(len(ordered), dtype=np.bool_)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    triangles = ordered[new]
    twice = triangles[:, 0] == triangles[:, 1]
    triangles[twice] = triangles[twice][:, ::-1]
    links_too: IntArray = triangles[triangles[:, 0] != triangles[:, 1]]
    return links_too


def _mean(weights: FloatArray, values: FloatArray) -> FloatArray:
    """Return weighted means, of shape (Q,), in which an infinite value of no weight is nothing."""
    counted = np.where(weights > 0, values, 0.0)
    return np.asarray(np.einsum("qc,qc->q", weights, counted))


def _kink(
    weights: FloatArray,
    corners: FloatArray,
    feet: FloatArray,
    starts: FloatArray,
    rings: FloatArray,
) -> FloatArray:
    """Return what linear interpolation misses of the straight distance from the nearest source.

    Zero at the corners, and past some `rings` around the source: a straight line would cross from
    one sheet of a thin shape to the other.
    """
    start = starts[closest_points(feet, starts)]
    straight = _length(feet - start)
    missed = straight - _mean(weights, _length(corners - start[:, None]))
    fading = np.clip(2 - rings / NEAR, 0.0, 1.0)
    return np.asarray(missed * fading)


def _length(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(vectors, axis=-1))
