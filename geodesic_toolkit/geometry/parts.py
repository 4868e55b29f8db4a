"""Statistics of the connected components of a mesh: their edge lengths."""

import numpy as np

from geodesic_toolkit.core.rows import CompressedRows
from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["lengths_of_pattern", "mean_edges_of_parts", "part_scales"]


def lengths_of_pattern(vertices: FloatArray, edges: CompressedRows) -> tuple[IntArray, FloatArray]:
    """Return one end and the length of each edge in the pattern of a symmetric matrix.

    Parameters
    ----------
    vertices : ndarray of shape (N, 3)
    edges : CompressedRows of shape (N, N)
    """
    tails = np.repeat(np.arange(len(vertices)), np.diff(edges.indptr))
    upper = edges.indices > tails
    tails, heads = tails[upper], edges.indices[upper]
    return tails, np.asarray(np.linalg.norm(vertices[tails] - vertices[heads], axis=1))


def mean_edges_of_parts(
    lengths: FloatArray, tails: IntArray, parts: IntArray, spacing: float | None = None
) -> FloatArray:
    """Return the mean edge length of each component, (C,); `spacing` in those without any edge.

    Parameters
    ----------
    lengths, tails : ndarray of shape (E,)
        The length of every edge, and one of its ends.
    parts : ndarray of shape (N,), int64
        The connected component of every vertex.
    spacing : float, optional
        The mean of all lengths, unless given.
    """
    count = int(parts.max()) + 1
    mean = np.full(count, lengths.mean() if spacing is None else spacing)
    total = np.bincount(parts[tails], lengths, count)
    number = np.bincount(parts[tails], minlength=count)
    np.divide(total, number, out=mean, where=total > 0)
    return mean


def part_scales(
    parts: IntArray,
    mean: FloatArray,
    *,
    first_vertices: IntArray,
    squares: FloatArray,
    areas: FloatArray,
) -> FloatArray:
    """Return the square root of the default time step of each component, of shape (C,).

    It is the mean edge length h, as in the paper, but at least half of the root mean square edge of
    the *surface*, with edges weighted by the area of their triangles. If most edges are short ones
    in corners and the surface is a few long triangles, heat has to cross those. Measured: scans and
    sampled shapes keep h, as their ratio is below 1; the error on a body of a CAD model with a
    ratio of 3.6 falls from 17 to 2.5 %.

    Parameters
    ----------
    parts : ndarray of shape (N,), int64
        The connected component of every vertex.
    mean : ndarray of shape (C,), float64
        The mean edge length of each component.
    first_vertices : ndarray of shape (F,)
        One vertex of every triangle.
    squares, areas : ndarray of shape (F,)
        Mean squared edge length and area of the triangles.
    """
    count = len(mean)
    part = parts[first_vertices] if count > 1 else None
    area, covered = _totals(areas, part, count), _totals(areas * squares, part, count)
    square = np.divide(covered, area, out=np.zeros(count), where=area > 0)
    half = np.sqrt(square) / 2
    return np.where(half > mean, half, mean)


def _totals(values: FloatArray, part: IntArray | None, count: int) -> FloatArray:
    """Return the sum of values in each component, (C,); `part` is None for a single component."""
    return np.asarray(
        values.sum(keepdims=True) if part is None else np.bincount(part, values, count)
    )
