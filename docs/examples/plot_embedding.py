"""
A matrix of distances, and the sheet that it unrolls
====================================================

Distances between landmarks of a rolled sheet, and the flat map that has the same distances.
"""

import matplotlib.pyplot as plt
import numpy as np

import geodesic_toolkit as gt

# %%
# A sheet of 10 by 6 is rolled up. Distances along it are those of the flat sheet, which classical
# multidimensional scaling finds again from the matrix alone.

flat = gt.testing.shapes.grid(60)
along, across, _ = (flat.vertices * [10.0, 6.0, 0.0]).T
turn = np.sqrt(2 * (along + 2))  # arc length grows with the square of the angle, nearly
rolled = gt.TriangleMesh(
    np.column_stack([turn * np.cos(2 * turn), across, turn * np.sin(2 * turn)]) / 1.0, flat.faces
)
solver = gt.GeodesicSolver(rolled)
landmarks = gt.farthest_point_sampling(solver, 60, start=0)
matrix = gt.distance_matrix(solver, landmarks, targets=landmarks)
print(matrix.shape)

# %%
# The eigenvalues say how many dimensions the distances need: two are large, the rest is noise.

centre = np.eye(len(matrix)) - 1 / len(matrix)
values, vectors = np.linalg.eigh(-centre @ matrix**2 @ centre / 2)
share = values[-2:].sum() / np.abs(values).sum()
print(f"two dimensions carry {share:.2%} of the squared distances")
assert share > 0.99
flat_again = vectors[:, -2:] * np.sqrt(values[-2:])

fig = plt.figure(figsize=(8, 3.6), layout="constrained")
left = fig.add_subplot(1, 2, 1, projection="3d")
left.scatter(*rolled.vertices[landmarks].T, c=along[landmarks])
left.set_title("landmarks in space")
right = fig.add_subplot(1, 2, 2)
right.scatter(flat_again[:, 1], flat_again[:, 0], c=along[landmarks])
right.set(aspect="equal", title="from distances along the sheet")
