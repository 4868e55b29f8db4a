"""
A first distance
================

The distance along a knotted tube from one of its vertices, and how it differs from the distance
through the air.
"""

import matplotlib.pyplot as plt
import numpy as np

import geodesic_toolkit as gt

# %%
# The shape is generated; ``gt.read("bunny.off")`` would read one from a file. The solver
# factorises two sparse matrices once, and every source after that costs two pairs of
# back-substitutions.

mesh = gt.testing.shapes.knot(300, 16)
solver = gt.GeodesicSolver(mesh)
print(mesh)

# %%
# The result has one number for each vertex, in the unit of the mesh. The source reads 0, and the
# farthest vertex is half way around the knot.

source = 0
distance = solver.distance(source)
farthest = int(distance.argmax())
print(f"from vertex {source}: vertex {farthest} is farthest, at {distance[farthest]:.2f}")

# %%
# A picture as an array, with a line for every step of the distance. With a ``path`` it is saved.

picture = gt.viz.plot(mesh, distance, size=(1600, 700))
fig = plt.figure(figsize=(8, 3.5))
fig.add_axes((0, 0, 1, 1)).imshow(picture)
plt.axis("off")

# %%
# Where two strands of the knot pass close to each other, the distance through the air is a poor
# estimate.

straight = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)
edge = solver.method.metric.spacing  # the resolution of the mesh, and about that of the method
assert (distance > straight - edge).all()

fig, axes = plt.subplots(figsize=(6, 4), layout="constrained")
axes.scatter(straight, distance, s=3, color="#1f5f8b")
axes.axline((0, 0), slope=1, color="#b3541e", label="equal")
axes.set(xlabel="straight through the air", ylabel="along the surface", title="every vertex")
axes.legend()

# %%
# Further sources are cheap, and a block of them is cheaper still: one row a source.

distances = solver.distances([0, 1000, 2000])
print(distances.shape)
