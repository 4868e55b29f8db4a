"""The exact reference: distances along the polyhedron itself."""

from typing import Any

import numpy as np

from geodesic_toolkit._typing import FloatArray, IntArray
from geodesic_toolkit.conversion import as_domain, check_one_shape
from geodesic_toolkit.domains import Curve, OffsetSources, TriangleMesh
from geodesic_toolkit.errors import InvalidSourceError, SolverError, UnsupportedDomainError
from geodesic_toolkit.geometry.components import connected_by_edges
from geodesic_toolkit.geometry.insertion import insert_points
from geodesic_toolkit.geometry.pinches import cut_pinches
from geodesic_toolkit.geometry.triangles import edges_of_faces, proper_faces
from geodesic_toolkit.sources import locate_sources

__all__ = ["exact_distance"]


def exact_distance(mesh: Any, sources: Any, *others: Any) -> FloatArray:
    """Return the exact polyhedral distance of every vertex from the nearest source.

    The reference for tests and error reports, by libigl. Its cost grows faster than the number of
    faces: a second for 7,000 faces, a minute for 100,000. Where sheets meet in single vertices it
    runs once more for each of those that a path may pass.

    Parameters
    ----------
    mesh : TriangleMesh
        No edge with more than two faces in a component that has a source. Sheets may meet in a
        vertex: paths pass from one to the other there.
    sources : int, array-like of int, array-like of float, SurfacePoint or sequence of them
        Vertex indices; points in space, of shape (3,) or (P, 3), snapped to the nearest point of
        the surface; or points inside faces. A point that is no vertex is made one, by splitting
        the faces that it lies on.
    *others
        Nothing: an error says so, where vertices and faces were given as two arguments.

    Returns
    -------
    ndarray of shape (N,), float64
        In the unit of the mesh; ``inf`` in components without a source.

    Raises
    ------
    InvalidSourceError
        No source, an index out of range, a point that is not finite, a curve, offsets, something
        else.
    UnsupportedDomainError
        Not a triangle mesh, or a non-manifold one.
    SolverError
        The algorithm returned something that is no distance (degenerate faces can do that).

    References
    ----------
    J. S. B. Mitchell, D. M. Mount, C. H. Papadimitriou, *The Discrete Geodesic Problem*,
    SIAM J. Comput. 16, 1987, https://doi.org/10.1137/0216045

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> square = gt.TriangleMesh(corners, [[0, 1, 3], [1, 2, 3]])
    >>> gt.exact_distance(square, 0)
    array([0.        , 1.        , 1.41421356, 1.        ])
    >>> gt.exact_distance(square, [0.5, 0.25, 0.0]).round(4)
    array([0.559 , 0.559 , 0.9014, 0.9014])
    """
    check_one_shape("exact_distance", others)
    mesh = as_domain(mesh)
    if not isinstance(mesh, TriangleMesh):
        raise UnsupportedDomainError(
            f"exact distances need a TriangleMesh, not a {type(mesh).__name__}"
        )
    if isinstance(sources, Curve | OffsetSources):
        raise InvalidSourceError(
            "exact distances start at 0 from vertices and points, not from "
            f"{type(sources).__name__}"
        )
    places = locate_sources(mesh, sources)
    proper = mesh.faces[proper_faces(mesh.faces)]
    split = insert_points(mesh.vertices, proper, places.weights)
    return _through_pinches(split.vertices, split.faces, split.places)[: mesh.n_vertices]


def _through_pinches(vertices: FloatArray, faces: IntArray, sources: IntArray) -> FloatArray:
    """Return exact distances where sheets may meet in single vertices.

    The algorithm knows one fan of faces around a vertex, so others get copies of it, and the
    surface falls apart there. What it joins is put right by Dijkstra's algorithm: the nearest such
    vertex is settled, and paths start anew from those of its copies that lie behind it.
    """
    cut, origin = cut_pinches(faces, len(vertices))
    places = vertices[origin]
    distance = _by_components(places, cut, np.flatnonzero(np.isin(origin, sources)))
    waiting = np.unique(origin[len(vertices) :])
    whole = _joined(distance, origin, len(vertices))
    while np.isfinite(whole[waiting]).any():
        nearest = waiting[whole[waiting].argmin()]
        waiting = waiting[waiting != nearest]
        copies = np.flatnonzero(origin == nearest)
        behind = copies[distance[copies] > whole[nearest]]
        if len(behind):
            beyond = whole[nearest] + _by_components(places, cut, behind)
            distance = np.minimum(distance, beyond)
            whole = _joined(distance, origin, len(vertices))
    return whole


def _joined(distance: FloatArray, origin: IntArray, count: int) -> FloatArray:
    """Return the least distance of the copies of each vertex."""
    whole = np.full(count, np.inf)
    np.minimum.at(whole, origin, distance)
    return whole


def _by_components(vertices: FloatArray, faces: IntArray, sources: IntArray) -> FloatArray:
    """Return exact distances from source vertices, each component by itself."""
    count = len(vertices)
    edges, face_counts = edges_of_faces(faces, count)
    labels = connected_by_edges(edges, count)
    distance = np.full(count, np.inf)
    for component in np.unique(labels[sources]):
        members = np.flatnonzero(labels == component)
        own_sources = sources[labels[sources] == component]
        if len(members) == 1:
            distance[members] = 0.0
            continue
        crowded = edges[(face_counts > 2) & (labels[edges[:, 0]] == component)]
        if len(crowded):
            raise UnsupportedDomainError(
                f"edge {crowded[0].tolist()} has more than two faces; "
                "exact distances need at most two"
            )
        local = np.full(count, -1)
        local[members] = np.arange(len(members))
        own_faces = local[faces[labels[faces[:, 0]] == component]]
        distance[members] = _exact(vertices[members], own_faces, local[own_sources])
    return distance


def _exact(vertices: FloatArray, faces: IntArray, sources: IntArray) -> FloatArray:
    """Return exact distances on one connected component."""
    import igl  # heavy: 0.3 s

    nothing = np.zeros(0, dtype=np.int64)
    targets = np.arange(len(vertices))
    distance: FloatArray = igl.exact_geodesic(
        vertices, faces, np.unique(sources), nothing, targets, nothing
    )
    if not (np.isfinite(distance).all() and (distance >= 0).all()):
        raise SolverError("the exact algorithm failed on this mesh; are some faces degenerate?")
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    length = np.linalg.norm(vertices[sides[:, 0]] - vertices[sides[:, 1]], axis=1)
    excess = np.abs(distance[sides[:, 0]] - distance[sides[:, 1]]) - length
    if (excess > 1e-6 * distance.max()).any():
        raise SolverError(
            "the exact algorithm failed on this mesh: along some edge the distance changes by more "
            "than the edge is long; are some faces degenerate?"
        )
    return distance
