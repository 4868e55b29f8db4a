"""
A logarithmic map as a texture
==============================

From one point of a surface, the logarithmic map gives the direction and the length of the shortest
geodesic to every vertex. Its coordinates are those of a texture without a seam around the point.
"""

import matplotlib.pyplot as plt
import numpy as np

import geodesic_toolkit as gt

# %%
# On a sphere the map is known in closed form: the angle is that of the great circle, and the
# length is the arc.

sphere = gt.testing.shapes.icosphere(4)
solver = gt.GeodesicSolver(sphere)
log = gt.log_map(solver, 0)
near = (log.distance > 0) & (log.distance < 2.5)
x, y = (sphere.vertices[near] @ log.frame.T).T
error = np.angle(np.exp(1j * (log.angle[near] - np.arctan2(y, x))))
print(f"mean error of the angle: {np.degrees(abs(error).mean()):.3f} degrees")
assert np.degrees(abs(error).mean()) < 0.2

# %%
# Rings and sectors have colours of their distance, squares show how lengths are distorted: beside
# the source they are squares, and towards the antipode, where all geodesics meet, they are narrow.
# Faces across the cut locus, where the map jumps, have no pattern.

torus = gt.testing.shapes.torus(96, 48)
on_torus = gt.log_map(gt.GeodesicSolver(torus), 0)
pictures = [
    gt.viz.plot(sphere, log.distance, checkers=gt.viz.Checkers(log.coordinates, sectors=0),
                isolines=0, size=(1600, 700)),
    gt.viz.plot(torus, on_torus.distance, checkers=gt.viz.Checkers(on_torus.coordinates),
                isolines=0, size=(1600, 700), views=[[1, 0, 0.8], [-1, 0, 0.8]]),
]  # fmt: skip
fig, axes = plt.subplots(2, 1, figsize=(8, 7), layout="constrained")
for place, picture in zip(axes, pictures, strict=True):
    place.imshow(picture)
    place.axis("off")

# %%
# :func:`~geodesic_toolkit.exp_map` is the inverse: a straightest line along the logarithm of a
# vertex ends at that vertex.

vertices = np.flatnonzero(near)[::40]
ends = gt.exp_map(solver, 0, log.vectors[vertices])
gap = np.linalg.norm(ends.positions - sphere.vertices[vertices], axis=1)
print(f"the ends miss their vertices by {np.median(gap / log.distance[vertices]):.2%}")
