"""The compiled assembly of linear finite elements on triangles, and passes over a stiffness.

A stiffness here is in compressed rows with sorted columns, a diagonal entry in every row, and an
entry for every edge, be its weight zero. Rows and columns are int32, because they are half of a
sparse matrix's memory. Kernels write into arrays that NumPy has made: it asks the system for large
pages, and what Numba makes itself takes long to compile.
"""

import math

import numpy as np
from numba import types

from geodesic_toolkit._compiled import kernel
from geodesic_toolkit._pointers import pointer, prefetch, shifted
from geodesic_toolkit._typing import BoolArray, FloatArray, IndexArray, IntArray

__all__ = [
    "assemble",
    "components",
    "edge_lengths",
    "is_sound",
    "mean_edge_length",
    "measure_lengths",
    "measure_triangles",
    "obtuse_excess",
]

HELPERS = "05e4ccb5caf08178"
"""Digest of what else is compiled into the kernels: Numba looks at this file only."""

# One signature each, of arrays that are only read: those that may be written to fit as well.
FACES = types.Array(types.int64, 2, "C", readonly=True)
TABLE = types.Array(types.float64, 2, "C", readonly=True)
VALUES = types.Array(types.float64, 1, "C", readonly=True)
INDICES = types.Array(types.int32, 1, "C", readonly=True)
NUMBERS = types.int32[::1]  # that are written to
ROWS = (INDICES, INDICES, VALUES)

BROKEN = 1e-8
"""Part of a row's absolute sum from which on L 1 or L - Lᵀ is not zero."""

AHEAD = 8
"""Steps by which memory is asked for ahead, where it is visited in no order."""

GOLDEN = 0.6180339887498949
"""Multiples of it, without their whole parts, are as good as random."""


@kernel(
    types.Tuple((types.int64, types.float64, types.float64))(
        TABLE, FACES, types.float64[:, ::1], types.float64[::1]
    )
)
def measure_triangles(
    vertices: FloatArray, faces: IntArray, inverse_frames: FloatArray, areas: FloatArray
) -> tuple[int, float, float]:
    """Write inverse frames ``(p, q, r)`` and areas of triangles in space.

    As the functions of :mod:`geodesic_toolkit.geometry.triangles` do from positions.

    Returns
    -------
    proper : int
        Faces of three different vertices.
    total : float
        Sum of all edge lengths.
    slack : float
        The least by which two edges of a face are longer than the third, over its longest; 0 where
        a face is a single place.
    """
    proper, total, slack = 0, 0.0, math.inf
    for f in range(len(faces)):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        proper += (i != j) & (j != k) & (k != i)
        ux = vertices[j, 0] - vertices[i, 0]
        uy = vertices[j, 1] - vertices[i, 1]
        uz = vertices[j, 2] - vertices[i, 2]
        vx = vertices[k, 0] - vertices[i, 0]
        vy = vertices[k, 1] - vertices[i, 1]
        vz = vertices[k, 2] - vertices[i, 2]
        wx = vertices[k, 0] - vertices[j, 0]
        wy = vertices[k, 1] - vertices[j, 1]
        wz = vertices[k, 2] - vertices[j, 2]
        ij = math.sqrt(ux * ux + uy * uy + uz * uz)
        ik = math.sqrt(vx * vx + vy * vy + vz * vz)
        jk = math.sqrt(wx * wx + wy * wy + wz * wz)
        total += ij + ik + jk
        longest = max(ij, ik, jk)
        slack = min(slack, (ij + ik + jk - 2 * longest) / longest if longest > 0 else 0.0)
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        doubled = math.sqrt(x * x + y * y + z * z)
        along = (ux * vx + uy * vy + uz * vz) / ij
        inverse_frames[f, 0] = 1 / ij
        inverse_frames[f, 1] = -along / doubled
        inverse_frames[f, 2] = ij / doubled
        areas[f] = doubled / 2
    return proper, total, slack


@kernel(types.void(TABLE, types.float64[:, ::1], types.float64[::1]))
def measure_lengths(lengths: FloatArray, inverse_frames: FloatArray, areas: FloatArray) -> None:
    """Write inverse frames and areas of triangles with the edges opposite their corners, (F, 3).

    By the formulas of :func:`geodesic_toolkit.geometry.triangles.frames_from_lengths`.
    """
    for f in range(len(lengths)):
        jk, ki, ij = lengths[f, 0], lengths[f, 1], lengths[f, 2]
        along = (ij * ij + (ki - jk) * (ki + jk)) / (2 * ij)
        a, c = max(jk, ki, ij), min(jk, ki, ij)
        b = max(min(jk, ki), min(max(jk, ki), ij))
        product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
        doubled = math.sqrt(max(product, 0.0)) / 2
        inverse_frames[f, 0] = 1 / ij
        inverse_frames[f, 1] = -along / doubled
        inverse_frames[f, 2] = ij / doubled
        areas[f] = doubled / 2


@kernel(types.void(TABLE, types.float64[:, ::1]))
def edge_lengths(inverse_frames: FloatArray, lengths: FloatArray) -> None:
    """Write the (E, 3) edges opposite the corners of triangles."""
    for e in range(len(inverse_frames)):
        p, q, r = inverse_frames[e, 0], inverse_frames[e, 1], inverse_frames[e, 2]
        spanned, s = abs(p * r), q + r
        lengths[e, 0] = math.sqrt(p * p + s * s) / spanned
        lengths[e, 1] = math.sqrt(p * p + q * q) / spanned
        lengths[e, 2] = abs(r) / spanned


def assemble(
    elements: IntArray, inverse_frames: FloatArray, measure: FloatArray, n_vertices: int
) -> tuple[IndexArray, IndexArray, FloatArray, FloatArray, BoolArray]:
    """Return the stiffness of triangles, their barycentric mass, and the ends of boundary edges.

    Returns
    -------
    indptr, indices : ndarray of int32
    data : ndarray of float64
        L = Gᵀ W G in compressed rows, symmetric to the bit.
    thirds : ndarray of shape (N,), float64
        A third of the measure of the elements around each vertex.
    boundary : ndarray of shape (N,), bool
        Vertices of edges that one element has.
    """
    start, thirds = np.zeros(n_vertices + 1, dtype=np.int32), np.zeros(n_vertices)
    heads, weights = np.empty(3 * len(elements), dtype=np.int32), np.empty(3 * len(elements))
    room = np.empty(n_vertices, dtype=np.int32)
    _gather(elements, inverse_frames, measure, start, heads, weights, thirds, room)

    boundary, single = np.zeros(n_vertices, dtype=bool), np.empty(len(heads), dtype=bool)
    room[:] = 0
    _merge(start, heads, weights, single, boundary, room)

    n_entries = n_vertices + 2 * int(start[n_vertices])
    indptr, degree = np.zeros(n_vertices + 1, dtype=np.int32), np.zeros(n_vertices)
    indices, data = np.empty(n_entries, dtype=np.int32), np.empty(n_entries)
    _mirror(start, heads, weights, indptr, indices, data, degree, room)
    return indptr, indices, data, thirds, boundary


@kernel(
    types.void(
        FACES, TABLE, VALUES, NUMBERS, NUMBERS, types.float64[::1], types.float64[::1], NUMBERS
    )
)
def _gather(  # noqa: PLR0917 - kernels take no keywords
    elements: IntArray,
    inverse_frames: FloatArray,
    measure: FloatArray,
    start: IndexArray,
    heads: IndexArray,
    weights: FloatArray,
    thirds: FloatArray,
    free: IndexArray,
) -> None:
    """Gather the sides of all elements by their vertex of lower index, and the mass.

    Side s of vertex v, ``start[v] <= s < start[v + 1]``, goes to ``heads[s]`` and has the weight
    ``weights[s]``; those of a vertex are in the order of the elements. `start` and `thirds` are
    zero before.
    """
    for e in range(len(elements)):
        i, j, k = elements[e, 0], elements[e, 1], elements[e, 2]
        start[min(i, j) + 1] += i != j
        start[min(i, k) + 1] += i != k
        start[min(j, k) + 1] += j != k
    for v in range(len(free)):
        free[v] = start[v]
        start[v + 1] += start[v]
    for e in range(len(elements)):
        i, j, k = elements[e, 0], elements[e, 1], elements[e, 2]
        p, q, r = inverse_frames[e, 0], inverse_frames[e, 1], inverse_frames[e, 2]
        area, s, third = measure[e], q + r, measure[e] / 3
        thirds[i] += third
        thirds[j] += third
        thirds[k] += third
        for a, b, product in ((i, j, p * p + s * q), (i, k, s * r), (j, k, -(q * r))):
            if a != b:
                side = free[min(a, b)]
                heads[side], weights[side] = max(a, b), area * product
                free[min(a, b)] = side + 1


@kernel(types.void(NUMBERS, NUMBERS, types.float64[::1], *(types.boolean[::1],) * 2, NUMBERS))
def _merge(  # noqa: PLR0917 - kernels take no keywords
    start: IndexArray,
    heads: IndexArray,
    weights: FloatArray,
    single: BoolArray,
    boundary: BoolArray,
    edge_to: IndexArray,
) -> None:
    """Merge the sides of an edge in place, and mark the (N,) ends of edges of a single side.

    Sides are added in their order, so that an edge's weight is one sum of one order. `edge_to`, 0
    before, is the edge from v to a vertex, plus 1; of earlier vertices it is less.
    """
    count, begin = np.int32(0), start[0]
    for v in range(len(edge_to)):
        end, start[v] = start[v + 1], count
        for side in range(begin, end):
            head, weight = heads[side], weights[side]
            edge = edge_to[head] - 1
            new = edge < start[v]
            if new:
                edge = count
            heads[edge], single[edge] = head, new
            weights[edge] = weight if new else weights[edge] + weight
            edge_to[head] = edge + 1
            count += new
        for edge in range(start[v], count):
            boundary[v] |= single[edge]
            boundary[heads[edge]] |= single[edge]
        begin = end
    start[len(edge_to)] = count


@kernel(
    types.void(
        NUMBERS, NUMBERS, types.float64[::1], NUMBERS, NUMBERS, *(types.float64[::1],) * 2, NUMBERS
    )
)
def _mirror(  # noqa: PLR0917 - kernels take no keywords
    start: IndexArray,
    heads: IndexArray,
    weights: FloatArray,
    indptr: IndexArray,
    indices: IndexArray,
    data: FloatArray,
    degree: FloatArray,
    diagonal: IndexArray,
) -> None:
    """Write the graph Laplacian of edges that are stored at their vertex of lower index.

    Rows come out sorted without being sorted: the edges in the order of their lower ends fill what
    lies left of the diagonal, and then the rows in their order what lies right of it. `indptr` and
    `degree` are zero before; `start` is spoilt.
    """
    n_vertices = len(degree)
    for v in range(n_vertices):
        indptr[v + 1] += start[v + 1] - start[v] + 1
        for edge in range(start[v], start[v + 1]):
            indptr[heads[edge] + 1] += 1
            degree[v] += weights[edge]
            degree[heads[edge]] += weights[edge]
    for v in range(n_vertices):
        diagonal[v] = indptr[v]  # the next place left of it, until all are taken
        indptr[v + 1] += indptr[v]
    for v in range(n_vertices):
        for edge in range(start[v], start[v + 1]):
            place = diagonal[heads[edge]]
            indices[place], data[place] = v, -weights[edge]
            diagonal[heads[edge]] = place + 1
    free = start
    for v in range(n_vertices):
        indices[diagonal[v]], data[diagonal[v]] = v, degree[v]
        free[v] = diagonal[v] + 1
    for row in range(n_vertices):
        for left in range(indptr[row], diagonal[row]):
            place = free[indices[left]]
            indices[place], data[place] = row, data[left]
            free[indices[left]] = place + 1


@kernel(types.float64(TABLE, INDICES, INDICES))
def mean_edge_length(vertices: FloatArray, indptr: IndexArray, indices: IndexArray) -> float:
    """Return the mean length of the edges of a stiffness."""
    total, count = 0.0, 0
    for v in range(len(indptr) - 1):
        for entry in range(indptr[v], indptr[v + 1]):
            head = indices[entry]
            if head > v:
                x = vertices[head, 0] - vertices[v, 0]
                y = vertices[head, 1] - vertices[v, 1]
                z = vertices[head, 2] - vertices[v, 2]
                total += math.sqrt(x * x + y * y + z * z)
                count += 1
    return total / count


def obtuse_excess(
    indptr: IndexArray, indices: IndexArray, data: FloatArray, mass: FloatArray, rings: int
) -> FloatArray:
    """Return what :func:`geodesic_toolkit.positivity.obtuse_excess` does, for so many rings."""
    count = len(mass)
    mean = np.zeros(count)
    _average(indptr, indices, data, mass, rings, np.empty(2 * count), np.empty(2 * count), mean)
    return mean


@kernel(types.void(*ROWS, VALUES, types.int64, *(types.float64[::1],) * 3))
def _average(  # noqa: PLR0917 - kernels take no keywords
    indptr: IndexArray,
    indices: IndexArray,
    data: FloatArray,
    mass: FloatArray,
    rings: int,
    some: FloatArray,
    others: FloatArray,
    mean: FloatArray,
) -> None:
    """Write the excess of every vertex to `mean`, 0 before; `some` and `others` are to work in."""
    count = len(mass)
    begin, head, weight = pointer(indptr), pointer(indices), pointer(data)
    sums, wider = pointer(some), pointer(others)  # at 2 v those of vertex v, and its area
    for v in range(count):
        wrong, absolute = 0.0, 0.0
        for entry in range(begin[v], begin[v + 1]):
            if head[entry] != v:
                absolute += abs(weight[entry])
                wrong += max(weight[entry], 0.0)
        sums[2 * v] = wrong / absolute * mass[v] if absolute > 0 else 0.0
        sums[2 * v + 1] = mass[v]
    for _ in range(rings):
        for v in range(count):
            excess, area = 0.0, 0.0
            for entry in range(begin[v], begin[v + 1]):
                excess += sums[2 * head[entry]]
                area += sums[2 * head[entry] + 1]
            wider[2 * v], wider[2 * v + 1] = excess, area
        sums, wider = wider, sums
    for v in range(count):
        if sums[2 * v + 1] > 0:
            mean[v] = sums[2 * v] / sums[2 * v + 1]


def components(indptr: IndexArray, indices: IndexArray) -> IntArray:
    """Return the connected component of every vertex, numbered by their first vertices."""
    labels = np.full(len(indptr) - 1, -1)
    _label(indptr, indices, labels, np.empty_like(labels))
    return labels


@kernel(types.void(INDICES, INDICES, *(types.int64[::1],) * 2))
def _label(indptr: IndexArray, indices: IndexArray, labels: IntArray, waiting: IntArray) -> None:
    """Write the components to `labels`, -1 before; `waiting` is as long."""
    label = 0
    for seed in range(len(labels)):
        if labels[seed] >= 0:
            continue
        labels[seed], waiting[0] = label, seed
        done, known = 0, 1
        while done < known:
            prefetch(shifted(pointer(indptr), waiting[min(done + 2 * AHEAD, known - 1)]))
            soon = indptr[waiting[min(done + AHEAD, known - 1)]]
            prefetch(shifted(pointer(indices), np.int64(soon)))
            v = waiting[done]
            done += 1
            for entry in range(indptr[v], indptr[v + 1]):
                head = indices[entry]
                if labels[head] < 0:
                    labels[head], waiting[known] = label, head
                    known += 1
        label += 1


def is_sound(indptr: IndexArray, indices: IndexArray, data: FloatArray) -> bool:
    """Return whether a matrix is finite, symmetric, kills constants and has no negative diagonal.

    Symmetry is checked on one vector without a pattern, which L and Lᵀ take to the same.
    """
    count = len(indptr) - 1
    return _balanced(indptr, indices, data, np.zeros(count), np.zeros(count))


@kernel(types.boolean(*ROWS, *(types.float64[::1],) * 2))
def _balanced(
    indptr: IndexArray, indices: IndexArray, data: FloatArray, skew: FloatArray, scale: FloatArray
) -> bool:
    """Do so; what comes last are zeros, (N,)."""
    count = len(skew)
    for v in range(count):
        at_v = v * GOLDEN % 1.0
        total = 0.0
        for entry in range(indptr[v], indptr[v + 1]):
            head, value = indices[entry], data[entry]
            if head == v and value < 0:
                return False
            total += value
            scale[v] += abs(value)
            skew[v] += value * (head * GOLDEN % 1.0)
            skew[head] -= value * at_v
        if not abs(total) <= BROKEN * scale[v] < math.inf:
            return False
    symmetric = True
    for v in range(count):
        symmetric &= abs(skew[v]) <= BROKEN * scale[v]
    return symmetric
