"""Graphs that tests measure."""

import numpy as np

import geodesic_toolkit as gt


def lattice(n, dim):
    """The grid graph of n^dim vertices and its positions."""
    index = np.arange(n**dim).reshape((n,) * dim)
    edges = [
        np.column_stack(
            [
                np.take(index, range(n - 1), axis).ravel(),
                np.take(index, range(1, n), axis).ravel(),
            ]
        )
        for axis in range(dim)
    ]
    positions = np.stack(np.unravel_index(np.arange(n**dim), (n,) * dim), axis=1)
    return gt.Graph(n**dim, np.concatenate(edges)), positions.astype(float)


def boxes(*shape, spacing=(1, 1, 1), diagonals=False):
    """The graph of a box of voxels and their positions."""
    index = np.arange(np.prod(shape)).reshape(shape)
    steps = [step for step in np.ndindex(*(3,) * len(shape)) if step > (1,) * len(shape)]
    edges = []
    for step in np.array(steps) - 1:
        if diagonals or np.abs(step).sum() == 1:
            low = tuple(slice(max(0, -s), None if s <= 0 else -s) for s in step)
            high = tuple(slice(max(0, s), None if s >= 0 else s) for s in step)
            edges.append(np.column_stack([index[low].ravel(), index[high].ravel()]))
    edges = np.concatenate(edges)
    positions = np.stack(np.unravel_index(index.ravel(), shape), axis=1) * spacing[: len(shape)]
    lengths = np.linalg.norm(positions[edges[:, 0]] - positions[edges[:, 1]], axis=1)
    return gt.Graph(index.size, edges, lengths), positions.astype(float)
