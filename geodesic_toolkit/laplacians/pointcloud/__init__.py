"""The Laplacian of a point cloud: neighbours, normals, and the stars of tangent planes.

Imports discretizations, geometry and domains.
"""

from geodesic_toolkit.laplacians.pointcloud.operator import PointCloudLaplacian

__all__ = ["PointCloudLaplacian"]
