"""What distances are measured on: triangle meshes, point clouds, graphs.

Domains coerce, validate and freeze; they hold no algorithms.
"""

from geodesic_toolkit.domains.base import Domain
from geodesic_toolkit.domains.cloud import PointCloud
from geodesic_toolkit.domains.graph import Graph
from geodesic_toolkit.domains.mesh import TriangleMesh
from geodesic_toolkit.domains.positions import known_positions

__all__ = [
    "Domain",
    "Graph",
    "PointCloud",
    "TriangleMesh",
    "known_positions",
]
