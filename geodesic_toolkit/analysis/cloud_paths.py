"""Shortest paths on point clouds: through the triangles of the local Delaunay stars."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geodesic_toolkit._typing import FloatArray, IntArray
from geodesic_toolkit.analysis.ways import best_way
from geodesic_toolkit.discretization import Discretization
from geodesic_toolkit.domains import PointCloud
from geodesic_toolkit.errors import UnreachableError
from geodesic_toolkit.geometry.components import connected_by_edges
from geodesic_toolkit.geometry.fans import Fans
from geodesic_toolkit.gradient import ElementGradient
from geodesic_toolkit.source_points import SourcePoints

__all__ = ["CloudPath", "path_on_cloud"]

SAME = 1e-12
"""Share of the size of the cloud within which two points are one."""

BRIDGED = 0.99
"""Share of the refined distance below which a path has taken a bridge: a triangle of one star
alone, over a gap or across a bend, which the other stars have seen better. Such are left out then.
(They are not always: in noise stars differ all over, and a path around would be longer.)"""


@dataclass(frozen=True, eq=False)
class CloudPath:
    """A polyline through the local triangles of a point cloud, from source to target.

    Attributes
    ----------
    cloud : PointCloud
    corners : ndarray of shape (P, 3), int64
        For each of its points three points of the cloud that it lies between; some may be the same.
    weights : ndarray of shape (P, 3), float64
        The weights of these, non-negative with sum 1: what the cloud's points carry is interpolated
        along the path as ``(weights * values[corners]).sum(axis=1)``.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> cloud = gt.PointCloud(gt.testing.shapes.grid(9).vertices)
    >>> solver = gt.GeodesicSolver(cloud, operator=gt.PointCloudLaplacian(normals="pca"))
    >>> path = gt.geodesic_path(solver, 0, 80)
    >>> round(path.length, 6)
    1.414214
    >>> solver.distance(gt.Curve(path.points)).shape  # from a curve
    (81,)
    """

    cloud: PointCloud
    corners: IntArray
    weights: FloatArray

    @cached_property
    def points(self) -> FloatArray:
        """The (P, 3) positions of the points; ``Curve`` of them is a source."""
        positions: FloatArray = np.einsum("pc,pcd->pd", self.weights, self._places)
        return positions

    @property
    def _places(self) -> FloatArray:
        return self.cloud.points[self.corners]

    @property
    def length(self) -> float:
        """Length of the polyline, in the unit of the cloud."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())

    def __repr__(self) -> str:
        return f"CloudPath({len(self.corners)} points, length {self.length:.6g})"


def path_on_cloud(  # noqa: PLR0917 - what it needs, in the order of its doing
    cloud: PointCloud,
    metric: Discretization,
    distance: FloatArray,
    back: FloatArray,
    sources: SourcePoints,
    goal: SourcePoints,
) -> CloudPath:
    """Return the path that descends the refined distance from one point of a cloud to sources.

    Parameters
    ----------
    cloud : PointCloud
    metric : Discretization
        Whose elements are triangles (i, j, k) and links (i, j, j).
    distance : ndarray of shape (N,)
        The refined distance from the sources.
    back : ndarray of shape (N,)
        That from the goal.
    sources, goal : SourcePoints
        At vertices; one is the goal.

    Returns
    -------
    CloudPath

    Raises
    ------
    UnreachableError
        No triangle connects the goal with a source.
    """
    start = int(goal.vertices[0])
    ends = set(sources.vertices.tolist())
    if start in ends:
        return CloudPath(cloud, np.full((1, 3), start), np.array([[1.0, 0.0, 0.0]]))
    if not np.isfinite(distance[start]):
        raise UnreachableError(
            f"no triangle of the cloud connects point {start} with a source; one of them is "
            "masked, or they lie in different parts of the cloud"
        )
    path = _through(_elements(metric), cloud, distance, back, start, ends)
    if path.length < BRIDGED * distance[start]:
        agreed = _elements(metric, agreed=True)
        if _connects(agreed, distance, start, ends):
            path = _through(agreed, cloud, distance, back, start, ends)
    return path


def _through(  # noqa: PLR0917 - what it needs, in the order of its doing
    elements: tuple[IntArray, IntArray],
    cloud: PointCloud,
    distance: FloatArray,
    back: FloatArray,
    start: int,
    ends: set[int],
) -> CloudPath:
    """Return the path through triangles (T, 3) and links (L, 2)."""
    conducting = np.isfinite(distance) & np.isfinite(back)
    triangles, links = (some[conducting[some].all(axis=1)] for some in elements)
    # A link becomes a triangle without area, whose third corner is its middle.
    count = len(distance)
    middles = count + np.arange(len(links))
    places = np.where(conducting[:, None], cloud.points, 0.0)
    fans = Fans(
        np.concatenate([places, places[links].mean(axis=1)]),
        np.concatenate([triangles, np.column_stack([links, middles])]),
    )
    height, behind = (np.concatenate([d, d[links].mean(axis=1)]) for d in (distance, back))
    height[list(ends)] = 0.0
    corners, weights = [], []
    for _, shares in best_way(fans, height, behind, start, ends)[::-1]:
        spread = _on_the_cloud(shares, links, count)
        corners.append([*spread, *[next(iter(spread))] * (3 - len(spread))])
        weights.append([*spread.values(), *[0.0] * (3 - len(spread))])
    return _without_repeats(CloudPath(cloud, np.array(corners), np.array(weights)))


def _elements(metric: Discretization, *, agreed: bool = False) -> tuple[IntArray, IntArray]:
    """Return the triangles (T, 3) and the links (L, 2) of a soup, each once.

    On request without triangles that are in one star alone.
    """
    assert isinstance(metric.gradient, ElementGradient)  # for the type checker; it was refined on
    elements, stars = np.unique(
        np.sort(metric.gradient.elements, axis=1), axis=0, return_counts=True
    )
    linked = (elements[:, :2] == elements[:, 1:]).any(axis=1)
    return elements[~linked & (stars > agreed)], elements[linked][:, [0, 2]]


def _connects(
    elements: tuple[IntArray, IntArray], distance: FloatArray, start: int, ends: set[int]
) -> bool:
    """Return whether a way leads from the start to an end."""
    triangles, links = (some[np.isfinite(distance)[some].all(axis=1)] for some in elements)
    pairs = np.concatenate([triangles[:, :2], triangles[:, 1:], links])
    part = connected_by_edges(pairs, len(distance))
    return bool(part[start] in part[list(ends)])


def _on_the_cloud(shares: dict[int, float], links: IntArray, count: int) -> dict[int, float]:
    """Return the weights of a point on points of the cloud alone: half a link's middle each."""
    spread: dict[int, float] = {}
    for vertex, share in shares.items():
        ends = [vertex] if vertex < count else links[vertex - count].tolist()
        for end in ends:
            spread[end] = spread.get(end, 0.0) + share / len(ends)
    return spread


def _without_repeats(path: CloudPath) -> CloudPath:
    """Leave out points that are where the one before them is; the ends stay as they are."""
    places = path.points
    near = SAME * float(np.ptp(places, axis=0).max())
    kept = [0]
    for index in range(1, len(places)):
        if np.linalg.norm(places[index] - places[kept[-1]]) > near:
            kept.append(index)
    kept[-1] = len(places) - 1 if len(kept) > 1 else 0
    return CloudPath(path.cloud, path.corners[kept], path.weights[kept])
