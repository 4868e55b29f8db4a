"""Isolines of a field on a mesh, as curves of points in faces."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.analysis.curves.cuts import (
    Cuts,
    as_faces,
    as_field,
    as_level,
    cut_triangles,
    finite_faces,
)
from geodesic_toolkit.core.types import BoolArray, IntArray
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.domains.measured import MeasuredFaces
from geodesic_toolkit.sources.kinds import Curve
from geodesic_toolkit.sources.surface_point import SurfacePoint

__all__ = ["isolines"]


def isolines(domain: Any, values: ArrayLike, levels: ArrayLike) -> list[Curve]:
    """Return the lines on a mesh along which a field has given values.

    Within a face the field is linear between the values at its corners. The part with the level or
    more lies on the left, seen from outside, and the lines are its border within the surface. They
    close, or end at the boundary of the mesh, at edges of more than two faces, and where the field
    has no value. A vertex with exactly the level counts as above it.

    Parameters
    ----------
    domain : TriangleMesh, MetricMesh, IntrinsicMesh or object
        Faces, or what :func:`as_domain` makes a mesh of. With a cost, the isolines of travel times
        are isochrones.
    values : array-like of shape (N,)
        A distance, or any other number a vertex. Faces are left out where one is not finite.
    levels : float or array-like of float

    Returns
    -------
    list of Curve
        Of :class:`SurfacePoint`, those of the first level first: sources, and what pictures draw.
        Lines that are a single point are left out.

    Raises
    ------
    UnsupportedDomainError
        Neither a mesh nor faces with lengths.
    InvalidOptionError
        Values that are not one number a vertex, a level that is not finite.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> sphere = gt.testing.shapes.icosphere(4)
    >>> circle, = gt.isolines(sphere, gt.geodesic_distance(sphere, 0), 1.0)
    >>> circle.closed, round(gt.curve_length(sphere, circle), 2)  # 2 π sin(1) = 5.29
    (True, 5.28)
    """
    mesh = as_faces(domain, "isolines")
    field = as_field(values, mesh.n_vertices)
    faces = finite_faces(mesh, field)
    several = isinstance(levels, Sequence | np.ndarray) and np.ndim(levels) > 0
    chosen: list[Any] = list(levels) if several else [levels]  # type: ignore[arg-type]
    lines = []
    for level in [as_level(one) for one in chosen]:
        cuts = cut_triangles(mesh.faces[faces], field, level)
        for chain, closed in _chains(*_segments(cuts, mesh.n_vertices)):
            points = _points(mesh, faces, cuts, chain, closed=closed)
            if len(points) > 1:
                lines.append(Curve(points, closed=closed))
    return lines


def _segments(cuts: Cuts, n_vertices: int) -> tuple[IntArray, BoolArray]:
    """Return the places where each cut begins and ends, (C, 2), by number, and which places link.

    A place links two cuts, and only where no more than two faces meet.
    """
    keys = cuts.edges[..., 0] * n_vertices + cuts.edges[..., 1]
    _, places, counts = np.unique(keys, return_inverse=True, return_counts=True)
    places = places.reshape(-1, 2)
    return np.where(cuts.above[:, None], places, places[:, ::-1]), np.asarray(counts == 2)


def _chains(ends: IntArray, links: BoolArray) -> list[tuple[list[tuple[int, int]], bool]]:
    """Return chains of segments: of each the segments in order, with the side they are left at.

    Parameters
    ----------
    ends : ndarray of shape (C, 2), int64
    links : ndarray of shape (E,), bool

    Returns
    -------
    list of (list of (segment, 1 or 0), closed)
        0 where a segment is passed against its direction.
    """
    at: dict[int, list[int]] = {}
    for segment, pair in enumerate(ends.tolist()):
        for place in pair:
            at.setdefault(place, []).append(segment)
    free, table = [True] * len(ends), ends.tolist()

    def walk(segment: int, leaving: int) -> tuple[list[tuple[int, int]], bool]:
        chain = []
        while True:
            free[segment] = False
            chain.append((segment, leaving))
            place = table[segment][leaving]
            if not links[place]:
                return chain, False
            one, other = at[place]
            segment = other if one == segment else one
            if not free[segment]:
                return chain, True
            leaving = 0 if table[segment][1] == place else 1

    # Open ones from their ends, those that begin with one first; then the closed ones.
    begins = [(segment, 1) for segment in np.flatnonzero(~links[ends[:, 0]]).tolist()]
    begins += [(segment, 0) for segment in np.flatnonzero(~links[ends[:, 1]]).tolist()]
    begins += [(segment, 1) for segment in range(len(ends))]
    return [walk(segment, leaving) for segment, leaving in begins if free[segment]]


def _points(
    mesh: TriangleMesh | MeasuredFaces,
    faces: IntArray,
    cuts: Cuts,
    chain: list[tuple[int, int]],
    *,
    closed: bool,
) -> list[SurfacePoint]:
    """Return the points of a chain, each vertex of the mesh once in a row."""
    passed = [] if closed else [(chain[0][0], 1 - chain[0][1])]
    points: list[SurfacePoint] = []
    vertices: list[int | None] = []
    for segment, end in [*passed, *chain]:
        edge = end if cuts.above[segment] else 1 - end
        low, high = cuts.edges[segment, edge].tolist()
        share = float(cuts.shares[segment, edge])
        vertex = low if share == 0 else high if share == 1 else None
        if vertex is not None and vertices and vertices[-1] == vertex:
            continue
        face = int(faces[cuts.triangles[segment]])
        weight = {low: 1 - share, high: share}
        a, b, c = (weight.get(corner, 0.0) for corner in mesh.faces[face].tolist())
        points.append(SurfacePoint(face, (a, b, c)))
        vertices.append(vertex)
    if closed and len(points) > 1 and vertices[0] is not None and vertices[0] == vertices[-1]:
        points.pop()
    return points
