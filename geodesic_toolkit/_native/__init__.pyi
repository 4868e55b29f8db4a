"""The types of the compiled kernels; ``native/python/`` has their bindings.

Arrays must be C-contiguous and have exactly the stated dtype, or a TypeError is raised. Shapes that
do not fit together raise a ValueError. Indices in arrays are not checked unless stated.
"""

from typing import TypeAlias, final

import numpy as np
from numpy.typing import NDArray

Bools: TypeAlias = NDArray[np.bool_]
Rows: TypeAlias = NDArray[np.int32]
Indices: TypeAlias = NDArray[np.int64]
Numbers: TypeAlias = NDArray[np.float64]

LEVEL: int
"""The level of x86-64 of the loaded module, 2 to 4; 2 on other processors."""
LANES: int
"""Number of doubles in a vector register of that level."""

# -- memory ---------------------------------------------------------------------------------------

def empty(size: int) -> Numbers:
    """Return an uninitialised array of `size` numbers, from the memory pool of the kernels."""

def trim() -> None:
    """Return the unused memory of the pool to the system."""

# -- distances -----------------------------------------------------------------------------------

def edges_of(triangles: Indices, n_vertices: int) -> tuple[Rows, Rows]:
    """Return the edges of triangles (E, 3) as (indptr, indices), with sorted rows."""

@final
class Bounds:
    """Vertices, and the edges between them as a symmetric pattern with sorted rows.

    The diagonal is ignored; the pattern is empty if there are no edges that bound distances.
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
        """Limit distances (K, N) to between the straight line and the path along edges, in place.

        The sources of set k have the indices ``begins[k] <= p < begins[k + 1]`` in `places` and
        `starts`. Infinite distances stay.
        """
    def hold_near(
        self,
        begins: Indices,
        places: Numbers,
        starts: Numbers,
        row_begins: Indices,
        near: Indices,
        distances: Numbers,
        limits: Numbers,
    ) -> Bools:
        """Do the same with the distances of sparse rows; return False for those that lack some.

        They lack a vertex that a path along edges reaches within the limit of the row.
        """

@final
class Polyhedron:
    """Distinct faces (E, 3), each of three different vertices; indices are checked."""

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

        The vertices around point p have the indices ``begins[p] <= i < begins[p + 1]`` and belong
        to one face; `known` are their distances from the point.
        """

# -- sparse matrices in compressed rows ----------------------------------------------------------

def components(indptr: Rows, indices: Rows) -> Indices:
    """Return the connected component of every vertex, numbered by their first vertices.

    Entries on one side of the diagonal are enough.
    """

def components_of_edges(edges: Indices, n_vertices: int) -> Indices:
    """Return the connected component of every vertex from edges (E, 2), with checked indices."""

def is_sound(indptr: Rows, indices: Rows, data: Numbers) -> bool:
    """Return True if L is finite and symmetric, L 1 = 0, and the diagonal is not negative."""

def obtuse_excess(indptr: Rows, indices: Rows, data: Numbers, mass: Numbers, rings: int) -> Numbers:
    """Return the share of entries of the wrong sign around each vertex, over `rings` rings.

    The upper triangle of the matrix is enough.
    """

def diagonal_places(indptr: Rows, indices: Rows) -> Indices:
    """Return the indices of the diagonal entries, row by row, for rows that have one."""

def plus_diagonal(
    indptr: Rows, indices: Rows, data: Numbers, places: Indices, scales: Numbers, diagonal: Numbers
) -> Numbers:
    """Return the entries of diag(diagonal) + diag(scales) A; `places` index the diagonal of A.

    `scales` has a number for each row or one for all.
    """

def row_sums(indptr: Rows, indices: Rows, data: Numbers) -> Numbers:
    """Return the sum of the entries of each row."""

# -- the Cholesky solver ---------------------------------------------------------------------------

def is_symmetric(indptr: Rows, indices: Rows) -> bool:
    """Return True if every entry of a pattern has its mirror image."""

@final
class Elimination:
    """An elimination order, in groups of vertices that are eliminated together.

    Group g is ``order[starts[g]:starts[g + 1]]``; its first column has ``heights[g]`` rows, and
    ``parents[g]`` receives its update matrix. The last `n_full` vertices have nearly dense rows.
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
    """Order, supernodes and layout of the Cholesky factor of every matrix of one pattern.

    Column j belongs to vertex ``order[j]``. Supernode s has the columns ``first[s] <= j <
    first[s + 1]`` and the rows ``rows[row_starts[s]:row_starts[s + 1]]``, with its own columns
    first; its dense panel of that shape is stored by columns from ``panels[s]``, and ``parents[s]``
    is its parent, -1 at roots. The permuted lower triangle by columns is `starts` and `lower_rows`;
    `places` are the indices of its entries in the data of a matrix. Of an analysis `in_pairs` only
    the even columns are kept.
    """

    def in_pairs(self, indptr: Rows) -> Analysis:
        """Return that of complex Hermitian matrices of the pattern, in their real form."""

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
        """Return the bytes that a factor takes while it is made."""

def analyze(indptr: Rows, indices: Rows) -> Analysis:
    """Analyse a symmetric pattern with sorted columns."""

@final
class Factor:
    """The Cholesky factor of a matrix, with full numbers or their upper halves.

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
        """The dense panels of L, with the inverse of its diagonal.

        Upper halves of numbers are ``uint32``. Padding with zeros follows.
        """

def eliminate_front(panel: Numbers, height: int, width: int) -> tuple[int, Numbers]:
    """Eliminate the columns of a dense front in place, stored by columns.

    Return the first column with a pivot <= 0, or -1, and the update matrix by columns, whose lower
    triangle is valid.
    """

# -- triangles -------------------------------------------------------------------------------------

def proper_faces(faces: Indices, n_vertices: int) -> Bools:
    """Return a mask of the faces with three different vertices that do not repeat a face."""

def measure_triangles(vertices: Numbers, faces: Indices) -> tuple[Numbers, Numbers, float, float]:
    """Return inverse frames (F, 3), areas, and two numbers that measure their quality.

    These are the sum of all edge lengths, and the smallest slack of a triangle inequality, relative
    to the longest edge of the face.
    """

def measure_lengths(lengths: Numbers) -> tuple[Numbers, Numbers]:
    """Return inverse frames (F, 3) and areas from the edges opposite the corners, (F, 3)."""

def edge_lengths(frames: Numbers) -> Numbers:
    """Return the edges opposite the corners, (F, 3), from inverse frames."""

def faces_at(faces: Indices, marked: Bools) -> Indices:
    """Return the indices of the triangles (F, 3) that have a marked vertex."""

@final
class HalfEdges:
    """The half-edges of triangles, sorted by their smaller vertex."""

    @property
    def n_vertices(self) -> int: ...
    def twins(self) -> tuple[Indices, bool]:
        """Return the twin of each half-edge, or -1, and True if all twins have opposite
        directions."""

def sorted_half_edges(faces: Indices, n_vertices: int) -> HalfEdges:
    """Sort the half-edges of triangles, fewer than 2³¹ of them."""

def edge_sums(
    faces: Indices, sides: HalfEdges, frames: Numbers, measure: Numbers
) -> tuple[tuple[Rows, Rows, Numbers], Numbers, Bools]:
    """Return the strict upper triangle of L = Gᵀ W G, barycentric mass, and boundary.

    L = -Δ is positive semidefinite; rows are unordered.
    """

def mirrored(indptr: Rows, indices: Rows, data: Numbers) -> tuple[Rows, Rows, Numbers]:
    """Return a full stiffness from its strict upper triangle."""

def mean_edge_length(vertices: Numbers, indptr: Rows, indices: Rows) -> float:
    """Return the mean length of the edges in the upper triangle of a pattern."""

def flip_edges(faces: Indices, lengths: Numbers, twin: Indices, held: Bools) -> int:
    """Flip edges in place to an intrinsic Delaunay triangulation; return the number of flips.

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
    """Flip edges, and update the directions of half-edges that `polar_directions` returns."""

def vertex_normals(vertices: Numbers, faces: Indices, n_threads: int = 1) -> Numbers:
    """Return unit normals at vertices (N, 3), which are exact for vertices on a sphere."""

def tangent_axes(normals: Numbers) -> Numbers:
    """Return a unit vector at a right angle to each normal, (N, 3)."""

def unit_vectors(angles: Numbers) -> Numbers:
    """Return the cosines and sines (N, 2) of angles of up to 1e5."""

def to_space(pairs: Numbers, x_axes: Numbers, y_axes: Numbers) -> Numbers:
    """Return vectors in space (N, 3) from coordinates (N, 2) along two axes of each vertex."""

def polar_directions(
    vertices: Numbers,
    faces: Indices,
    lengths: Numbers,
    twin: Indices,
    mirrored: Bools,
    normals: Numbers,
    axes: Numbers,
) -> tuple[Numbers, Numbers]:
    """Return the direction of each half-edge at its tail, and the scale of angles there."""

def bisectors(lengths: Numbers, angles: Numbers, scales: Numbers) -> Numbers:
    """Return the direction of the bisector of each corner in the frame of its vertex, (F, 3)."""

def triangle_turns(lengths: Numbers, directions: Numbers, mirrored: Bools) -> Numbers:
    """Return turns (F, 6), as pairs of numbers, from bisectors into the frames of triangles."""

def space_turns(
    places: Numbers, elements: Indices, normals: Numbers, axes: Numbers, stars: bool
) -> tuple[Numbers, Bools]:
    """Return turns (E, 2 m) by least rotations of normals, and a mask of mirrored elements."""

# -- the heat method between its solves -----------------------------------------------------------

def connection_laplacian(
    indptr: Rows,
    indices: Rows,
    elements: Indices,
    frames: Numbers,
    measure: Numbers,
    turns: Numbers,
) -> Numbers | None:
    """Return complex entries (nnz, 2) of G_cᴴ W G_c on a symmetric pattern with sorted rows.

    None if it lacks the diagonal, or the entry of a pair of corners of a triangle.
    """

def edge_turns(indptr: Rows, indices: Rows, elements: Indices, turns: Numbers) -> Numbers:
    """Return the sums (nnz, 2) of turns from vertex j to vertex i through elements (E, m)."""

def real_form(
    indptr: Rows, indices: Rows, entries: Numbers, scale: Numbers, diagonal: Numbers
) -> tuple[Rows, Rows, Numbers]:
    """Return diag(diagonal) + diag(scale) A for complex A as a real matrix of 2 N unknowns."""

def polar_form(pairs: Numbers) -> tuple[Numbers, Numbers]:
    """Return the lengths (N,) of complex numbers (N, 2), and these numbers at length 1, or 0."""

def poisson_load(
    faces: Indices, frames: Numbers, measure: Numbers, heat: Numbers, logarithmic: bool
) -> Numbers:
    """Return Gᵀ W X with X = -∇u/|∇u|, from u or log u, (N,) or (N, K)."""

def fill(indptr: Rows, indices: Rows, data: Numbers, solution: Numbers, rows: Rows) -> None:
    """Fill the entries `rows` of u, which are 0, from neighbours with a value, ring by ring.

    The order of `rows` changes.
    """

# -- refinement ------------------------------------------------------------------------------------

@final
class Corners:
    """The triangles around each vertex, as :func:`gather_corners` returns them.

    Vertex v has the corners ``starts[v] <= c < starts[v + 1]``; if stars overlap, its own star
    comes first and ends before ``ends[v]``. The arrays are read-only views.
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
    elements: Indices,
    frames: Numbers,
    stars: bool,
    add_missed: bool,
    boundary: Bools,
    edges_agree: bool = True,
) -> Corners:
    """Sort the corners of triangles by their vertices; `add_missed` adds triangles that stars lack.

    Without stars, `edge` is negative for edges at which the surface ends, between vertices of the
    `boundary`; unless `edges_agree`, edges are distinguished by their ends alone.
    """

def in_sight(
    begins: Indices,
    vertices: Indices,
    distances: Numbers,
    elements: Indices,
    frames: Numbers,
    stars: bool,
    hidden: Bools,
) -> tuple[Indices, Indices, Numbers, Numbers]:
    """Return the vertices in sight of places in triangles and on edges, besides those around them.

    A place p lies between the two or three vertices ``begins[p]:begins[p + 1]``, at `distances`
    from these. Returns the place of each vertex in sight, the vertex, and its x and y in a plane
    about the place: the farthest of the vertices around it lies on the x axis, the next at y > 0.
    """

def angle_defects(elements: Indices, frames: Numbers, boundary: Bools) -> Numbers:
    """Return the angle defects of vertices: 2π, or π at the boundary, minus their total angles."""

def curvatures(
    elements: Indices,
    measure: Numbers,
    defects: Numbers,
    corners: Corners,
    boundary: Bools,
    coarse: float,
) -> Numbers:
    """Return the Gaussian curvature of vertices: angle defect over area, over one-rings.

    If K of a vertex, times its area, is `coarse`, it is halved; it is 0 at the boundary, and at
    edges of several sheets.
    """

def star_curvatures(elements: Indices, frames: Numbers, boundary: Bools, coarse: float) -> Numbers:
    """Return the Gaussian curvature of stars, from the angles around their own centres."""

def falling(heat: Numbers, logarithmic: bool) -> Rows:
    """Return the order of falling heat, compared to nine digits, and then by index."""

@final
class Sweeper:
    """Triangles and their curvature, prepared for sweeps; shared by all sources and threads."""

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
        have_offsets: bool = False,
    ) -> None:
        """Write the distances from K source sets, (K, N), in the order of their heat, (N, K)."""

    def sweep_near(
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
        limits: Numbers,
        n_threads: int = 1,
        have_offsets: bool = False,
    ) -> tuple[Indices, Indices, Numbers]:
        """Return the same up to limits (K,), and of some vertices beyond, in sparse rows."""

    def sweep_limited(
        self,
        vertices: Indices,
        known: Numbers,
        curvatures: Numbers,
        tolerance: float,
        latest: Numbers,
        most_visits: int,
        distances: Numbers,
        have_offsets: bool = False,
    ) -> None:
        """Write the distances (N,) from one source set where fronts come before `latest`, (N,)."""

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
    ) -> tuple[Numbers, Numbers, Numbers, Numbers, Rows, Rows, Rows, Numbers]:
        """Return angles, spreads, arrivals, rotations, labels (N,), and from where they came.

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
    """Return the triangles of local Delaunay stars, their frames, and a mask of open stars."""

def crowd_reaches(points: Numbers, neighbours: Indices, n_threads: int) -> Numbers:
    """Return the reach of the line or heap that contains each point, 0 outside them."""

def thinned(points: Numbers, neighbours: Indices, radii: Numbers) -> Bools:
    """Return a mask of points to keep, so that every other point has one within its radius."""

def pole_normals(points: Numbers, neighbours: Indices, normals: Numbers, n_threads: int) -> Numbers:
    """Return normals, the uncertain ones turned to the emptiest side."""

# -- shortest paths --------------------------------------------------------------------------------

class Surface:
    """Triangles (F, 3) of three different vertices each, and those around each vertex.

    Any number may share an edge. The arrays are kept, not copied.
    """

    def __init__(self, vertices: Numbers, faces: Indices) -> None: ...

def best_path(
    surface: Surface,
    height: Numbers,
    back: Numbers,
    start: int,
    ends: Indices,
) -> tuple[Indices, Indices, Numbers]:
    """Return a geodesic from a vertex to one of several ends.

    `height` and `back` are the distances (N,) from the ends and
    from the start. The result holds the face of each point of the path, (P,), the two vertices
    between which it lies, (P, 2), and the share of the second, (P,); it is empty if triangles do
    not connect the ends.
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
    """Return the points of straightest lines at starts, edges and ends, and their missing lengths.

    The result is (begins, faces, weights, missing). Lines start in faces, with checked indices, at
    an angle to half-edge 3 f, and cross at most `most` edges.
    """

def geodesic_through(
    vertices: Numbers,
    faces: Indices,
    stops: Indices,
    *,
    closed: bool,
    held: bool,
    min_length: float,
) -> tuple[tuple[Indices, Indices, Numbers], int]:
    """Shorten a chain of edges through stops to a geodesic; return it and the unreached stop.

    Its points are as those of `best_path`, from the first stop, or where it is closed from any
    vertex on it back to that; there are none where a closed one shrinks to less than `min_length`.
    Where it is `held` it runs through the stops. The number is that of the stop that no triangle
    connects with the one before it, or -1.
    """

def shortest_loop(
    vertices: Numbers, faces: Indices, vertex: int | None = None, *, min_hole: float = 0.0
) -> tuple[tuple[Indices, Indices, Numbers], int, int]:
    """Return the shortest loop that does not shrink to a point, held at a vertex or anywhere.

    Its points are as those of `geodesic_through`; there are none where every loop shrinks. The two
    numbers are -1, or where there is no loop for another reason the ends of an edge of more than
    two faces, or a vertex and -1 where holes meet that are to be filled: those shorter than
    `min_hole`.
    """

def distinct_triangles(elements: Indices) -> tuple[Indices, Indices]:
    """Return the distinct triangles of elements (E, 3), (T, 3), and their numbers of copies, (T,).

    Corners are sorted, and elements (i, j, j) are excluded.
    """

# -- graphs ----------------------------------------------------------------------------------------

class GraphCorners:
    """The corners of a graph, which fronts cross; edges are (E, 2), distinct and without loops."""

    def __init__(self, n_vertices: int, edges: Indices, lengths: Numbers) -> None: ...
    @property
    def n_corners(self) -> int: ...
    @property
    def covered(self) -> float:
        """Share of the vertices of three edges or more whose edges are connected by corners."""
    @property
    def growth(self) -> float:
        """Number of vertices up to two edges away, per neighbour."""
    @property
    def closed(self) -> float:
        """Share of the edges surrounded by triangles, whose third corners are connected."""
    @property
    def lattice(self) -> bool:
        """True if nine of ten corners are corners of rectangles."""
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
        """Write the distances (K, N) from each of K sets of vertices, infinite without a path."""

    def cross_near(
        self,
        begins: Indices,
        vertices: Indices,
        starts: Numbers,
        limits: Numbers,
        n_threads: int,
    ) -> tuple[Indices, Indices, Numbers]:
        """Return the same up to limits (K,), in sparse rows."""
