"""Points of a cloud on curves, and lines along which a surface is sampled."""

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.geometry.components import connected_by_edges
from geodesic_toolkit.laplacians.pointcloud.crowds import Representatives
from geodesic_toolkit.laplacians.pointcloud.curves import largest_chain
from geodesic_toolkit.laplacians.pointcloud.soup import Soup

__all__ = ["on_curves", "share_of_longest_line"]

MAX_CLOSED_SHARE_OF_THINNED_CURVES = 0.1
"""Share of closed stars below which a thinned component of a cloud is taken for curves. Measured:
two lines have 0, scan lines of surfaces 0.5 to 0.9."""

MAX_CLOSED_SHARE_OF_CURVES = 0.4
"""The same share for components, thinned or not, with most points on lines: three lines side by
side have a third."""

MIN_SHARE_ON_LINES_OF_CURVES = 0.8
"""Minimum share of points on lines in a component of curves. Measured: wires have 0.95 and more, a
band of random points as wide as their spacing 0.6."""


def on_curves(soup: Soup, thin: Representatives, on_lines: BoolArray) -> BoolArray:
    """Return a mask (N,) of the points on curves instead of surfaces.

    Lines of a surface have others on either side, so that most of their stars are closed. If almost
    no star is closed, the stars connect a wire, or a few lines at most.
    """
    count = len(on_lines)
    crowded = thin.reaches > 0
    if not (crowded.any() or on_lines.any()):
        return crowded
    alone = np.bincount(soup.triangles.ravel(), minlength=count) == 0
    # A line goes on where it bends, although the points there have triangles.
    steps = np.concatenate([soup.triangles[:, :2], soup.triangles[:, 1:], soup.links])
    part = connected_by_edges(steps, count)
    whole = ~soup.boundary & ~alone
    open_crowds = _shares(part, whole, crowded) < MAX_CLOSED_SHARE_OF_THINNED_CURVES
    few_lines = _shares(part, whole, thin.is_kept) < MAX_CLOSED_SHARE_OF_CURVES
    few_lines &= _shares(part, on_lines, thin.is_kept) > MIN_SHARE_ON_LINES_OF_CURVES
    represented_alone = alone[thin.kept][thin.nearest]
    curved = crowded & (alone | represented_alone | open_crowds[part])
    return np.asarray(curved | few_lines[part])


def _shares(part: IntArray, chosen: BoolArray, among: BoolArray) -> FloatArray:
    """Return the chosen share of the points `among` in each component; 1 if there are none."""
    count = int(part.max()) + 1
    total = np.bincount(part[among], minlength=count)
    found = np.bincount(part[among & chosen], minlength=count)
    return np.divide(found, total, out=np.ones(count), where=total > 0)


def share_of_longest_line(points: FloatArray, thin: Representatives, on_lines: BoolArray) -> float:
    """Return the share of all points that the longest line of a surface holds."""
    on_lines = on_lines[thin.kept]
    if not on_lines.any():
        return 0.0
    return largest_chain(points[thin.kept], thin.own, on_lines)
