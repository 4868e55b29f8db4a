"""The page of a picture: the layout of views, colour bar and texts by matplotlib, in pixels."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodesic_toolkit.core.optional import require
from geodesic_toolkit.viz.camera import View, fit
from geodesic_toolkit.viz.colours import INK, UNREACHED, Style
from geodesic_toolkit.viz.scene import Scene

__all__ = ["Page"]

PIXELS_PER_POINT = 0.72
"""Size of a pixel in typographic points, at the figure's 100 pixels per inch."""

MOST_MARKS = 60
"""Largest number of isolines drawn in the colour bar; more would blacken it."""


class Page:
    """The layout of one picture.

    Attributes
    ----------
    em : float
        Size of the type, the unit of all other lengths.
    cell : (int, int)
        Width and height of the cell of each view.
    scale : float
        Pixels per unit of the scene, the same in all views.
    views : sequence of View
    frames : ndarray of shape (V, 4)
        Centre and half extents of the shape on the picture of each view.
    """

    def __init__(
        self, size: tuple[int, int], scene: Scene, views: Sequence[View], *, titled: bool
    ) -> None:
        figures = require("matplotlib.figure", "viz", "Pictures need")
        canvases = require("matplotlib.backends.backend_agg", "viz", "Pictures need")
        self.width, self.height = size
        self.scene, self.views = scene, views
        self.frames = fit(scene, views)
        self.em = max(7.0, min(self.width / 1.6, self.height) / 46)
        self.top = round((3.0 if titled else 0.6) * self.em)
        self.bar = round((8.2 if scene.reached.any() else 0.6) * self.em)
        columns, self.scale = self._arrange()
        self.columns = columns
        rows = -(-len(views) // columns)
        self.cell = ((self.width - self.bar) // columns, (self.height - self.top) // rows)
        inches = (self.width / 100, self.height / 100)
        self.figure = figures.Figure(figsize=inches, dpi=100, facecolor="white")
        canvases.FigureCanvasAgg(self.figure)  # not pyplot: no global state, no display

    def _arrange(self) -> tuple[int, float]:
        """Return the number of columns that shows the shape largest, and the scale of that layout.

        Views are side by side unless another layout is larger by a tenth.
        """
        best = (len(self.views), 1.0)
        extent = np.maximum(2 * self.frames[:, 2:].max(axis=0), 1e-9)
        margin = np.array([2.0, 3.6]) * self.em
        for columns in range(len(self.views), 0, -1):
            rows = -(-len(self.views) // columns)
            free = np.array([(self.width - self.bar) / columns, (self.height - self.top) / rows])
            scale = float(np.min((free - margin) / extent))
            if scale > 1.1 * best[1]:
                best = (columns, scale)
        return best

    def place(self, index: int, picture: NDArray[np.uint8]) -> None:
        """Copy a rendered view into its cell, pixel by pixel."""
        row, column = divmod(index, self.columns)
        left, top = column * self.cell[0], self.top + row * self.cell[1]
        self.figure.figimage(picture, left, self.height - top - picture.shape[0], origin="upper")
        name = self.views[index].name
        if name and len(self.views) > 1:
            middle, below = left + self.cell[0] / 2, top + self.cell[1] - 0.9 * self.em
            self._text(middle, below, name, size=0.85, color="#777777")

    def write_title(self, title: str) -> None:
        """Write a line above the views."""
        self._text(self.width / 2, 1.6 * self.em, title, size=1.25)

    def write_legend(self, style: Style, label: str) -> None:
        """Draw the colour bar with the isolines in it, and explain grey if it occurs."""
        if not self.scene.reached.any():
            return
        cm = require("matplotlib.cm", "viz", "Pictures need")
        colors = require("matplotlib.colors", "viz", "Pictures need")
        free, em = self.height - self.top, self.em
        left, bottom, wide = self.width - self.bar + 0.6 * em, 0.14 * free, 1.1 * em
        mappable = cm.ScalarMappable(
            colors.Normalize(*self.scene.limits), colors.ListedColormap(style.table)
        )
        place = self._axes(left, bottom, wide, 0.72 * free)
        bar = self.figure.colorbar(mappable, cax=place, extend=self._beyond())
        bar.set_label(label, fontsize=em * PIXELS_PER_POINT, labelpad=0.4 * em, color=INK)
        bar.ax.tick_params(
            labelsize=0.9 * em * PIXELS_PER_POINT, width=0.8, length=0.3 * em, colors=INK
        )
        bar.outline.set_linewidth(0.6)
        for level in style.levels if len(style.levels) <= MOST_MARKS else ():
            bar.ax.axhline(level, color=INK, linewidth=0.7)
        if not self.scene.reached[self.scene.present].all():
            box = self._axes(left, bottom - 2.4 * em, wide, 1.1 * em)
            box.set(xticks=[], yticks=[], facecolor=UNREACHED)
            for spine in box.spines.values():
                spine.set_linewidth(0.6)
            beside, below = left + wide + 0.5 * em, self.height - bottom + 1.85 * em
            self._text(beside, below, "not reached", size=0.9, align="left")

    def _beyond(self) -> str:
        """Return the ends of the bar that have an arrow, as values exceed the limits there."""
        low, high = self.scene.limits
        values = self.scene.values[self.scene.reached & self.scene.present]
        slack = 1e-6 * (high - low)
        ends = (bool(values.min() < low - slack), bool(values.max() > high + slack))
        return {
            (False, False): "neither",
            (True, False): "min",
            (False, True): "max",
            (True, True): "both",
        }[ends]

    def finish(self) -> NDArray[np.uint8]:
        """Return the page as an array of shape (height, width, 3)."""
        self.figure.canvas.draw()
        return np.array(self.figure.canvas.buffer_rgba(), dtype=np.uint8)[:, :, :3].copy()

    def _axes(self, left: float, bottom: float, width: float, height: float) -> Any:
        return self.figure.add_axes(
            (left / self.width, bottom / self.height, width / self.width, height / self.height)
        )

    def _text(
        self,
        x: float,
        y: float,
        words: str,
        *,
        size: float,
        color: Any = INK,
        align: str = "center",
    ) -> None:
        self.figure.text(
            x / self.width,
            1 - y / self.height,
            words,
            ha=align,
            va="center",
            fontsize=size * self.em * PIXELS_PER_POINT,
            color=color,
            parse_math=False,  # a title is literal text, including "$" and "_"
        )
