"""Tangent frames of any discretization with vertices in space."""

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.core.words import a_kind_of
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.edge_gradient import EdgeGradient
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.domains import Domain
from geodesic_toolkit.errors import UnsupportedDomainError
from geodesic_toolkit.geometry.frames import Frames, frames_in_space, normals_of_faces
from geodesic_toolkit.geometry.normals import normals_from_edges, oriented_normals
from geodesic_toolkit.geometry.triangles import proper_faces

__all__ = ["default_frames", "frames_of_stars"]

NORMAL_OF_ISOLATED_VERTICES = (0.0, 0.0, 1.0)
"""The normal of a vertex without connections."""


def default_frames(domain: Domain, metric: Discretization) -> Frames:
    """Return frames whose turns are the least rotations between normals, for elements in space.

    Raises
    ------
    UnsupportedDomainError
        A graph; a surface with one side; elements that are neither edges nor triangles.
    """
    elements, positions = _elements(domain, metric), _finite(domain)
    if domain.has("triangles"):
        triangles = domain.triangles[proper_faces(domain.triangles)]
        return _frames(positions, metric, elements, normals_of_faces(positions, triangles))
    if domain.normals is not None:
        normals = np.where(domain.present[:, None], domain.normals, NORMAL_OF_ISOLATED_VERTICES)
        return _frames(positions, metric, elements, normals)
    edges, gradient = _edges_of(elements), metric.gradient
    # Weights matter, because edges of tiny weight appear and vanish as the cloud is rotated.
    weights = gradient.edge_weights if isinstance(gradient, EdgeGradient) else None
    normals = oriented_normals(positions, normals_from_edges(positions, edges, weights), edges)
    return _frames(positions, metric, elements, normals)


def frames_of_stars(cloud: Domain, metric: Discretization) -> Frames:
    """Return frames in the tangent planes of the stars of a cloud."""
    positions, normals, elements = _finite(cloud), metric.normals, _elements(cloud, metric)
    if cloud.normals is None:
        normals = oriented_normals(positions, normals, _edges_of(elements))
    return frames_in_space(positions, elements, normals, stars=True)


def _frames(
    positions: FloatArray, metric: Discretization, elements: IntArray, normals: FloatArray
) -> Frames:
    frames = frames_in_space(positions, elements, normals, stars=False)
    if metric.surface is None:
        return frames
    surface = frames_in_space(positions, metric.surface.elements, normals, stars=False)
    return Frames(
        frames.normals,
        frames.x_axes,
        frames.turns,
        frames.mirrored,
        surface.turns,
        surface.mirrored,
    )


def _elements(domain: Domain, metric: Discretization) -> IntArray:
    """Return the elements (E, 3), or the edges (E, 2), of the gradient."""
    if not domain.has("positions"):
        raise UnsupportedDomainError(
            f"{a_kind_of(domain)} has no directions: an edge has no angle; directions need a "
            "shape in space, such as a mesh or a point cloud"
        )
    gradient = metric.gradient
    if isinstance(gradient, EdgeGradient):
        return gradient.edges
    if isinstance(gradient, ElementGradient) and gradient.of_planes:
        return gradient.elements
    raise UnsupportedDomainError(
        f"directions need triangles or edges in space, and this discretization has {gradient!r}"
    )


def _edges_of(elements: IntArray) -> IntArray:
    """Return the edges (E, 2) of triangles at their first corners, or given edges."""
    return np.concatenate([elements[:, [0, other]] for other in range(1, elements.shape[1])])


def _finite(domain: Domain) -> FloatArray:
    """Return the positions of the vertices, with 0 for missing ones."""
    positions = domain.positions
    finite = np.isfinite(positions).all(axis=1, keepdims=True)
    return np.where(finite, positions, 0.0)
