"""Geodesic distance on anything that has a Laplacian.

Meshes, point clouds, graphs and domains of plugins use one heat method (Crane, Weischedel and
Wardetzky, *Geodesics in Heat*, 2013, https://doi.org/10.1145/2516971.2516977).

All public names are here, and heavy packages are imported only when used.
"""

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from geodesic_toolkit import errors, testing, viz
    from geodesic_toolkit.analysis.comparison import Comparison, compare
    from geodesic_toolkit.analysis.curves.discs import GeodesicDisc, geodesic_disc
    from geodesic_toolkit.analysis.curves.isolines import isolines
    from geodesic_toolkit.analysis.curves.measures import area_above, curve_length
    from geodesic_toolkit.analysis.directions.extension import extend
    from geodesic_toolkit.analysis.directions.log_map import LogMap, log_map
    from geodesic_toolkit.analysis.directions.means import GeodesicMean, geodesic_mean
    from geodesic_toolkit.analysis.directions.transport import parallel_transport
    from geodesic_toolkit.analysis.directions.voronoi import CentroidalVoronoi, centroidal_voronoi
    from geodesic_toolkit.analysis.exponential import ExpMap, exp_map
    from geodesic_toolkit.analysis.matrix.matrix import distance_matrix
    from geodesic_toolkit.analysis.paths.cloud import CloudPath
    from geodesic_toolkit.analysis.paths.edges import EdgePath
    from geodesic_toolkit.analysis.paths.loops import geodesic_loop
    from geodesic_toolkit.analysis.paths.mesh import geodesic_path
    from geodesic_toolkit.analysis.paths.path import GeodesicPath
    from geodesic_toolkit.analysis.paths.shortest_loops import shortest_loop
    from geodesic_toolkit.analysis.residual import eikonal_residual, mean_eikonal_residual
    from geodesic_toolkit.analysis.sampling import farthest_point_sampling, geodesic_voronoi
    from geodesic_toolkit.analysis.signed import signed_distance
    from geodesic_toolkit.analysis.tangent_frames import TangentFrames, tangent_frames
    from geodesic_toolkit.analysis.thinning import Thinned, thin
    from geodesic_toolkit.analysis.variants import Variant, variants_for
    from geodesic_toolkit.analysis.volume import VolumeDistance, signed_distance_volume
    from geodesic_toolkit.discretization.data import Discretization
    from geodesic_toolkit.discretization.edge_gradient import EdgeGradient
    from geodesic_toolkit.discretization.element_gradient import ElementGradient
    from geodesic_toolkit.discretization.fronts import Fronts
    from geodesic_toolkit.discretization.gradient import Gradient
    from geodesic_toolkit.discretization.positivity import positive_part
    from geodesic_toolkit.discretization.subdivision import Subdivision
    from geodesic_toolkit.domains import (
        Domain,
        Graph,
        IntrinsicMesh,
        Located,
        MetricMesh,
        PointCloud,
        TriangleMesh,
    )
    from geodesic_toolkit.exact import exact_distance
    from geodesic_toolkit.heat.method import HeatMethod, HeatReport
    from geodesic_toolkit.interop.attaching import attach
    from geodesic_toolkit.interop.conversion import as_domain
    from geodesic_toolkit.interop.merging import merge_vertices
    from geodesic_toolkit.io import (
        read,
        read_curves,
        read_mask,
        read_points,
        read_polygons,
        read_vertices,
        write,
        write_curves,
        write_log_map,
    )
    from geodesic_toolkit.laplacians.base import LaplaceOperator
    from geodesic_toolkit.laplacians.charts import discretization_of_charts
    from geodesic_toolkit.laplacians.cotan import CotanLaplacian
    from geodesic_toolkit.laplacians.pointcloud.operator import PointCloudLaplacian
    from geodesic_toolkit.laplacians.uniform import UniformLaplacian
    from geodesic_toolkit.linear.base import Analysis, Factor, LinearSolver
    from geodesic_toolkit.linear.cg import CG
    from geodesic_toolkit.linear.superlu import SuperLU
    from geodesic_toolkit.linear.supernodal import Supernodal
    from geodesic_toolkit.registry.catalog import operators, readers, solvers, writers
    from geodesic_toolkit.registry.registry import PluginStatus, Registry
    from geodesic_toolkit.registry.writer import Writer
    from geodesic_toolkit.solver.convenience import geodesic_distance
    from geodesic_toolkit.solver.diagnosis import Diagnosis
    from geodesic_toolkit.solver.queries import interpolate
    from geodesic_toolkit.solver.solver import GeodesicSolver
    from geodesic_toolkit.sources.kinds import Curve, OffsetSources
    from geodesic_toolkit.sources.points import SourcePoints
    from geodesic_toolkit.sources.surface_point import SurfacePoint

# Repeated because type checkers read nothing else; a test keeps the two together.
__all__ = [
    "CG",
    "Analysis",
    "CentroidalVoronoi",
    "CloudPath",
    "Comparison",
    "CotanLaplacian",
    "Curve",
    "Diagnosis",
    "Discretization",
    "Domain",
    "EdgeGradient",
    "EdgePath",
    "ElementGradient",
    "ExpMap",
    "Factor",
    "Fronts",
    "GeodesicDisc",
    "GeodesicMean",
    "GeodesicPath",
    "GeodesicSolver",
    "Gradient",
    "Graph",
    "HeatMethod",
    "HeatReport",
    "IntrinsicMesh",
    "LaplaceOperator",
    "LinearSolver",
    "Located",
    "LogMap",
    "MetricMesh",
    "OffsetSources",
    "PluginStatus",
    "PointCloud",
    "PointCloudLaplacian",
    "Registry",
    "SourcePoints",
    "Subdivision",
    "SuperLU",
    "Supernodal",
    "SurfacePoint",
    "TangentFrames",
    "Thinned",
    "TriangleMesh",
    "UniformLaplacian",
    "Variant",
    "VolumeDistance",
    "Writer",
    "__version__",
    "area_above",
    "as_domain",
    "attach",
    "centroidal_voronoi",
    "compare",
    "curve_length",
    "discretization_of_charts",
    "distance_matrix",
    "eikonal_residual",
    "errors",
    "exact_distance",
    "exp_map",
    "extend",
    "farthest_point_sampling",
    "geodesic_disc",
    "geodesic_distance",
    "geodesic_loop",
    "geodesic_mean",
    "geodesic_path",
    "geodesic_voronoi",
    "interpolate",
    "isolines",
    "log_map",
    "mean_eikonal_residual",
    "merge_vertices",
    "operators",
    "parallel_transport",
    "positive_part",
    "read",
    "read_curves",
    "read_mask",
    "read_points",
    "read_polygons",
    "read_vertices",
    "readers",
    "shortest_loop",
    "signed_distance",
    "signed_distance_volume",
    "solvers",
    "tangent_frames",
    "testing",
    "thin",
    "variants_for",
    "viz",
    "write",
    "write_curves",
    "write_log_map",
    "writers",
]

_HOMES = {
    "CG": "linear.cg",
    "Analysis": "linear.base",
    "CentroidalVoronoi": "analysis.directions.voronoi",
    "CloudPath": "analysis.paths.cloud",
    "Comparison": "analysis.comparison",
    "CotanLaplacian": "laplacians.cotan",
    "Curve": "sources.kinds",
    "Diagnosis": "solver.diagnosis",
    "Discretization": "discretization.data",
    "Domain": "domains",
    "EdgeGradient": "discretization.edge_gradient",
    "EdgePath": "analysis.paths.edges",
    "ElementGradient": "discretization.element_gradient",
    "ExpMap": "analysis.exponential",
    "Factor": "linear.base",
    "Fronts": "discretization.fronts",
    "GeodesicDisc": "analysis.curves.discs",
    "GeodesicMean": "analysis.directions.means",
    "GeodesicPath": "analysis.paths.path",
    "GeodesicSolver": "solver.solver",
    "Gradient": "discretization.gradient",
    "Graph": "domains",
    "HeatMethod": "heat.method",
    "HeatReport": "heat.method",
    "IntrinsicMesh": "domains",
    "LaplaceOperator": "laplacians.base",
    "LinearSolver": "linear.base",
    "Located": "domains",
    "LogMap": "analysis.directions.log_map",
    "MetricMesh": "domains",
    "OffsetSources": "sources.kinds",
    "PluginStatus": "registry.registry",
    "PointCloud": "domains",
    "PointCloudLaplacian": "laplacians.pointcloud.operator",
    "Registry": "registry.registry",
    "SourcePoints": "sources.points",
    "Subdivision": "discretization.subdivision",
    "SuperLU": "linear.superlu",
    "Supernodal": "linear.supernodal",
    "SurfacePoint": "sources.surface_point",
    "TangentFrames": "analysis.tangent_frames",
    "Thinned": "analysis.thinning",
    "TriangleMesh": "domains",
    "UniformLaplacian": "laplacians.uniform",
    "Variant": "analysis.variants",
    "VolumeDistance": "analysis.volume",
    "Writer": "registry.writer",
    "area_above": "analysis.curves.measures",
    "as_domain": "interop.conversion",
    "attach": "interop.attaching",
    "centroidal_voronoi": "analysis.directions.voronoi",
    "compare": "analysis.comparison",
    "curve_length": "analysis.curves.measures",
    "discretization_of_charts": "laplacians.charts",
    "distance_matrix": "analysis.matrix.matrix",
    "eikonal_residual": "analysis.residual",
    "exact_distance": "exact",
    "exp_map": "analysis.exponential",
    "extend": "analysis.directions.extension",
    "farthest_point_sampling": "analysis.sampling",
    "geodesic_disc": "analysis.curves.discs",
    "geodesic_distance": "solver.convenience",
    "geodesic_loop": "analysis.paths.loops",
    "geodesic_mean": "analysis.directions.means",
    "geodesic_path": "analysis.paths.mesh",
    "geodesic_voronoi": "analysis.sampling",
    "interpolate": "solver.queries",
    "isolines": "analysis.curves.isolines",
    "log_map": "analysis.directions.log_map",
    "mean_eikonal_residual": "analysis.residual",
    "merge_vertices": "interop.merging",
    "operators": "registry.catalog",
    "parallel_transport": "analysis.directions.transport",
    "positive_part": "discretization.positivity",
    "read": "io",
    "read_curves": "io",
    "read_mask": "io",
    "read_points": "io",
    "read_polygons": "io",
    "read_vertices": "io",
    "readers": "registry.catalog",
    "shortest_loop": "analysis.paths.shortest_loops",
    "signed_distance": "analysis.signed",
    "signed_distance_volume": "analysis.volume",
    "solvers": "registry.catalog",
    "tangent_frames": "analysis.tangent_frames",
    "thin": "analysis.thinning",
    "variants_for": "analysis.variants",
    "write": "io",
    "write_curves": "io",
    "write_log_map": "io",
    "writers": "registry.catalog",
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
