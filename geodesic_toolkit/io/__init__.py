"""Input and output of files: one reader per format, and outputs that are complete or absent."""

from geodesic_toolkit.core.atomic import check_output, replacing
from geodesic_toolkit.core.deprecation import deprecated_alias
from geodesic_toolkit.io.curve_files import read_curves
from geodesic_toolkit.io.curves import write_curves
from geodesic_toolkit.io.log_maps import write_log_map
from geodesic_toolkit.io.polygons import read_polygons
from geodesic_toolkit.io.reading import read
from geodesic_toolkit.io.tables.points import read_points
from geodesic_toolkit.io.tables.values import read_values
from geodesic_toolkit.io.tables.vertices import read_mask, read_vertices
from geodesic_toolkit.io.writing import write

write_distances = deprecated_alias(
    write, "geodesic_toolkit.io.write_distances", "geodesic_toolkit.write", since="0.1"
)

__all__ = [
    "check_output",
    "read",
    "read_curves",
    "read_mask",
    "read_points",
    "read_polygons",
    "read_values",
    "read_vertices",
    "replacing",
    "write",
    "write_curves",
    "write_distances",
    "write_log_map",
]
