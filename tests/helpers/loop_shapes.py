"""Shapes with handles and holes, and classes of the loops on them."""

from itertools import pairwise

import numpy as np

import geodesic_toolkit as gt


def polygon(n, radius):
    """Circumference of the regular polygon with n corners on a circle."""
    return 2 * n * radius * np.sin(np.pi / n)


def tilted_cylinder(radius=1.0, height=6.0, rings=25, around=40):
    """A cylinder without lids, whose rings are turned against each other at random."""
    rng = np.random.default_rng(0)
    turns = rng.uniform(0, 2 * np.pi / around, rings)
    angle = 2 * np.pi * np.arange(around) / around + turns[:, None]
    up = np.repeat(np.linspace(0, height, rings), around)
    places = np.column_stack([radius * np.cos(angle).ravel(), radius * np.sin(angle).ravel(), up])
    cell = np.arange(rings * around).reshape(rings, around)
    low, high = cell[:-1], cell[1:]
    faces = np.concatenate(
        [
            np.stack([low, np.roll(low, -1, 1), high], -1).reshape(-1, 3),
            np.stack([np.roll(low, -1, 1), np.roll(high, -1, 1), high], -1).reshape(-1, 3),
        ]
    )
    return gt.TriangleMesh(places, faces), cell


def pretzel(holes=3, size=7):
    """A block with square holes through it, all faces squares cut in two: genus `holes`."""
    solid = np.ones((size * holes + 1, size + 2, 3), dtype=bool)
    for hole in range(holes):
        begin = hole * size + 2
        solid[begin : begin + size - 3, 3 : size - 1] = False
    return surface_of(solid)


def surface_of(solid):
    """The surface of unit cubes, all squares cut in two, and the vertex at each corner."""
    corners, quads = {}, []
    padded = np.pad(solid, 1)
    for place in np.argwhere(padded).tolist():
        for axis in range(3):
            for side in (0, 1):
                beside = list(place)
                beside[axis] += 2 * side - 1
                if padded[tuple(beside)]:
                    continue
                one, other = (axis + 1) % 3, (axis + 2) % 3
                quad = []
                for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    corner = list(place)
                    corner[axis] += side
                    corner[one] += u
                    corner[other] += v
                    quad.append(corners.setdefault(tuple(corner), len(corners)))
                quads.append(quad if side else quad[::-1])
    quads = np.array(quads)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return gt.TriangleMesh(np.array(list(corners), dtype=float), faces), corners


def subdivided(mesh):
    """The same surface, each face cut in four."""
    edges = np.sort(mesh.faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    edges, middle = np.unique(edges, axis=0, return_inverse=True)
    middle = middle.reshape(-1, 3) + mesh.n_vertices
    a, b, c = mesh.faces.T
    ab, bc, ca = middle.T
    faces = np.vstack(
        [np.column_stack(rows) for rows in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    )
    return gt.TriangleMesh(np.vstack([mesh.vertices, mesh.vertices[edges].mean(axis=1)]), faces)


class Homology:
    """Cycles of edges modulo 2, and modulo the boundaries of faces."""

    def __init__(self, faces):
        self._edges = {}
        self._pivots = {}
        for i, j, k in faces.tolist():
            row = self._reduced(self._bit(i, j) ^ self._bit(j, k) ^ self._bit(k, i))
            if row:
                self._pivots[row.bit_length()] = row

    def _bit(self, i, j):
        return 1 << self._edges.setdefault((min(i, j), max(i, j)), len(self._edges))

    def _reduced(self, row):
        for length in sorted(self._pivots, reverse=True):
            if row >> (length - 1) & 1:
                row ^= self._pivots[length]
        return row

    def bounds(self, cycle):
        """True if a closed chain of vertices is the boundary of some faces."""
        row = 0
        for i, j in pairwise([*cycle, cycle[0]]):
            row ^= self._bit(i, j) if i != j else 0
        return self._reduced(row) == 0

    @property
    def rank(self):
        """Number of independent classes."""
        edges = np.array(list(self._edges))
        used, ends = np.unique(edges, return_inverse=True)
        ends = ends.reshape(-1, 2)
        parts = np.arange(len(used))
        while (parts[ends[:, 0]] != parts[ends[:, 1]]).any():
            np.minimum.at(parts, ends[:, 0], parts[ends[:, 1]])
            np.minimum.at(parts, ends[:, 1], parts[ends[:, 0]])
        return len(edges) - len(used) + len(np.unique(parts)) - len(self._pivots)


def along_edges(path):
    """The vertices of a chain of edges beside a path, of the same class."""
    corners = (path.barycentric > 1e-9).argmax(axis=1)
    return path.mesh.faces[path.faces, corners].tolist()
