"""The compiled assembly of linear finite elements on triangles, and passes over a stiffness.

A stiffness here is in compressed rows with sorted columns, a diagonal entry in every row, and an
entry for every edge, be its weight zero. Rows and columns are int32, because they are half of a
sparse matrix's memory. Kernels write into arrays that NumPy has made: it asks the system for large
pages, and what Numba makes itself takes long to compile.
"""

import math
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from geodesic_toolkit._compiled import kernel
from geodesic_toolkit._pointers import pointer, prefetch, shifted
from geodesic_toolkit._sides import SIDES, Sides
from geodesic_toolkit._typing import BoolArray, FloatArray, IndexArray, IntArray

__all__ = [
    "components",
    "edge_lengths",
    "edge_sums",
    "is_sound",
    "mean_edge_length",
    "measure_lengths",
    "measure_triangles",
    "mirrored",
    "obtuse_excess",
]

HELPERS = "9c48fa060695d630"
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

AHEAD = 16
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


def edge_sums(
    elements: IntArray, sides: Sides, inverse_frames: FloatArray, measure: FloatArray
) -> tuple[IndexArray, IndexArray, FloatArray, FloatArray, BoolArray]:
    """Return what lies right of the diagonal of the stiffness of triangles, mass, and boundary.

    Returns
    -------
    indptr, indices : ndarray of int32
    data : ndarray of float64
        The strict upper triangle of L = Gᵀ W G in compressed rows, in no order within them.
    thirds : ndarray of shape (N,), float64
        A third of the measure of the elements around each vertex.
    boundary : ndarray of shape (N,), bool
        Vertices of edges that one element has.
    """
    n_vertices, n_sides = len(sides.starts) - 1, len(sides.halves)
    thirds, entries = np.zeros(n_vertices), np.empty(n_sides)
    _weigh(elements, inverse_frames, measure, entries, thirds)
    indptr, boundary = np.empty(n_vertices + 1, dtype=np.int32), np.zeros(n_vertices, dtype=bool)
    indices, data = np.empty(n_sides, dtype=np.int32), np.empty(n_sides)
    single, room = np.empty(n_sides, dtype=np.int8), np.zeros(n_vertices, dtype=np.int32)
    _merge(sides.starts, sides.halves, entries, single, room, indptr, indices, data, boundary)
    n_edges = int(indptr[-1])
    return indptr, indices[:n_edges], data[:n_edges], thirds, boundary


@kernel(types.void(FACES, TABLE, VALUES, *(types.float64[::1],) * 2))
def _weigh(
    elements: IntArray,
    inverse_frames: FloatArray,
    measure: FloatArray,
    entries: FloatArray,
    thirds: FloatArray,
) -> None:
    """Write the stiffness of each half-edge, and add the mass to `thirds`, zero before."""
    for e in range(len(elements)):
        p, q, r = inverse_frames[e, 0], inverse_frames[e, 1], inverse_frames[e, 2]
        area, s, third = measure[e], q + r, measure[e] / 3
        entries[3 * e] = area * (q * r)
        entries[3 * e + 1] = -(area * (s * r))
        entries[3 * e + 2] = -(area * (p * p + s * q))
        for c in range(3):
            thirds[elements[e, c]] += third


@kernel(
    types.void(
        INDICES, SIDES, VALUES, types.int8[::1], *(NUMBERS,) * 3, types.float64[::1],
        types.boolean[::1],
    )
)  # fmt: skip
def _merge(  # noqa: PLR0917 - kernels take no keywords
    starts: IndexArray,
    halves: NDArray[Any],
    entries: FloatArray,
    single: NDArray[np.int8],
    edge_to: IndexArray,
    indptr: IndexArray,
    indices: IndexArray,
    data: FloatArray,
    boundary: BoolArray,
) -> None:
    """Add up the sides of each edge, and mark the (N,) ends of edges of a single side.

    Sides are added in their order, so that an edge's weight is one sum of one order. `edge_to`, 0
    before, is the edge from v to a vertex, plus 1; of earlier vertices it is less.
    """
    count, last = np.int64(0), len(halves) - 1
    start, entry, begin, head_of = (
        pointer(starts),
        pointer(entries),
        pointer(indptr),
        pointer(indices),
    )
    sum_of, alone, known = pointer(data), pointer(single), pointer(edge_to)
    for v in range(len(edge_to)):
        begin[v], old = count, count
        for side in range(start[v], start[v + 1]):
            head, signed = halves[side].head, halves[side].half
            soon = halves[min(side + AHEAD, last)].half
            prefetch(shifted(entry, np.int64(max(soon, ~soon))))
            value = entry[max(signed, ~signed)]
            if head == v:  # from a vertex to itself
                continue
            edge = known[head] - 1
            if edge < old:
                head_of[count], alone[count], sum_of[count] = head, 1, value
                count += 1
                known[head] = count
            else:
                alone[edge] = 0
                sum_of[edge] += value
        for edge in range(old, count):
            boundary[v] |= alone[edge] != 0
            boundary[head_of[edge]] |= alone[edge] != 0
    begin[len(edge_to)] = count


def mirrored(
    indptr: IndexArray, indices: IndexArray, data: FloatArray
) -> tuple[IndexArray, IndexArray, FloatArray]:
    """Return a stiffness from what lies right of its diagonal: symmetric to the bit, L 1 = 0."""
    n_vertices = len(indptr) - 1
    n_entries = n_vertices + 2 * len(indices)
    starts, diagonal = np.zeros_like(indptr), np.zeros(n_vertices)
    columns, entries = np.empty(n_entries, dtype=np.int32), np.empty(n_entries)
    room = np.empty((2, n_vertices), dtype=np.int32)
    _mirror(indptr, indices, data, starts, columns, entries, diagonal, room)
    return starts, columns, entries


@kernel(types.void(*ROWS, NUMBERS, NUMBERS, *(types.float64[::1],) * 2, types.int32[:, ::1]))
def _mirror(  # noqa: PLR0917 - kernels take no keywords
    indptr: IndexArray,
    indices: IndexArray,
    data: FloatArray,
    starts: IndexArray,
    columns: IndexArray,
    entries: FloatArray,
    diagonal: FloatArray,
    room: IndexArray,
) -> None:
    """Write both triangles and the diagonal.

    Rows come out sorted without being sorted: the edges in the order of their lower ends fill what
    lies left of the diagonal, and then the rows in their order what lies right of it. `starts` and
    `diagonal` are zero before.
    """
    n_vertices = len(diagonal)
    begin, head, weight = pointer(indptr), pointer(indices), pointer(data)
    start, column, entry, degree = (
        pointer(starts),
        pointer(columns),
        pointer(entries),
        pointer(diagonal),
    )
    middle, free = pointer(room[0]), pointer(room[1])
    for v in range(n_vertices):
        start[v + 1] += begin[v + 1] - begin[v] + 1
        for edge in range(begin[v], begin[v + 1]):
            start[head[edge] + 1] += 1
            degree[v] -= weight[edge]
            degree[head[edge]] -= weight[edge]
    for v in range(n_vertices):
        middle[v] = start[v]  # the next place left of it, until all are taken
        start[v + 1] += start[v]
    for v in range(n_vertices):
        for edge in range(begin[v], begin[v + 1]):
            place = middle[head[edge]]
            column[place], entry[place] = v, weight[edge]
            middle[head[edge]] = place + 1
    for v in range(n_vertices):
        column[middle[v]], entry[middle[v]] = v, degree[v]
        free[v] = middle[v] + 1
    for row in range(n_vertices):
        for left in range(start[row], middle[row]):
            place = free[column[left]]
            column[place], entry[place] = row, entry[left]
            free[column[left]] = place + 1


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
    _average(indptr, indices, data, mass, rings, np.zeros(2 * count), np.empty(2 * count), mean)
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
    """Write the excess of every vertex to `mean`; that and `some` are 0 before, `others` is room.

    Of the stiffness only what lies right of the diagonal is looked at.
    """
    count = len(mass)
    begin, head, weight = pointer(indptr), pointer(indices), pointer(data)
    sums, wider = pointer(some), pointer(others)  # at 2 v those of vertex v, and its area
    for v in range(count):
        for entry in range(begin[v], begin[v + 1]):
            if head[entry] > v:
                for end in (v, np.int64(head[entry])):
                    sums[2 * end] += max(weight[entry], 0.0)
                    sums[2 * end + 1] += abs(weight[entry])
    for v in range(count):
        absolute = sums[2 * v + 1]
        sums[2 * v] = sums[2 * v] / absolute * mass[v] if absolute > 0 else 0.0
        sums[2 * v + 1] = mass[v]
    for _ in range(rings):
        for place in range(2 * count):
            wider[place] = sums[place]
        for v in range(count):
            excess, area = wider[2 * v], wider[2 * v + 1]
            for entry in range(begin[v], begin[v + 1]):
                if head[entry] > v:
                    other = 2 * np.int64(head[entry])
                    excess += sums[other]
                    area += sums[other + 1]
                    wider[other] += sums[2 * v]
                    wider[other + 1] += sums[2 * v + 1]
            wider[2 * v], wider[2 * v + 1] = excess, area
        sums, wider = wider, sums
    for v in range(count):
        if sums[2 * v + 1] > 0:
            mean[v] = sums[2 * v] / sums[2 * v + 1]


def components(indptr: IndexArray, indices: IndexArray) -> IntArray:
    """Return the connected component of every vertex, numbered by their first vertices.

    Edges that are entries right of the diagonal are enough.
    """
    labels = np.empty(len(indptr) - 1, dtype=np.int64)
    _label(indptr, indices, labels)
    return labels


@kernel(types.void(INDICES, INDICES, types.int64[::1]))
def _label(indptr: IndexArray, indices: IndexArray, labels: IntArray) -> None:
    """Write the components to `labels`, by union and find.

    Until the end they are vertices: each names an earlier one of its component, the first itself.
    """
    first = pointer(labels)
    for v in range(len(labels)):
        first[v] = v
    for v in range(len(labels)):
        for entry in range(indptr[v], indptr[v + 1]):
            one, other = v, np.int64(indices[entry])
            while first[one] != one:
                first[one] = first[first[one]]
                one = first[one]
            while first[other] != other:
                first[other] = first[first[other]]
                other = first[other]
            first[max(one, other)] = min(one, other)
    count = 0
    for v in range(len(labels)):
        if first[v] == v:
            first[v] = count
            count += 1
        else:
            first[v] = first[first[v]]


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
