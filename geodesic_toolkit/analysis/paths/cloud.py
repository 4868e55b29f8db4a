"""Shortest paths on point clouds: through the triangles of the local Delaunay stars."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from geodesic_toolkit.analysis.paths.fronts import first_to_arrive, refined_distance
from geodesic_toolkit.analysis.paths.polyline import Polyline, extent_of, without_repeats
from geodesic_toolkit.analysis.paths.reach import path_within_reach
from geodesic_toolkit.analysis.paths.star_paths import path_down
from geodesic_toolkit.core.types import FloatArray, IntArray
from geodesic_toolkit.domains import PointCloud
from geodesic_toolkit.errors import UnreachableError
from geodesic_toolkit.refinement.wavefronts import WavefrontSweeper
from geodesic_toolkit.solver.solver import GeodesicSolver
from geodesic_toolkit.sources.points import SourcePoints

__all__ = ["CloudPath", "path_on_cloud"]


@dataclass(frozen=True, eq=False, repr=False)
class CloudPath(Polyline):
    """A polyline through the local triangles of a point cloud, from source to target.

    Attributes
    ----------
    cloud : PointCloud
    corners : ndarray of shape (P, 3), int64
        For each point of the path, the three points of the cloud around it; some may be equal.
    weights : ndarray of shape (P, 3), float64
        Weights of the corners, non-negative with sum 1. Values at the cloud's points are
        interpolated along the path as ``(weights * values[corners]).sum(axis=1)``.

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
        """The (P, 3) positions of the points; a ``Curve`` of them can be a source."""
        positions = self.cloud.points[self.corners]
        return np.asarray(np.einsum("pc,pcd->pd", self.weights, positions))


def path_on_cloud(solver: GeodesicSolver, sources: SourcePoints, goal: SourcePoints) -> CloudPath:
    """Return the path that descends the refined distance from one point of a cloud to the sources.

    Parameters
    ----------
    solver : GeodesicSolver
        Of a cloud.
    sources, goal : SourcePoints
        A path begins at the point nearest to a source between points. The goal is a single point.

    Returns
    -------
    CloudPath

    Raises
    ------
    UnsupportedDomainError
        The metric has no triangles.
    UnreachableError
        No triangle connects the goal with a source.
    """
    cloud, metric = solver.domain, solver.method.metric
    assert isinstance(cloud, PointCloud)  # for the type checker
    start = int(goal.vertices[0])
    sweeper = WavefrontSweeper(metric)  # it raises if there are no triangles
    if sources.delayed:
        sources = first_to_arrive(sources, refined_distance(solver.method, sweeper, goal))
    if not sources.are_vertices:
        sources = replace(
            SourcePoints.at_vertices(sources.nearest_vertices, sources.n_vertices),
            starts=sources.starts,
        )
    if start in sources.vertices:
        return CloudPath(cloud, np.full((1, 3), start), np.array([[1.0, 0.0, 0.0]]))
    path = path_within_reach(solver, sources, goal)
    if path is None:
        distance = refined_distance(solver.method, sweeper, sources)
        if np.isfinite(distance[start]):
            back = refined_distance(solver.method, sweeper, goal)
            path = path_down(
                metric, cloud.points, distance, back, ends=sources.vertices, start=start
            )
    if path is None:
        raise UnreachableError(
            f"no triangle of the cloud connects point {start} with a source; one of them is "
            "masked, or they are in different components of the cloud"
        )
    corners, weights = path
    positions = CloudPath(cloud, corners, weights).points
    kept = without_repeats(positions, extent_of(positions))
    return CloudPath(cloud, corners[kept], weights[kept])
