"""Colours by value: named colour maps, and round values for isolines."""

import difflib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geodesic_toolkit.core.optional import require
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.errors import InvalidOptionError
from geodesic_toolkit.viz.scene import Scene

__all__ = [
    "CURVE",
    "INK",
    "MARKER",
    "UNREACHED",
    "colour_table",
    "isoline_levels",
    "packed",
    "point_colours",
]

UNREACHED = (0.78, 0.78, 0.78)
"""Grey of vertices without a finite value."""

INK = (0.08, 0.08, 0.10)
"""Colour of isolines and text."""

CURVE = (0.93, 0.38, 0.02)
"""Orange of curves, which no value of the default map has."""

MARKER = (0.86, 0.08, 0.14)
"""Red of the sources."""


@dataclass(frozen=True)
class Style:
    """Colours from the least value to the greatest, and the values of isolines.

    Attributes
    ----------
    table : ndarray of shape (256, 3)
        Red, green and blue between 0 and 1.
    levels : ndarray of shape (L,)
    """

    table: FloatArray
    levels: FloatArray


def choose_style(scene: Scene, cmap: Any, isolines: int | ArrayLike) -> Style:
    """Return the requested colours and levels; on points, only as many levels as discernible."""
    levels = isoline_levels(isolines, scene.limits)
    return Style(
        colour_table(cmap), levels if scene.faces is not None else _thinned(levels, 6 * scene.band)
    )


def colour_table(cmap: Any, n: int = 256) -> FloatArray:
    """Return `n` colours from the least value to the greatest.

    Parameters
    ----------
    cmap : str or matplotlib Colormap
        Name of a colour map of matplotlib, including registered ones.
    n : int
        Number of colours.

    Returns
    -------
    ndarray of shape (n, 3), float64
        Red, green and blue between 0 and 1.

    Raises
    ------
    InvalidOptionError
        There is no map of that name; the message lists near misses.
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> colour_table("brg", 2)
    array([[0., 0., 1.],
           [0., 1., 0.]])
    """
    matplotlib = require("matplotlib", "viz", "Colour maps need")
    if isinstance(cmap, str):
        known = {name.lower(): name for name in matplotlib.colormaps}
        if cmap not in matplotlib.colormaps:
            near = difflib.get_close_matches(cmap.lower(), known, n=3, cutoff=0.5)
            hint = (
                f"did you mean {' or '.join(repr(known[name]) for name in near)}?" if near else ""
            )
            raise InvalidOptionError(
                f"no colour map {cmap!r}; {hint or 'use a name in matplotlib.colormaps'}"
            )
        cmap = matplotlib.colormaps[cmap]
    if not isinstance(cmap, require("matplotlib.colors", "viz", "Colour maps need").Colormap):
        raise InvalidOptionError(f"cmap must be a name or a matplotlib Colormap, not {cmap!r}")
    table: FloatArray = np.asarray(cmap(np.linspace(0.0, 1.0, n)), dtype=np.float64)[:, :3]
    return table


def isoline_levels(isolines: int | ArrayLike, limits: tuple[float, float]) -> FloatArray:
    """Return the values of isolines.

    Parameters
    ----------
    isolines : int or array-like of float
        Approximate number, at round values (0 for none); or the values themselves.
    limits : (float, float)
        Least and greatest value of the field; levels lie between them.

    Returns
    -------
    ndarray of shape (L,), float64
        Increasing.

    Raises
    ------
    InvalidOptionError
        A negative number, or values that are not finite numbers.

    Examples
    --------
    >>> isoline_levels(5, (0.0, 1.1))
    array([0.2, 0.4, 0.6, 0.8, 1. ])
    """
    low, high = limits
    try:
        wanted = np.asarray(isolines)
        levels = wanted.astype(np.float64).ravel()
    except (TypeError, ValueError) as error:
        raise InvalidOptionError(f"isolines are a number or values, not {isolines!r}") from error
    if wanted.dtype.kind not in "iuf" or not np.isfinite(levels).all():
        raise InvalidOptionError(f"isolines must be a number or finite values, not {isolines!r}")
    if wanted.ndim == 0:
        if wanted.dtype.kind == "f" or wanted < 0:
            raise InvalidOptionError(f"isolines are values or an integer >= 0, not {isolines!r}")
        if wanted == 0:
            return np.zeros(0)
        ticker = require("matplotlib.ticker", "viz", "Isolines need")
        locator = ticker.MaxNLocator(nbins=int(1.5 * wanted) + 1, steps=[1, 2, 2.5, 5, 10])
        levels = np.asarray(locator.tick_values(low, high), dtype=np.float64)
    margin = 1e-9 * (high - low)
    return np.unique(levels[(levels > low + margin) & (levels < high - margin)])


def point_colours(scene: Scene, style: Style) -> FloatArray:
    """Return a colour for each point, of shape (N, 3): by its value, darker close to a level."""
    low, high = scene.limits
    values, levels = scene.values, style.levels
    place = np.clip((np.nan_to_num(values) - low) / (high - low), 0.0, 1.0)
    colours = style.table[np.round(place * (len(style.table) - 1)).astype(np.int64)]
    if len(levels):
        after = np.clip(np.searchsorted(levels, values), 1, max(len(levels) - 1, 1))
        nearest = levels[np.stack([after - 1, np.minimum(after, len(levels) - 1)])]
        colours[np.abs(values - nearest).min(axis=0) < scene.band] *= 0.5
    if scene.checkers is not None:
        colours = 1 - scene.checkers.shares() * (1 - colours)
    colours[~scene.reached] = UNREACHED
    return colours


def packed(colour: Any) -> int:
    """Return a colour as one number, 0xRRGGBB.

    Examples
    --------
    >>> hex(packed((1.0, 0.5, 0.0)))
    '0xff8000'
    """
    red, green, blue = (round(255 * float(part)) for part in colour)
    return red << 16 | green << 8 | blue


def _thinned(levels: FloatArray, gap: float) -> FloatArray:
    """Return every second, fifth, tenth ... level, so that they are at least `gap` apart.

    Levels are counted from one that stays round: 0.2, 0.4 rather than 0.1, 0.3. The result is empty
    if even two levels do not fit.
    """
    if len(levels) < 2:
        return levels
    step = float(np.diff(levels).min())
    for stride in (1, 2, 5, 10, 20, 50):
        if stride * step >= gap:
            number = np.round(levels / step).astype(np.int64)
            kept: FloatArray = levels[number % stride == 0]
            return kept
    return levels[:0]
