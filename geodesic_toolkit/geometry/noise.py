"""An estimate of the amount by which noise lengthens the edges between samples of a surface.

Noise in many dimensions adds about the same to the square of every distance, however short. Four
neighbours that are all connected then span a tetrahedron, whereas without noise they would lie in a
plane: the smallest variance of the four is half of the amount that noise has added.
"""

from __future__ import annotations

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["squared_noise"]

N_TRIED_QUADRUPLES, MAX_QUADRUPLES, MIN_QUADRUPLES = 160_000, 4000, 100
"""Numbers of quadruples that are drawn, and of connected ones that are used at most and at
least."""

MIN_VARIANCE_RATIO_OF_PLANES = 0.3
"""Second over first variance of four vertices, below which they lie on a line, not in a plane."""

MIN_DETECTED_NOISE = 0.004
"""Noise relative to squared lengths below which it is taken as 0: without noise 0.000 to 0.002 are
found, with a standard deviation of 0.05 mean distances in each of ten dimensions 0.011 to 0.03.
"""


def squared_noise(n_vertices: int, edges: IntArray, lengths: FloatArray) -> float:
    """Return the amount that noise has added to squared lengths, 0 if noise is not found.

    Curvature, too, moves four vertices out of a plane, by an amount that grows with the fourth
    power of length: a fit separates it from noise, which is the same for short and long edges.

    Parameters
    ----------
    n_vertices : int
    edges : ndarray of shape (E, 2), int64
        Distinct, without loops.
    lengths : ndarray of shape (E,), float64
        Positive.

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.geometry.noise import squared_noise
    >>> rng = np.random.default_rng(0)
    >>> points = np.hstack([rng.random((60, 2)), 0.03 * rng.normal(size=(60, 8))])
    >>> edges = np.array([(i, j) for i in range(60) for j in range(i)])
    >>> lengths = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    >>> round(squared_noise(60, edges, lengths), 3)  # of 2 * 8 * 0.03² = 0.014
    0.015
    """
    squared = _connected_quadruples(n_vertices, edges, lengths)
    if len(squared) < MIN_QUADRUPLES:
        return 0.0
    first, second, third = _variances(squared).T
    planar = second > MIN_VARIANCE_RATIO_OF_PLANES * first
    if np.count_nonzero(planar) < MIN_QUADRUPLES:
        return 0.0
    size, height = squared[planar].mean(axis=1), third[planar]
    terms = np.column_stack([np.ones(len(size)), (size / size.mean()) ** 2])
    weights = 1 / (size + size.mean())  # the spread of heights grows with size
    (constant, _), *_ = np.linalg.lstsq(terms * weights[:, None], height * weights, rcond=None)
    noise = 2 * float(constant)
    return noise if noise > MIN_DETECTED_NOISE * float(np.median(lengths**2)) else 0.0


def _connected_quadruples(n_vertices: int, edges: IntArray, lengths: FloatArray) -> FloatArray:
    """Return the squared distances 01, 02, 03, 12, 13, 23 of quadruples that are all connected."""
    rng = np.random.default_rng(0)
    ends = np.concatenate([edges, edges[:, ::-1]])
    keys = ends[:, 0] * n_vertices + ends[:, 1]
    order = np.argsort(keys)
    keys, ends, squared = keys[order], ends[order], np.tile(lengths**2, 2)[order]
    degree = np.bincount(ends[:, 0], minlength=n_vertices)
    begins = np.cumsum(degree) - degree
    apex = rng.integers(n_vertices, size=N_TRIED_QUADRUPLES)
    apex = apex[degree[apex] >= 3]
    slots = begins[apex] + (rng.random((3, len(apex))) * degree[apex]).astype(np.int64)
    found = np.ones(len(apex), dtype=np.bool_)
    columns = list(squared[slots])
    for one, other in ((0, 1), (0, 2), (1, 2)):
        searched = ends[slots[one], 1] * n_vertices + ends[slots[other], 1]
        place = np.minimum(np.searchsorted(keys, searched), len(keys) - 1)
        found &= keys[place] == searched
        columns.append(squared[place])
    return np.column_stack(columns)[found][:MAX_QUADRUPLES]


def _variances(squared: FloatArray) -> FloatArray:
    """Return the sums of squares along the three principal axes of four vertices, largest first."""
    table = np.zeros((len(squared), 4, 4))
    rows, columns = np.triu_indices(4, 1)
    table[:, rows, columns] = table[:, columns, rows] = squared
    centre = np.eye(4) - 0.25
    values = np.linalg.eigvalsh(-0.5 * centre @ table @ centre)
    return np.asarray(np.sort(values, axis=1)[:, :0:-1])
