"""Colours by component instead of by distance."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.types import FloatArray

__all__ = ["OF_PARTS", "by_part"]

N_COLOURS = 20
"""Number of colours of matplotlib's tab20; further components share all but the first."""

OF_PARTS: dict[str, Any] = {
    "cmap": "tab20",
    "limits": (0, N_COLOURS - 1),
    "isolines": 0,
    "label": "part, the largest 0",
}
"""Options of pictures of components."""


def by_part(components: ArrayLike) -> FloatArray:
    """Return values that draw each component of a shape in its own colour.

    Parameters
    ----------
    components : array-like of shape (N,), int
        The component of each vertex, ``solver.method.metric.components``.

    Returns
    -------
    ndarray of shape (N,), float64
        0 on the largest component, 1 on the second, ... 19; further ones have 1 to 19 again. Those
        of a single vertex have NaN, and are grey.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.viz.by_part([7, 7, 4, 4, 4, 2]).tolist()
    [1.0, 1.0, 0.0, 0.0, 0.0, nan]

    ``gt.viz.plot(cloud, gt.viz.by_part(components), path="parts.png", **gt.viz.OF_PARTS)`` draws
    it.
    """
    part, sizes = np.unique(np.asarray(components), return_inverse=True, return_counts=True)[1:]
    order = np.empty(len(sizes))
    order[np.argsort(-sizes, kind="stable")] = np.arange(len(sizes))
    shown = np.where(order < N_COLOURS, order, 1 + (order - 1) % (N_COLOURS - 1))
    shown[sizes == 1] = np.nan
    return np.asarray(shown[part])
