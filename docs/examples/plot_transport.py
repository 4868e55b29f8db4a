"""
Parallel transport
==================

A tangent vector is carried along geodesics without turning. Around a loop it comes back turned by
the curvature that the loop encloses.
"""

import matplotlib.pyplot as plt
import numpy as np

import geodesic_toolkit as gt

# %%
# Along each geodesic the angle between the vector and the geodesic stays the same, as far as the
# point opposite the source, around which the results of different geodesics differ.

sphere = gt.testing.shapes.icosphere(4)
solver = gt.GeodesicSolver(sphere)
log = gt.log_map(solver, 0)
vectors = gt.parallel_transport(solver, 0, log.frame[0])

# %%
# In closed form: transport along a great circle is the rotation that takes the source to its end.

near = log.distance < 2.5
source, ends = sphere.vertices[0], sphere.vertices[near]
share = ends @ log.frame[0] / (1 + ends @ source)
exact = log.frame[0] - share[:, None] * (source + ends)
cosine = np.einsum("nd,nd->n", vectors[near], exact)
error = np.degrees(np.arccos(np.clip(cosine, -1, 1))).mean()
print(f"mean error: {error:.3f} degrees")
assert error < 0.2

picture = gt.viz.plot(sphere, log.distance, arrows=vectors, size=(1600, 750))
fig = plt.figure(figsize=(8, 3.75))
fig.add_axes((0, 0, 1, 1)).imshow(picture)
plt.axis("off")

# %%
# Several sources have a vector each, and every vertex takes that of the nearest source.
# :func:`~geodesic_toolkit.extend` does the same with numbers: with labels the result is a Voronoi
# diagram.

torus = gt.testing.shapes.torus(96, 48)
on_torus = gt.GeodesicSolver(torus)
sites = [0, 1600, 3000]
axes = gt.tangent_frames(on_torus).x_axes[sites]
carried = gt.parallel_transport(on_torus, sites, axes)
labels = gt.extend(on_torus, sites, [0, 1, 2])
print("vertices of each cell:", np.bincount(labels))
picture = gt.viz.plot(
    torus, on_torus.distance(sites), arrows=carried, sources=sites, size=(1600, 700)
)
fig = plt.figure(figsize=(8, 3.5))
fig.add_axes((0, 0, 1, 1)).imshow(picture)
plt.axis("off")
