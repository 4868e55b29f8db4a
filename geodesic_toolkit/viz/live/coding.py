"""Values and colours as the page gets them: three bytes for a vertex, and a table of colours."""

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit.core.types import BoolArray, FloatArray
from geodesic_toolkit.viz.colours import INK, UNREACHED

__all__ = ["N_COLOURS", "coded", "style_rows"]

HIDDEN = 2**24 - 1
"""Code of a vertex that is hidden with its faces; surface.js has the same numbers."""

NO_VALUE = 2**24 - 3
"""Code of a vertex without a value, whose faces are grey. Codes are whole numbers in floats of 24
bits, which have no halves there: between two of them lies a limit that both programs compare to."""

LARGEST_CODE = 2**24 - 5
"""Code of the upper end of the colours."""

N_COLOURS = 64
"""Number of colours of the table; the page interpolates between them."""


def coded(
    values: FloatArray, limits: tuple[float, float], hidden: BoolArray | None = None
) -> NDArray[np.uint8]:
    """Return values as whole numbers of 24 bits between the ends of the colours.

    Parameters
    ----------
    values : ndarray of shape (N,)
        Not finite where there are none.
    limits : (float, float)
        Ends of the colour map.
    hidden : ndarray of shape (N,), bool, optional

    Returns
    -------
    ndarray of shape (N, 3), uint8
        The lowest byte first.

    Examples
    --------
    >>> coded(np.array([0.0, 1.0, np.inf]), (0.0, 1.0)).tolist()
    [[0, 0, 0], [251, 255, 255], [253, 255, 255]]
    """
    low, high = limits
    known = np.isfinite(values)
    share = np.where(known, values, low)
    share = np.clip((share - low) / (high - low), 0.0, 1.0)
    code = np.rint(share * LARGEST_CODE).astype("<u4")
    code[~known] = NO_VALUE
    if hidden is not None:
        code[hidden] = HIDDEN
    low_bytes: NDArray[np.uint8] = code.view(np.uint8).reshape(-1, 4)[:, :3]
    return low_bytes


def style_rows(table: FloatArray, limits: tuple[float, float], step: float) -> NDArray[np.float32]:
    """Return how the page shows values: colours in linear light, ends, distance of isolines.

    Parameters
    ----------
    table : ndarray of shape (N_COLOURS, 3)
        Red, green and blue between 0 and 1, as screens take them.
    limits : (float, float)
        Ends of the colour map.
    step : float
        The distance between isolines; 0 for none.

    Returns
    -------
    ndarray of shape (N_COLOURS + 3, 3), float32
        The colours; the colour without a value; that of isolines; both ends and the step.
    """
    colours = np.vstack([table, UNREACHED, INK])
    linear = np.where(colours <= 0.04045, colours / 12.92, ((colours + 0.055) / 1.055) ** 2.4)
    return np.vstack([linear, [*limits, step]]).astype(np.float32)
