"""
A cortical surface with its medial wall
=======================================

Masks, labels as sources, and the distances between parcels, as neuroimaging needs them.
"""

import matplotlib.pyplot as plt
import numpy as np

import geodesic_toolkit as gt

# %%
# A bumpy closed surface stands for a hemisphere; `gt.read("lh.pial")` reads one of FreeSurfer, and
# `gt.read_mask("lh.aparc.annot", n_vertices, region="unknown")` its medial wall. No path may
# cross the wall: it is a mask.

ball = gt.testing.shapes.icosphere(5)
x, y, z = ball.vertices.T
folds = 1 + 0.06 * np.sin(9 * x) * np.sin(8 * y) * np.sin(7 * z)
cortex = gt.TriangleMesh(70 * folds[:, None] * ball.vertices * [0.7, 1.0, 0.8], ball.faces)
wall = (x > 0.75) & (np.abs(y) < 0.6)
solver = gt.GeodesicSolver(cortex, mask=wall)

# %%
# A label is a set of vertices, which is one source: the distance from its edge. Through the wall
# the distance would be shorter, and wrong.

label = np.flatnonzero((z > 0.7) & (x > 0.2) & ~wall)
distance = solver.distance(label)
through = gt.GeodesicSolver(cortex).distance(label)
longer = np.where(wall, 0.0, distance - through)
print(f"up to {longer.max():.1f} mm longer around the wall")
assert np.isinf(distance[wall]).all()
assert longer.min() > -0.5

picture = gt.viz.plot(cortex, distance, views=("x", "z"), unit="mm", size=(1400, 700))
fig = plt.figure(figsize=(7, 3.5))
fig.add_axes((0, 0, 1, 1)).imshow(picture)
plt.axis("off")

# %%
# Parcel to parcel: sources are the parcels, and each entry is the mean of the distances in the
# other parcel.

parcel = (np.digitize(y, [-0.4, 0.1, 0.5]) * 2 + (z > 0)).astype(int)
parcel[wall] = -1
numbers = np.unique(parcel[parcel >= 0])
rows = solver.distances([np.flatnonzero(parcel == one) for one in numbers])
matrix = np.array([[row[parcel == one].mean() for one in numbers] for row in rows])
fig, axes = plt.subplots(figsize=(4, 3.4), layout="constrained")
axes.set(title="mean distance between parcels", xlabel="to", ylabel="from")
fig.colorbar(axes.imshow(matrix), label="mm")
