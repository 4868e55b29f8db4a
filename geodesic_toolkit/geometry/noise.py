"""An estimate of how much noise lengthens the edges between samples of a surface.

Noise in many dimensions adds about the same to the square of every distance, however short. Four
neighbours that are all connected then span a tetrahedron, where those of a surface would lie in a
plane: the least variance of the four is half of what noise has added.
"""

from __future__ import annotations

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray

__all__ = ["squared_noise"]

TRIES, TAKEN, FEWEST = 160_000, 4000, 100
"""Numbers of quadruples that are drawn, of connected ones that are used, and their least number."""

MIN_VARIANCE_RATIO_OF_PLANES = 0.3
"""Second over first variance of four vertices, below which they are a line rather than a plane."""

MIN_DETECTED_NOISE = 0.004
"""Part of the squared length below which it is none: without noise 0.000 to 0.002 are found, with a
standard deviation of 0.05 mean distances in each of ten dimensions 0.011 to 0.03.
"""


def squared_noise(n_vertices: int, edges: IntArray, lengths: FloatArray) -> float:
    """Return what noise has added to squared lengths, 0 where none is found.

    Curvature lifts four vertices from a plane as well, by the square of a length squared: a fit
    tells it from noise, which is the same for short edges as for long ones.

    Parameters
    ----------
    n_vertices : int
    edges : ndarray of shape (E, 2), int64
        Each once, without loops.
    lengths : ndarray of shape (E,), float64
        Positive.

    Examples
    --------
    >>> import numpy as np
    >>> from geodesic_toolkit.geometry.noise import squared_noise
    >>> rng = np.random.default_rng(0)
    >>> places = np.hstack([rng.random((60, 2)), 0.03 * rng.normal(size=(60, 8))])
    >>> edges = np.array([(i, j) for i in range(60) for j in range(i)])
    >>> lengths = np.linalg.norm(places[edges[:, 0]] - places[edges[:, 1]], axis=1)
    >>> round(squared_noise(60, edges, lengths), 3)  # of 2 * 8 * 0.03² = 0.014
    0.015
    """
    squared = _connected_fours(n_vertices, edges, lengths)
    if len(squared) < FEWEST:
        return 0.0
    first, second, third = _variances(squared).T
    fat = second > MIN_VARIANCE_RATIO_OF_PLANES * first
    if np.count_nonzero(fat) < FEWEST:
        return 0.0
    size, height = squared[fat].mean(axis=1), third[fat]
    terms = np.column_stack([np.ones(len(size)), (size / size.mean()) ** 2])
    weights = 1 / (size + size.mean())  # heights spread as sizes do
    (constant, _), *_ = np.linalg.lstsq(terms * weights[:, None], height * weights, rcond=None)
    noise = 2 * float(constant)
    return noise if noise > MIN_DETECTED_NOISE * float(np.median(lengths**2)) else 0.0


def _connected_fours(n_vertices: int, edges: IntArray, lengths: FloatArray) -> FloatArray:
    """Return the squared distances 01, 02, 03, 12, 13, 23 of vertices that are all connected."""
    rng = np.random.default_rng(0)
    ends = np.concatenate([edges, edges[:, ::-1]])
    keys = ends[:, 0] * n_vertices + ends[:, 1]
    order = np.argsort(keys)
    keys, ends, squared = keys[order], ends[order], np.tile(lengths**2, 2)[order]
    degree = np.bincount(ends[:, 0], minlength=n_vertices)
    begins = np.cumsum(degree) - degree
    apex = rng.integers(n_vertices, size=TRIES)
    apex = apex[degree[apex] >= 3]
    slots = begins[apex] + (rng.random((3, len(apex))) * degree[apex]).astype(np.int64)
    found = np.ones(len(apex), dtype=np.bool_)
    columns = list(squared[slots])
    for one, other in ((0, 1), (0, 2), (1, 2)):
        wanted = ends[slots[one], 1] * n_vertices + ends[slots[other], 1]
        place = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        found &= keys[place] == wanted
        columns.append(squared[place])
    return np.column_stack(columns)[found][:TAKEN]


def _variances(squared: FloatArray) -> FloatArray:
    """Return the sums of squares along the three principal axes of four vertices, largest first."""
    table = np.zeros((len(squared), 4, 4))
    rows, columns = np.triu_indices(4, 1)
    table[:, rows, columns] = table[:, columns, rows] = squared
    centre = np.eye(4) - 0.25
    values = np.linalg.eigvalsh(-0.5 * centre @ table @ centre)
    return np.asarray(np.sort(values, axis=1)[:, :0:-1])
