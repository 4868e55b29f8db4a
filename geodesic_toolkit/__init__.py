"""Geodesic distance on anything that has a Laplacian.

Meshes, point clouds, graphs and what plugins add go through one heat method (Crane, Weischedel and
Wardetzky, *Geodesics in Heat*, 2013, https://doi.org/10.1145/2516971.2516977).

Everything public is here, and nothing heavy is imported until it is used.
"""

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from geodesic_toolkit.analysis.cloud_paths import CloudPath
    from geodesic_toolkit.analysis.comparison import Comparison, compare
    from geodesic_toolkit.analysis.matrix import distance_matrix
    from geodesic_toolkit.analysis.paths import GeodesicPath, geodesic_path
    from geodesic_toolkit.analysis.residual import eikonal_residual, mean_eikonal_residual
    from geodesic_toolkit.analysis.sampling import farthest_point_sampling, geodesic_voronoi
    from geodesic_toolkit.analysis.thinning import Thinned, thin
    from geodesic_toolkit.analysis.variants import Variant, variants_for
    from geodesic_toolkit.api import geodesic_distance
    from geodesic_toolkit.catalog import operators, readers, solvers
    from geodesic_toolkit.conversion import as_domain
    from geodesic_toolkit.diagnosis import Diagnosis
    from geodesic_toolkit.discretization import Discretization
    from geodesic_toolkit.domains import (
        Curve,
        Domain,
        Graph,
        OffsetSources,
        PointCloud,
        SurfacePoint,
        TriangleMesh,
    )
    from geodesic_toolkit.exact import exact_distance
    from geodesic_toolkit.gradient import EdgeGradient, ElementGradient, Gradient
    from geodesic_toolkit.heat import HeatMethod, HeatReport
    from geodesic_toolkit.io import read, read_mask, read_points, read_vertices, write
    from geodesic_toolkit.laplacians.base import LaplaceOperator
    from geodesic_toolkit.laplacians.cotan import CotanLaplacian
    from geodesic_toolkit.laplacians.pointcloud import PointCloudLaplacian
    from geodesic_toolkit.laplacians.uniform import UniformLaplacian
    from geodesic_toolkit.linear.base import Factor, LinearSolver
    from geodesic_toolkit.linear.cg import CG
    from geodesic_toolkit.linear.superlu import SuperLU
    from geodesic_toolkit.linear.supernodal import Supernodal
    from geodesic_toolkit.merging import merge_vertices
    from geodesic_toolkit.queries import interpolate
    from geodesic_toolkit.registry import PluginStatus, Registry
    from geodesic_toolkit.solver import GeodesicSolver
    from geodesic_toolkit.source_points import SourcePoints

# Spelt out once more, because type checkers read nothing else; a test keeps the two together.
__all__ = [
    "CG",
    "CloudPath",
    "Comparison",
    "CotanLaplacian",
    "Curve",
    "Diagnosis",
    "Discretization",
    "Domain",
    "EdgeGradient",
    "ElementGradient",
    "Factor",
    "GeodesicPath",
    "GeodesicSolver",
    "Gradient",
    "Graph",
    "HeatMethod",
    "HeatReport",
    "LaplaceOperator",
    "LinearSolver",
    "OffsetSources",
    "PluginStatus",
    "PointCloud",
    "PointCloudLaplacian",
    "Registry",
    "SourcePoints",
    "SuperLU",
    "Supernodal",
    "SurfacePoint",
    "Thinned",
    "TriangleMesh",
    "UniformLaplacian",
    "Variant",
    "__version__",
    "as_domain",
    "compare",
    "distance_matrix",
    "eikonal_residual",
    "errors",
    "exact_distance",
    "farthest_point_sampling",
    "geodesic_distance",
    "geodesic_path",
    "geodesic_voronoi",
    "interpolate",
    "mean_eikonal_residual",
    "merge_vertices",
    "operators",
    "read",
    "read_mask",
    "read_points",
    "read_vertices",
    "readers",
    "solvers",
    "testing",
    "thin",
    "variants_for",
    "viz",
    "write",
]

_HOMES = {
    "CG": "linear.cg",
    "CloudPath": "analysis.cloud_paths",
    "Comparison": "analysis.comparison",
    "CotanLaplacian": "laplacians.cotan",
    "Curve": "domains",
    "Diagnosis": "diagnosis",
    "Discretization": "discretization",
    "Domain": "domains",
    "EdgeGradient": "gradient",
    "ElementGradient": "gradient",
    "Factor": "linear.base",
    "GeodesicPath": "analysis.paths",
    "GeodesicSolver": "solver",
    "Gradient": "gradient",
    "Graph": "domains",
    "HeatMethod": "heat",
    "HeatReport": "heat",
    "LaplaceOperator": "laplacians.base",
    "LinearSolver": "linear.base",
    "OffsetSources": "domains",
    "PluginStatus": "registry",
    "PointCloud": "domains",
    "PointCloudLaplacian": "laplacians.pointcloud",
    "Registry": "registry",
    "SourcePoints": "source_points",
    "SuperLU": "linear.superlu",
    "Supernodal": "linear.supernodal",
    "SurfacePoint": "domains",
    "Thinned": "analysis.thinning",
    "TriangleMesh": "domains",
    "UniformLaplacian": "laplacians.uniform",
    "Variant": "analysis.variants",
    "as_domain": "conversion",
    "compare": "analysis.comparison",
    "distance_matrix": "analysis.matrix",
    "eikonal_residual": "analysis.residual",
    "exact_distance": "exact",
    "farthest_point_sampling": "analysis.sampling",
    "geodesic_distance": "api",
    "geodesic_path": "analysis.paths",
    "geodesic_voronoi": "analysis.sampling",
    "interpolate": "queries",
    "mean_eikonal_residual": "analysis.residual",
    "merge_vertices": "merging",
    "operators": "catalog",
    "read": "io",
    "read_mask": "io",
    "read_points": "io",
    "read_vertices": "io",
    "readers": "catalog",
    "solvers": "catalog",
    "thin": "analysis.thinning",
    "variants_for": "analysis.variants",
    "write": "io",
}
_SUBPACKAGES = ("errors", "testing", "viz")


def __getattr__(name: str) -> Any:
    if name in _SUBPACKAGES:
        return importlib.import_module(f"{__name__}.{name}")
    if name in _HOMES:
        value = getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
