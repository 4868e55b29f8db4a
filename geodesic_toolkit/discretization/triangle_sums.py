"""Sums over triangles, computed on first use: edge weights first, then the stiffness."""

from dataclasses import dataclass

from geodesic_toolkit import _native
from geodesic_toolkit.core.rows import MOST_ENTRIES, CompressedRows
from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.errors import NotEnoughMemoryError

__all__ = ["TriangleSums", "sums_of_triangles"]


@dataclass(frozen=True, eq=False)
class TriangleSums:
    """Edges, mass and boundary of triangles.

    Attributes
    ----------
    edges : CompressedRows of shape (N, N)
        The upper triangle, without the diagonal, of the stiffness L = Gᵀ W G, with L = -Δ positive
        semidefinite, unordered within rows. There is an entry for every edge.
    lumped_mass : ndarray of shape (N,), float64
        The barycentric mass: a third of the measure of the triangles around each vertex.
    boundary : ndarray of shape (N,), bool
        Vertices of edges of one triangle.
    sides : _native.HalfEdges
        The half-edges of the triangles, sorted.
    """

    edges: CompressedRows
    lumped_mass: FloatArray
    boundary: BoolArray
    sides: _native.HalfEdges

    def stiffness(self) -> CompressedRows:
        """Return the stiffness. It takes half the time of the edges, so callers keep the result."""
        return CompressedRows(*_native.mirrored(*self.edges.arrays))


def sums_of_triangles(
    elements: IntArray, inverse_frames: FloatArray, measure: FloatArray, n_vertices: int
) -> TriangleSums:
    """Return the sums of triangles.

    Parameters
    ----------
    elements : ndarray of shape (E, 3), int64
    inverse_frames : ndarray of shape (E, 3), float64
    measure : ndarray of shape (E,), float64
    n_vertices : int

    Raises
    ------
    NotEnoughMemoryError
        The stiffness could have more entries than 32-bit indices allow.
    """
    if n_vertices + 6 * len(elements) > MOST_ENTRIES:
        raise NotEnoughMemoryError(
            f"the stiffness of {len(elements)} triangles may have more entries than 32-bit indices "
            "allow; simplify the shape, or work on its parts"
        )
    sides = _native.sorted_half_edges(elements, n_vertices)
    rows, lumped_mass, boundary = _native.edge_sums(elements, sides, inverse_frames, measure)
    return TriangleSums(CompressedRows(*rows), lumped_mass, boundary, sides)
