"""What triangles add up to, as far as it has been asked for: edges first, and the stiffness."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from scipy.sparse import csr_array

from geodesic_toolkit._typing import BoolArray, FloatArray, IntArray

if TYPE_CHECKING:
    from geodesic_toolkit._sides import Sides  # imports Numba

__all__ = ["TriangleSums", "sums_of_triangles"]


@dataclass(frozen=True, eq=False)
class TriangleSums:
    """Edges, mass and boundary of triangles.

    Attributes
    ----------
    edges : csr_array of shape (N, N)
        The part of the stiffness L = Gᵀ W G, with L = -Δ positive semidefinite, that lies right of
        the diagonal, in no order within its rows; or all of it. There is an entry for every edge.
    thirds : ndarray of shape (N,), float64
        The barycentric mass: a third of the measure of the triangles around each vertex.
    boundary : ndarray of shape (N,), bool
        Vertices of edges that one triangle has.
    sides : Sides, optional
        The half-edges of the triangles, where they have been sorted.
    """

    edges: csr_array
    thirds: FloatArray
    boundary: BoolArray
    sides: "Sides | None" = None

    def stiffness(self) -> csr_array:
        """Return the stiffness: half as long again as the edges have taken, so ask once."""
        if self.sides is None:
            return self.edges
        from geodesic_toolkit._assembly import mirrored

        rows = mirrored(self.edges.indptr, self.edges.indices, self.edges.data)
        stiffness = csr_array((rows[2], rows[1], rows[0]), shape=self.edges.shape)
        stiffness.has_canonical_format = True  # or SciPy looks through it
        return stiffness


def sums_of_triangles(
    elements: IntArray, inverse_frames: FloatArray, measure: FloatArray, n_vertices: int
) -> TriangleSums:
    """Return the sums of triangles by compiled passes.

    Parameters
    ----------
    elements : ndarray of shape (E, 3), int64
    inverse_frames : ndarray of shape (E, 3), float64
    measure : ndarray of shape (E,), float64
    n_vertices : int
    """
    from geodesic_toolkit._assembly import edge_sums
    from geodesic_toolkit._sides import sorted_sides

    sides = sorted_sides(elements, n_vertices)
    indptr, indices, data, thirds, boundary = edge_sums(elements, sides, inverse_frames, measure)
    edges = csr_array((data, indices, indptr), shape=(n_vertices, n_vertices))
    return TriangleSums(edges, thirds, boundary, sides)
