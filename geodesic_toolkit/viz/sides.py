"""Colours of signed values: white at zero, blue on one side, red on the other."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.errors import InvalidOptionError

__all__ = ["two_sided"]


def two_sided(values: ArrayLike) -> dict[str, Any]:
    """Return options of :func:`plot` that draw signed values with 0 in the middle of the colours.

    Parameters
    ----------
    values : array-like of shape (N,)
        Such as the result of :func:`~geodesic_toolkit.signed_distance`; not finite where there are
        none.

    Returns
    -------
    dict
        ``cmap``, ``limits``, ``sources`` and ``label``: positive values are blue, negative ones
        red, and values of the same size equally dark.

    Raises
    ------
    InvalidOptionError
        Something that is not an array of numbers.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.viz.two_sided([-1.0, 3.0, float("inf")])["limits"]
    (-3.0, 3.0)

    ``gt.viz.plot(mesh, signed, curves=curve, **gt.viz.two_sided(signed))`` draws it.
    """
    try:
        sizes = np.abs(np.asarray(values, dtype=np.float64))
    except (TypeError, ValueError) as error:
        raise InvalidOptionError(f"the values cannot be read as numbers: {error}") from error
    largest = float(sizes[np.isfinite(sizes)].max(initial=0.0)) or 1.0
    return {
        "cmap": "RdBu",
        "limits": (-largest, largest),
        "sources": [],
        "label": "signed distance",
    }
