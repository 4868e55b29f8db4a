"""Polygon meshes for geodesic-toolkit: quadrangles, any polygons, flat or not, convex or not."""

from geodesic_toolkit_polygon.mesh import PolygonMesh
from geodesic_toolkit_polygon.operator import PolygonGradient, PolygonLaplacian

__all__ = ["PolygonGradient", "PolygonLaplacian", "PolygonMesh"]
