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

    The format stores three corners a face and no vertices; corners with the same coordinates
    become one vertex, numbered in the order of first appearance, and so do those at open edges that
    differ by rounding. No face is left out, though corners that agree make some degenerate.
    """
    data = path.read_bytes()
    # Binary files may begin with "solid" too, so their length is looked at first.
    announced = int.from_bytes(data[80:HEADER], "little") if len(data) >= HEADER else 0
    size = HEADER + announced * FACET.itemsize
    text = data.lstrip()[:5].lower() == b"solid" and b"\0" not in data
    if len(data) >= HEADER and (size == len(data) or (size < len(data) and not text)):
        facets = np.frombuffer(data, FACET, announced, HEADER)
        return _weld(facets["corners"].reshape(-1, 3).astype(np.float64))
    if text:
        return _weld(_text_corners(data))
    if len(data) < HEADER:
        raise ReadError("not an STL file: too short for a binary one, and no text one either")
    raise ReadError(
        f"not an STL file, or one that was cut off: {announced} faces take {size} bytes, "
        f"there are {len(data)}"
    )


def _text_corners(data: bytes) -> FloatArray:
    tokens = [token for vertex in VERTEX.findall(data) for token in vertex]
    facets = len(re.findall(rb"\bendfacet\b", data, re.IGNORECASE))
    if len(tokens) != 9 * facets or not data.rstrip().splitlines()[-1].strip().lower().startswith(
        b"endsolid"
    ):
        raise ReadError(
            f"a text STL, cut off or damaged: {facets} facets with {len(tokens) // 3} corners"
        )
    return floats(tokens, "vertex coordinates").reshape(-1, 3)


def _weld(corners: FloatArray) -> TriangleMesh:
    """Return the mesh whose vertices are the positions of corners.

    Equal corners are merged first. The remaining open edges may have been rounded differently in
    each facet: their ends are merged within :data:`COINCIDENCE_TOLERANCE`, but closed bodies are
    never merged, however near they are to each other.
    """
    corners = corners + 0.0  # makes of -0.0 the 0.0 that it equals
    first, place = same_positions(corners)
    points, faces = corners[first], place.reshape(-1, 3)
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
