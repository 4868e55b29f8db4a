"""Polygon meshes about which the truth is known."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

import geodesic_toolkit as gt
from geodesic_toolkit_polygon.mesh import PolygonMesh

__all__ = ["hexagons", "l_shapes", "polygon_samples", "quad_sphere", "quads"]

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]

MEAN_ERROR = 0.05
"""Mean relative error allowed at some 20 edges across, as the core's own samples have it."""

BESIDE = np.array([10.0, 0.0, 0.0])
"""Shift that sets one sample well apart from another."""


def quads(n: int) -> PolygonMesh:
    """Return the unit square as n x n squares."""
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    ring = (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    faces = np.column_stack([corner.ravel() for corner in ring])
    return PolygonMesh(np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]), faces)


def hexagons(n: int) -> PolygonMesh:
    """Return n x n regular hexagons in a plane, with edges of length 1 / n."""
    across, along = (axis.ravel() for axis in np.meshgrid(np.arange(n), np.arange(n)))
    centres = np.column_stack([np.sqrt(3) * (across + along % 2 / 2), 1.5 * along])
    angles = np.pi / 3 * np.arange(6) + np.pi / 6
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    return _joined((centres[:, None] + ring) / n)


def l_shapes(n: int) -> PolygonMesh:
    """Return the unit square as L shapes of three squares, two of them a block of 2 x 3 squares.

    They have eight corners, three of them on straight edges, where others meet.
    """
    one = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2], [0, 1]])
    # The second one is the first turned by 180 degrees; together they fill 2 x 3 squares.
    pair = np.stack([one, [2, 3] - one])
    shifts = np.stack(np.meshgrid(2 * np.arange(3 * n), 3 * np.arange(2 * n)), axis=-1)
    places = shifts.reshape(-1, 1, 1, 2) + pair
    return _joined(places.reshape(-1, 8, 2) / (6 * n))


def quad_sphere(n: int) -> PolygonMesh:
    """Return the unit sphere as a cube of n x n quadrangles a side, blown up; almost none is flat.

    Lines of the cube are drawn at even angles.
    """
    ticks = np.tan(np.linspace(-np.pi / 4, np.pi / 4, n + 1))
    side = quads(n)
    u, v = ticks[np.rint(side.positions[:, :2] * n).astype(np.int64)].T
    one = np.ones_like(u)
    sides = [(one, u, v), (-one, v, u), (v, one, u), (u, -one, v), (u, v, one), (v, u, -one)]
    places = np.stack([np.column_stack(each) for each in sides])
    places /= np.linalg.norm(places, axis=2, keepdims=True)
    corners = side.corners.reshape(-1, 4)
    return _joined(places[:, corners].reshape(-1, 4, 3))


def _joined(rings: FloatArray) -> PolygonMesh:
    """Return polygons (P, n, d) as a mesh in which corners at one place are one vertex."""
    flat = rings.reshape(-1, rings.shape[2])
    if flat.shape[1] == 2:
        flat = np.column_stack([flat, np.zeros(len(flat))])
    _, first, number = np.unique(
        np.round(flat, 9) + 0.0, axis=0, return_index=True, return_inverse=True
    )
    return PolygonMesh(flat[first], number.reshape(rings.shape[:2]))


def _flat(mesh: PolygonMesh, name: str) -> gt.testing.Sample:
    positions = mesh.positions[:, :2]
    middle = (positions.min(axis=0) + positions.max(axis=0)) / 2
    reach = np.ptp(positions, axis=0).min()
    source = int(np.abs(positions - middle).sum(axis=1).argmin())
    return gt.testing.Sample(
        name=f"{name}, {mesh.n_vertices} vertices",
        domain=mesh,
        dim=2,
        positions=positions,
        source=source,
        distance=np.linalg.norm(positions - positions[source], axis=1),
        spacing=float(mesh.as_graph().lengths.mean()),
        measure=_area(mesh),
        error=MEAN_ERROR,
        inner=np.abs(positions - middle).max(axis=1) < 0.3 * reach,
    )


def _area(mesh: PolygonMesh) -> float:
    """Return the area of flat polygons, by Gauss."""
    first = mesh.positions[mesh.corners]
    begins = np.cumsum(mesh.sizes) - mesh.sizes
    after = np.arange(len(first)) + 1
    after[begins + mesh.sizes - 1] = begins
    return float(np.cross(first, first[after])[:, 2].sum() / 2)


def _sphere(n: int) -> gt.testing.Sample:
    mesh = quad_sphere(n)
    cosine = np.clip(mesh.positions @ mesh.positions[0], -1.0, 1.0)
    return gt.testing.Sample(
        name=f"sphere, {mesh.n_vertices} vertices",
        domain=mesh,
        dim=2,
        positions=mesh.positions,
        source=0,
        distance=np.arccos(cosine),
        spacing=float(mesh.as_graph().lengths.mean()),
        measure=4 * np.pi,
        error=MEAN_ERROR,
    )


def _moved(mesh: PolygonMesh, positions: FloatArray) -> PolygonMesh:
    return PolygonMesh.of_corners(positions, *mesh.polygons)


def _lumpy() -> PolygonMesh:
    """Return an ellipsoid with lumps: a closed surface without symmetry."""
    ball = quad_sphere(5)
    x, y, z = ball.positions.T
    radius = 1 + 0.1 * np.sin(3 * x + 1) + 0.07 * np.cos(4 * y + z) + 0.05 * np.sin(2 * z + x)
    return _moved(ball, ball.positions * radius[:, None] * [1.0, 0.8, 0.65])


def _united(first: PolygonMesh, second: PolygonMesh) -> PolygonMesh:
    return PolygonMesh.of_corners(
        np.concatenate([first.positions, second.positions + BESIDE]),
        np.concatenate([first.sizes, second.sizes]),
        np.concatenate([first.corners, second.corners + first.n_vertices]),
    )


def polygon_samples() -> gt.testing.DomainSamples[PolygonMesh]:
    """Return planes of quadrangles, hexagons and L shapes, and spheres of quadrangles."""
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    line = np.outer([0.0, 1.0, 2.0, 3.0], [1.0, 0.0, 0.0])
    return gt.testing.DomainSamples(
        kind=PolygonMesh,
        families=(
            [_flat(quads(n), "quadrangles") for n in (10, 20)],
            [_flat(hexagons(n), "hexagons") for n in (8, 16)],
            [_flat(l_shapes(n), "L shapes") for n in (2, 4)],
            [_sphere(n) for n in (5, 10)],
        ),
        generic=_lumpy(),
        permuted=lambda mesh, order: PolygonMesh.of_corners(
            mesh.positions[order], mesh.sizes, np.argsort(order)[mesh.corners]
        ),
        united=_united,
        isolated=lambda mesh: _moved(mesh, np.concatenate([mesh.positions, [[0.1, 0.2, 0.3]]])),
        moved=lambda mesh, rotation, shift: _moved(mesh, mesh.positions @ rotation.T + shift),
        scaled=lambda mesh, factor: _moved(mesh, mesh.positions * factor),
        degenerate=(
            PolygonMesh(square, [[0, 1, 2, 3]]),
            PolygonMesh(square, [[0, 1, 2, 3], [3, 2, 1, 0], [1, 2, 3, 0]]),
            PolygonMesh(square, [[0, 1, 1, 2]]),
            PolygonMesh(np.ones((4, 3)), [[0, 1, 2, 3]]),
            PolygonMesh(line, [[0, 1, 2, 3]]),
        ),
    )
