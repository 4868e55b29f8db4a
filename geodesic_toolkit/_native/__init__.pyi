"""The types of the compiled kernels; ``native/python/`` has their bindings.

Arrays are C-contiguous and of just the dtype that is stated, or a TypeError says so. Shapes that do
not fit together are a ValueError. Indices within arrays are not looked at unless that is said.
"""

from typing import TypeAlias, final

import numpy as np
from numpy.typing import NDArray

Bools: TypeAlias = NDArray[np.bool_]
Rows: TypeAlias = NDArray[np.int32]
Indices: TypeAlias = NDArray[np.int64]
Numbers: TypeAlias = NDArray[np.float64]

LEVEL: int
"""The level of x86-64 of the module that is loaded, 2 to 4; 2 on other processors."""
LANES: int
"""Numbers in one of its registers."""

# -- memory ---------------------------------------------------------------------------------------

def empty(size: int) -> Numbers:
    """Return an array of so many numbers, in memory that kernels take theirs from."""

def trim() -> None:
    """Give what waits for the next array back to the system."""

# -- distances -----------------------------------------------------------------------------------

def edges_of(triangles: Indices, n_vertices: int) -> tuple[Rows, Rows]:
    """Return the edges of triangles (E, 3) as (indptr, indices), with sorted rows."""

@final
class Bounds:
    """Vertices, and the edges between them as a symmetric pattern with sorted rows.

    The diagonal is of no account; there are no entries where there are no edges to hold to.
    """

    def __init__(self, vertices: Numbers, indptr: Rows, indices: Rows) -> None: ...
    def hold(
        self,
        begins: Indices,
        places: Numbers,
        starts: Numbers,
        distances: Numbers,
        n_threads: int = 1,
    ) -> None:
        """Hold distances (K, N) between the straight line and the way along edges, in place.

        The places of set k are ``begins[k] <= p < begins[k + 1]``, and ``starts`` is read at them.
        Infinite distances stay.
        """

@final
class Polyhedron:
    """Different faces (E, 3), of three different vertices each; both ranges are checked."""

    def __init__(self, vertices: Numbers, faces: Indices) -> None: ...
    @property
    def n_vertices(self) -> int: ...
    def distances(
        self,
        begins: Indices,
        vertices: Indices,
        shares: Numbers,
        known: Numbers,
        starts: Numbers,
        most: int,
    ) -> Numbers | None:
        """Return exact distances (N,) from points, None after more than `most` windows.

        The vertices around point p are ``begins[p] <= i < begins[p + 1]``, of a face that they
        share, and ``known`` is how far they are from it.
        """

# -- sparse matrices in compressed rows ----------------------------------------------------------

def components(indptr: Rows, indices: Rows) -> Indices:
    """Return the connected component of every vertex, numbered by their first vertices.

    Entries on one side of the diagonal are enough.
    """

def components_of_edges(edges: Indices, n_vertices: int) -> Indices:
    """Return the same from edges (E, 2), whose range is checked."""

def is_sound(indptr: Rows, indices: Rows, data: Numbers) -> bool:
    """Return whether L is finite and symmetric, L 1 = 0, and no diagonal entry is negative."""

def obtuse_excess(indptr: Rows, indices: Rows, data: Numbers, mass: Numbers, rings: int) -> Numbers:
    """Return the share of entries of the wrong sign around each vertex, over so many rings.

    What lies right of the diagonal is enough.
    """

def diagonal_places(indptr: Rows, indices: Rows) -> Indices:
    """Return where the diagonal entries are, row by row; of rows that have one."""

def plus_diagonal(
    indptr: Rows, indices: Rows, data: Numbers, places: Indices, scales: Numbers, diagonal: Numbers
) -> Numbers:
    """Return the entries of diag(diagonal) + diag(scales) A, whose diagonal has these places.

    `scales` has a number for each row or one for all.
    """

def row_sums(indptr: Rows, indices: Rows, data: Numbers) -> Numbers:
    """Return the sum of the entries of each row."""

# -- the Cholesky solver ---------------------------------------------------------------------------

def is_symmetric(indptr: Rows, indices: Rows) -> bool:
    """Return whether every entry of a pattern has its mirror image."""

@final
class Elimination:
    """An order of elimination, in groups of vertices that are eliminated together.

    Group g is ``order[starts[g]:starts[g + 1]]``; its first column has ``heights[g]`` rows, and
    ``parents[g]`` takes over what its elimination leaves. The last `n_full` were set aside.
    """

    @property
    def order(self) -> Rows: ...
    @property
    def starts(self) -> Rows: ...
    @property
    def heights(self) -> Rows: ...
    @property
    def parents(self) -> Rows: ...
    @property
    def n_full(self) -> int: ...

def minimum_degree(indptr: Rows, indices: Rows) -> Elimination:
    """Return an approximate minimum degree order of a symmetric pattern."""

@final
class Analysis:
    """Order, supernodes and places of the Cholesky factor of every matrix of one pattern.

    Column j belongs to vertex ``order[j]``. Supernode s has the columns ``first[s] <= j <
    first[s + 1]`` and the rows ``rows[row_starts[s]:row_starts[s + 1]]``, of which its own columns
    come first; its dense panel of that shape is stored by columns from ``panels[s]``, and
    ``above[s]`` is its parent, -1 at roots. The permuted lower triangle by columns is `starts` and
    `lower_rows`; `places` is where its entries are in a matrix's data.
    """

    @property
    def order(self) -> Rows: ...
    @property
    def starts(self) -> Indices: ...
    @property
    def lower_rows(self) -> Rows: ...
    @property
    def places(self) -> Rows: ...
    @property
    def panels(self) -> Indices: ...
    @property
    def first(self) -> Rows: ...
    @property
    def row_starts(self) -> Indices: ...
    @property
    def rows(self) -> Rows: ...
    @property
    def parents(self) -> Rows: ...
    @property
    def n_stored(self) -> int: ...
    @property
    def nbytes(self) -> int: ...
    def factor_bytes(self, compact: bool) -> int:
        """Return what making a factor takes."""

def analyze(indptr: Rows, indices: Rows) -> Analysis:
    """Analyse a symmetric pattern with sorted columns."""

@final
class Factor:
    """The Cholesky factor of a matrix, of whole numbers or of their upper halves.

    Raises
    ------
    SolverError
        The matrix is not positive definite to working precision; the message names the vertex.
    """

    def __init__(self, analysis: Analysis, data: Numbers, compact: bool = False) -> None: ...
    def solve(self, b: Numbers, x: Numbers) -> None:
        """Write x with A x = b, (N,) or (N, K); x may be b.

        Raises
        ------
        SolverError
            The solution is not finite.
        """

    @property
    def nbytes(self) -> int: ...
    @property
    def panels(self) -> Numbers | NDArray[np.uint32]:
        """The dense panels: L, but for its diagonal, of which they hold the inverse.

        Upper halves of numbers are ``uint32``. Some zeros follow.
        """

def eliminate_front(panel: Numbers, height: int, width: int) -> tuple[int, Numbers]:
    """Eliminate the columns of a dense front in place, stored by columns.

    Return the first column with a pivot <= 0, or -1, and the update matrix by columns, of which the
    lower triangle counts.
    """

# -- triangles -------------------------------------------------------------------------------------

def proper_faces(faces: Indices, n_vertices: int) -> Bools:
    """Return where a face has three different vertices that no face before it has."""

def measure_triangles(vertices: Numbers, faces: Indices) -> tuple[Numbers, Numbers, float, float]:
    """Return inverse frames (F, 3), areas, and what tells whether they are sound.

    The sum of all edge lengths, and the least by which two edges of a face are longer than the
    third, over its longest.
    """

def measure_lengths(lengths: Numbers) -> tuple[Numbers, Numbers]:
    """Return inverse frames (F, 3) and areas from the edges opposite the corners, (F, 3)."""

def edge_lengths(frames: Numbers) -> Numbers:
    """Return the edges opposite the corners, (F, 3), from inverse frames."""

def faces_at(faces: Indices, marked: Bools) -> Indices:
    """Return the triangles (F, 3) that have a marked vertex, by number."""

@final
class HalfEdges:
    """The half-edges of triangles, sorted by their vertices of lower index."""

    @property
    def n_vertices(self) -> int: ...
    def twins(self) -> tuple[Indices, bool]:
        """Return the twin of each half-edge, or -1, and whether all run against each other."""

def sorted_half_edges(faces: Indices, n_vertices: int) -> HalfEdges:
    """Sort the half-edges of triangles, fewer than 2³¹ of them."""

def edge_sums(
    faces: Indices, sides: HalfEdges, frames: Numbers, measure: Numbers
) -> tuple[tuple[Rows, Rows, Numbers], Numbers, Bools]:
    """Return the strict upper triangle of L = Gᵀ W G, barycentric mass, and boundary.

    L = -Δ is positive semidefinite; rows are in no order.
    """

def mirrored(indptr: Rows, indices: Rows, data: Numbers) -> tuple[Rows, Rows, Numbers]:
    """Return all of a stiffness from what lies right of its diagonal."""

def mean_edge_length(vertices: Numbers, indptr: Rows, indices: Rows) -> float:
    """Return the mean length of the edges that a pattern has right of its diagonal."""

def flip_edges(faces: Indices, lengths: Numbers, twin: Indices, held: Bools) -> int:
    """Flip edges in place to an intrinsic Delaunay triangulation; return how many.

    Edges of a held vertex stay.
    """

def flip_edges_with_directions(
    faces: Indices,
    lengths: Numbers,
    twin: Indices,
    held: Bools,
    angles: Numbers,
    scales: Numbers,
) -> int:
    """Do the same, and carry along the directions of half-edges that `polar_directions` returns."""

def vertex_normals(vertices: Numbers, faces: Indices) -> Numbers:
    """Return unit normals at vertices (N, 3), exact where these are on a sphere."""

def tangent_axes(normals: Numbers) -> Numbers:
    """Return a unit vector at a right angle to each normal, (N, 3)."""

def polar_directions(
    vertices: Numbers,
    faces: Indices,
    lengths: Numbers,
    twin: Indices,
    mirrored: Bools,
    normals: Numbers,
    axes: Numbers,
) -> tuple[Numbers, Numbers]:
    """Return the direction of each half-edge at its tail, and by what angles are scaled there."""

def bisectors(lengths: Numbers, angles: Numbers, scales: Numbers) -> Numbers:
    """Return the direction of the bisector of each corner in the frame of its vertex, (F, 3)."""

def triangle_turns(lengths: Numbers, directions: Numbers, mirrored: Bools) -> Numbers:
    """Return turns (F, 6), pairs of numbers, that take bisectors into frames of triangles."""

def space_turns(
    places: Numbers, elements: Indices, normals: Numbers, axes: Numbers, stars: bool
) -> tuple[Numbers, Bools]:
    """Return turns (E, 2 m) by the least rotations of normals, and which elements are mirrored."""

# -- the heat method between its solves -----------------------------------------------------------

def connection_laplacian(
    indptr: Rows,
    indices: Rows,
    elements: Indices,
    frames: Numbers,
    measure: Numbers,
    turns: Numbers,
) -> Numbers:
    """Return complex entries (nnz, 2) of G_cᴴ W G_c on a pattern with all edges and the diagonal.

    It must have an entry for every pair of corners of a triangle.
    """

def edge_turns(indptr: Rows, indices: Rows, elements: Indices, turns: Numbers) -> Numbers:
    """Return the sums (nnz, 2) of turns from vertex j to vertex i through elements (E, m)."""

def real_form(
    indptr: Rows, indices: Rows, entries: Numbers, scale: Numbers, diagonal: Numbers
) -> tuple[Rows, Rows, Numbers]:
    """Return diag(diagonal) + diag(scale) A for complex A as a real matrix of 2 N unknowns."""

def poisson_load(
    faces: Indices, frames: Numbers, measure: Numbers, heat: Numbers, logarithmic: bool
) -> Numbers:
    """Return Gᵀ W X with X = -∇u/|∇u|, from u or log u, (N,) or (N, K)."""

def fill(indptr: Rows, indices: Rows, data: Numbers, solution: Numbers, rows: Rows) -> None:
    """Fill the entries `rows` of u, which are 0, from neighbours with a value, ring by ring.

    `rows` comes out in another order.
    """

# -- refinement ------------------------------------------------------------------------------------

@final
class Corners:
    """The triangles around each vertex, as :func:`gather_corners` returns them.

    Vertex v has the corners ``starts[v] <= c < starts[v + 1]``, but where stars overlap its own
    star first, which ends before ``ends[v]``. The arrays are read-only views.
    """

    @property
    def starts(self) -> Rows: ...
    @property
    def ends(self) -> Rows: ...
    @property
    def a(self) -> NDArray[np.uint32]: ...
    @property
    def b(self) -> NDArray[np.uint32]: ...
    @property
    def to_a(self) -> Numbers: ...
    @property
    def to_b(self) -> Numbers: ...
    @property
    def edge(self) -> Numbers: ...

def gather_corners(
    elements: Indices, frames: Numbers, stars: bool, add_missed: bool, boundary: Bools
) -> Corners:
    """Sort the corners of triangles by their vertices; `add_missed` adds triangles that stars lack.

    Where there are no stars and the surface ends in an edge, between vertices of the `boundary`,
    the edge is less than zero.
    """

def angle_defects(elements: Indices, frames: Numbers, boundary: Bools) -> Numbers:
    """Return what the angles about vertices lack of 2π, where the domain ends of π."""

def curvatures(
    elements: Indices,
    measure: Numbers,
    defects: Numbers,
    corners: Corners,
    boundary: Bools,
    coarse: float,
) -> Numbers:
    """Return the Gaussian curvature of vertices: angle defect over area, over one-rings.

    Where K of a vertex, times its area, comes to `coarse` it counts for half; it is 0 where the
    domain ends, and where sheets meet.
    """

def star_curvatures(elements: Indices, frames: Numbers, boundary: Bools, coarse: float) -> Numbers:
    """Return the same of stars, from the angles about their own centres."""

def falling(heat: Numbers, logarithmic: bool) -> Rows:
    """Return the order in which heat falls as far as nine digits tell, and then by number."""

@final
class Sweeper:
    """Triangles and their curvature, ready for sweeps; shared by all sources and threads."""

    def __init__(self, corners: Corners, curvature: Numbers, reflex: Bools) -> None: ...
    def sweep(
        self,
        heat: Numbers,
        logarithmic: bool,
        begins: Indices,
        vertices: Indices,
        known: Numbers,
        curvatures: Numbers,
        tolerances: Numbers,
        returns: int,
        steady: int,
        most_sweeps: int,
        distances: Numbers,
        kappas: Numbers | None = None,
        n_threads: int = 1,
    ) -> None:
        """Write the distances from K source sets, (K, N), in the order of their heat, (N, K)."""

def directions_of(
    elements: Indices, lengths: Numbers, turns: Numbers, mirrored: Bools, twin: Indices
) -> tuple[Numbers, Numbers]:
    """Return the direction of each half-edge at its tail, and by what angles are scaled there.

    From the turns (E, 6) of corners into triangles, as `triangle_turns` returns them.
    """

@final
class Tracer:
    """Triangles with the directions of their edges, for what fronts carry along."""

    def __init__(
        self,
        elements: Indices,
        frames: Numbers,
        stars: bool,
        add_missed: bool,
        boundary: Bools,
        flat: Numbers,
        angles: Numbers,
        scales: Numbers,
        curvature: Numbers,
        reflex: Bools,
    ) -> None:
        """Make them ready: `flat` are the lengths (E, 3) by which angles between edges go."""

    def carry(
        self,
        distances: Numbers,
        kappas: Numbers,
        vertices: Indices,
        known: Numbers,
        angles: Numbers,
        spreads: Numbers,
        arrivals: Numbers,
        labels: Rows,
        period: float,
        clockwise: bool,
        directions: bool,
    ) -> tuple[Numbers, Numbers, Numbers, Rows, Rows, Rows, Numbers]:
        """Return angles, spreads, arrivals, labels (N,), and from where they came.

        The latter are the ends of the edge that the front to a vertex crossed, -1 at sources, and
        the share of the second.
        """

# -- point clouds ----------------------------------------------------------------------------------

def delaunay_stars(
    points: Numbers,
    normals: Numbers,
    centres: Indices,
    neighbours: Indices,
    reaches: Numbers,
    weights: Numbers,
    k: int,
    oriented: bool,
    smooth: bool,
    n_threads: int,
) -> tuple[Indices, Numbers, Bools]:
    """Return the triangles of local Delaunay stars, their frames, and which stars are open."""

def crowd_reaches(points: Numbers, neighbours: Indices, n_threads: int) -> Numbers:
    """Return how far the line or the heap that a point is one of reaches, 0 where there is none."""

def thinned(points: Numbers, neighbours: Indices, radii: Numbers) -> Bools:
    """Return which points to keep so that each other one has one of them within its radius."""

def pole_normals(points: Numbers, neighbours: Indices, normals: Numbers, n_threads: int) -> Numbers:
    """Return normals in which those that are in doubt point to the emptiest side."""

# -- shortest paths --------------------------------------------------------------------------------

def best_path(
    vertices: Numbers,
    faces: Indices,
    height: Numbers,
    back: Numbers,
    start: int,
    ends: Indices,
) -> tuple[Indices, Indices, Numbers]:
    """Return a geodesic from a vertex to one of several ends over triangles (F, 3).

    Each has three different vertices; `height` and `back` are the distances (N,) from the ends and
    from the start. What comes back are the faces (P,) that the points of the way are in, the
    vertices (P, 2) that they are between, and the share (P,) of the second; nothing where no
    triangle connects.
    """

def straight_lines(
    lengths: Numbers,
    twin: Indices,
    faces: Indices,
    weights: Numbers,
    angles: Numbers,
    distances: Numbers,
    most: int,
) -> tuple[Indices, Indices, Numbers, Numbers]:
    """Return where straightest lines start, cross edges and end, and what is left of their lengths.

    As (begins, faces, weights, missing). They start in faces, whose range is checked, at an angle
    to half-edge 3 f, and cross `most` edges at most.
    """

def distinct_triangles(elements: Indices) -> tuple[Indices, Indices]:
    """Return each triangle of elements (E, 3) once, (T, 3), its corners sorted, and how often it is
    there, (T,). Elements (i, j, j) are left out.
    """

# -- graphs ----------------------------------------------------------------------------------------

class GraphCorners:
    """The corners of a graph, across which fronts go; edges are (E, 2), each once, no loops."""

    def __init__(self, n_vertices: int, edges: Indices, lengths: Numbers) -> None: ...
    @property
    def n_corners(self) -> int: ...
    @property
    def covered(self) -> float:
        """Share of the vertices of three edges and more whose edges corners connect."""
    @property
    def growth(self) -> float:
        """Vertices up to two edges away, for each neighbour."""
    @property
    def closed(self) -> float:
        """Share of the edges whose triangles surround them: their third corners connect."""
    @property
    def lattice(self) -> bool:
        """Whether nine of ten corners are those of rectangles."""
    @property
    def nbytes(self) -> int: ...
    def cross(
        self,
        begins: Indices,
        vertices: Indices,
        starts: Numbers,
        distances: Numbers,
        n_threads: int,
    ) -> None:
        """Write the distances (K, N) from each of K sets of vertices, infinite where none leads."""
