"""Statistics of the components of a cloud: their coarseness, and gaps between them."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.core.warning import warn
from geodesic_toolkit.errors import CurveWarning, FragmentedCloudWarning

__all__ = ["CloudParts", "warn_of_fragments", "warn_of_lines"]

MAX_RELATIVE_HEIGHT_OF_SLIVERS = 0.01
"""Height of a triangle, relative to its longest edge, below which it is a sliver."""

N_NEAREST = 8
"""Neighbours of a point among which another component is searched."""

MIN_SHARE_OF_LOST_POINTS = 0.02
"""Minimum share of points outside the largest component for a warning: scans have outliers."""

MAX_POINTS_WITHOUT_WARNING = 100
"""Points up to which a cloud is not a scan, and a warning is not given."""

MAX_SHARE_OF_ONE_LINE = 0.5
"""Maximum share of the points on one line of a surface without a warning. The lines of a scan are
many; a coil, the track of a probe and a skeleton are one."""


@dataclass(frozen=True)
class CloudParts:
    """The stars of a cloud and the components that they connect.

    Parameters
    ----------
    triangles : ndarray of shape (E, 3), int64
    frames : ndarray of shape (E, 3), float64
    shares : ndarray of shape (E,), float64
        Weights of the triangles.
    links : ndarray of shape (L, 2), int64
    link_lengths : ndarray of shape (L,), float64
    parts : ndarray of shape (N,), int64
        The component of every position.
    """

    triangles: IntArray
    frames: FloatArray
    shares: FloatArray
    links: IntArray
    link_lengths: FloatArray
    parts: IntArray

    def scales(self, spacing: float) -> FloatArray:
        """Return the square root of the default time step of each component, of shape (C,).

        It is the mean length of the spokes, but at least half of the root mean square edge,
        weighted by the area of its triangles, as on meshes. Most points of a sweep lie close to the
        scanner, and heat has to cross the triangles between the outermost rings.

        Parameters
        ----------
        spacing : float
            The mean length of all spokes, used for components without spokes.
        """
        mean, half = self._lengths(spacing)
        return np.maximum(mean, half)

    def _lengths(self, spacing: float) -> tuple[FloatArray, FloatArray]:
        """Return the mean spoke and half of the root mean square edge by component, (C,) each."""
        count = int(self.parts.max()) + 1
        mean = np.full(count, spacing)
        square = np.zeros(count)
        part = self.parts[self.triangles[:, 0]]
        length, along, height = self.frames.T
        weights = self.shares * length * height
        if count > 1:
            spokes = self.shares * (length + np.hypot(along, height)) / 2
            ends = self.parts[self.links[:, 0]]
            total = np.bincount(part, spokes, count) + np.bincount(ends, self.link_lengths, count)
            number = np.bincount(part, self.shares, count) + np.bincount(ends, minlength=count)
            np.divide(total, number, out=mean, where=number > 0)
        squares = 2 * (length**2 + along**2 + height**2 - length * along) / 3  # mean of the edges
        covered = np.bincount(part, weights, count)
        np.divide(
            np.bincount(part, weights * squares, count), covered, out=square, where=covered > 0
        )
        return mean, np.sqrt(square) / 2

    def notes(self, neighbours: IntArray, spacing: float) -> dict[str, Any]:
        """Return statistics of the components that matter to users, by name.

        Parameters
        ----------
        neighbours : ndarray of shape (N, k), int64
            Nearest first.
        spacing : float
            The mean length of all spokes.
        """
        longest = np.maximum(self.frames[:, 0], np.hypot(self.frames[:, 1], self.frames[:, 2]))
        thin = self.triangles[self.frames[:, 2] < MAX_RELATIVE_HEIGHT_OF_SLIVERS * longest, 0]
        sizes = np.bincount(self.parts)
        near = np.zeros(len(sizes), dtype=np.bool_)
        if len(sizes) > 1:
            own = self.parts[:, None]
            foreign = (self.parts[neighbours[:, :N_NEAREST]] != own).any(axis=1)
            near[self.parts[foreign]] = True
        near[sizes.argmax()] = False
        largest = sizes.argmax()
        mean, half = self._lengths(spacing)
        return {
            "parts": len(sizes),
            "torn_off": int(sizes[near].sum()),
            "sliver_stars": len(np.unique(thin)),
            "unevenness": float(max(half[largest] / mean[largest], 1.0)),
        }


def warn_of_fragments(notes: dict[str, Any], count: int) -> None:
    """Warn if components of a cloud are near each other without a connection.

    Parameters
    ----------
    notes : mapping
        Of the discretization.
    count : int
        Number N of places.
    """
    lost = notes["torn_off"]
    if count <= MAX_POINTS_WITHOUT_WARNING or lost <= MIN_SHARE_OF_LOST_POINTS * count:
        return
    warn(
        f"the cloud is disconnected: it has {notes['parts']} components, and {lost} of {count} "
        "points are not connected to the largest, although they lie among its neighbours; their "
        f"distance from it is inf. {notes['open_stars']} stars are open, {notes['sliver_stars']} "
        "have slivers. If these points are of one surface, PointCloudLaplacian(k=...) with more "
        "neighbours bridges wider gaps, gt.thin(cloud, spacing) makes the density more even, and "
        "given normals that are correct keep neighbours which estimated ones exclude",
        FragmentedCloudWarning,
    )


def warn_of_lines(notes: dict[str, Any]) -> None:
    """Warn if most points follow one line that was taken for a surface.

    Parameters
    ----------
    notes : mapping
        Of the discretization.
    """
    if notes["longest_line"] <= MAX_SHARE_OF_ONE_LINE:
        return
    warn(
        f"{notes['longest_line']:.0%} of the points follow one line, whose turns are so close to "
        "each other that they are taken for a surface: distances cross from one turn to the next. "
        "If the line itself is the shape (a coil, a wire, a track), connect its points by "
        "gt.Graph(n_vertices, edges, lengths); if it is the track of a probe over a surface, the "
        "distances are correct",
        CurveWarning,
    )
