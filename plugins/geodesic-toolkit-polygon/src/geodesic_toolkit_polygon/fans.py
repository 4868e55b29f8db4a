"""Polygons as fans of triangles about a vertex inside each."""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls
from scipy.sparse import csr_array

__all__ = ["Fans", "fans_of"]

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]

FLATNESS = 1e-10
"""Share of the squared size of a polygon below which it has no extent in a direction: single
precision, the coarsest that files have, leaves 1e-14."""

TILT = 1e-9
"""Share of its polygon that a triangle of a fan may be turned over by rounding."""

EVENNESS = 1e-3
"""Weight of even shares against the best place, where the best place has none that are convex."""


@dataclass(frozen=True)
class Fans:
    """Triangles that cover polygons.

    Attributes
    ----------
    triangles : ndarray of shape (F, 3), int64
        Of N + V vertices, the further ones last.
    weights : csr_array of shape (V, N), float64
        The place of each further vertex as a convex combination of the corners of its polygon.
    """

    triangles: IntArray
    weights: csr_array


def fans_of(vertices: FloatArray, sizes: IntArray, corners: IntArray, split: IntArray) -> Fans:
    """Return polygons as fans about a vertex inside each; triangles stay as they are.

    The vertex is where the squares of the areas of the triangles have the least sum (Bunge et al.
    2020, section 4.1). A polygon with a corner that this place does not see is split into triangles
    without a further vertex.

    Parameters
    ----------
    vertices : ndarray of shape (N, 3), float64
    sizes, corners : ndarray of int64
        Corners of each polygon, three at least, and their vertex indices, polygon by polygon.
    split : ndarray of shape (T, 3), int64
        Triangles inside the polygons without further vertices: those of a polygon follow each
        other, two fewer than it has corners.
    """
    count = len(vertices)
    begins = np.cumsum(sizes) - sizes
    split_begins = begins - 2 * np.arange(len(sizes))
    triangles = [split[split_begins[sizes == 3]]]
    rows: list[tuple[IntArray, FloatArray]] = []
    further = 0
    for size in np.unique(sizes[sizes > 3]).tolist():
        polygons = np.flatnonzero(sizes == size)
        rings = corners[begins[polygons, None] + np.arange(size)]
        weights, seen = _centres(vertices[rings])
        unseen = split_begins[polygons[~seen], None] + np.arange(size - 2)
        triangles.append(split[unseen.ravel()])
        rings, weights = rings[seen], weights[seen]
        centres = np.broadcast_to(count + further + np.arange(len(rings))[:, None], rings.shape)
        fan = np.stack([rings, np.roll(rings, -1, axis=1), centres], axis=2)
        triangles.append(fan.reshape(-1, 3))
        rows.append((rings, weights))
        further += len(rings)
    return Fans(np.concatenate(triangles), _matrix(rows, count))


def _matrix(rows: list[tuple[IntArray, FloatArray]], count: int) -> csr_array:
    lengths = [np.full(len(rings), rings.shape[1]) for rings, _ in rows]
    indptr = np.append(0, np.cumsum(np.concatenate([np.zeros(0, dtype=np.int64), *lengths])))
    columns = np.concatenate([np.zeros(0, dtype=np.int64), *(rings.ravel() for rings, _ in rows)])
    data = np.concatenate([np.zeros(0), *(weights.ravel() for _, weights in rows)])
    matrix = csr_array((data, columns, indptr), shape=(len(indptr) - 1, count))
    matrix.sum_duplicates()
    matrix.eliminate_zeros()
    return matrix


def _centres(rings: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Return the weights, (P, n), of a place inside each polygon (P, n, 3), and if it sees all."""
    spokes = rings - rings.mean(axis=1, keepdims=True)
    extent = np.abs(spokes).max(axis=(1, 2), keepdims=True)
    spokes = spokes / np.where(extent > 0, extent, 1.0)
    weights = _convex_weights(spokes, _of_least_areas(spokes))
    rays = spokes - np.einsum("pn,pnd->pd", weights, spokes)[:, None]
    areas = np.cross(rays, np.roll(rays, -1, axis=1))
    normals = areas.sum(axis=1)
    along = np.einsum("pnd,pd->pn", areas, normals)
    whole = np.einsum("pd,pd->p", normals, normals)
    return weights, np.asarray((along >= -TILT * whole[:, None]).all(axis=1))


def _of_least_areas(spokes: FloatArray) -> FloatArray:
    """Return the place, (P, 3), from which the squared areas of the fans add up to the least."""
    edges = np.roll(spokes, -1, axis=1) - spokes
    squares = np.einsum("pnd,pnd->p", edges, edges)
    matrix = squares[:, None, None] * np.eye(3) - np.einsum("pnd,pne->pde", edges, edges)
    # Where all edges lie on one line any place along it is as good: this takes the middle.
    matrix += (FLATNESS * np.where(squares > 0, squares, 1.0))[:, None, None] * np.eye(3)
    moments = np.cross(edges, np.cross(spokes, np.roll(spokes, -1, axis=1))).sum(axis=1)
    return np.asarray(np.linalg.solve(matrix, moments[..., None])[..., 0])


def _convex_weights(spokes: FloatArray, places: FloatArray) -> FloatArray:
    """Return the most even weights of the corners, (P, n), that make the places, or nearly so."""
    spread = np.einsum("pnd,pne->pde", spokes, spokes)
    inverse = np.linalg.pinv(spread, rcond=FLATNESS, hermitian=True)
    weights = 1 / spokes.shape[1] + np.einsum("pnd,pde,pe->pn", spokes, inverse, places)
    for polygon in np.flatnonzero(weights.min(axis=1) <= 0):
        weights[polygon] = _nonnegative_weights(spokes[polygon], places[polygon])
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def _nonnegative_weights(spokes: FloatArray, place: FloatArray) -> FloatArray:
    count = len(spokes)
    even = EVENNESS * np.eye(count)
    system = np.concatenate([spokes.T, np.ones((1, count)), even])
    wanted = np.concatenate([place, [1.0], np.full(count, EVENNESS / count)])
    return np.asarray(nnls(system, wanted)[0])
