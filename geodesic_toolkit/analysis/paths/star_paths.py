"""Paths through the triangles and links of a cloud's stars."""

import numpy as np

from geodesic_toolkit import _native
from geodesic_toolkit.analysis.paths.candidates import Candidate, best_path
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.discretization.element_gradient import ElementGradient
from geodesic_toolkit.geometry.components import connected_by_edges

__all__ = ["length_of", "path_down", "stars_connect"]

MIN_LENGTH_RATIO = 0.99
"""Share of the refined distance below which a path has taken a bridge: a triangle of one star
alone, over a gap or across a bend, with which the other stars disagree. Such triangles are then
omitted. (Not always: in noise all stars differ, and a path around them would be longer.)"""


def path_down(
    metric: Discretization,
    points: FloatArray,
    distance: FloatArray,
    back: FloatArray,
    *,
    ends: IntArray,
    start: int,
) -> tuple[IntArray, FloatArray] | None:
    """Return the path that descends a distance: corners and weights, both (P, 3), from an end.

    Parameters
    ----------
    metric : Discretization
        Its elements are triangles (i, j, k) and links (i, j, j).
    points : ndarray of shape (N, 3), float64
    distance, back : ndarray of shape (N,), float64
        The refined distances from the ends and from the start.
    ends : ndarray of shape (K,), int64
    start : int
        Not one of the ends.

    Returns
    -------
    (corners, weights) or None
        None if no triangle leads from the start to an end.
    """
    assert isinstance(metric.gradient, ElementGradient)  # for the type checker
    elements = metric.gradient.elements
    reached = np.isfinite(distance) & np.isfinite(back)
    triangles, stars, links = _apart(elements[reached[elements].all(axis=1)])
    positions = np.where(reached[:, None], points, 0.0)
    path = _through(triangles, links, positions, distance, back, ends=ends, start=start)
    if path is not None and length_of(positions, *path) < MIN_LENGTH_RATIO * distance[start]:
        agreed = triangles[stars > 1]
        around = _through(agreed, links, positions, distance, back, ends=ends, start=start)
        return path if around is None else around
    return path


def stars_connect(metric: Discretization, ends: IntArray, start: int) -> bool:
    """Return whether triangles in more than one star, and links, lead from a start to an end."""
    assert isinstance(metric.gradient, ElementGradient)  # for the type checker
    triangles, stars, links = _apart(metric.gradient.elements)
    agreed = triangles[stars > 1]
    pairs = np.concatenate([agreed[:, :2], agreed[:, 1:], links])
    part = connected_by_edges(pairs, metric.n_vertices)
    return bool(part[start] in part[ends])


def _apart(elements: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return triangles (T, 3), the number of stars of each (T,), and links (L, 2), each once."""
    triangles, stars = _native.distinct_triangles(np.ascontiguousarray(elements))
    linked = (elements[:, :2] == elements[:, 1:]).any(axis=1)
    links = np.unique(np.sort(elements[linked], axis=1)[:, [0, 2]], axis=0)
    return triangles, stars, links


def _through(
    triangles: IntArray,
    links: IntArray,
    points: FloatArray,
    distance: FloatArray,
    back: FloatArray,
    *,
    ends: IntArray,
    start: int,
) -> tuple[IntArray, FloatArray] | None:
    """Return the path through triangles (T, 3) and links (L, 2)."""
    # A link becomes a triangle without area, whose third corner is its midpoint.
    middles = len(points) + np.arange(len(links))
    positions = np.concatenate([points, points[links].mean(axis=1)])
    faces = np.concatenate([triangles, np.column_stack([links, middles])])
    height, behind = (np.concatenate([d, d[links].mean(axis=1)]) for d in (distance, back))
    height[ends] = 0.0
    surface = _native.Surface(positions, faces)
    path = best_path(surface, height, behind, start=start, ends=ends)
    return None if path is None else _between_points(path, links, len(points))


def _between_points(path: Candidate, links: IntArray, count: int) -> tuple[IntArray, FloatArray]:
    """Return a path from its end to its start, each point between three points of the cloud."""
    corners, weights = [], []
    for pair, shares in zip(path.ends[::-1].tolist(), path.weights[::-1].tolist(), strict=True):
        spread: dict[int, float] = {}
        for vertex, share in zip(pair, shares, strict=True):
            own = [vertex] if vertex < count else links[vertex - count].tolist()
            for end in own:
                spread[end] = spread.get(end, 0.0) + share / len(own)
        missing = 3 - len(spread)
        corners.append([*spread, *[next(iter(spread))] * missing])
        weights.append([*spread.values(), *[0.0] * missing])
    return np.array(corners), np.array(weights)


def length_of(points: FloatArray, corners: IntArray, weights: FloatArray) -> float:
    """Return the length of a path as `path_down` returns it."""
    positions = np.einsum("pc,pcd->pd", weights, points[corners])
    return float(np.linalg.norm(np.diff(positions, axis=0), axis=1).sum())
