"""Checks of the costs of cells and voxels."""

from typing import Any

import numpy as np

from geodesic_toolkit.domains.base import as_floats
from geodesic_toolkit.errors import InvalidDomainError
from geodesic_toolkit_volume.marching import Floats

__all__ = ["costs_of"]


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
