"""STL, binary and text."""

import re
from pathlib import Path

import numpy as np

from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.domains import TriangleMesh
from geodesic_toolkit.errors import ReadError
from geodesic_toolkit.geometry.seams import COINCIDENCE_TOLERANCE
from geodesic_toolkit.geometry.welding import (
    boundary_edges,
    edges_and_counts,
    merged_positions,
    movable_by,
    rounding_of,
    same_positions,
)
from geodesic_toolkit.io.common import floats

__all__ = ["read_stl"]

FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
HEADER = 84
VERTEX = re.compile(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)", re.IGNORECASE)


def read_stl(path: Path) -> TriangleMesh:
    """Read an STL file and weld its corners.

    The format stores three corners per face and no vertices. Corners with the same coordinates
    become one vertex, numbered in the order of first appearance, and so do corners at open edges
    that differ by rounding. All faces are kept, even those that become degenerate.
    """
    data = path.read_bytes()
    # Binary files may begin with "solid" too, so their length is checked first.
    announced = int.from_bytes(data[80:HEADER], "little") if len(data) >= HEADER else 0
    size = HEADER + announced * FACET.itemsize
    text = data.lstrip()[:5].lower() == b"solid" and b"\0" not in data
    if len(data) >= HEADER and (size == len(data) or (size < len(data) and not text)):
        facets = np.frombuffer(data, FACET, announced, HEADER)
        return _weld(facets["corners"].reshape(-1, 3).astype(np.float64))
    if text:
        return _weld(_text_corners(data))
    if len(data) < HEADER:
        raise ReadError("not an STL file: too short for a binary one, and not a text one")
    raise ReadError(
        f"not an STL file, or a truncated one: {announced} faces need {size} bytes, but there are "
        f"{len(data)}"
    )


def _text_corners(data: bytes) -> FloatArray:
    tokens = [token for vertex in VERTEX.findall(data) for token in vertex]
    facets = len(re.findall(rb"\bendfacet\b", data, re.IGNORECASE))
    if len(tokens) != 9 * facets or not data.rstrip().splitlines()[-1].strip().lower().startswith(
        b"endsolid"
    ):
        raise ReadError(
            f"a text STL, truncated or damaged: {facets} facets with {len(tokens) // 3} corners"
        )
    return floats(tokens, "vertex coordinates").reshape(-1, 3)


def _weld(corners: FloatArray) -> TriangleMesh:
    """Return the mesh whose vertices are the positions of the corners.

    First, equal corners are merged. Open edges may then have been rounded differently for each
    facet: their ends are merged within :data:`COINCIDENCE_TOLERANCE`. Closed bodies do not change,
    however near to each other.
    """
    corners = corners + 0.0  # turns -0.0 into the equal 0.0
    first, vertex_of_corner = same_positions(corners)
    points, faces = corners[first], vertex_of_corner.reshape(-1, 3)
    rim = np.unique(boundary_edges(faces))
    if len(rim):
        limit = movable_by(points, edges_and_counts(faces)[0], rounding_of(points))[rim]
        extent = float(np.linalg.norm(np.ptp(points, axis=0)))
        near = max(COINCIDENCE_TOLERANCE * extent, rounding_of(points))
        owner = np.arange(len(points))
        owner[rim] = rim[merged_positions(points[rim], np.minimum(limit, near))]
        kept, new = np.unique(owner, return_inverse=True)
        points, faces = points[kept], new[faces]
    return TriangleMesh(points, faces)
