"""Sources on the triangles of a subdivision."""

from dataclasses import replace

import numpy as np

from geodesic_toolkit.discretization.subdivision import Subdivision
from geodesic_toolkit.domains import Located
from geodesic_toolkit.geometry.closest import TriangleTree
from geodesic_toolkit.sources.locate import locate_sources
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["on_subdivision"]


def on_subdivision(points: SourcePoints, subdivision: Subdivision) -> SourcePoints:
    """Return sources between vertices of a domain as sources in triangles of its subdivision.

    Parameters
    ----------
    points : SourcePoints
        Of N vertices. The samples of a curve stay between them: a front leaves it that is known.
    subdivision : Subdivision

    Returns
    -------
    SourcePoints
        Of M vertices.
    """
    mesh = subdivision.mesh
    if points.front_curvatures is not None or len(points.vertices) == points.count:
        return replace(points, n_vertices=mesh.n_vertices, copy=False)
    # Only triangles about the same vertices: another sheet may lie at the same place.
    own = np.zeros(points.n_vertices)
    own[points.vertices] = 1.0
    faces = mesh.faces[(subdivision.extended(own) > 0)[mesh.faces].any(axis=1)]
    places = np.add.reduceat(
        points.shares[:, None] * mesh.vertices[points.vertices], points.begins[:-1]
    )
    found, weights = TriangleTree(mesh.vertices, faces).closest(places)
    corners = faces[found]
    at_vertex = np.diff(points.begins) == 1
    corners[at_vertex] = points.first_vertices[at_vertex, None]
    weights[at_vertex] = [1.0, 0.0, 0.0]
    return replace(
        locate_sources(mesh, Located(corners, weights)), starts=points.starts, copy=False
    )
