"""Generated shapes, most with closed-form distances."""

import numpy as np

from geodesic_toolkit.core.types import BoolArray, FloatArray, IntArray
from geodesic_toolkit.domains import TriangleMesh

__all__ = [
    "bumpy_torus",
    "disjoint_union",
    "grid",
    "icosphere",
    "knot",
    "pyramid",
    "torus",
    "tube",
]


def grid(
    n: int, m: int | None = None, *, spacing: float | None = None, shear: float = 0.0
) -> TriangleMesh:
    """Return a flat rectangle of n x m vertices in the plane z = 0.

    Parameters
    ----------
    n, m : int
        Vertices along x and along y; m = n by default.
    spacing : float, optional
        Distance between neighbours; ``1 / (n - 1)`` by default, so that x runs from 0 to 1.
    shear : float
        Adds `shear` times y to x; distances stay Euclidean.

    Returns
    -------
    TriangleMesh
        Vertex ``i + n * j`` lies in column i and row j. Diagonals alternate, so that no direction
        is favoured; under shear all have the same direction.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.testing.shapes.grid(3).vertices[4]
    array([0.5, 0.5, 0. ])
    """
    m = n if m is None else m
    step = 1 / (n - 1) if spacing is None else spacing
    x, y = np.meshgrid(np.arange(n) * step, np.arange(m) * step)
    vertices = np.column_stack([(x + shear * y).ravel(), y.ravel(), np.zeros(n * m)])
    faces = _quads_to_triangles(np.arange(n * m).reshape(m, n), None if shear == 0 else True)
    return TriangleMesh(vertices, faces)


def icosphere(level: int, radius: float = 1.0) -> TriangleMesh:
    """Return a sphere about the origin: an icosahedron subdivided `level` times.

    It has ``10 * 4**level + 2`` vertices; the distance of two points is `radius` times the angle
    between them.

    Parameters
    ----------
    level : int
        Number of times that each triangle is split in four.
    radius : float
        Distance of the vertices from the origin.

    Returns
    -------
    TriangleMesh

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.testing.shapes.icosphere(2)
    TriangleMesh(162 vertices, 320 faces)
    """
    golden = (1 + np.sqrt(5)) / 2
    corners = [[0, s, t * golden] for s in (-1, 1) for t in (-1, 1)]
    vertices = np.array([np.roll(corner, shift) for shift in range(3) for corner in corners], float)
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    faces = _icosahedron_faces(vertices)
    for _ in range(level):
        vertices, faces = _subdivide(vertices, faces)
        vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    return TriangleMesh(radius * vertices, faces)


def torus(n: int, m: int, *, major: float = 2.0, minor: float = 0.5) -> TriangleMesh:
    """Return a torus of n rings of m vertices about the z axis.

    Vertex ``i * m + j`` is on ring i at angle ``2 π j / m`` of the ring, counted from outside.
    The vertices with j = 0 are therefore the outer equator. Distances along it, and across a ring,
    have closed forms.

    Parameters
    ----------
    n, m : int
        Rings, and vertices on each.
    major, minor : float
        Radius of the circle of ring centres, and of a ring.

    Returns
    -------
    TriangleMesh

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.testing.shapes.torus(40, 12)
    TriangleMesh(480 vertices, 960 faces)
    """
    u = np.repeat(2 * np.pi * np.arange(n) / n, m)
    v = np.tile(2 * np.pi * np.arange(m) / m, n)
    out = major + minor * np.cos(v)
    vertices = np.column_stack([out * np.cos(u), out * np.sin(u), minor * np.sin(v)])
    cells = np.pad(np.arange(n * m).reshape(n, m), ((0, 1), (0, 1)), mode="wrap")
    return TriangleMesh(vertices, _quads_to_triangles(cells))


def bumpy_torus(n: int = 72, m: int = 36, *, rng: np.random.Generator) -> TriangleMesh:
    """Return a torus with bumps and dents whose vertices lie irregularly: like a scan, closed.

    There is no closed form for its distances; `exact_distance` has them.

    Parameters
    ----------
    n, m : int
        Rings, and vertices on each.
    rng : numpy.random.Generator
        Moves each vertex along the surface by up to a third of the way to its neighbours, and
        chooses one of the two diagonals of each quadrangle.

    Returns
    -------
    TriangleMesh

    Examples
    --------
    >>> import numpy as np
    >>> import geodesic_toolkit as gt
    >>> gt.testing.shapes.bumpy_torus(rng=np.random.default_rng(0))
    TriangleMesh(2592 vertices, 5184 faces)
    """
    ring, place = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    u = 2 * np.pi * (ring + rng.uniform(-1 / 3, 1 / 3, (n, m))).ravel() / n
    v = 2 * np.pi * (place + rng.uniform(-1 / 3, 1 / 3, (n, m))).ravel() / m
    minor = 1.0 + 0.2 * np.sin(3 * u) * np.cos(2 * v) + 0.1 * np.cos(5 * u + v)
    out = 2.2 + 0.2 * np.sin(2 * u) + minor * np.cos(v)
    vertices = np.column_stack([out * np.cos(u), out * np.sin(u), minor * np.sin(v)])
    cells = np.pad(np.arange(n * m).reshape(n, m), ((0, 1), (0, 1)), mode="wrap")
    faces = _quads_to_triangles(cells, rng.random((n, m)) < 0.5)
    return TriangleMesh(vertices, faces[:, ::-1])  # turned outwards


def tube(rings: int, around: int, *, edge: float = 1.0) -> TriangleMesh:
    """Return an open cylinder along z: `rings` rings of `around` vertices, all edges near `edge`.

    Rings are twisted by half a step against each other, so that faces are nearly equilateral.
    Vertex ``i * around + j`` is the j-th of ring i. The distance of two vertices is that of the
    unrolled plane.

    Parameters
    ----------
    rings, around : int
        Rings, and vertices on each.
    edge : float
        Length of the edges along a ring.

    Returns
    -------
    TriangleMesh

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> tube = gt.testing.shapes.tube(4, 6)
    >>> float(tube.vertices[6:12, 2].min().round(3))
    0.866
    """
    radius = edge / (2 * np.sin(np.pi / around))
    ring = np.repeat(np.arange(rings), around)
    angle = 2 * np.pi * (np.tile(np.arange(around), rings) + 0.5 * ring) / around
    height = ring * edge * np.sqrt(3) / 2
    vertices = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])
    cells = np.pad(np.arange(rings * around).reshape(rings, around), ((0, 0), (0, 1)), mode="wrap")
    a, b = cells[:-1, :-1].ravel(), cells[:-1, 1:].ravel()
    c, d = cells[1:, :-1].ravel(), cells[1:, 1:].ravel()
    return TriangleMesh(
        vertices, np.concatenate([np.column_stack([a, b, c]), np.column_stack([b, d, c])])
    )


def pyramid(sides: int, rings: int, *, height: float = 1.0) -> TriangleMesh:
    """Return a pyramid without a base, flat except at its tip and straight edges.

    At its tip, vertex 0, the angles add up to ``sides * arccos((cos(2π / sides) + height²) /
    (1 + height²))``.

    Parameters
    ----------
    sides : int
        Three at least.
    rings : int
        How often its sides are cut across; ring k lies k times `height` below the tip, and has the
        radius k.
    height : float

    Returns
    -------
    TriangleMesh
        The vertices of ring k, from 1 on, begin at ``1 + (k - 1) * sides``.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.testing.shapes.pyramid(5, 2)
    TriangleMesh(11 vertices, 15 faces)
    """
    turn = 2 * np.pi * np.arange(sides) / sides
    ring = np.column_stack([np.cos(turn), np.sin(turn), np.full(sides, -height)])
    vertices = np.concatenate([np.zeros((1, 3)), *(k * ring for k in range(1, rings + 1))])
    here = np.arange(sides)
    there = (here + 1) % sides
    faces = [np.column_stack([0 * here, 1 + here, 1 + there])]
    for k in range(rings - 1):
        inner, outer = 1 + k * sides, 1 + (k + 1) * sides
        faces.append(np.column_stack([inner + here, outer + here, outer + there]))
        faces.append(np.column_stack([inner + here, outer + there, inner + there]))
    return TriangleMesh(vertices, np.concatenate(faces))


def knot(
    n: int = 600, m: int = 24, *, p: int = 2, q: int = 3, thickness: float = 0.42
) -> TriangleMesh:
    """Return a tube around a (p, q) torus knot, the trefoil by default, as an example shape.

    Parameters
    ----------
    n, m : int
        Rings along the knot, and vertices on each.
    p, q : int
        Turns about the axis and about the core circle, without a common factor.
    thickness : float
        Radius of the tube; the knot winds around a circle of radius 2.

    Returns
    -------
    TriangleMesh

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.testing.shapes.knot(100, 10)
    TriangleMesh(1000 vertices, 2000 faces)
    """
    s = 2 * np.pi * np.arange(n) / n
    ring = 2 + np.cos(q * s)
    curve = np.column_stack([ring * np.cos(p * s), ring * np.sin(p * s), -np.sin(q * s)])
    tangent = np.roll(curve, -1, axis=0) - np.roll(curve, 1, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    core = np.column_stack([2 * np.cos(p * s), 2 * np.sin(p * s), np.zeros(n)])
    out = curve - core  # from the core circle: a periodic frame
    out -= np.einsum("nd,nd->n", out, tangent)[:, None] * tangent
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    side = np.cross(tangent, out)
    angle = 2 * np.pi * np.arange(m) / m
    circle = (
        np.cos(angle)[None, :, None] * out[:, None] + np.sin(angle)[None, :, None] * side[:, None]
    )
    vertices = (curve[:, None] + thickness * circle).reshape(-1, 3)
    cells = np.pad(np.arange(n * m).reshape(n, m), ((0, 1), (0, 1)), mode="wrap")
    return TriangleMesh(vertices, _quads_to_triangles(cells))


def disjoint_union(*meshes: TriangleMesh) -> TriangleMesh:
    """Return meshes side by side as one: vertices one after the other, without merging.

    Parameters
    ----------
    *meshes : TriangleMesh
        One or more.

    Returns
    -------
    TriangleMesh

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.testing.shapes.disjoint_union(gt.testing.shapes.grid(2), gt.testing.shapes.grid(2))
    TriangleMesh(8 vertices, 4 faces)
    """
    starts = np.cumsum([0] + [mesh.n_vertices for mesh in meshes])
    return TriangleMesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate(
            [mesh.faces + start for mesh, start in zip(meshes, starts[:-1], strict=True)]
        ),
    )


def _quads_to_triangles(cells: IntArray, one_way: BoolArray | bool | None = None) -> IntArray:
    """Return two triangles for each square of a grid of vertex indices.

    `one_way` says of each square, or of all, which diagonal it has; by default they alternate.
    """
    a, b = cells[:-1, :-1], cells[:-1, 1:]
    d, c = cells[1:, :-1], cells[1:, 1:]
    if one_way is None:
        row, column = np.indices(a.shape)
        one_way = (row + column) % 2 == 0
    chosen = np.where(
        np.broadcast_to(one_way, a.shape)[..., None],
        np.stack([a, b, c, a, c, d], axis=-1),
        np.stack([a, b, d, b, c, d], axis=-1),
    )
    return chosen.reshape(-1, 3)


def _icosahedron_faces(vertices: FloatArray) -> IntArray:
    """Return the triples of mutual neighbours, oriented outwards."""
    near = (vertices @ vertices.T > 0.4) & ~np.eye(len(vertices), dtype=np.bool_)
    faces = [
        (i, j, k) if np.dot(vertices[i], np.cross(vertices[j], vertices[k])) > 0 else (i, k, j)
        for i in range(12)
        for j in range(i + 1, 12)
        for k in range(j + 1, 12)
        if near[i, j] and near[j, k] and near[k, i]
    ]
    return np.array(faces, dtype=np.int64)


def _subdivide(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """Return the mesh with each triangle split in four at the midpoints of its edges."""
    sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, position = np.unique(sides, axis=0, return_inverse=True)
    middle = len(vertices) + position.reshape(-1, 3)
    a, b, c = faces.T
    ab, bc, ca = middle.T
    split = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=-1)
    return np.concatenate([vertices, vertices[edges].mean(axis=1)]), split.reshape(-1, 3)
