"""Readable forms of the compiled kernels, in NumPy, SciPy and libigl, to compare them with.

Each takes and returns what the kernel of its name in ``geodesic_toolkit._native`` does.
"""

import igl
import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array, triu
from scipy.sparse.csgraph import connected_components

from geodesic_toolkit.geometry.triangles import (
    face_areas,
    face_edge_lengths,
    frames_from_lengths,
    frames_from_positions,
    hat_gradients_from_inverse,
    inverse_frames,
)

NAMES = (
    "components",
    "components_of_edges",
    "edge_lengths",
    "edge_sums",
    "fill",
    "flip_edges",
    "is_sound",
    "mean_edge_length",
    "measure_lengths",
    "measure_triangles",
    "proper_faces",
    "mirrored",
    "obtuse_excess",
    "poisson_load",
    "sorted_half_edges",
)


def square(indptr, indices, data=None):
    data = np.ones(len(indices)) if data is None else data
    return csr_array((data, indices, indptr), shape=(len(indptr) - 1, len(indptr) - 1))


def rows_of(matrix):
    matrix = csr_array(matrix)
    return matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32), matrix.data


# -- matrices ----------------------------------------------------------------------------------


def components(indptr, indices):
    return connected_components(square(indptr, indices), directed=False)[1].astype(np.int64)


def components_of_edges(edges, n_vertices):
    entries = (np.ones(len(edges)), tuple(edges.T))
    return components(*rows_of(coo_array(entries, shape=(n_vertices, n_vertices)))[:2])


def is_sound(indptr, indices, data):
    matrix = square(indptr, indices, data).toarray()
    if not np.isfinite(matrix).all() or (matrix.diagonal() < 0).any():
        return False
    scale = 1e-8 * np.abs(matrix).sum(axis=1)
    skew = np.abs(matrix - matrix.T).max(axis=1, initial=0.0)
    return bool((np.abs(matrix.sum(axis=1)) <= scale).all() and (skew <= scale).all())


def whole(indptr, indices, data):
    """Return both sides of the diagonal, of a matrix of which one is enough."""
    upper = triu(square(indptr, indices, data), 1)
    return csr_array(upper + upper.T)


def obtuse_excess(indptr, indices, data, mass, rings):
    weights = whole(indptr, indices, data).toarray()
    absolute = np.abs(weights).sum(axis=1)
    wrong = np.maximum(weights, 0).sum(axis=1)
    share = np.divide(wrong, absolute, out=np.zeros_like(wrong), where=absolute > 0)
    disk = whole(indptr, indices, np.ones(len(data))).toarray() + np.eye(len(mass))
    excess, area = share * mass, mass
    for _ in range(rings):
        excess, area = disk @ excess, disk @ area
    return np.divide(excess, area, out=np.zeros_like(area), where=area > 0)


def fill(indptr, indices, data, solution, rows):
    matrix = square(indptr, indices, data).toarray()
    waiting = set(rows.tolist())
    while waiting:
        found = {}
        for row in waiting:
            weight = np.abs(matrix[row]) * (np.arange(len(matrix)) != row)
            known = (solution > 0) & (weight > 0)
            if known.any():
                total = abs(matrix[row].sum()) + weight.sum()
                found[row] = (weight * solution)[known].sum() / total
        if not found:
            return
        for row, value in found.items():
            solution[row] = value
        waiting -= found.keys()


# -- triangles ---------------------------------------------------------------------------------


def proper_faces(faces, n_vertices):
    seen, proper = set(), []
    for face in faces.tolist():
        vertices = frozenset(face)
        proper.append(len(vertices) == 3 and vertices not in seen)
        seen.add(vertices)
    return np.array(proper, dtype=np.bool_)


def measure_triangles(vertices, faces):
    with np.errstate(all="ignore"):
        frames, lengths = frames_from_positions(vertices, faces), face_edge_lengths(vertices, faces)
        longest = lengths.max(axis=1)
        slack = np.where(longest > 0, (lengths.sum(axis=1) - 2 * longest) / longest, 0.0)
        inverse = inverse_frames(frames)
    return inverse, face_areas(frames), float(lengths.sum()), slack.min(initial=np.inf)


def measure_lengths(lengths):
    frames = frames_from_lengths(lengths)
    return inverse_frames(frames), face_areas(frames)


def edge_lengths(frames):
    length, height = 1 / frames[:, 0], 1 / frames[:, 2]
    along = -frames[:, 1] * length * height
    return np.column_stack([np.hypot(length - along, height), np.hypot(along, height), length])


class HalfEdges:
    def __init__(self, faces, n_vertices):
        self.faces, self.n_vertices = faces, n_vertices

    def twins(self):
        tails, heads = self.faces[:, [1, 2, 0]].ravel(), self.faces[:, [2, 0, 1]].ravel()
        edges = {}
        for half, ends in enumerate(zip(tails.tolist(), heads.tolist(), strict=True)):
            edges.setdefault(frozenset(ends), []).append(half)
        twin, coherent = np.full(self.faces.size, -1), True
        for halves in edges.values():
            if len(halves) == 2:
                one, other = halves
                twin[one], twin[other] = other, one
                coherent &= bool(tails[one] != tails[other])
        return twin, coherent


def sorted_half_edges(faces, n_vertices):
    return HalfEdges(faces, n_vertices)


def edge_sums(faces, sides, frames, measure):
    n = sides.n_vertices
    gradients = hat_gradients_from_inverse(frames)
    pairs = [(1, 2), (2, 0), (0, 1)]
    entries = np.concatenate(
        [measure * np.einsum("ed,ed->e", *(gradients[:, :, i] for i in pair)) for pair in pairs]
    )
    tails, heads = (np.concatenate([faces[:, pair[k]] for pair in pairs]) for k in (0, 1))
    apart = tails != heads
    ends = np.sort(np.column_stack([tails, heads])[apart], axis=1)
    shape = (n, n)
    upper = csr_array(coo_array((entries[apart], tuple(ends.T)), shape=shape))
    counts = coo_array(csr_array(coo_array((np.ones(len(ends)), tuple(ends.T)), shape=shape)))
    boundary = np.zeros(n, dtype=bool)
    boundary[np.column_stack(counts.coords)[counts.data == 1]] = True
    lumped_mass = np.bincount(faces.ravel(), np.repeat(measure / 3, 3), n)
    return rows_of(upper), lumped_mass, boundary


def mirrored(indptr, indices, data):
    n = len(indptr) - 1
    pattern = whole(indptr, indices, np.ones(len(data))) + diags_array(np.ones(n))
    dense = whole(indptr, indices, data).toarray()
    dense -= np.diag(dense.sum(axis=1))
    rows, columns = coo_array(csr_array(pattern)).coords
    return rows_of(csr_array((dense[rows, columns], pattern.indices, pattern.indptr)))


def mean_edge_length(vertices, indptr, indices):
    rows, columns = coo_array(triu(square(indptr, indices), 1)).coords
    return float(np.linalg.norm(vertices[rows] - vertices[columns], axis=1).mean())


def flip_edges(faces, lengths, twin, held):
    assert not held.any()
    flipped_lengths, flipped_faces, *_, sides = igl.intrinsic_delaunay_triangulation(lengths, faces)
    flips = int((flipped_faces != faces).any(axis=1).sum())
    faces[:], lengths[:] = flipped_faces, flipped_lengths
    twin[:] = -1
    for pair in sides:  # half-edges, all of the first corners before those of the second
        if len(pair) == 2:
            one, other = (3 * (side % len(faces)) + side // len(faces) for side in pair)
            twin[one], twin[other] = other, one
    return flips


# -- the Poisson step --------------------------------------------------------------------------


def poisson_load(faces, frames, measure, heat, logarithmic):
    if not logarithmic:
        heat = np.log(heat, out=np.full(heat.shape, -np.inf), where=~(heat <= 0))
    columns = heat.reshape(len(heat), -1)
    load = np.zeros_like(columns)
    gradients = hat_gradients_from_inverse(frames)
    for k, column in enumerate(columns.T):
        corners = column[faces]
        largest = corners.max(axis=1, keepdims=True)
        scaled = np.exp(corners - np.where(largest > -np.inf, largest, 0.0))
        gradient = np.einsum("edc,ec->ed", gradients[:, :, 1:], scaled[:, 1:] - scaled[:, :1])
        size = np.linalg.norm(gradient, axis=1)
        unit = np.divide(gradient, size[:, None], out=gradient, where=size[:, None] > 0)
        pull = -np.einsum("e,edc,ed->ec", measure, gradients, unit)
        np.add.at(load[:, k], faces, pull)
    return load.reshape(heat.shape)
