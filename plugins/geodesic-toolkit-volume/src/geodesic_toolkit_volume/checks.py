"""Checks of the costs and the sizes of cells and voxels."""

from typing import Any

import numpy as np

from geodesic_toolkit.domains.base import as_floats
from geodesic_toolkit.errors import InvalidDomainError, UnsupportedDomainError
from geodesic_toolkit.geometry.widths import MIN_WIDTH, check_width, widest
from geodesic_toolkit_volume.marching import Floats

__all__ = ["check_sizes", "costs_of"]


def costs_of(values: Any, shape: tuple[int, ...], what: str, where: Any = True) -> Floats:
    """Return costs of this shape, all 1 for None, that are positive and finite `where`."""
    if values is None:
        return np.ones(shape)
    costs = as_floats(values, "costs", shape)
    good = (np.isfinite(costs) & (costs > 0)) | ~np.broadcast_to(where, shape)
    if not good.all():
        bad = np.unravel_index(int(good.argmin()), shape)
        place = ", ".join(map(str, bad))
        raise InvalidDomainError(
            f"{what} {place} has the cost {costs[bad]}; costs must be positive and finite. Leave "
            "obstacles out of the body"
        )
    return costs


def check_sizes(points: Floats, costs: Floats) -> None:
    """Raise an `UnsupportedDomainError` if powers of lengths or costs over- or underflow.

    Parameters
    ----------
    points : ndarray of shape (N, 3)
        Points as far apart as those of the solid, or those of a voxel.
    costs : ndarray of shape (C,)
    """
    if not len(points) or not len(costs):
        return
    extent = widest(points) or 1.0
    check_width(extent, "solid")
    for cost in (float(costs.min()), float(costs.max())):
        least, most = cost * min(1.0, extent), cost * max(1.0, extent)
        if not MIN_WIDTH <= least <= most <= 1 / MIN_WIDTH:
            raise UnsupportedDomainError(
                f"the cost {cost:.3g} in a solid {extent:.3g} wide is out of the range of double "
                "precision; use another unit of costs"
            )
