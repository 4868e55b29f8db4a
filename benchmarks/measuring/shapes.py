"""The meshes: real ones of the shared data set, or spheres of the same sizes."""

from pathlib import Path

import numpy as np

import geodesic_toolkit as gt

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"

REAL = {
    "3.5k": ("igltut__bunny.off", 0, "bunny"),
    "35k": ("jacobson__stanford-bunny.obj", 0, "Stanford bunny"),
    "173k": ("igltut__armadillo.obj", 1, "armadillo, subdivided once"),
    "557k": ("jacobson__stanford-bunny.obj", 2, "Stanford bunny, subdivided twice"),
}
"""By size: the file, how often every triangle is split in four, and what to call it."""

Arrays = tuple[np.ndarray, np.ndarray]


def mesh_of_size(size: str, *, generated: bool) -> tuple[str, Arrays] | None:
    """Return the name and arrays of a mesh, or None and why where its file is not there."""
    if generated or size not in REAL:
        vertices, faces = sphere(count(size))
        return "sphere", (vertices, faces)
    file, times, name = REAL[size]
    if not (DATA / file).exists():
        print(f"{size}: {DATA / file} is not there; --generated takes a sphere instead")
        return None
    import trimesh

    mesh = gt.read(DATA / file)
    vertices, faces = referenced(np.array(mesh.vertices), np.array(mesh.faces))
    for _ in range(times):
        vertices, faces = trimesh.remesh.subdivide(vertices, faces)
    return name, (np.ascontiguousarray(vertices), np.ascontiguousarray(faces, dtype=np.int64))


def referenced(vertices: np.ndarray, faces: np.ndarray) -> Arrays:
    """Return the mesh without vertices of no face: the other libraries fail on them."""
    used, renumbered = np.unique(faces, return_inverse=True)
    return vertices[used], renumbered.reshape(-1, 3)


def count(size: str) -> int:
    """Return the number that "35k" or "5M" stands for."""
    units = {"k": 1e3, "M": 1e6}
    return round(float(size.rstrip("kM")) * units.get(size[-1], 1))


def sphere(n_vertices: int) -> Arrays:
    """Return a unit sphere of nearly `n_vertices`: triangles of an icosahedron, each divided.

    Every edge of the icosahedron is divided into the same number of parts, which gives
    ``10 parts**2 + 2`` vertices. Vertex 0 has its antipode among them.
    """
    corners, sides = gt.testing.shapes.icosphere(0).vertices, gt.testing.shapes.icosphere(0).faces
    parts = max(round(((n_vertices - 2) / 10) ** 0.5), 1)
    edges = np.unique(np.sort(sides[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    number_of = {(a, b): k for k, (a, b) in enumerate(edges.tolist())}
    steps = np.arange(1, parts)
    i, j = (axis.ravel() for axis in np.meshgrid(steps, steps, indexing="ij"))
    i, j = i[i + j < parts], j[i + j < parts]
    inside = len(i)
    start = len(corners) + len(edges) * len(steps)
    ends = corners[edges][:, :, None] * np.stack([parts - steps, steps])[None, :, :, None]
    vertices = [corners, ends.sum(axis=1).reshape(-1, 3)]
    faces = []
    for k, side in enumerate(sides.tolist()):
        place = np.full((parts + 1, parts + 1), -1)  # of i steps from a to b, and j from a to c
        place[0, 0], place[parts, 0], place[0, parts] = side
        place[i, j] = start + k * inside + np.arange(inside)
        place[steps, 0] = _along(side[0], side[1], number_of, len(corners), parts)
        place[0, steps] = _along(side[0], side[2], number_of, len(corners), parts)
        place[parts - steps, steps] = _along(side[1], side[2], number_of, len(corners), parts)
        vertices.append(np.column_stack([parts - i - j, i, j]) @ corners[side])
        up = np.stack([place[:-1, :-1], place[1:, :-1], place[:-1, 1:]], axis=-1)
        down = np.stack([place[1:, :-1], place[1:, 1:], place[:-1, 1:]], axis=-1)
        cells = np.concatenate([up.reshape(-1, 3), down.reshape(-1, 3)])
        faces.append(cells[(cells >= 0).all(axis=1)])
    points = np.concatenate(vertices)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return points, np.concatenate(faces)


def _along(
    a: int, b: int, number_of: dict[tuple[int, int], int], n_corners: int, parts: int
) -> np.ndarray:
    """Return the vertices between the corners `a` and `b`, from a on."""
    number = n_corners + number_of[min(a, b), max(a, b)] * (parts - 1) + np.arange(parts - 1)
    return number if a < b else number[::-1]


def sphere_cloud(n_points: int) -> np.ndarray:
    """Return points drawn at random from the unit sphere."""
    points = np.random.default_rng(0).standard_normal((n_points, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)
