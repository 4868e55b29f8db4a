"""Errors, CPU time and memory of distances inside solids, beside LaPy and scikit-fmm.

``python benchmarks/volumes.py`` prints the tables of docs/volumes.md, a process for each row; it
needs geodesic-toolkit-volume, and leaves out the peers that are not installed. With a file of
tetrahedra it prints instead how its distances change when cells are subdivided.
"""

import resource
import subprocess
import sys
import time

import numpy as np

import geodesic_toolkit as gt
from geodesic_toolkit_volume import TetMesh, VoxelImage
from geodesic_toolkit_volume.samples import box, subdivided

RADIUS = 0.4
"""Radius of the cavity of the shell, of the hole of the slab, and of the obstacle among voxels."""


def ball(n):
    """Return a ball of n vertices along its diameter, with the centre, and exact distances."""
    vertices, cells = box((n, n, n))
    cube = vertices / (n - 1) * 2 - 1
    length = np.linalg.norm(cube, axis=1)
    scale = np.abs(cube).max(axis=1) / np.where(length > 0, length, 1)
    places = cube * scale[:, None]
    source = int(np.linalg.norm(places - [0.5, 0.3, 0.2], axis=1).argmin())
    return TetMesh(places, cells), source, np.linalg.norm(places - places[source], axis=1)


def merged(vertices, cells):
    """Return a mesh in which equal vertices are one."""
    _, first, number = np.unique(vertices.round(9), axis=0, return_index=True, return_inverse=True)
    return TetMesh(vertices[first], number.ravel()[cells])


def shell(n):
    """Return a shell around a cavity, from a source at its outer side."""
    parts, cells, count = [], [], 0
    vertices, own = box((n, n, n // 2))
    x, y, z = (vertices / [n - 1, n - 1, n // 2 - 1]).T
    face = np.tan((np.column_stack([x, y]) - 0.5) * np.pi / 2)
    cube = np.column_stack([face, np.ones(len(face))])
    places = cube / np.linalg.norm(cube, axis=1)[:, None] * (RADIUS + (1 - RADIUS) * z)[:, None]
    for axis in range(3):
        for sign in (1, -1):
            parts.append(np.roll(places * sign, axis, axis=1))
            cells.append(own + count)
            count += len(places)
    mesh = merged(np.concatenate(parts), np.concatenate(cells))
    source = int(np.linalg.norm(mesh.vertices - [0, 0, 1], axis=1).argmin())
    return mesh, source, around_ball(mesh.vertices[source], mesh.vertices)


def slab(n):
    """Return a square slab with a round hole through it, from a source beside the hole."""
    vertices, cells = box((4 * n + 1, n, max(n // 4, 3)))
    angle, out, up = (vertices / vertices.max(axis=0)).T
    angle = angle * 2 * np.pi
    rim = 1 / np.maximum(np.abs(np.cos(angle)), np.abs(np.sin(angle)))
    radius = RADIUS + (rim - RADIUS) * out
    mesh = merged(
        np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 0.3 * up]), cells
    )
    source = int(np.linalg.norm(mesh.vertices - [-0.8, 0, 0], axis=1).argmin())
    flat = mesh.vertices * [1, 1, 0]
    across = around_ball(flat[source], flat)
    return mesh, source, np.hypot(across, mesh.vertices[:, 2] - mesh.vertices[source, 2])


def around_ball(start, ends, radius=RADIUS):
    """Return the shortest distances from a point around a ball, or a disk, at the origin."""
    steps = ends - start
    squared = np.maximum((steps**2).sum(axis=1), 1e-300)
    share = np.clip(-(steps @ start) / squared, 0, 1)
    near = np.linalg.norm(start + share[:, None] * steps, axis=1)
    a, b = np.linalg.norm(start), np.maximum(np.linalg.norm(ends, axis=1), 1e-300)
    angle = np.arccos(np.clip(ends @ start / (a * b), -1, 1))
    arc = angle - np.arccos(min(radius / a, 1)) - np.arccos(np.minimum(radius / b, 1))
    tangents = np.sqrt(max(a * a - radius**2, 0)) + np.sqrt(np.maximum(b * b - radius**2, 0))
    straight = np.sqrt((steps**2).sum(axis=1))
    return np.where(near >= radius * (1 - 1e-9), straight, tangents + radius * np.maximum(arc, 0))


SOLIDS = {"ball": ball, "shell": shell, "slab": slab}
SIZES = {"ball": (14, 27, 54), "shell": (9, 19, 37), "slab": (11, 27, 53)}


def voxels(kind, n):
    """Return an image of n voxels along each side, its source, and exact distances."""
    index = np.indices((n, n, n)).reshape(3, -1).T
    image, places = None, (index + 0.5) / n * 2 - 1
    source = int(np.linalg.norm(places - [-0.8, 0.1, 0.05], axis=1).argmin())
    straight = np.linalg.norm(places - places[source], axis=1)
    if kind == "box":
        image = VoxelImage(np.ones((n, n, n), dtype=bool), [2 / n] * 3)
        return image, source, straight
    if kind == "obstacle":
        free = np.linalg.norm(places, axis=1) >= RADIUS
        image = VoxelImage(free.reshape(n, n, n), [2 / n] * 3)
        return image, source, np.where(free, around_ball(places[source], places), np.inf)
    speed = 1.5 + places[:, 0]  # rays are circles
    image = VoxelImage(np.ones((n, n, n), dtype=bool), [2 / n] * 3, (1 / speed).reshape(n, n, n))
    return image, source, np.arccosh(1 + straight**2 / (2 * speed * speed[source]))


def fronts(shape, source):
    solver = gt.GeodesicSolver(shape)
    yield
    yield solver.distance(source)


def heat(shape, source):
    solver = gt.GeodesicSolver(shape, refine=False)
    yield
    yield solver.distance(source)


def lapy(shape, source):
    from lapy import TetMesh as Solid
    from lapy.diffgeo import compute_geodesic_f
    from lapy.heat import diffusion

    solid = Solid(shape.vertices, shape.cells)
    solid.orient_()
    yield
    found = compute_geodesic_f(solid, diffusion(solid, [source], 1))
    yield found - found[source]


def cg(shape, source):
    solver = gt.GeodesicSolver(shape, refine=False, solver="cg")
    yield
    yield solver.distance(source)


def skfmm(image, source, radius=0.999):
    from skfmm import travel_time

    # A source is given by a level set: here that of a sphere about it, of a radius in voxels.
    places, radius = image.positions, radius * min(image.spacing)
    straight = np.linalg.norm(places - places[source], axis=1)
    level = np.ma.MaskedArray((straight - radius).reshape(image.shape), ~image.mask)
    costs = np.ones(image.shape) if image.costs is None else image.costs
    yield
    found = travel_time(level, 1 / costs, dx=list(image.spacing), order=2)
    found = np.ma.filled(found, np.inf).ravel() + radius * costs.ravel()[source]
    yield np.where(straight < radius, straight * costs.ravel()[source], found)


def skfmm_of_a_ball(image, source):
    """Begin with exact distances within four voxels, which only a body without costs has."""
    return skfmm(image, source, 4.0)


WAYS = {
    "fronts": fronts,
    "heat": heat,
    "heat, CG": cg,
    "LaPy": lapy,
    "scikit-fmm": skfmm,
    "scikit-fmm, 4 voxels": skfmm_of_a_ball,
}


def row(kind, size, way):
    """Print one row of a table."""
    shape, source, exact = SOLIDS[kind](size) if kind in SOLIDS else voxels(kind, size)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    begin = time.process_time()
    work = WAYS[way](shape, source)
    next(work)
    ready = time.process_time()
    found = next(work)
    end = time.process_time()
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    far = (exact > 0) & np.isfinite(exact)
    errors = np.abs(found[far] / exact[far] - 1)
    print(
        f"| {kind} | {shape.n_vertices:,} | {way} | {errors.mean():.3%} | {errors.max():.2%} | "
        f"{ready - begin:.2f} | {end - ready:.2f} | {used / 1024:.0f} |",
        flush=True,
    )


def refined(path):
    """Compare the distances of a solid with those after three subdivisions."""
    solid = gt.read(path)
    count, found = solid.n_vertices, []
    for level in range(4):
        solver = gt.GeodesicSolver(solid)
        distances = solver.distances([[0], [count // 4], [count // 2]])
        found.append((solid, distances[:, :count]))
        solid = subdivided(solid) if level < 3 else None
    finest = found[-1][1]
    away = finest > 0
    for mesh, distance in found[:-1]:
        errors = np.abs(distance[away] / finest[away] - 1)
        print(f"| {mesh} | {errors.mean():.2%} | {errors.max():.1%} |")


def main():
    """Print all rows, each from a process of its own."""
    print("| solid | vertices | way | mean error | largest | build, s | source, s | MB |")
    print("|---|---|---|---|---|---|---|---|")
    rows = [
        (kind, size, way)
        for kind, sizes in SIZES.items()
        for size in sizes
        for way in ("fronts", "heat", "heat, CG", "LaPy")
        if way == "fronts" or size < sizes[-1]
    ]
    rows += [
        (kind, size, way)
        for kind in ("box", "obstacle", "costs")
        for size in (22, 46, 100, 171)
        for way in ("fronts", "heat", "heat, CG", "scikit-fmm", "scikit-fmm, 4 voxels")
        if (size < 50 or not way.startswith("heat")) and (kind != "costs" or "4" not in way)
    ]
    for kind, size, way in rows:
        done = subprocess.run(
            [sys.executable, __file__, kind, str(size), way], check=False, capture_output=True
        )
        said = done.stdout.decode().strip() or done.stderr.decode().strip().splitlines()[-1]
        print(said, flush=True)


if __name__ == "__main__":
    if len(sys.argv) == 2:
        refined(sys.argv[1])
    elif len(sys.argv) > 2:
        row(sys.argv[1], int(sys.argv[2]), sys.argv[3])
    else:
        main()
