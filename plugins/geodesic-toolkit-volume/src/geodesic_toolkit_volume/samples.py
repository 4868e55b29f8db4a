"""Solids with known distances, on which the checks measure operators."""

from typing import Any

import numpy as np

import geodesic_toolkit as gt
from geodesic_toolkit_volume.marching import Floats, Integers
from geodesic_toolkit_volume.tet_mesh import EDGES, TetMesh
from geodesic_toolkit_volume.voxel_image import VoxelImage

__all__ = ["box", "subdivided", "tet_samples", "voxel_samples"]

SIDES = (6, 11)
"""Vertices along the side of the cube, coarse and fine."""

MEAN_ERROR = 0.12
"""Largest mean relative error of heat there: 4 to 11 % were measured; fronts are exact."""

PATHS = np.array(
    [[0, 1, 3, 7], [0, 1, 5, 7], [0, 2, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 4, 6, 7]]
)
"""Kuhn's six tetrahedra of a cube, by its corners in binary."""

EIGHTH_PARTS = np.array(
    [
        *([0, 4, 5, 6], [1, 4, 7, 8], [2, 5, 7, 9], [3, 6, 8, 9]),
        *([4, 9, 5, 6], [4, 9, 6, 8], [4, 9, 8, 7], [4, 9, 7, 5]),
    ]
)
"""The parts of a tetrahedron, by its corners and then the middles of its edges."""


def box(shape: tuple[int, int, int], spacing: float = 1.0) -> tuple[Floats, Integers]:
    """Return vertices and cells of a box of so many vertices along each side, six to a cube.

    Parameters
    ----------
    shape : tuple of three ints
    spacing : float

    Returns
    -------
    vertices : ndarray of shape (N, 3)
    cells : ndarray of shape (C, 4)

    Examples
    --------
    >>> from geodesic_toolkit_volume.samples import box
    >>> [array.shape for array in box((3, 3, 3))]
    [(27, 3), (48, 4)]
    """
    index = np.arange(np.prod(shape)).reshape(shape)
    corners = np.stack(
        [
            index[i : shape[0] - 1 + i, j : shape[1] - 1 + j, k : shape[2] - 1 + k].ravel()
            for i, j, k in np.ndindex(2, 2, 2)
        ],
        axis=1,
    )
    vertices = np.indices(shape).reshape(3, -1).T * spacing
    return np.asarray(vertices, dtype=np.float64), corners[:, PATHS].reshape(-1, 4)


def subdivided(mesh: TetMesh) -> TetMesh:
    """Return a mesh whose cells are split into eight; its first vertices are the given ones.

    Parameters
    ----------
    mesh : TetMesh

    Returns
    -------
    TetMesh

    Examples
    --------
    >>> from geodesic_toolkit_volume import TetMesh
    >>> from geodesic_toolkit_volume.samples import box, subdivided
    >>> subdivided(TetMesh(*box((2, 2, 2))))
    TetMesh(27 vertices, 48 cells)
    """
    pairs = np.sort(mesh.cells[:, EDGES], axis=2)
    edges, inverse = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    corners = np.column_stack([mesh.cells, inverse.reshape(-1, 6) + mesh.n_vertices])
    middles = mesh.vertices[edges].mean(axis=1)
    return TetMesh(
        np.concatenate([mesh.vertices, middles]),
        corners[:, EIGHTH_PARTS].reshape(-1, 4),
        np.repeat(mesh.costs, 8),
    )


def _jittered(n: int) -> tuple[Floats, Integers]:
    """Return the unit cube with its inner vertices moved, without ties."""
    vertices, cells = box((n, n, n), 1 / (n - 1))
    inner = np.asarray(((vertices > 0.01) & (vertices < 0.99)).all(axis=1))
    moves = np.random.default_rng(1).uniform(-0.15, 0.15, size=vertices.shape) / (n - 1)
    return np.asarray(vertices + moves * inner[:, None], dtype=np.float64), cells


def _cube(domain: Any, positions: Floats, spacing: float, measure: float) -> Any:
    source = int(np.abs(positions - positions.mean(axis=0)).sum(axis=1).argmin())
    return gt.testing.Sample(
        name=f"cube, {len(positions)} vertices, {type(domain).__name__}",
        domain=domain,
        dim=3,
        positions=positions,
        source=source,
        distance=np.linalg.norm(positions - positions[source], axis=1),
        spacing=spacing,
        measure=measure,
        error=MEAN_ERROR,
        inner=np.abs(positions - positions.mean(axis=0)).max(axis=1) < 0.25,
    )


def tet_samples() -> Any:
    """Return cubes of tetrahedra."""

    def of(arrays: tuple[Floats, Integers]) -> Any:
        mesh = TetMesh(*arrays)
        return _cube(mesh, mesh.vertices, float(mesh.as_graph().lengths.mean()), 1.0)

    def united(first: TetMesh, second: TetMesh) -> TetMesh:
        shift = [10.0, 0.0, 0.0]
        return TetMesh(
            np.concatenate([first.vertices, second.vertices + shift]),
            np.concatenate([first.cells, second.cells + first.n_vertices]),
        )

    one = np.eye(4)[:, 1:]
    return gt.testing.DomainSamples(
        kind=TetMesh,
        families=([of(box((n, n, n), 1 / (n - 1))) for n in SIDES],),
        generic=TetMesh(*_jittered(6)),
        permuted=lambda m, order: TetMesh(m.vertices[order], np.argsort(order)[m.cells]),
        united=united,
        isolated=lambda m: TetMesh(np.concatenate([m.vertices, [[0.1, 0.2, 9.0]]]), m.cells),
        moved=lambda m, rotation, shift: TetMesh(m.vertices @ rotation.T + shift, m.cells),
        scaled=lambda m, factor: TetMesh(m.vertices * factor, m.cells),
        degenerate=(
            TetMesh(one, [[0, 1, 2, 3]]),
            TetMesh(one, []),
            TetMesh(one, [[0, 1, 2, 2]]),
            TetMesh(np.ones((4, 3)), [[0, 1, 2, 3]]),
            TetMesh(one, [[0, 1, 2, 3], [0, 0, 1, 2]]),
        ),
    )


def voxel_samples() -> Any:
    """Return cubes of voxels."""

    def of(n: int) -> Any:
        image = VoxelImage(np.ones((n, n, n), dtype=np.bool_), spacing=[1 / n] * 3)
        return _cube(image, image.positions, 1 / n, 1.0)

    x, y, z = np.indices((7, 6, 5))
    costs = 1 + 0.1 * np.sin(2 * x + 1) + 0.07 * np.cos(3 * y + z) + 0.05 * np.sin(2 * z + x)
    lone = np.zeros((3, 3, 3), dtype=np.bool_)
    lone[1, 1, 1] = True
    pairs = np.zeros((4, 1, 1), dtype=np.bool_)
    pairs[:2] = True
    return gt.testing.DomainSamples(
        kind=VoxelImage,
        families=([of(n) for n in SIDES],),
        generic=VoxelImage(x + y + z > 1, [1.0, 0.8, 1.3], costs),
        moved=_moved,
        scaled=_scaled,
        degenerate=(VoxelImage(lone), VoxelImage(pairs), VoxelImage(lone | lone[::-1])),
    )


def _moved(image: VoxelImage, rotation: Floats, shift: Floats) -> VoxelImage:
    affine = np.eye(4)
    affine[:3, :3], affine[:3, 3] = rotation, shift
    return VoxelImage(image.mask, costs=image.costs, affine=affine @ image.affine)


def _scaled(image: VoxelImage, factor: float) -> VoxelImage:
    return VoxelImage(
        image.mask, costs=image.costs, affine=np.diag([factor, factor, factor, 1.0]) @ image.affine
    )
