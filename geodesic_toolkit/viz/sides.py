"""Colours of signed values: blue on one side of zero, red on the other."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.checks import real_numbers
from geodesic_toolkit.core.optional import require

__all__ = ["two_sided"]

HALF_GAP = 0.1
"""Share of the colours at each side of white that are omitted, so that sides differ at 0 too."""


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
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.viz.two_sided([-1.0, 3.0, float("inf")])["limits"]
    (-3.0, 3.0)

    ``gt.viz.plot(mesh, signed, curves=curve, **gt.viz.two_sided(signed))`` draws it.
    """
    sizes = np.abs(real_numbers(values, "values"))
    largest = float(sizes[np.isfinite(sizes)].max(initial=0.0)) or 1.0
    colormaps = require("matplotlib", "viz", "Colour maps need").colormaps
    colors = require("matplotlib.colors", "viz", "Colour maps need")
    places = np.linspace(-1.0, 1.0, 256)
    places = 0.5 + places * (0.5 - HALF_GAP) + np.sign(places) * HALF_GAP
    return {
        "cmap": colors.ListedColormap(colormaps["RdBu"](places), name="two_sided"),
        "limits": (-largest, largest),
        "sources": [],
        "label": "signed distance",
    }
