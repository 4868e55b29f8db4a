"""Stars in plane charts: the Laplacian of a surface that is known by neighbourhoods alone."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.errors import InvalidDiscretizationError
from geodesic_toolkit.geometry.triangles import (
    face_areas,
    frames_from_lengths,
    inverse_frames,
)
from geodesic_toolkit.laplacians.pointcloud.elements import with_segments
from geodesic_toolkit.laplacians.pointcloud.stars import delaunay_stars, tie_widths

__all__ = ["discretization_of_charts"]

AT_ONCE = 20_000
"""Charts whose stars are made at once: each has a copy of its neighbours in space."""

STIFFEST = 100.0
"""Largest width of a link in shares of its length, as in ``pointcloud.soup``."""


def discretization_of_charts(
    neighbours: IntArray,
    coordinates: FloatArray,
    *,
    n_vertices: int,
    centres: IntArray | None = None,
    k: int | None = None,
    positions: FloatArray | None = None,
    links: IntArray | None = None,
    link_lengths: FloatArray | None = None,
    representatives: IntArray | None = None,
    notes: Mapping[str, Any] = MappingProxyType({}),
) -> Discretization:
    """Return the discretization of -Δ (positive semidefinite) on a surface given by charts.

    Each chart lays the neighbours of one vertex out in the plane about it. The star of the Delaunay
    triangulation there are its triangles; each counts a third, as on point clouds.

    Parameters
    ----------
    neighbours : array of shape (M, m), int64
        Vertices, nearest first.
    coordinates : array of shape (M, m, 2), float64
        Where they lie in the chart, the centre at (0, 0); NaN for those on another sheet.
    n_vertices : int
        Number N of vertices.
    centres : array of shape (M,), int64, optional
        The vertex of each chart, ascending; by default all N.
    k : int, optional
        Neighbours that a star begins with, half of m by default; it grows where these do not
        determine it.
    positions : array of shape (N, d), float64, optional
        Places in a Euclidean space of any dimension, by which refinement measures the triangles:
        for vertices that lie on the surface almost without noise.
    links : array of shape (L, 2), int64, optional
        Further connections between vertices.
    link_lengths : array of shape (L,), float64, optional
        Their lengths.
    representatives : array of shape (N,), int64, optional
        The vertex whose distance each vertex reads, as in :class:`Discretization`.
    notes : mapping, optional
        For :class:`Discretization`; ``open_stars`` and ``links`` are added.

    Returns
    -------
    Discretization

    Raises
    ------
    InvalidDiscretizationError
        Shapes that do not fit, a vertex out of range, or neither triangles nor links.

    Examples
    --------
    >>> import numpy as np
    >>> import geodesic_toolkit as gt
    >>> plane = np.random.default_rng(0).random((200, 2))
    >>> steps = plane[None] - plane[:, None]
    >>> near = np.linalg.norm(steps, axis=2).argsort()[:, 1:21]
    >>> charts = np.take_along_axis(steps, near[:, :, None], 1)
    >>> square = gt.discretization_of_charts(near, charts, n_vertices=200)
    >>> round(float(square.mass.sum()), 1)
    0.9
    """
    near, laid_out, own = _checked(neighbours, coordinates, centres, n_vertices)
    pairs = np.zeros((0, 2), dtype=np.int64) if links is None else np.asarray(links, np.int64)
    far = np.zeros(0) if link_lengths is None else np.asarray(link_lengths, np.float64)
    first = near.shape[1] // 2 if k is None else k
    weights = _tie_breakers(laid_out, own, n_vertices)
    triangles, frames, is_open = _stars(
        near, laid_out, own, weights, k=first, smooth=positions is not None
    )
    if not len(triangles) + len(pairs):
        raise InvalidDiscretizationError("the charts have neither triangles nor links")
    spokes = np.concatenate([frames[:, 0], np.hypot(frames[:, 1], frames[:, 2])])
    spacing = float((spokes if len(spokes) else far).mean())
    widths = np.minimum(spacing, STIFFEST * far)
    shares = np.ones(len(triangles))
    gradient = with_segments(
        triangles,
        frames,
        shares,
        links=(pairs, far, widths),
        ties=np.zeros((0, 2), dtype=np.int64),
        tie_length=1.0,
        n_vertices=n_vertices,
    )
    corners = np.repeat(face_areas(frames) / 9, 3)
    ends = np.repeat(far * widths / 2, 2)
    mass = np.asarray(
        np.bincount(triangles.ravel(), corners, minlength=n_vertices)
        + np.bincount(pairs.ravel(), ends, minlength=n_vertices),
        dtype=np.float64,
    )
    boundary = np.zeros(n_vertices, dtype=np.bool_)
    boundary[own] = is_open
    others = np.zeros(0, dtype=np.int64) if representatives is None else representatives
    return Discretization(
        mass=mass,
        stiffness=gradient.stiffness(),
        gradient=gradient,
        spacing=spacing,
        boundary=boundary,
        surface_frames=_in_space(triangles, positions, gradient),
        representatives=others,
        notes={**notes, "open_stars": int(is_open.sum()), "links": len(pairs)},
        copy=False,
    )


def _checked(
    neighbours: IntArray, coordinates: FloatArray, centres: IntArray | None, n_vertices: int
) -> tuple[IntArray, FloatArray, IntArray]:
    near = np.asarray(neighbours, dtype=np.int64)
    laid_out = np.asarray(coordinates, dtype=np.float64)
    own = np.arange(n_vertices) if centres is None else np.asarray(centres, dtype=np.int64)
    if near.ndim != 2 or laid_out.shape != (*near.shape, 2) or own.shape != near.shape[:1]:
        raise InvalidDiscretizationError(
            f"neighbours {near.shape}, coordinates {laid_out.shape} and centres {own.shape} must "
            "be (M, m), (M, m, 2) and (M,)"
        )
    for indices in (near, own):
        if indices.size and not 0 <= indices.min() <= indices.max() < n_vertices:
            raise InvalidDiscretizationError(
                f"a chart refers to vertex {indices.min() if indices.min() < 0 else indices.max()}"
                f"; there are {n_vertices}, numbered from 0"
            )
    return near, laid_out, own


def _stars(
    near: IntArray,
    laid_out: FloatArray,
    own: IntArray,
    weights: FloatArray,
    *,
    k: int,
    smooth: bool,
) -> tuple[IntArray, FloatArray, BoolArray]:
    """Return the stars of all charts: triangles (E, 3), frames (E, 3), which stars are open."""
    squared = np.einsum("nmd,nmd->nm", laid_out, laid_out)
    on_sheet = np.isfinite(squared)
    size = near.shape[1]
    triangles, frames = [np.zeros((0, 3), dtype=np.int64)], [np.zeros((0, 3))]
    is_open = np.ones(len(own), dtype=np.bool_)
    for begin in range(0, len(own), AT_ONCE):
        some = slice(begin, begin + AT_ONCE)
        count = len(own[some])
        places = np.zeros((count, size + 1, 3))
        # Straight above its centre a neighbour is on another sheet.
        places[:, 1:, :2] = np.where(on_sheet[some][:, :, None], laid_out[some], 0.0)
        places[:, 1:, 2] = np.where(on_sheet[some], 0.0, _reach(squared[some])[:, None])
        vertices = np.column_stack([own[some], near[some]])
        middle = np.arange(count) * (size + 1)
        found, planar, is_open[some] = delaunay_stars(
            places.reshape(-1, 3),
            np.broadcast_to([0.0, 0.0, 1.0], (places.size // 3, 3)),
            middle[:, None] + 1 + np.arange(size),
            k=k,
            oriented=False,
            smooth=smooth,
            centres=middle,
            weights=weights[vertices].ravel(),
        )
        triangles.append(vertices.ravel()[found])
        frames.append(planar)
    return np.concatenate(triangles), np.concatenate(frames), is_open


def _tie_breakers(laid_out: FloatArray, own: IntArray, n_vertices: int) -> FloatArray:
    """Return what squared distances from vertices are lessened by, (N,), in all charts."""
    squared = np.einsum("nmd,nmd->nm", laid_out, laid_out)
    nearest = np.where(np.isfinite(squared), squared, np.inf).min(axis=1, initial=np.inf)
    weights = np.zeros(n_vertices)
    weights[own] = tie_widths(np.where(np.isfinite(nearest), nearest, 0.0))
    return weights


def _reach(squared: FloatArray) -> FloatArray:
    """Return the distance of the farthest neighbour on the sheet of each chart, 1 without any."""
    reach = np.sqrt(np.where(np.isfinite(squared), squared, 0.0).max(axis=1, initial=0.0))
    return np.where(reach > 0, reach, 1.0)


def _in_space(
    triangles: IntArray, positions: FloatArray | None, gradient: ElementGradient
) -> FloatArray:
    """Return all elements' inverse frames, the triangles' measured between positions."""
    if positions is None:
        return np.zeros((0, 3))
    sides = [
        positions[triangles[:, (corner + 1) % 3]] - positions[triangles[:, (corner + 2) % 3]]
        for corner in range(3)
    ]
    lengths = np.sqrt(np.stack([np.einsum("ed,ed->e", side, side) for side in sides], axis=1))
    inverse = gradient.inverse_frames.copy()
    inverse[: len(triangles)] = inverse_frames(frames_from_lengths(lengths))
    return inverse
