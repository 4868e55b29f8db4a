"""Vertices around sources, at which fronts begin, and their directions from the sources."""

from dataclasses import dataclass

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import Domain, positions_of
from geodesic_toolkit.geometry.frames import ComplexArray, Frames
from geodesic_toolkit.refinement.sight import Sight
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["Surroundings", "surroundings"]


@dataclass(frozen=True, eq=False)
class Surroundings:
    """P sources with their tangent frames, and the vertices around them that fronts begin at.

    Attributes
    ----------
    points : SourcePoints
        The sources. One that lies between vertices may have more of them than those of its face or
        edge: those in sight.
    axes : ndarray of shape (P, 2, 3), float64
        Two unit vectors at right angles for each source: those of the vertex, or else the first of
        them leads along the first edge of the face.
    angles : ndarray of shape (nnz,), float64
        The direction from a source to each vertex around it; 0 if it is that vertex.
    arrivals : ndarray of shape (nnz,), float64
        The direction away from the source in the frame of the vertex; 0 at the source.
    """

    points: SourcePoints
    axes: FloatArray
    angles: FloatArray
    arrivals: FloatArray

    def to_frames(self, vectors: FloatArray) -> ComplexArray:
        """Return vectors in space, (P, 3), as complex numbers in the frames, (P,)."""
        along = np.einsum("pad,pd->pa", self.axes, vectors)
        return np.asarray(along[:, 0] + 1j * along[:, 1])


def surroundings(
    domain: Domain, frames: Frames, points: SourcePoints, sight: Sight
) -> Surroundings:
    """Return the surroundings of sources.

    Parameters
    ----------
    domain : TriangleMesh or PointCloud
    frames : Frames
        Of its vertices.
    points : SourcePoints
        No curve.
    sight : Sight
        The vertices in sight of the points, besides those around them.
    """
    first, rows = points.vertices[points.begins[:-1]], points.rows
    axes = np.stack([frames.x_axes[first], frames.y_axes[first]], axis=1)
    none = np.zeros(len(points.vertices))
    if points.are_vertices:
        return Surroundings(points, axes, none, none)
    positions, sizes = positions_of(domain), np.diff(points.begins)
    corners = positions[points.vertices]
    places = np.add.reduceat(points.shares[:, None] * corners, points.begins[:-1])
    steps = corners - places[rows]
    for size in (2, 3):
        own = np.flatnonzero(sizes == size)
        entries = points.begins[own][:, None] + np.arange(size)
        axes[own] = _axes_between(steps[entries], frames.normals[points.vertices[entries]])
    flat = np.einsum("kd,kad->ka", steps, axes[rows]) @ [1, 1j]
    away = positions[sight.vertices] - places[sight.rows]
    seen = _turned(points, sight, flat, np.einsum("kd,kad->ka", away, axes[sight.rows]) @ [1, 1j])
    between = sizes[rows] > 1
    angles = np.where(between, np.angle(flat), 0.0)
    arrivals = np.where(between, np.angle(frames.to_frames(steps, points.vertices)), 0.0)
    order = np.argsort(np.append(rows, sight.rows), kind="stable")
    distances = np.append(points.distances, sight.distances)[order]
    with np.errstate(divide="ignore"):
        curvatures = 1 / distances  # given, so that what is in sight is not looked for again
    around = SourcePoints(
        np.append(points.vertices, sight.vertices)[order],
        np.append(points.shares, np.zeros(len(seen)))[order],
        np.append(0, np.cumsum(sizes + np.bincount(sight.rows, minlength=points.count))),
        points.n_vertices,
        distances,
        points.starts,
        curvatures,
    )
    return Surroundings(
        around,
        axes,
        np.append(angles, np.angle(seen))[order],
        np.append(arrivals, np.angle(frames.to_frames(away, sight.vertices)))[order],
    )


def _turned(
    points: SourcePoints, sight: Sight, flat: ComplexArray, directions: ComplexArray
) -> ComplexArray:
    """Return the places of vertices in sight in the frames of their sources, (S,).

    Parameters
    ----------
    points : SourcePoints
    sight : Sight
    flat : ndarray of shape (nnz,), complex128
        The places of the vertices around the sources in these frames.
    directions : ndarray of shape (S,), complex128
        Those of the vertices in sight, projected to them.
    """
    begins, sizes, rows = points.begins[:-1], np.diff(points.begins), sight.rows
    is_farthest = points.distances == np.maximum.reduceat(points.distances, begins)[points.rows]
    farthest = np.flatnonzero(is_farthest)
    _, first = np.unique(points.rows[farthest], return_index=True)
    farthest = farthest[first]
    second, third = (begins + (farthest - begins + step) % sizes for step in (1, 2))
    x_axis = (flat[farthest] / np.maximum(np.abs(flat[farthest]), np.finfo(float).tiny)).conj()
    # In the plane of the sight the second vertex around a source lies above the x axis, and a third
    # one below it; beside an edge, which has two, vertices in sight decide.
    of_face = (flat[second] * x_axis).imag - (flat[third] * x_axis).imag
    agreement = (directions * x_axis[rows]).imag * sight.positions.imag
    of_edge = np.bincount(rows, agreement, minlength=points.count)
    mirrored = np.where(sizes == 3, of_face, of_edge)[rows] < 0
    placed = np.where(mirrored, sight.positions.conj(), sight.positions)
    return np.asarray(placed * x_axis[rows].conj())


def _axes_between(steps: FloatArray, normals: FloatArray) -> FloatArray:
    """Return two axes (P, 2, 3) in planes of triangles, or in those of edges and mean normals."""
    along = _unit(steps[:, 1] - steps[:, 0])
    up = normals.sum(axis=1)
    if steps.shape[1] == 3:
        own = np.cross(along, steps[:, 2] - steps[:, 0])
        up = np.where((np.einsum("pd,pd->p", own, up) < 0)[:, None], -own, own)
    return np.stack([along, _unit(np.cross(up, along))], axis=1)


def _unit(vectors: FloatArray) -> FloatArray:
    sizes = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(np.divide(vectors, sizes, out=np.zeros_like(vectors), where=sizes > 0))
