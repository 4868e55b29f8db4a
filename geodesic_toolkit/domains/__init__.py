"""Shapes that distances are measured on: meshes, point clouds, graphs, and their base class.

Domains coerce, validate and freeze arrays; they do not hold algorithms.
"""

from geodesic_toolkit.domains.base import Domain
from geodesic_toolkit.domains.checked import (
    graph_of,
    normals_of,
    polygons_of,
    positions_of,
    triangles_of,
)
from geodesic_toolkit.domains.cloud import PointCloud
from geodesic_toolkit.domains.graph import Graph
from geodesic_toolkit.domains.located import Located, check_present
from geodesic_toolkit.domains.measured import IntrinsicMesh, MeasuredFaces, MetricMesh
from geodesic_toolkit.domains.mesh import TriangleMesh

__all__ = [
    "Domain",
    "Graph",
    "IntrinsicMesh",
    "Located",
    "MeasuredFaces",
    "MetricMesh",
    "PointCloud",
    "TriangleMesh",
    "check_present",
    "graph_of",
    "normals_of",
    "polygons_of",
    "positions_of",
    "triangles_of",
]
