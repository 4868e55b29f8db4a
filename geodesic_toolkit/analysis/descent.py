"""Steepest descent over the triangles of a mesh."""

import numpy as np

from geodesic_toolkit._typing import FloatArray
from geodesic_toolkit.geometry.fans import Fans

__all__ = ["descend"]

AT_A_VERTEX = 1e-9
"""Share of an edge within which a point of it counts as its end."""


def descend(fans: Fans, height: FloatArray, start: int) -> tuple[list[int], list[list[int]]]:
    """Follow the steepest descent of a piecewise linear function from a vertex to a minimum.

    Parameters
    ----------
    fans : Fans
    height : ndarray of shape (N,), float64
        One number a vertex.
    start : int
        A vertex.

    Returns
    -------
    stops : list of int
        The vertices on the way: the start, and at the end one that has no lower neighbour.
    strips : list of lists of int
        The faces passed between each stop and the next, each sharing an edge with the one after.
    """
    walk = _Walk(fans, height)
    stops = [start]
    vertex = walk.from_vertex(start)
    while vertex is not None:
        stops.append(vertex)
        vertex = walk.from_vertex(vertex)
    return stops, walk.strips


class _Walk:
    """A way down; every step ends lower than it began, so that it ends."""

    def __init__(self, fans: Fans, height: FloatArray) -> None:
        self.fans = fans
        self.height = height
        self.strips: list[list[int]] = []

    def from_vertex(self, vertex: int) -> int | None:
        """Go down until the next vertex, and return it; None where nothing is lower."""
        fans, height = self.fans, self.height
        steepest, choice = 0.0, None
        for face in fans.around(vertex):
            p, q = fans.others(face, vertex)
            for corner in (p, q):
                length = float(np.linalg.norm(fans.vertices[corner] - fans.vertices[vertex]))
                drop = height[vertex] - height[corner]
                slope = np.inf if length == 0 < drop else drop / (length or 1.0)
                if slope > steepest:
                    steepest, choice = slope, (face, corner, None)
            down = self._down((vertex, p, q))
            if down is not None and down[1] > 0 < down[2]:
                slope = float(np.sqrt(down @ (height[vertex] - height[[vertex, p, q]])))
                if slope >= steepest:
                    steepest, choice = slope, (face, p, down[2] / (down[1] + down[2]))
        if choice is None:
            return None
        face, corner, share = choice
        self.strips.append([face])
        if share is None:
            return corner
        return self._across(face, corner, fans.third(face, vertex, corner), share)

    def _across(self, face: int, a: int, b: int, share: float) -> int:
        """Go on from a point of an edge of a face, until a vertex, and return it."""
        fans, height = self.fans, self.height
        while True:
            if share < AT_A_VERTEX:
                return a
            if share > 1 - AT_A_VERTEX:
                return b
            best = None
            for beside in fans.at_edge(a, b):
                if beside == face:
                    continue
                c = fans.third(beside, a, b)
                down = self._down((a, b, c))
                if down is not None and down[2] > 0:
                    slope = float(down @ (height[a] - height[[a, b, c]]))
                    if best is None or slope > best[0]:
                        best = (slope, beside, c, down)
            if best is None:
                return a if height[a] < height[b] else b
            _, face, c, down = best
            self.strips[-1].append(face)
            # Barycentric weights (1 - share, share, 0) change along `down`; one of the first two
            # reaches 0 first, and the way leaves through the edge opposite.
            times = [
                weight / -speed if speed < 0 else np.inf
                for weight, speed in ((1 - share, down[0]), (share, down[1]))
            ]
            time = min(times)
            reached = min(max(time * down[2], 0.0), 1.0)
            a, b = (b, c) if times[0] <= times[1] else (a, c)
            share = reached

    def _down(self, corners: tuple[int, int, int]) -> FloatArray | None:
        """Return how weights on corners change along minus the gradient; None without area."""
        a, b, c = corners
        vertices, height = self.fans.vertices, self.height
        if not np.isfinite(height[list(corners)]).all():
            return None
        u, v = vertices[b] - vertices[a], vertices[c] - vertices[a]
        uu, uv, vv = u @ u, u @ v, v @ v
        determinant = uu * vv - uv * uv
        if determinant <= 1e-24 * uu * vv:
            return None
        rise_u, rise_v = height[b] - height[a], height[c] - height[a]
        along_u = -(vv * rise_u - uv * rise_v) / determinant
        along_v = -(uu * rise_v - uv * rise_u) / determinant
        return np.array([-along_u - along_v, along_u, along_v])
