"""Shapes that tests of sources ask."""

import numpy as np

import geodesic_toolkit as gt
from geodesic_toolkit.testing import shapes

PCA = gt.PointCloudLaplacian(normals="pca")
GRID = shapes.grid(41)
SPHERE = shapes.icosphere(4)


def on_segment(points, start, end):
    along = end - start
    share = np.clip((points - start) @ along / (along @ along), 0, 1)
    return np.linalg.norm(points - start - share[:, None] * along, axis=1)


GRAPH = gt.Graph(
    400, [[i, j] for i in range(400) for j in (i + 1, i + 20) if j < 400 and (j % 20 or j > i + 1)]
)
SHAPES = {"mesh": SPHERE, "cloud": gt.PointCloud(shapes.icosphere(3).vertices), "graph": GRAPH}
