"""`merge_vertices`: merge coincident vertices, so that paths cross from face to face."""

import math
import numbers
from typing import Any

import numpy as np

from geodesic_toolkit.core.types import IntArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit.geometry.welding import merged_positions, movable_by, rounding_of
from geodesic_toolkit.interop.conversion import as_domain

__all__ = ["merge_vertices"]


def merge_vertices(mesh: Any, tolerance: float = 0.0) -> tuple[TriangleMesh, IntArray]:
    """Return a mesh whose coincident, or nearly coincident, vertices are merged.

    A mesh is cut where vertices repeat a position, and paths do not cross: at seams of textures, at
    parts that share a rim, at facets that were written one by one. Distances on the merged mesh are
    carried back to the vertices of the given one by ``distance[new]``.

    Of the vertices within the tolerance, the first one stays and does not move, and others move by
    at most the tolerance. Features stay too: a vertex never moves by more than a quarter of the
    shortest edge at it, whatever the tolerance, so that faces do not collapse; edges as short as
    the rounding of single precision are ignored in this.

    Parameters
    ----------
    mesh : TriangleMesh or object
        A mesh, or an object that :func:`as_domain` converts to one.
    tolerance : float
        In the unit of the mesh, 0 or more; 0 merges only equal positions.

    Returns
    -------
    merged : TriangleMesh
        Its vertices are those that stay, in their order. It has the same faces in the same order;
        faces that became the same triangle count once.
    new : ndarray of shape (N,), int64
        The vertex of `merged` for each given vertex.

    Raises
    ------
    InvalidOptionError
        The tolerance is not a length, or more than the size of the mesh.
    UnsupportedDomainError
        The object is not a mesh.

    Examples
    --------
    >>> import numpy as np
    >>> import geodesic_toolkit as gt
    >>> sphere = gt.testing.shapes.icosphere(2)
    >>> soup = sphere.vertices[sphere.faces.ravel()], np.arange(960).reshape(320, 3)
    >>> merged, new = gt.merge_vertices(soup)
    >>> merged
    TriangleMesh(162 vertices, 320 faces)
    >>> gt.geodesic_distance(merged, new[0])[new].shape
    (960,)
    """
    domain = as_domain(mesh)
    if not isinstance(domain, TriangleMesh):
        raise UnsupportedDomainError(
            f"vertices of a TriangleMesh can be merged, not those of {a_kind_of(domain)}"
        )
    if isinstance(tolerance, bool) or not isinstance(tolerance, numbers.Real):
        raise InvalidOptionError(f"tolerance must be a length, not {tolerance!r}")
    if not (tolerance >= 0 and math.isfinite(tolerance)):
        raise InvalidOptionError(f"tolerance must be finite and not negative, not {tolerance}")
    vertices, faces = domain.vertices, domain.faces
    used = vertices[domain.used]
    size = float(np.linalg.norm(np.ptp(used, axis=0)))
    if tolerance > size > 0:
        raise InvalidOptionError(
            f"tolerance {tolerance:g} is more than the size of the mesh, {size:.4g}; all its "
            "vertices are closer; give the gap of the seams, 0 for equal positions"
        )
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    limit = movable_by(vertices, edges, rounding_of(used))
    owner = merged_positions(vertices, np.minimum(limit, float(tolerance)))
    kept, new = np.unique(owner, return_inverse=True)
    return TriangleMesh(vertices[kept], new[faces]), np.asarray(new, dtype=np.int64)
